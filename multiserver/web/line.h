// SPDX-License-Identifier: Apache-2.0
// How the bytes of one client come and go: over TCP as they are, or in a WebSocket.
#pragma once
#include <utility>  // Asio 1.74 forgets it under C++20

#include <boost/asio/ip/tcp.hpp>

#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace gxy {

/// All functions are called on the thread of the socket's executor, and so are the callbacks, never from
/// within the call that gave them. One read and one write may be under way at a time. What they read into or
/// write must stay until they are done; the line itself lives until then.
class Line {
 public:
  using Socket = boost::asio::ip::tcp::socket;
  using Done = std::function<void(boost::system::error_code, size_t bytes)>;

  virtual ~Line() = default;

  /// Reads some bytes of the client's messages; perhaps none, although nothing has failed.
  virtual void read(std::span<std::byte> into, Done done) = 0;
  /// Writes one message. Returns the number of bytes that the line sends for it.
  virtual size_t write(std::span<const std::byte> header, std::span<const std::byte> payload, Done done) = 0;
  /// The number of bytes that the system has accepted so far.
  virtual int64_t written() const = 0;
  /// Why a read has failed, where the client broke the rules of the line and is to be told so; else empty.
  virtual std::string violation() const { return {}; }
  /// Closes at once. What is under way fails.
  virtual void close() = 0;
  virtual Socket& socket() = 0;
};

}  // namespace gxy
