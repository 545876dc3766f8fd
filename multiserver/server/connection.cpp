// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/connection.h"

#include <linux/sockios.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>

#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include <algorithm>

#include "core/comm/error.h"
#include "multiserver/protocol/json.h"

namespace gxy {

namespace asio = boost::asio;
using protocol::MessageChannel;

namespace {

constexpr int kSendBuffer = 256 << 10;  // Twice the need of 20 Mbit/s and 40 ms. More would only add latency.
// Bytes that the system accepts before it sends them. The Outbox can no longer drop these.
constexpr int kUnsent = 64 << 10;

}  // namespace

Connection::Connection(Socket socket, std::shared_ptr<asio::io_context> context, ServerRank& serverRank,
                       Options options, Dialogue::Admit admit, Closed closed)
    : context_(std::move(context)),
      socket_(std::move(socket)),
      timer_(socket_.get_executor()),
      serverRank_(serverRank),
      options_(options),
      admit_(std::move(admit)),
      onClosed_(std::move(closed)) {}

void Connection::start() {
  boost::system::error_code ignored;
  socket_.set_option(asio::ip::tcp::no_delay(true), ignored);
  socket_.set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
  ::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsent, sizeof kUnsent);
  // A machine that acknowledges nothing, not even pings, is gone.
  const auto gone = unsigned(options_.patience.silence.count());
  ::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_USER_TIMEOUT, &gone, sizeof gone);
  // Makes a function that calls `action` on the sockets' thread, as long as the connection lives.
  const auto later = [weak = weak_from_this(), context = context_](void (Connection::*action)()) {
    return [weak, context, action] {
      asio::post(*context, [weak, action] {
        if (const auto self = weak.lock()) (self.get()->*action)();
      });
    };
  };
  outbox_ = std::make_shared<Outbox>(options_.outbox, later(&Connection::wake),
                                     serverRank_.ledger.enter("server", "to be sent", 0));
  dialogue_.emplace(
      outbox_, options_.limits,
      [this, answered = later(&Connection::read)](
          const protocol::Hello& hello, const std::shared_ptr<Outbox>& outbox, protocol::Welcome& welcome) {
        auto session = admit_(hello, outbox, welcome);
        session->onAnswered = answered;
        outbox->chargeTo(serverRank_.ledger.enter(session->tenant(), "to be sent", 0));
        return session;
      });
  greet();
  read();
  watch();
}

void Connection::read() {
  if (reading_ || closed_ || leaving_ || dialogue_->paused()) return;
  if (!unread_.empty()) return consume();
  reading_ = true;
  socket_.async_read_some(asio::buffer(buffer_), [self = shared_from_this()](auto failed, size_t size) {
    self->reading_ = false;
    if (failed) return self->close();
    self->heard_ = Clock::now();
    self->received_ += size;
    self->unread_ = std::span<const std::byte>(self->buffer_).first(size);
    self->consume();
  });
}

void Connection::consume() {
  if (closed_ || leaving_) return;
  try {
    dialogue_->take(unread_);
  } catch (const std::exception& e) {
    return bye(e.what());
  }
  if (dialogue_->over()) return close();
  // A direct call would grow the stack with each read.
  asio::post(socket_.get_executor(), [self = shared_from_this()] { self->read(); });
}

void Connection::greet() {
  writing_ = true;
  asio::async_write(socket_, asio::buffer(greeting_), [self = shared_from_this()](auto failed, size_t) {
    self->writing_ = false;
    if (failed) return self->close();
    self->write();
  });
}

void Connection::wake() {
  write();
  read();
}

void Connection::write() {
  if (writing_ || closed_) return;
  writing_ = true;
  auto message = outbox_->next();
  if (!message) {
    writing_ = false;
    if (leaving_) close();
    return;
  }
  sent_ = *std::move(message);
  header_ = protocol::headerOf(sent_);
  const bool control = sent_.channel == MessageChannel::Control;
  const std::array<asio::const_buffer, 2> parts{asio::buffer(header_), asio::buffer(sent_.payload)};
  const auto wrote = [this, control, before = written_](auto failed, size_t size) {
    if (!control) written_ = before + int64_t(size);
    return asio::transfer_all()(failed, size);
  };
  asio::async_write(socket_, parts, wrote, [self = shared_from_this()](auto failed, size_t) {
    self->writing_ = false;
    self->sent_ = {};
    if (failed) return self->close();
    self->wake();
  });
}

// Checks at intervals whether the client has completed the handshake and is still there.
void Connection::watch() {
  const auto soon =
      std::min({options_.patience.handshake, options_.patience.ping, options_.patience.silence}) / 4;
  timer_.expires_after(std::max(soon, std::chrono::milliseconds(10)));
  timer_.async_wait([self = shared_from_this()](auto failed) {
    if (failed || self->closed_) return;
    const auto now = Clock::now();
    const Patience& patience = self->options_.patience;
    if (!self->session() && now > self->begin_ + patience.handshake) return self->close();
    // A slow reader may answer a ping late, but its machine keeps acknowledging bytes. A dead machine
    // acknowledges nothing.
    int underWay = 0;
    if (ioctl(self->socket_.native_handle(), SIOCOUTQ, &underWay) == 0 &&
        self->written_ - underWay > self->acknowledged_) {
      self->acknowledged_ = self->written_ - underWay;
      self->heard_ = now;
    }
    // While no more requests are read from a client, its pongs are not read either.
    const bool unread = self->session() && self->session()->full() && !self->outbox_->aboveWatermark();
    if (unread) self->heard_ = now;
    if (now > self->heard_ + patience.silence) return self->close();
    const auto last = unread ? self->asked_ : std::max(self->heard_, self->asked_);
    if (self->session() && now > last + patience.ping) {
      self->asked_ = now;
      self->outbox_->control("ping 0");
    }
    self->watch();
  });
}

void Connection::bye(const std::string& reason) {
  if (closed_ || leaving_) return;
  leaving_ = true;
  outbox_->farewell("bye " + protocol::printable(reason));
  write();
  // A client that has not read everything after a second will not do so.
  timer_.expires_after(std::chrono::seconds(1));
  timer_.async_wait([self = shared_from_this()](auto failed) {
    if (!failed) self->close();
  });
}

void Connection::close() {
  if (std::exchange(closed_, true)) return;
  boost::system::error_code ignored;
  timer_.cancel(ignored);
  socket_.shutdown(Socket::shutdown_both, ignored);
  socket_.close(ignored);
  outbox_->close();
  onClosed_(shared_from_this());
}

}  // namespace gxy
