// SPDX-License-Identifier: Apache-2.0
// What a browser sends, byte by byte: requests over HTTP, and messages in a WebSocket.
#pragma once
#include <cstring>
#include <string>

#include "tests/multiserver/raw_client.h"

namespace gxy::test {

/// A text as bytes to send.
inline std::span<const std::byte> bytesIn(std::string_view text) { return std::as_bytes(std::span(text)); }

/// A request of a page of the server itself. `more` are further fields, each with its line end.
inline std::string webRequest(const std::string& target, const std::string& more = "",
                              const std::string& method = "GET", const std::string& host = "localhost:5001") {
  return method + " " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" + more + "\r\n";
}

/// The fields of a request for a WebSocket, from a page of this origin.
inline std::string upgradeFields(const std::string& origin = "http://localhost:5001") {
  return "Connection: keep-alive, Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: galaxy.1\r\n" +
         (origin.empty() ? "" : "Origin: " + origin + "\r\n");
}

/// One connection that reads answers.
class WebClient {
 public:
  explicit WebClient(uint16_t port, int receiveBuffer = 0) : raw_(port, receiveBuffer) {}

  struct Response {
    int status = 0;  ///< 0: the server has closed without an answer
    std::string head, body;
    bool has(const std::string& field) const { return head.find("\r\n" + field + "\r\n") != head.npos; }
  };

  bool send(std::string_view text) { return raw_.send(bytesIn(text)); }
  /// Reads an answer. That to HEAD, and 304, have no body, whatever length they tell.
  Response response(bool bodiless = false) {
    Response r;
    size_t end;
    while ((end = buffer_.find("\r\n\r\n")) == buffer_.npos)
      if (!more()) return r;
    r.head = buffer_.substr(0, end + 2);
    buffer_.erase(0, end + 4);
    r.status = std::stoi(r.head.substr(9, 3));
    const size_t at = r.head.find("\r\nContent-Length: ");
    const size_t size = bodiless || at == r.head.npos ? 0 : std::stoul(r.head.substr(at + 18));
    while (buffer_.size() < size)
      if (!more()) break;
    r.body = buffer_.substr(0, size);
    buffer_.erase(0, std::min(size, buffer_.size()));
    return r;
  }
  Response ask(const std::string& request, bool bodiless = false) {
    send(request);
    return response(bodiless);
  }
  bool closedByServer() { return raw_.closedByServer(); }
  RawClient& raw() { return raw_; }

 protected:
  /// Reads more into buffer_; false if nothing comes for a minute, or the server has closed.
  bool more() {
    std::array<std::byte, 65536> bytes;
    const size_t size = raw_.receive(bytes, 60000);
    buffer_.append(reinterpret_cast<const char*>(bytes.data()), size);
    return size > 0;
  }

  RawClient raw_;
  std::string buffer_;  ///< read and not used
};

/// A WebSocket; it has the functions of RawClient.
class WebSocketClient : public WebClient {
 public:
  explicit WebSocketClient(uint16_t port, int receiveBuffer = 0, const std::string& target = "/ws")
      : WebClient(port, receiveBuffer) {
    const Response r = ask(webRequest(target, upgradeFields()), true);
    if (r.status != 101) throw std::runtime_error("no WebSocket: " + r.head);
  }

  static constexpr int kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10;

  /// The bytes of one frame.
  static std::string frame(int opcode, std::string_view payload, bool last = true, bool masked = true) {
    std::string bytes{char(opcode | (last ? 0x80 : 0))};
    const auto bits = [&](int n) {
      for (int shift = n - 8; shift >= 0; shift -= 8) bytes += char(uint64_t(payload.size()) >> shift & 255);
    };
    const int mask = masked ? 0x80 : 0;
    if (payload.size() < 126) {
      bytes += char(mask | int(payload.size()));
    } else {
      const bool middle = payload.size() < 65536;
      bytes += char(mask | (middle ? 126 : 127));
      bits(middle ? 16 : 64);
    }
    constexpr std::array<char, 4> kMask{0x11, 0x22, 0x33, 0x44};
    if (masked) bytes.append(kMask.data(), kMask.size());
    const size_t at = bytes.size();
    bytes += payload;
    for (size_t i = 0; masked && i < payload.size(); i++) bytes[at + i] = char(bytes[at + i] ^ kMask[i % 4]);
    return bytes;
  }

  /// Header and payload of a message.
  static std::string bytesOf(const protocol::WireMessage& message) {
    const auto header = protocol::headerOf(message);
    std::string bytes(reinterpret_cast<const char*>(header.data()), header.size());
    return bytes.append(message.text());
  }

  bool send(const protocol::WireMessage& message) { return sendFrame(kBinary, bytesOf(message)); }
  bool sendFrame(int opcode, std::string_view payload, bool last = true, bool masked = true) {
    return WebClient::send(frame(opcode, payload, last, masked));
  }
  bool request(uint32_t id, const std::string& text) {
    return send(protocol::textMessage(protocol::MessageChannel::Request, id, text));
  }
  void greet(const std::string& tenant = "user") { hello({"", "raw", tenant}); }
  void hello(const protocol::Hello& hello) {
    send(protocol::textMessage(protocol::MessageChannel::Control, 0, protocol::helloText(hello)));
  }

  struct Frame {
    int opcode = -1;  ///< -1: the server has closed
    std::string payload;
  };
  Frame nextFrame() {
    const auto have = [this](size_t bytes) {
      while (buffer_.size() < bytes)
        if (!more()) return false;
      return true;
    };
    const auto number = [this](size_t at, size_t bytes) {
      uint64_t value = 0;
      for (size_t i = 0; i < bytes; i++) value = value << 8 | uint8_t(buffer_[at + i]);
      return value;
    };
    if (!have(2)) return {};
    const int opcode = buffer_[0] & 15, kind = buffer_[1];
    if ((buffer_[0] & 0x80) == 0 || kind < 0) throw std::runtime_error("a fragment, or a masked frame");
    const size_t wide = kind == 126 ? 2 : kind == 127 ? 8 : 0;
    if (!have(2 + wide)) return {};
    const size_t size = wide ? number(2, wide) : size_t(kind);
    if (!have(2 + wide + size)) return {};
    Frame frame{opcode, buffer_.substr(2 + wide, size)};
    buffer_.erase(0, 2 + wide + size);
    return frame;
  }

  /// As RawClient::readUntil(). Throws if a WebSocket message is not exactly one message.
  template <class Last>
  bool readUntil(const Last& last) {
    for (;;) {
      const Frame frame = nextFrame();
      if (frame.opcode == -1 || frame.opcode == kClose) return false;
      if (frame.opcode != kBinary) continue;
      protocol::MessageReader reader(protocol::MessageReader::fromServer());
      std::span<const std::byte> bytes = bytesIn(frame.payload);
      const auto message = reader.take(bytes);
      if (!message || !bytes.empty()) throw std::runtime_error("a WebSocket message that is not one message");
      if (message->channel == protocol::MessageChannel::Control && message->text().starts_with("ping"))
        send(protocol::textMessage(protocol::MessageChannel::Control, 0, "pong 0"));
      if (last(*message)) return true;
    }
  }

  /// Reads until the next control text that begins so; what follows it. "closed" if the server closes before.
  std::string awaitControl(std::string_view word) {
    std::string found = "closed";
    readUntil([&](const protocol::WireMessage& message) {
      const auto rest = protocol::afterWord(message.text(), word);
      if (message.channel == protocol::MessageChannel::Control && rest) found = *rest;
      return found != "closed";
    });
    return found;
  }
};

}  // namespace gxy::test
