// SPDX-License-Identifier: Apache-2.0
// Values as what files and samples hold.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace gxy {

template <typename T>
std::span<const std::byte> bytes(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

}  // namespace gxy
