// SPDX-License-Identifier: Apache-2.0
// A TCP connection that sends and receives messages and never blocks.
#pragma once
#include <netdb.h>

#include <array>
#include <deque>
#include <optional>
#include <span>
#include <string>

#include "insitu/client/interrupt.h"
#include "multiserver/protocol/wire_message.h"

namespace gxy::insitu {

/// One thread uses it. Functions throw Error once the connection is lost. SIGPIPE is never raised.
class WireSocket {
 public:
  /// Connects and exchanges preambles. Throws Error, with advice, if that fails or is not done at time `end`, and Closing.
  WireSocket(const std::string& host, uint16_t port, protocol::Purpose purpose, Interrupt& interrupt,
             Interrupt::Clock::time_point end);
  ~WireSocket();
  WireSocket(const WireSocket&) = delete;
  WireSocket& operator=(const WireSocket&) = delete;

  int descriptor() const { return socket_; }
  bool isLoopback() const { return loopback_; }

  /// Queues a message. `borrowed` is sent behind its payload as a part of it. It is read until it is sent, or until own().
  void send(const protocol::WireMessage& message, std::span<const std::byte> borrowed = {});
  /// Copies what is left to send of borrowed memory.
  void own();
  /// Sends what the connection takes now.
  void flush();
  bool sent() const { return queue_.empty(); }
  /// Sends the rest, says that nothing follows, and waits for the other end to close, until time `end` at most.
  void finish(Interrupt::Clock::time_point end);

  /// Receives what there is. Returns the next message, if one is complete.
  std::optional<protocol::WireMessage> receive();
  /// Waits for the next message.
  protocol::WireMessage expect(Interrupt& interrupt, Interrupt::Clock::time_point end);

 private:
  struct Output {
    Bytes own;
    std::span<const std::byte> borrowed;
    size_t sent = 0;
    size_t size() const { return own.size() + borrowed.size(); }
  };
  void connect(const std::string& host, uint16_t port, Interrupt& interrupt,
               Interrupt::Clock::time_point end);
  int connect(const addrinfo& address, Interrupt& interrupt, Interrupt::Clock::time_point end);
  void wait(short events, Interrupt& interrupt, Interrupt::Clock::time_point end);

  int socket_ = -1;
  bool loopback_ = false, finished_ = false;
  std::string where_;
  std::deque<Output> queue_;
  protocol::MessageReader reader_;
  std::array<std::byte, 64 << 10> buffer_;
  std::span<const std::byte> unread_;
};

}  // namespace gxy::insitu
