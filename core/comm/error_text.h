// SPDX-License-Identifier: Apache-2.0
// What messages say to a user.
#pragma once
#include <exception>
#include <new>
#include <string>
#include <string_view>

namespace gxy {

/// Its message; that of std::bad_alloc in words.
inline std::string textOf(const std::exception& error) {
  return dynamic_cast<const std::bad_alloc*>(&error) ? "not enough memory" : error.what();
}

/// User text for a message: in the given quotes, control characters of UTF-8 replaced by '?', cut when long.
std::string inQuotes(std::string_view text, char quote = '"');

}  // namespace gxy
