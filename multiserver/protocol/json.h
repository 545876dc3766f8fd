// SPDX-License-Identifier: Apache-2.0
// JSON that comes from outside.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace gxy::protocol {

/// Parses an object. The bounds of core/scene/json_text.h hold, and its messages: Error "WHAT:LINE:COLUMN: ...". Throws
/// Error also for a value that is no object.
nlohmann::json parseObject(std::string_view text, const std::string& what);

/// The same of what a server sends to its client, with as many values as there are.
nlohmann::json parseAnswer(std::string_view text, const std::string& what);

/// On one line; bytes that are no UTF-8 are replaced. Never throws.
std::string dump(const nlohmann::json& value);

bool isUtf8(std::string_view text);

/// Whether text has control characters: C0, DEL or C1.
bool hasControls(std::string_view text);

/// Text for people: what is no UTF-8, and control characters but line ends and tabs, which a terminal could obey, is U+FFFD.
std::string printable(std::string_view text);

/// JSON on one line, with the control characters that RFC 8259 allows in strings (DEL, U+0080 to U+009F) as escapes: the
/// same value.
std::string printableJson(std::string_view json);

}  // namespace gxy::protocol
