// SPDX-License-Identifier: Apache-2.0
// Priority: who a frame is rendered for. ReadyQueue and Credits share processors and rays by it.
#pragma once
#include <cstdint>

namespace gxy {

struct Priority {
  uint32_t tenant = 0;
  bool interactive = false;  ///< somebody waits to see the frame, so it may go before others
  /// The stream of frames that the frame belongs to, for instance those of a window or of a batch. Unique
  /// within the tenant. Frames of a stream are wanted in their order.
  uint64_t stream = 0;
};

}  // namespace gxy
