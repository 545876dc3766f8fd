// SPDX-License-Identifier: Apache-2.0
// A server of one client that answers as a test says.
#pragma once
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "multiserver/protocol/handshake.h"
#include "multiserver/protocol/wire_message.h"

namespace gxy::test {

class StandIn {
 public:
  /// `answer`: the reply to a statement. Called on a thread of its own.
  explicit StandIn(std::function<std::string(std::string_view)> answer)
      : answer_(std::move(answer)), listening_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof where;
    auto* const address = reinterpret_cast<sockaddr*>(&where);
    if (::bind(listening_, address, size) != 0 || ::listen(listening_, 1) != 0 ||
        ::getsockname(listening_, address, &size) != 0)
      throw std::runtime_error("cannot listen");
    port_ = ntohs(where.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  /// After its client has gone.
  ~StandIn() {
    ::shutdown(listening_, SHUT_RDWR);
    thread_.join();
    ::close(listening_);
    if (client_ >= 0) ::close(client_);
  }
  StandIn(const StandIn&) = delete;
  StandIn& operator=(const StandIn&) = delete;

  uint16_t port() const { return port_; }
  /// Once the client is connected.
  void tell(std::string_view event) {
    send(protocol::textMessage(protocol::MessageChannel::Event, 0, event));
  }

 private:
  void send(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(client_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return;  // it has gone
      bytes = bytes.subspan(size_t(sent));
    }
  }
  void send(const protocol::WireMessage& frame) {
    const std::lock_guard lock(sending_);
    send(protocol::headerOf(frame));
    send(frame.payload);
  }
  void serve() {
    using protocol::MessageChannel;
    client_ = ::accept(listening_, nullptr, nullptr);
    if (client_ < 0) return;
    send(protocol::preamble());
    size_t preamble = protocol::kPreambleBytes;
    protocol::MessageReader reader(protocol::MessageReader::fromClient(1 << 20));
    std::array<std::byte, 4096> buffer;
    for (;;) {
      const ssize_t size = ::recv(client_, buffer.data(), buffer.size(), 0);
      if (size <= 0) return;
      std::span<const std::byte> bytes = std::span<const std::byte>(buffer).first(size_t(size));
      const size_t skipped = std::min(preamble, bytes.size());
      preamble -= skipped;
      bytes = bytes.subspan(skipped);
      while (!bytes.empty()) {
        const auto frame = reader.take(bytes);
        if (!frame) break;
        if (frame->channel == MessageChannel::Request)
          send(protocol::textMessage(MessageChannel::Reply, frame->id, answer_(frame->text())));
        else if (protocol::afterWord(frame->text(), "hello"))
          send(protocol::textMessage(MessageChannel::Control, 0, protocol::welcomeText({})));
      }
    }
  }

  const std::function<std::string(std::string_view)> answer_;
  const int listening_;
  int client_ = -1;
  uint16_t port_ = 0;
  std::mutex sending_;
  std::thread thread_;
};

}  // namespace gxy::test
