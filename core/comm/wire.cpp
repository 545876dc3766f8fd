// SPDX-License-Identifier: Apache-2.0
#include "core/comm/wire.h"

namespace gxy {

void Writer::append(const void* data, size_t size) {
  const auto* bytes = static_cast<const std::byte*>(data);
  bytes_.insert(bytes_.end(), bytes, bytes + size);
}

void Reader::fail(const std::string& reason) const {
  throw Error("malformed message '" + std::string(what_) + "': " + reason);
}

std::span<const std::byte> Reader::take(size_t size) {
  if (size > rest_.size())
    fail("it ends after " + std::to_string(rest_.size()) + " more bytes, expected " + std::to_string(size));
  const auto head = rest_.first(size);
  rest_ = rest_.subspan(size);
  return head;
}

}  // namespace gxy
