// SPDX-License-Identifier: Apache-2.0
// How many frames of a batch are rendered at once.
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <utility>
#include <vector>

#include "core/render/share.h"

namespace gxy {

/// Admits the frames of each stream in their order, as long as the framebuffers of those that it admitted and that are not over
/// take at most so many bytes, or are few. More at once would make no more frames, and take memory that the system has to clear.
/// Not thread safe.
class Admission {
 public:
  using FrameId = uint64_t;

  /// Admits `few` frames of a stream, however large they are.
  Admission(int64_t bytes, size_t few) : bytes_(bytes), few_(few) {}

  /// A new frame. True if it may begin; otherwise it waits until over() names it.
  bool enter(const Share& share, FrameId frame, int64_t bytes);
  /// A frame that began is over. Returns those that may begin now, oldest first. Nothing happens for frames that were never
  /// entered.
  std::vector<FrameId> over(FrameId frame);
  /// A frame that waits begins now, as it ends at once.
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
    int64_t bytes = 0;  ///< of those that have begun
  };
  bool mayBegin(const Stream& stream, int64_t bytes) const;

  const int64_t bytes_;
  const size_t few_;
  std::map<Key, Stream> streams_;
  std::map<FrameId, Key> keys_;
};

}  // namespace gxy
