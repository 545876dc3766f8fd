// SPDX-License-Identifier: Apache-2.0
// What an exception says to a user.
#pragma once
#include <exception>
#include <new>
#include <string>

namespace gxy {

/// Its message; that of std::bad_alloc in words.
inline std::string textOf(const std::exception& error) {
  return dynamic_cast<const std::bad_alloc*>(&error) ? "not enough memory" : error.what();
}

}  // namespace gxy
