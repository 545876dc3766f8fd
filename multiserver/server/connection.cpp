// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/connection.h"

#include <linux/sockios.h>
#include <netinet/tcp.h>
#include <sys/ioctl.h>

#include <boost/asio/post.hpp>

#include <algorithm>

#include "core/comm/error.h"
#include "multiserver/protocol/json.h"
#include "multiserver/web/tcp_line.h"

namespace gxy {

namespace asio = boost::asio;
using protocol::MessageChannel;

namespace {

constexpr int kSendBuffer = 256 << 10;  // Twice the need of 20 Mbit/s and 40 ms. More would only add latency.
// Bytes that the system accepts before it sends them. The Outbox can no longer drop these.
constexpr int kUnsent = 64 << 10;

}  // namespace

Connection::Connection(Socket socket, std::shared_ptr<asio::io_context> context, ServerRank& serverRank,
                       Options options, std::shared_ptr<const Site> site, Dialogue::Admit admit,
                       Closed closed)
    : context_(std::move(context)),
      line_(makeTcpLine(std::move(socket))),
      timer_(*context_),
      serverRank_(serverRank),
      options_(options),
      site_(std::move(site)),
      admit_(std::move(admit)),
      onClosed_(std::move(closed)) {}

void Connection::start() {
  Socket& socket = line_->socket();
  boost::system::error_code ignored;
  socket.set_option(asio::ip::tcp::no_delay(true), ignored);
  socket.set_option(asio::socket_base::send_buffer_size(kSendBuffer), ignored);
  ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsent, sizeof kUnsent);
  // A machine that acknowledges nothing, not even pings, is gone.
  const auto gone = unsigned(options_.patience.silence.count());
  ::setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_USER_TIMEOUT, &gone, sizeof gone);
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
  listenFirst();
  watch();
}

// Reads until it is clear what the client speaks.
void Connection::listenFirst() {
  reading_ = true;
  const size_t had = unread_.size();
  const auto into = std::span(buffer_).subspan(had, protocol::kPreambleBytes - had);
  line_->read(into, [self = shared_from_this(), had](auto failed, size_t size) {
    self->reading_ = false;
    if (failed) return self->close();
    self->heard_ = Clock::now();
    self->received_ += size;
    self->unread_ = std::span<const std::byte>(self->buffer_).first(had + size);
    const Opening opening = openingOf(self->unread_);
    if (opening == Opening::Unknown) return self->listenFirst();
    self->open(opening);
  });
}

void Connection::open(Opening opening) {
  if (closed_) return;
  if (opening == Opening::Galaxy) return consume();
  if (opening == Opening::Web && site_) return serveBrowser();
  close();
}

void Connection::serveBrowser() {
  browses_ = true;
  const auto line = makeWebLine(std::move(line_->socket()), site_, std::exchange(unread_, {}));
  line_ = line;
  line->serve([weak = weak_from_this()](WebLine::State state) {
    if (const auto self = weak.lock()) self->browserIs(state);
  });
}

void Connection::browserIs(WebLine::State state) {
  if (closed_) return;
  if (state == WebLine::State::Ended) return close();
  answering_ = state == WebLine::State::Answers;
  waits_ = heard_ = Clock::now();
  if (state != WebLine::State::Upgraded) return;
  browses_ = false;
  dialogue_->skipPreamble();
  open_ = true;
  read();
}

void Connection::read() {
  if (reading_ || browses_ || closed_ || leaving_ || dialogue_->paused()) return;
  if (!unread_.empty()) return consume();
  reading_ = true;
  line_->read(buffer_, [self = shared_from_this()](auto failed, size_t size) {
    self->reading_ = false;
    if (failed && !self->line_->violation().empty()) return self->bye(self->line_->violation());
    if (failed) return self->close();
    self->heard_ = Clock::now();
    self->received_ += size;
    self->unread_ = std::span<const std::byte>(self->buffer_).first(size);
    self->consume();
  });
}

void Connection::consume() {
  if (closed_ || leaving_) return;
  std::string wrong;
  try {
    dialogue_->take(unread_);
  } catch (const std::exception& e) {
    wrong = e.what();
  }
  if (!open_ && dialogue_->preambleTaken()) greet();
  if (!wrong.empty()) return bye(wrong);
  if (dialogue_->over()) return close();
  // A direct call would grow the stack with each read.
  asio::post(*context_, [self = shared_from_this()] { self->read(); });
}

void Connection::greet() {
  open_ = writing_ = true;
  line_->write(greeting_, {}, [self = shared_from_this()](auto failed, size_t) {
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
  if (writing_ || closed_ || !open_) return;
  writing_ = true;
  auto message = outbox_->next();
  if (!message) {
    writing_ = false;
    if (leaving_) close();
    return;
  }
  sent_ = *std::move(message);
  header_ = protocol::headerOf(sent_);
  const size_t bytes = line_->write(header_, sent_.payload, [self = shared_from_this()](auto failed, size_t) {
    self->writing_ = false;
    self->sent_ = {};
    if (failed) return self->close();
    self->wake();
  });
  if (sent_.channel == MessageChannel::Control) control_ += int64_t(bytes);
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
    if (self->isTooLate(now)) return self->close();
    // A slow reader may answer a ping late, but its machine keeps acknowledging bytes. A dead machine
    // acknowledges nothing.
    int underWay = 0;
    if (ioctl(self->line_->socket().native_handle(), SIOCOUTQ, &underWay) == 0) {
      const int64_t taken = self->line_->written() - self->control_ - underWay;
      if (taken > self->acknowledged_) {
        self->acknowledged_ = taken;
        self->heard_ = now;
      }
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

bool Connection::isTooLate(Clock::time_point now) const {
  return !session() && !answering_ && now > waits_ + options_.patience.handshake;
}

void Connection::bye(const std::string& reason) {
  if (closed_ || leaving_) return;
  if (!open_) return close();
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
  line_->close();
  outbox_->close();
  onClosed_(shared_from_this());
}

}  // namespace gxy
