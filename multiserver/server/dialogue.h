// SPDX-License-Identifier: Apache-2.0
// Interprets the bytes that one client sends: preamble, hello, then messages. It uses no sockets; the
// Connection passes on the bytes that arrive.
#pragma once
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "multiserver/protocol/handshake.h"
#include "multiserver/protocol/wire_message.h"
#include "multiserver/server/outbox.h"
#include "multiserver/server/session.h"

namespace gxy {

/// One thread at a time may use it.
class Dialogue {
 public:
  /// Makes the session of a client that has said hello, and fills in the welcome. Throws Error with the
  /// reason to refuse it.
  using Admit = std::function<std::shared_ptr<Session>(const protocol::Hello&, const std::shared_ptr<Outbox>&,
                                                       protocol::Welcome&)>;

  Dialogue(std::shared_ptr<Outbox> outbox, protocol::Limits limits, Admit admit);

  /// What comes begins with the hello, as in a WebSocket, where the subprotocol stands for the preamble.
  void skipPreamble() { preambleBytes_ = preamble_.size(); }
  /// Whether a whole preamble has come, of this version or another. The server then sends its own.
  bool preambleTaken() const { return preambleBytes_ == preamble_.size() && !isStrange_; }

  /// Takes bytes from the front until all are taken, or until paused() or over(). Throws Error if the client
  /// breaks the protocol or is refused: then the caller sends it the message and reads nothing more.
  void take(std::span<const std::byte>& bytes);

  /// True while too much waits to be sent or answered to read more. The caller asks again when something has
  /// been sent or answered.
  bool paused() const;
  /// True if the client has said bye or speaks another protocol. Then nothing more is sent.
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
  protocol::MessageReader reader_;
  std::shared_ptr<Session> session_;
  bool over_ = false, isStrange_ = false;  ///< isStrange_: the preamble is of no Galaxy
};

}  // namespace gxy
