// SPDX-License-Identifier: Apache-2.0
// Parses JSON that comes from the network, and prints JSON and text safely.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace gxy::protocol {

/// Parses an object within the bounds of core/scene/json_text.h. Throws Error "WHAT:LINE:COLUMN: ..." as
/// parseJson() does, and also for a value that is not an object.
nlohmann::json parseObject(std::string_view text, const std::string& what);

/// The same for text from a server, without a limit on the number of values.
nlohmann::json parseAnswer(std::string_view text, const std::string& what);

/// Returns JSON on one line. Bytes that are not UTF-8 are replaced. Never throws.
std::string dump(const nlohmann::json& value);

bool isUtf8(std::string_view text);

/// Whether text has control characters: C0, DEL or C1.
bool hasControls(std::string_view text);

/// Returns text that is safe to show in a terminal: bytes that are not UTF-8, and control characters other
/// than line ends and tabs, become U+FFFD.
std::string printable(std::string_view text);

/// Returns JSON on one line with the same value, in which the control characters that RFC 8259 allows in
/// strings (DEL, U+0080 to U+009F) are escapes.
std::string printableJson(std::string_view json);

}  // namespace gxy::protocol
