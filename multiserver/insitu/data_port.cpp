// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/data_port.h"

#include <netinet/tcp.h>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <mutex>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "core/comm/error.h"
#include "multiserver/protocol/handshake.h"

namespace gxy {

namespace asio = boost::asio;
using asio::ip::tcp;
using protocol::MessageChannel;
using protocol::MessageReader;
using protocol::WireMessage;

namespace {

constexpr std::chrono::seconds kHandshake(5);  // within which a connection says which stream it is of
constexpr size_t kHandshakes = 4096;           // connections without a stream; beyond it the oldest is closed
constexpr size_t kUnread =
    64 << 20;  // bytes that a simulation may leave unread before its connection is closed
// Bytes that are read where no payload is under way. So most of a long payload is read to where it stays.
constexpr size_t kReadBytes = 4096;
constexpr size_t kPayloadBytes = 1 << 20;  // and most bytes of a payload that are read at once

Bytes bytesOf(const WireMessage& message) {
  const auto header = protocol::headerOf(message);
  Bytes bytes(header.size() + message.payload.size());
  std::copy(header.begin(), header.end(), bytes.begin());
  std::copy(message.payload.begin(), message.payload.end(), bytes.begin() + std::ptrdiff_t(header.size()));
  return bytes;
}

// One connection. It lives as long as one of its operations is under way or somebody holds it. All but send() and bye() are
// called on the port's thread.
class Socket final : public DataLink, public std::enable_shared_from_this<Socket> {
 public:
  Socket(tcp::socket socket, std::shared_ptr<asio::io_context> context, const DataPort::Admit& admit)
      : context_(std::move(context)), socket_(std::move(socket)), timer_(*context_), admit_(admit) {}

  void start() {
    boost::system::error_code ignored;
    socket_.set_option(tcp::no_delay(true), ignored);
    socket_.set_option(asio::socket_base::keep_alive(true), ignored);
    // A machine from which nothing comes any more is given up after 45 s, whether something is under way or not.
    const int silent = 45000, idle = 15, between = 5, probes = 6;
    ::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_USER_TIMEOUT, &silent, sizeof silent);
    ::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_KEEPIDLE, &idle, sizeof idle);
    ::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_KEEPINTVL, &between, sizeof between);
    ::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_KEEPCNT, &probes, sizeof probes);
    const auto greeting = protocol::preamble(protocol::Purpose::Data);
    write(Bytes(greeting.begin(), greeting.end()));
    timer_.expires_after(kHandshake);
    timer_.async_wait([self = shared_from_this()](auto failed) {
      if (!failed && !self->taker_) self->close();
    });
    asio::async_read(socket_, asio::buffer(theirs_), [self = shared_from_this()](auto failed, size_t) {
      if (failed) return self->close();
      try {
        protocol::checkPreamble(self->theirs_, protocol::Purpose::Data);
      } catch (const Error&) {
        return self->close();
      }
      self->read();
    });
  }

  // What the port's thread posts is run after what another thread posts a moment later, so the order is kept here.
  void send(WireMessage message) override {
    {
      const std::lock_guard lock(sending_);
      unsent_.push_back(std::move(message));
    }
    asio::post(*context_, [weak = weak_from_this()] {
      if (const auto self = weak.lock()) self->writeUnsent();
    });
  }
  void bye(const std::string& reason) override {
    asio::post(*context_, [weak = weak_from_this(), reason] {
      if (const auto self = weak.lock()) self->leave(reason);
    });
  }

  // Sends what waits, then the reason, and closes.
  void leave(const std::string& reason) {
    if (closed_ || leaving_) return;
    writeUnsent();
    if (closed_) return;
    leaving_ = true;
    WireMessage message =
        protocol::textMessage(MessageChannel::Bye, 0, std::string_view(reason).substr(0, 4000));
    write(bytesOf(message));
    timer_.expires_after(std::chrono::seconds(1));  // Whoever does not read is closed all the same.
    timer_.async_wait([self = shared_from_this()](auto failed) {
      if (!failed) self->close();
    });
  }
  void close() { end("the server closes the connection", false); }
  bool admitted() const { return taker_ != nullptr; }
  std::function<void(const std::shared_ptr<Socket>&)> onClosed;

 private:
  void read() {
    if (closed_ || leaving_) return;
    const std::span<std::byte> payload = taker_ ? reader_.room(kPayloadBytes) : std::span<std::byte>();
    const bool isPayload = !payload.empty();
    buffer_.resize(taker_ ? kReadBytes : 256);
    reading_ = true;
    socket_.async_read_some(isPayload ? asio::buffer(payload.data(), payload.size()) : asio::buffer(buffer_),
                            [self = shared_from_this(), isPayload](auto failed, size_t size) {
                              self->hasRead(failed, size, isPayload);
                            });
  }

  void hasRead(const boost::system::error_code& failed, size_t size, bool isPayload) {
    reading_ = false;
    if (closed_) return;
    if (failed)
      return end(failed == asio::error::eof ? "the connection has ended without a word" : failed.message(),
                 false);
    if (leaving_) return discard();
    try {
      if (isPayload) {
        if (auto message = reader_.took(size)) take(*std::move(message));
      } else {
        consume(std::span<const std::byte>(buffer_).first(size));
      }
      read();
    } catch (const std::exception& e) {
      if (!taker_) return close();  // Whoever has no ticket gets no advice.
      failure_ = e.what();
      return leave(failure_);
    }
  }

  void consume(std::span<const std::byte> bytes) {
    while (!bytes.empty() && !closed_ && !leaving_)
      if (auto message = reader_.take(bytes)) take(*std::move(message));
  }

  void take(WireMessage message) {
    if (taker_) {
      if (message.channel == MessageChannel::Bye)
        return end(std::string(protocol::asLogged(message.text())), true);
      taker_->take(message);
      if (message.channel == MessageChannel::Piece) reader_.reuse(std::move(message.payload));
      return;
    }
    const std::shared_ptr<DataTaker> taker = admit_(insitu::readHello(message.payload), shared_from_this());
    if (!taker) return close();
    taker_ = taker;
    reader_.setRules(taker_->rules());
  }

  void writeUnsent() {
    std::vector<WireMessage> messages;
    {
      const std::lock_guard lock(sending_);
      messages.swap(unsent_);
    }
    for (const WireMessage& message : messages) write(bytesOf(message));
  }
  void write(Bytes bytes) {
    if (closed_) return;
    if (queued_ > kUnread) return end("the simulation does not read what it is told", false);
    queued_ += bytes.size();
    queue_.push_back(std::move(bytes));
    if (queue_.size() == 1) writeNext();
  }
  void writeNext() {
    asio::async_write(socket_, asio::buffer(queue_.front()),
                      [self = shared_from_this()](auto failed, size_t) {
                        if (failed) return self->end(failed.message(), false);
                        self->queued_ -= self->queue_.front().size();
                        self->queue_.pop_front();
                        if (!self->queue_.empty()) return self->writeNext();
                        if (self->leaving_) self->finish();
                      });
  }

  // Reads on without using it: to close with unread bytes would take the last words away from the other end.
  void finish() {
    boost::system::error_code ignored;
    socket_.shutdown(tcp::socket::shutdown_send, ignored);
    discard();
  }
  void discard() {
    if (reading_) return;  // consume() goes on with it
    reading_ = true;
    socket_.async_read_some(asio::buffer(buffer_), [self = shared_from_this()](auto failed, size_t) {
      self->reading_ = false;
      if (failed) return self->end("the stream has ended", false);
      self->discard();
    });
  }

  void end(const std::string& reason, bool regularly) {
    if (std::exchange(closed_, true)) return;
    boost::system::error_code ignored;
    timer_.cancel(ignored);
    // First: once the other end sees the connection closed, the stream knows that it has ended.
    if (taker_) taker_->ended(failure_.empty() ? reason : failure_, regularly);
    socket_.close(ignored);
    taker_ = nullptr;
    if (onClosed) onClosed(shared_from_this());
  }

  const std::shared_ptr<asio::io_context> context_;
  tcp::socket socket_;
  asio::steady_timer timer_;
  const DataPort::Admit& admit_;
  std::array<std::byte, protocol::kPreambleBytes> theirs_{};
  Bytes buffer_;
  MessageReader reader_{MessageReader::ofDataHello()};
  std::shared_ptr<DataTaker> taker_;  ///< null before the hello
  std::deque<Bytes> queue_;           ///< the first one is being written
  std::string failure_;               ///< why this end closes the connection
  size_t queued_ = 0;                 ///< bytes in queue_
  bool reading_ = false, leaving_ = false, closed_ = false;
  std::mutex sending_;
  std::vector<WireMessage> unsent_;  ///< guarded by sending_; in the order in which they are written
};

}  // namespace

class DataPort::Impl {
 public:
  Impl(const std::string& address, Admit admit)
      : admit_(std::move(admit)), acceptor_(*context_), retry_(*context_) {
    try {
      const tcp::endpoint where(asio::ip::make_address(address), 0);
      acceptor_.open(where.protocol());
      acceptor_.bind(where);
      acceptor_.listen();
      port_ = acceptor_.local_endpoint().port();
    } catch (const boost::system::system_error& e) {
      throw Error("cannot listen for simulations on " + address + ": " + e.code().message() +
                  "; expected an address of this machine");
    }
    accept();
    thread_ = std::thread([this] { context_->run(); });
  }
  ~Impl() {
    asio::post(*context_, [this] {
      boost::system::error_code ignored;
      acceptor_.close(ignored);
      retry_.cancel(ignored);
      for (const auto& socket : std::set(sockets_))
        socket->admitted() ? socket->leave("the server stops") : socket->close();
    });
    // The thread ends when the last operation has. A socket that does not take its last words has one second.
    thread_.join();
  }
  uint16_t port() const { return port_; }

 private:
  void accept() {
    acceptor_.async_accept([this](auto failed, tcp::socket socket) {
      if (!acceptor_.is_open()) return;
      if (failed) {
        retry_.expires_after(std::chrono::milliseconds(100));  // for instance, no descriptors are left
        return retry_.async_wait([this](auto cancelled) {
          if (!cancelled) accept();
        });
      }
      admitOne(std::move(socket));
      accept();
    });
  }
  void admitOne(tcp::socket socket) {
    std::erase_if(shaking_, [](const std::weak_ptr<Socket>& s) {
      const auto one = s.lock();
      return !one || one->admitted();
    });
    if (shaking_.size() >= kHandshakes)
      if (const auto oldest = shaking_.front().lock()) oldest->close();
    const auto one = std::make_shared<Socket>(std::move(socket), context_, admit_);
    one->onClosed = [this](const std::shared_ptr<Socket>& closed) { sockets_.erase(closed); };
    sockets_.insert(one);
    shaking_.push_back(one);
    one->start();
  }

  const Admit admit_;
  const std::shared_ptr<asio::io_context> context_ = std::make_shared<asio::io_context>(1);
  tcp::acceptor acceptor_;
  asio::steady_timer retry_;
  uint16_t port_ = 0;
  std::set<std::shared_ptr<Socket>> sockets_;  ///< used on the port's thread only, like the next
  std::deque<std::weak_ptr<Socket>> shaking_;  ///< those that may be without a stream, the oldest first
  std::thread thread_;
};

DataPort::DataPort(const std::string& address, Admit admit)
    : impl_(std::make_unique<Impl>(address, std::move(admit))) {}
DataPort::~DataPort() = default;
uint16_t DataPort::port() const { return impl_->port(); }

}  // namespace gxy
