// SPDX-License-Identifier: Apache-2.0
// Keeps track of the frames that a window has asked for and that have not come yet.
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include "core/scene/scene.h"
#include "tools/gxyviewer/pace.h"

namespace gxy {

/// The frames that have been requested and of which nothing has been shown yet. The server's replies give their
/// numbers and come in the order of the requests. Pixels and the end of a frame may come before its number.
class FramesAsked {
 public:
  using Clock = std::chrono::steady_clock;
  struct Asked {
    Clock::time_point at;
    std::optional<Detail> moving;      ///< detail of the frame, if the camera is moving
    std::optional<uint64_t> number{};  ///< known once the server has replied
    Camera camera{};
  };

  Asked& ask(Clock::time_point now) { return asked_.emplace_back(Asked{now, {}, {}}); }
  /// Takes the number in the reply to the oldest request without a reply.
  void number(uint64_t frame) {
    const auto asked = oldestWithoutReply();
    asked->number = frame;
    newest_ = std::max(newest_, frame);
    if (frame <= done_ || frame == skipped_) asked_.erase(asked);
  }
  void refuse() { asked_.erase(oldestWithoutReply()); }
  /// Returns the request of a frame; null if this window has not requested it or does not know its number yet.
  const Asked* find(uint64_t frame) const {
    const auto asked = std::ranges::find(asked_, std::optional(frame), &Asked::number);
    return asked == asked_.end() ? nullptr : &*asked;
  }
  /// Returns the camera of a frame of which something has come. If no request has its number yet, it must be
  /// the frame of the oldest request without a reply.
  std::optional<Camera> cameraOf(uint64_t frame) const {
    const Asked* asked = find(frame);
    if (!asked) {
      const auto oldest = std::ranges::find(asked_, std::optional<uint64_t>(), &Asked::number);
      if (oldest != asked_.end()) asked = &*oldest;
    }
    return asked ? std::optional(asked->camera) : std::nullopt;
  }
  /// Called when something of `frame` is shown or it has ended. Nothing of older frames will be shown any more.
  void done(uint64_t frame) {
    done_ = std::max(done_, frame);
    newest_ = std::max(newest_, frame);
    std::erase_if(asked_, [&](const Asked& a) { return a.number && *a.number <= frame; });
  }
  /// Called when `frame` was superseded before it began. The frame before it is still to come.
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

  std::deque<Asked> asked_;  // in the order of requests
  uint64_t newest_ = 0, done_ = 0, skipped_ = 0;
};

}  // namespace gxy
