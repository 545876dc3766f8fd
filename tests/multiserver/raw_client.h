// SPDX-License-Identifier: Apache-2.0
// A connection that says whatever bytes a test wants.
#pragma once
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "multiserver/protocol/handshake.h"
#include "multiserver/protocol/pixel_record.h"
#include "multiserver/protocol/wire_message.h"

namespace gxy::test {

class RawClient {
 public:
  /// `receiveBuffer` > 0 makes the system keep no more than about that.
  explicit RawClient(uint16_t port, int receiveBuffer = 0) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (receiveBuffer) ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receiveBuffer, sizeof receiveBuffer);
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_port = htons(port);
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&where), sizeof where) != 0)
      throw std::runtime_error("cannot connect");
  }
  ~RawClient() {
    if (socket_ >= 0) ::close(socket_);
  }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  /// Closes with a reset, as a process that is killed with unread data does.
  void reset() {
    const linger none{1, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &none, sizeof none);
    ::close(socket_);
    socket_ = -1;
  }

  /// Sends until there has been no room for so long; false if not all is sent.
  bool send(std::span<const std::byte> bytes, int milliseconds = 100) {
    while (!bytes.empty()) {
      pollfd ready{socket_, POLLOUT, 0};
      if (::poll(&ready, 1, milliseconds) <= 0) return false;
      const ssize_t n = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (n <= 0) return false;
      bytes = bytes.subspan(size_t(n));
    }
    return true;
  }
  bool send(const protocol::WireMessage& frame, int milliseconds = 100) {
    return send(protocol::headerOf(frame), milliseconds) && send(frame.payload, milliseconds);
  }
  bool request(uint32_t id, const std::string& text) {
    return send(protocol::textMessage(protocol::MessageChannel::Request, id, text));
  }

  /// Preamble and hello, without waiting for the answer.
  void greet(const std::string& tenant = "user") {
    send(protocol::preamble());
    send(protocol::textMessage(protocol::MessageChannel::Control, 0,
                               protocol::helloText({"", "raw", tenant})));
  }

  /// Tells the server that nothing more comes.
  void endOfInput() { ::shutdown(socket_, SHUT_WR); }

  /// Bytes that come within the time; 0: none, or the end.
  size_t receive(std::span<std::byte> into, int milliseconds) {
    pollfd ready{socket_, POLLIN, 0};
    if (::poll(&ready, 1, milliseconds) <= 0) return 0;
    const ssize_t n = ::recv(socket_, into.data(), into.size(), 0);
    return n > 0 ? size_t(n) : 0;
  }

  /// Reads until the server closes; false if it has not after ten seconds.
  bool closedByServer() {
    std::array<std::byte, 65536> buffer;
    for (int i = 0; i < 100; i++) {
      pollfd ready{socket_, POLLIN, 0};
      if (::poll(&ready, 1, 100) <= 0) continue;
      if (::recv(socket_, buffer.data(), buffer.size(), 0) <= 0) return true;
    }
    return false;
  }

  /// Reads from the first byte on, and answers pings, until `last` says so of a frame; false if nothing more comes for a
  /// minute.
  template <class Last>
  bool readUntil(const Last& last) {
    std::vector<std::byte> buffer(65536);
    size_t preamble = protocol::kPreambleBytes;
    protocol::MessageReader reader(protocol::MessageReader::fromServer());
    for (;;) {
      const size_t size = receive(buffer, 60000);
      if (size == 0) return false;
      std::span<const std::byte> bytes = std::span<const std::byte>(buffer).first(size);
      const size_t skipped = std::min(preamble, bytes.size());
      preamble -= skipped;
      bytes = bytes.subspan(skipped);
      while (!bytes.empty()) {
        const auto frame = reader.take(bytes);
        if (!frame) break;
        if (frame->channel == protocol::MessageChannel::Control && frame->text().starts_with("ping"))
          send(protocol::textMessage(protocol::MessageChannel::Control, 0, "pong 0"));
        if (last(*frame)) return true;
      }
    }
  }

  /// Reads until so many replies and ends of frames have come: what went wrong, or nothing. A minute at most.
  std::string repliesAndEnds(size_t replies, size_t ends) {
    std::string wrong;
    const bool all = readUntil([&](const protocol::WireMessage& frame) {
      if (frame.channel == protocol::MessageChannel::Reply) {
        if (!frame.text().starts_with("ok")) wrong = frame.text();
        replies--;
      }
      ends -= isEnd(frame);
      return !wrong.empty() || (replies == 0 && ends == 0);
    });
    return all ? wrong : "nothing more comes, though not all has come";
  }
  static bool isEnd(const protocol::WireMessage& frame) {
    return frame.channel == protocol::MessageChannel::Pixels &&
           protocol::pixelHeader(frame.payload).kind == protocol::PixelKind::EndOfFrame;
  }

 private:
  int socket_;
};

}  // namespace gxy::test
