// SPDX-License-Identifier: Apache-2.0
// A line to a browser: HTTP until the page opens its WebSocket, and from then on messages.
#pragma once
#include <memory>

#include "multiserver/web/line.h"

namespace gxy {

struct Site;

/// A line that is used for messages only after it was upgraded.
class WebLine : public Line {
 public:
  enum class State {
    Waits,     ///< for the next request, or for the client to close
    Answers,   ///< sends an answer
    Upgraded,  ///< to a WebSocket: from now on the functions of Line may be used
    Ended      ///< the connection is over
  };
  using Changed = std::function<void(State)>;

  /// Answers requests. `changed` is called when the state changes, until close().
  virtual void serve(Changed changed) = 0;
};

/// `first`, at most 1 KiB, has been read from the socket already.
std::shared_ptr<WebLine> makeWebLine(Line::Socket socket, std::shared_ptr<const Site> site,
                                     std::span<const std::byte> first);

}  // namespace gxy
