// SPDX-License-Identifier: Apache-2.0
// The connection of one client, a program or a browser: reads bytes, writes messages, and finds out whether the client is
// still there.
#pragma once
#include <utility>  // Asio 1.74 forgets it under C++20

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
#include "multiserver/web/line.h"
#include "multiserver/web/opening.h"
#include "multiserver/web/web_line.h"

namespace gxy {

/// Time limits of a connection. A client that has not said hello after `handshake` is disconnected, and so is a browser
/// that asks for nothing for so long. After `ping` without a sign of life from the client, the server sends a ping; after
/// `silence`, it disconnects the client.
struct Patience {
  std::chrono::milliseconds handshake{5000}, ping{15000}, silence{45000};
};

/// A client's connection. It lives as long as one of its operations is under way or somebody holds it. All
/// functions are called on the thread of the socket's executor.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  using Socket = Line::Socket;
  using Clock = std::chrono::steady_clock;

  using Closed = std::function<void(const std::shared_ptr<Connection>&)>;

  struct Options {
    protocol::Limits limits;
    Patience patience;
    Outbox::Limits outbox;
  };

  /// `context` is the socket's. It is shared because sessions may post to it until their last task has ended. Without a
  /// site, browsers are disconnected.
  Connection(Socket socket, std::shared_ptr<boost::asio::io_context> context, ServerRank& serverRank,
             Options options, std::shared_ptr<const Site> site, Dialogue::Admit admit, Closed closed);

  void start();
  /// Sends the replies and events that wait, then `bye REASON`, and closes. Closes after a second in any case, and at once if
  /// the client has not begun to speak the protocol.
  void bye(const std::string& reason);
  /// Closes at once.
  void close();

  /// Null before the handshake. This and the following functions may be called after start().
  const std::shared_ptr<Session>& session() const { return dialogue_->session(); }
  Outbox& outbox() { return *outbox_; }
  uint64_t receivedBytes() const { return received_; }
  Clock::time_point begin() const { return begin_; }

 private:
  void listenFirst();
  void open(Opening opening);
  void serveBrowser();
  void browserIs(WebLine::State state);
  void greet();
  void read();
  void consume();
  void write();
  void watch();
  bool isTooLate(Clock::time_point now) const;
  void wake();

  const std::shared_ptr<boost::asio::io_context> context_;
  std::shared_ptr<Line> line_;
  boost::asio::steady_timer timer_;
  ServerRank& serverRank_;
  const Options options_;
  const std::shared_ptr<const Site> site_;
  const Dialogue::Admit admit_;
  const Closed onClosed_;
  std::shared_ptr<Outbox> outbox_;
  std::optional<Dialogue> dialogue_;

  const std::array<std::byte, protocol::kPreambleBytes> greeting_ = protocol::preamble();
  std::array<std::byte, 64 << 10> buffer_;
  std::span<const std::byte> unread_;  ///< part of buffer_
  std::array<std::byte, protocol::kHeaderBytes> header_{};
  protocol::WireMessage sent_;  ///< being written
  bool open_ = false;     ///< messages may be written: the preambles were exchanged, or there is a WebSocket
  bool browses_ = false;  ///< requests come over HTTP
  bool answering_ = false;  ///< an answer over HTTP is being sent
  bool reading_ = false, writing_ = false, leaving_ = false, closed_ = false;
  Clock::time_point heard_ = Clock::now(), asked_ = Clock::now();
  const Clock::time_point begin_ = Clock::now();
  Clock::time_point waits_ =
      begin_;  ///< since when the server waits for the handshake or a request over HTTP
  /// Bytes of control messages; and those of all other bytes that the client's machine has acknowledged.
  int64_t control_ = 0, acknowledged_ = 0;
  std::atomic<uint64_t> received_ = 0;
};

}  // namespace gxy
