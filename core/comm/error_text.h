// SPDX-License-Identifier: Apache-2.0
// Texts of error messages for users.
#pragma once
#include <exception>
#include <new>
#include <string>
#include <string_view>

namespace gxy {

/// The message of `error`; "not enough memory" for std::bad_alloc.
inline std::string textOf(const std::exception& error) {
  return dynamic_cast<const std::bad_alloc*>(&error) ? "not enough memory" : error.what();
}

/// Returns text that came from a user for use in a message: in the given quotes, with control characters of
/// UTF-8 replaced by '?', and cut with "..." after 60 bytes.
std::string inQuotes(std::string_view text, char quote = '"');

}  // namespace gxy
