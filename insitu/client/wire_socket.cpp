// SPDX-License-Identifier: Apache-2.0
#include "insitu/client/wire_socket.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include "core/comm/error.h"

namespace gxy::insitu {

namespace {

bool wouldBlock() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

bool isOfThisMachine(const sockaddr& address) {
  if (address.sa_family == AF_INET)
    return (ntohl(reinterpret_cast<const sockaddr_in&>(address).sin_addr.s_addr) >> 24) == 127;
  return address.sa_family == AF_INET6 &&
         IN6_IS_ADDR_LOOPBACK(&reinterpret_cast<const sockaddr_in6&>(address).sin6_addr);
}

}  // namespace

WireSocket::WireSocket(const std::string& host, uint16_t port, protocol::Purpose purpose,
                       Interrupt& interrupt, Interrupt::Clock::time_point end)
    : where_(host + " port " + std::to_string(port)),
      reader_(purpose == protocol::Purpose::Data ? protocol::MessageReader::ofDataToSimulation()
                                                 : protocol::MessageReader::fromServer()) {
  try {
    connect(host, port, interrupt, end);
    const auto preamble = protocol::preamble(purpose);
    queue_.push_back({Bytes(preamble.begin(), preamble.end()), {}, 0});
    flush();
    std::array<std::byte, protocol::kPreambleBytes> theirs;
    for (size_t read = 0; read < theirs.size();) {
      wait(POLLIN, interrupt, end);
      const auto n = ::recv(socket_, theirs.data() + read, theirs.size() - read, 0);
      if (n == 0 || (n < 0 && !wouldBlock())) throw Error(where_ + " has closed the connection");
      read += size_t(std::max<ssize_t>(n, 0));
    }
    protocol::checkPreamble(theirs, purpose);
  } catch (...) {
    if (socket_ >= 0) ::close(socket_);
    throw;
  }
}

WireSocket::~WireSocket() { ::close(socket_); }

void WireSocket::connect(const std::string& host, uint16_t port, Interrupt& interrupt,
                         Interrupt::Clock::time_point end) {
  addrinfo hints{}, *list = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  if (const int failed = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &list))
    throw Error("cannot find host " + host + ": " + ::gai_strerror(failed));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> addresses(list, ::freeaddrinfo);
  int error = 0;
  for (const addrinfo* a = list; a; a = a->ai_next) {
    const auto now = Interrupt::Clock::now();
    error = connect(*a, interrupt, a->ai_next ? now + (end - now) / 2 : end);
    if (error == 0) return;
  }
  throw Error("cannot connect to " + where_ + ": " + std::strerror(error) + "; is a server running there?");
}

// Returns what is wrong, as errno; 0 if nothing is.
int WireSocket::connect(const addrinfo& address, Interrupt& interrupt, Interrupt::Clock::time_point end) {
  if (socket_ >= 0) ::close(socket_);
  socket_ =
      ::socket(address.ai_family, address.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, address.ai_protocol);
  if (socket_ < 0) return errno;
  loopback_ = isOfThisMachine(*address.ai_addr);
  // A connection on which nothing comes any more is given up after 45 s, whether something is under way or not.
  const int yes = 1, silent = 45000, idle = 15, between = 5, probes = 6;
  ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  ::setsockopt(socket_, IPPROTO_TCP, TCP_USER_TIMEOUT, &silent, sizeof silent);
  ::setsockopt(socket_, SOL_SOCKET, SO_KEEPALIVE, &yes, sizeof yes);
  ::setsockopt(socket_, IPPROTO_TCP, TCP_KEEPIDLE, &idle, sizeof idle);
  ::setsockopt(socket_, IPPROTO_TCP, TCP_KEEPINTVL, &between, sizeof between);
  ::setsockopt(socket_, IPPROTO_TCP, TCP_KEEPCNT, &probes, sizeof probes);
  int error = ::connect(socket_, address.ai_addr, address.ai_addrlen) == 0 ? 0 : errno;
  if (error != EINPROGRESS) return error;
  try {
    wait(POLLOUT, interrupt, end);
  } catch (const Error&) {
    return ETIMEDOUT;
  }
  socklen_t size = sizeof error;
  ::getsockopt(socket_, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

void WireSocket::wait(short events, Interrupt& interrupt, Interrupt::Clock::time_point end) {
  for (;;) {
    if (Interrupt::Clock::now() >= end) throw Error(where_ + " does not answer");
    std::array<pollfd, 2> sockets{pollfd{socket_, events, 0}, pollfd{}};
    interrupt.wait(sockets, end);
    if (sockets[0].revents != 0) return;
  }
}

void WireSocket::send(const protocol::WireMessage& message, std::span<const std::byte> borrowed) {
  const auto header = protocol::headerOf(message, borrowed.size());
  Bytes own(header.begin(), header.end());
  own.insert(own.end(), message.payload.begin(), message.payload.end());
  queue_.push_back({std::move(own), borrowed, 0});
}

void WireSocket::own() {
  for (Output& o : queue_) {
    o.own.insert(o.own.end(), o.borrowed.begin(), o.borrowed.end());
    o.borrowed = {};
  }
}

void WireSocket::flush() {
  while (!queue_.empty()) {
    Output& o = queue_.front();
    const bool inOwn = o.sent < o.own.size();
    const std::span<const std::byte> part =
        inOwn ? std::span<const std::byte>(o.own).subspan(o.sent) : o.borrowed.subspan(o.sent - o.own.size());
    const int flags = MSG_NOSIGNAL | (inOwn && !o.borrowed.empty() ? MSG_MORE : 0);
    const auto n = ::send(socket_, part.data(), part.size(), flags);
    if (n < 0 && wouldBlock()) return;
    if (n < 0) throw Error("the connection to " + where_ + " is lost: " + std::strerror(errno));
    o.sent += size_t(n);
    if (o.sent == o.size()) queue_.pop_front();
  }
}

void WireSocket::finish(Interrupt::Clock::time_point end) {
  for (;;) {
    flush();
    if (sent() && !std::exchange(finished_, true)) ::shutdown(socket_, SHUT_WR);
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - Interrupt::Clock::now()).count();
    if (left <= 0) return;
    pollfd socket{socket_, short(sent() ? POLLIN : POLLIN | POLLOUT), 0};
    ::poll(&socket, 1, int(left));
    const auto n = ::recv(socket_, buffer_.data(), buffer_.size(), 0);
    if (n == 0 || (n < 0 && !wouldBlock())) return;
  }
}

std::optional<protocol::WireMessage> WireSocket::receive() {
  for (;;) {
    if (!unread_.empty())
      if (auto message = reader_.take(unread_)) return message;
    const auto n = ::recv(socket_, buffer_.data(), buffer_.size(), 0);
    if (n < 0 && wouldBlock()) return std::nullopt;
    if (n < 0) throw Error("the connection to " + where_ + " is lost: " + std::strerror(errno));
    if (n == 0) throw Error(where_ + " has closed the connection");
    unread_ = std::span<const std::byte>(buffer_).first(size_t(n));
  }
}

protocol::WireMessage WireSocket::expect(Interrupt& interrupt, Interrupt::Clock::time_point end) {
  for (;;) {
    flush();
    if (auto message = receive()) return *std::move(message);
    wait(short(sent() ? POLLIN : POLLIN | POLLOUT), interrupt, end);
  }
}

}  // namespace gxy::insitu
