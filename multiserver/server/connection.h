// SPDX-License-Identifier: Apache-2.0
// The socket of one client: bytes in, frames out, keep-alive.
#pragma once
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "multiserver/server/dialogue.h"

namespace gxy {

/// How patient the server is with its clients.
struct Patience {
  std::chrono::milliseconds handshake{5000}, ping{15000}, silence{45000};
};

/// Lives as long as one of its operations is under way, or somebody holds it. All but counters() run on the thread of its
/// executor.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  using Socket = boost::asio::ip::tcp::socket;
  using Clock = std::chrono::steady_clock;

  using Closed = std::function<void(const std::shared_ptr<Connection>&)>;

  struct Options {
    protocol::Limits limits;
    Patience patience;
    Outbox::Limits outbox;
  };

  /// `context`: the socket's. Sessions may have something to say until their last task has ended, so it is shared.
  Connection(Socket socket, std::shared_ptr<boost::asio::io_context> context, Node& node, Options options,
             Dialogue::Admit admit, Closed closed);

  void start();
  /// Says `bye REASON`, sends what control frames wait, and closes.
  void bye(const std::string& reason);
  /// At once.
  void close();

  /// Null before the handshake. This and what follows: once it has started.
  const std::shared_ptr<Session>& session() const { return dialogue_->session(); }
  Outbox& outbox() { return *outbox_; }
  uint64_t receivedBytes() const { return received_; }
  Clock::time_point begin() const { return begin_; }

 private:
  void greet();
  void read();
  void consume();
  void write();
  void watch();
  void wake();

  const std::shared_ptr<boost::asio::io_context> context_;
  Socket socket_;
  boost::asio::steady_timer timer_;
  Node& node_;
  const Options options_;
  const Dialogue::Admit admit_;
  const Closed onClosed_;
  std::shared_ptr<Outbox> outbox_;
  std::optional<Dialogue> dialogue_;

  const std::array<std::byte, protocol::kPreambleBytes> greeting_ = protocol::preamble();
  std::array<std::byte, 64 << 10> buffer_;
  std::span<const std::byte> unread_;  ///< of buffer_
  std::array<std::byte, protocol::kHeaderBytes> header_{};
  protocol::Frame writingFrame_;
  bool reading_ = false, writing_ = false, leaving_ = false, closed_ = false;
  Clock::time_point heard_ = Clock::now(), asked_ = Clock::now();
  const Clock::time_point begin_ = Clock::now();
  int64_t written_ = 0,
          acknowledged_ = 0;  ///< bytes, without control frames, which dead peers' systems take too
  std::atomic<uint64_t> received_ = 0;
};

}  // namespace gxy
