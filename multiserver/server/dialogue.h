// SPDX-License-Identifier: Apache-2.0
// What one client says: preamble, hello, then frames. No sockets here: whoever has one hands over the bytes that come.
#pragma once
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "multiserver/protocol/frame.h"
#include "multiserver/protocol/handshake.h"
#include "multiserver/server/outbox.h"
#include "multiserver/server/session.h"

namespace gxy {

/// One thread at a time.
class Dialogue {
 public:
  /// Makes the session of a client that has said hello, and fills in the welcome. Throws Error, the reason, to refuse it.
  using Admit = std::function<std::shared_ptr<Session>(const protocol::Hello&, const std::shared_ptr<Outbox>&,
                                                       protocol::Welcome&)>;

  Dialogue(std::shared_ptr<Outbox> outbox, protocol::Limits limits, Admit admit);

  /// Takes bytes off the front until all are taken, or the client is to be read no further (paused, over). Throws Error for
  /// what breaks the protocol, and to a client that is refused: it is told, and nothing more is read.
  void take(std::span<const std::byte>& bytes);

  /// As much waits to be sent or answered as may: to be asked again when something has been.
  bool paused() const;
  /// The client has said bye, or speaks another protocol: nothing more is to be said.
  bool over() const { return over_; }
  /// Null before the handshake.
  const std::shared_ptr<Session>& session() const { return session_; }

 private:
  void takePreamble(std::span<const std::byte>& bytes);
  void control(std::string_view text);
  void hello(std::string_view text);

  const std::shared_ptr<Outbox> outbox_;
  const protocol::Limits limits_;
  const Admit admit_;
  std::array<std::byte, protocol::kPreambleBytes> preamble_{};
  size_t preambleBytes_ = 0;
  protocol::FrameReader reader_;
  std::shared_ptr<Session> session_;
  bool over_ = false;
};

}  // namespace gxy
