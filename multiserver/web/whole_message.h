// SPDX-License-Identifier: Apache-2.0
// On a WebSocket, one binary message is one message of docs/protocol.md: no less, and no more.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "multiserver/protocol/wire_message.h"

namespace gxy {

/// Compares the length of each WebSocket message with the length that its header tells. It keeps the header
/// only, however the message is cut into pieces.
class WholeMessage {
 public:
  /// Takes the next piece of a message; `last` says that the message ends with it. Throws Error if the message
  /// is shorter or longer than its header tells; a piece that makes it too long must not be used at all.
  void take(std::span<const std::byte> piece, bool last);

 private:
  std::array<std::byte, protocol::kHeaderBytes> header_{};
  uint64_t taken_ = 0;   ///< bytes of this message
  uint64_t length_ = 0;  ///< of the payload; known once the header has come
};

}  // namespace gxy
