// SPDX-License-Identifier: Apache-2.0
#include "multiserver/web/whole_message.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "core/comm/error.h"

namespace gxy {

namespace {

[[noreturn]] void failLength(uint64_t found, uint64_t length) {
  throw Error("WebSocket message of " + std::to_string(found) + " bytes whose header tells " +
              std::to_string(length) + ", expected these and " + std::to_string(protocol::kHeaderBytes) +
              " of the header");
}

}  // namespace

void WholeMessage::take(std::span<const std::byte> piece, bool last) {
  constexpr uint64_t kHeader = protocol::kHeaderBytes;
  if (taken_ < kHeader) {
    const size_t size = std::min(piece.size(), size_t(kHeader - taken_));
    std::copy_n(piece.begin(), size, header_.begin() + std::ptrdiff_t(taken_));
    taken_ += size;
    piece = piece.subspan(size);
    if (taken_ == kHeader) std::memcpy(&length_, header_.data(), sizeof length_);
  }
  taken_ += piece.size();
  if (taken_ > kHeader && taken_ - kHeader > length_) failLength(taken_, length_);
  if (!last) return;
  if (taken_ < kHeader)
    throw Error("WebSocket message of " + std::to_string(taken_) + " bytes, expected a header of " +
                std::to_string(kHeader) + " and a payload");
  if (taken_ - kHeader != length_) failLength(taken_, length_);
  taken_ = 0;
}

}  // namespace gxy
