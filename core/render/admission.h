// SPDX-License-Identifier: Apache-2.0
// Admission: how many frames of a stream are rendered at once.
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "core/render/priority.h"

namespace gxy {

/// Admits the frames of each stream in their order. The next frame of a stream begins while fewer than `few`
/// are under way, or while its framebuffer and those of the frames under way together take at most `bytes`.
/// More frames at once would not raise the throughput, and the system would have to clear the memory of their
/// framebuffers. Not thread safe.
class Admission {
 public:
  using FrameId = uint64_t;

  Admission(int64_t bytes, size_t few) : bytes_(bytes), few_(few) {}

  /// Enters a new frame. Returns true if it may begin; otherwise it waits until over() returns it.
  bool enter(const Priority& priority, FrameId frame, int64_t bytes);
  /// Says that a frame is over. Returns the waiting frames that may begin now, oldest first. Does nothing for
  /// frames that were never entered.
  std::vector<FrameId> over(FrameId frame);
  /// Counts a waiting frame as begun whatever the limits, because it is superseded and ends at once.
  void beginAnyway(FrameId frame);
  size_t waiting() const;

 private:
  using Key = std::pair<uint32_t, uint64_t>;  ///< tenant and stream
  struct Entry {
    FrameId frame;
    int64_t bytes;
  };
  struct Stream {
    std::vector<Entry> begun;
    std::deque<Entry> waiting;
    int64_t bytes = 0;  ///< of the frames in `begun`
  };
  bool mayBegin(const Stream& stream, int64_t bytes) const;

  const int64_t bytes_;
  const size_t few_;
  std::map<Key, Stream> streams_;
  std::map<FrameId, Key> keys_;
};

}  // namespace gxy
