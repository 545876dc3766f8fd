// SPDX-License-Identifier: Apache-2.0
// Text from elsewhere, for a terminal.
#pragma once
#include <string>
#include <string_view>

namespace gxy::protocol {

/// What a terminal could obey, control characters but line feeds and tabs, and what is no UTF-8, becomes U+FFFD.
std::string printable(std::string_view text);

/// JSON on one line, with the control characters that RFC 8259 allows in strings (DEL, U+0080 to U+009F) as escapes: the same
/// value.
std::string printableJson(std::string_view json);

}  // namespace gxy::protocol
