// SPDX-License-Identifier: Apache-2.0
// Which of the frames that a window has asked for are still to come.
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include "core/scene/scene.h"
#include "tools/gxyviewer/pace.h"

namespace gxy {

/// Frames that were asked for and of which nothing is shown yet. The server numbers them in its replies, which come in the order
/// of the requests; pixels and ends of a frame may come before its number.
class FramesAsked {
 public:
  using Clock = std::chrono::steady_clock;
  struct Asked {
    Clock::time_point at;
    std::optional<Detail> moving;      ///< of a camera that moves
    std::optional<uint64_t> number{};  ///< once the server has said it
    Camera camera{};
  };

  Asked& ask(Clock::time_point now) { return asked_.emplace_back(Asked{now, {}, {}}); }
  /// The reply to the oldest request without one.
  void number(uint64_t frame) {
    const auto asked = oldestWithoutReply();
    asked->number = frame;
    newest_ = std::max(newest_, frame);
    if (frame <= done_ || frame == skipped_) asked_.erase(asked);
  }
  void refuse() { asked_.erase(oldestWithoutReply()); }
  /// The request of a frame; null where this window has not asked for it, or does not know its number yet.
  const Asked* find(uint64_t frame) const {
    const auto asked = std::ranges::find(asked_, std::optional(frame), &Asked::number);
    return asked == asked_.end() ? nullptr : &*asked;
  }
  /// The camera of a frame of which something has come. Before the server has said its number, it is that of the oldest request
  /// without one.
  std::optional<Camera> cameraOf(uint64_t frame) const {
    const Asked* asked = find(frame);
    if (!asked) {
      const auto oldest = std::ranges::find(asked_, std::optional<uint64_t>(), &Asked::number);
      if (oldest != asked_.end()) asked = &*oldest;
    }
    return asked ? std::optional(asked->camera) : std::nullopt;
  }
  /// Something of `frame` is shown, or it has ended: nothing of older ones will be shown any more.
  void done(uint64_t frame) {
    done_ = std::max(done_, frame);
    newest_ = std::max(newest_, frame);
    std::erase_if(asked_, [&](const Asked& a) { return a.number && *a.number <= frame; });
  }
  /// `frame` was overtaken while it waited to begin: the one before it is still to come.
  void skip(uint64_t frame) {
    skipped_ = frame;
    newest_ = std::max(newest_, frame);
    std::erase_if(asked_, [&](const Asked& a) { return a.number == frame; });
  }
  size_t underWay() const { return asked_.size(); }
  /// The newest frame that the server has numbered.
  uint64_t newest() const { return newest_; }

 private:
  std::deque<Asked>::iterator oldestWithoutReply() {
    return std::ranges::find(asked_, std::optional<uint64_t>(), &Asked::number);
  }

  std::deque<Asked> asked_;  // in order
  uint64_t newest_ = 0, done_ = 0, skipped_ = 0;
};

}  // namespace gxy
