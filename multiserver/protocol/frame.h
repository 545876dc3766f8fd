// SPDX-License-Identifier: Apache-2.0
// Frames: a header of 16 bytes and a payload. docs/protocol.md section 2. No sockets here.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/comm/transport.h"

namespace gxy::protocol {

inline constexpr uint32_t kVersion = 1;
inline constexpr std::array<unsigned char, 8> kMagic{'G', 'A', 'L', 'A', 'X', 'Y', '\r', '\n'};
inline constexpr size_t kPreambleBytes = 16, kHeaderBytes = 16;
inline constexpr uint64_t kMaxHelloBytes = 64 << 10;
inline constexpr uint64_t kMaxServerFrameBytes = uint64_t(1) << 30;

enum class FrameChannel : uint16_t { Control = 0, Request = 1, Reply = 2, Event = 3, Pixels = 4, File = 5 };

struct Frame {
  FrameChannel channel = FrameChannel::Control;
  uint32_t id = 0;  ///< of the request on channels 1, 2 and 5
  Bytes payload;
  bool skipped = false;  ///< there was no room for its payload, so it is not here

  /// The payload as text.
  std::string_view text() const { return {reinterpret_cast<const char*>(payload.data()), payload.size()}; }
};

/// Bytes of a text.
Bytes bytesOf(std::string_view text);
Frame textFrame(FrameChannel channel, uint32_t id, std::string_view text);

std::array<std::byte, kPreambleBytes> preamble();
/// Throws Error where the magic or the version is another.
void checkPreamble(std::span<const std::byte, kPreambleBytes> theirs);

std::array<std::byte, kHeaderBytes> headerOf(const Frame& frame);

/// Cuts a stream of bytes into frames. Memory: what has come of the frame under way, never what its header announces.
class FrameReader {
 public:
  /// Which frames may come. An id other than 0 may come with channels that have ids only.
  struct Rules {
    std::array<uint64_t, 6> most{};        ///< bytes of payload by channel; 0: none may come on it
    std::function<bool(uint64_t)> room{};  ///< whether a payload of so many bytes may be kept; empty: always
  };
  static Rules fromClient(uint64_t requestBytes);
  static Rules fromServer();

  explicit FrameReader(Rules rules) : rules_(std::move(rules)) {}

  /// Other rules, from the next frame on.
  void setRules(Rules rules) { rules_ = std::move(rules); }

  /// Takes bytes off the front of `bytes`; a frame when one is complete, nothing when all have been taken. Throws Error
  /// when a header breaks the rules; the reader is of no use afterwards.
  std::optional<Frame> take(std::span<const std::byte>& bytes);

 private:
  void readHeader();

  Rules rules_;
  std::array<std::byte, kHeaderBytes> header_{};
  size_t headerBytes_ = 0;
  uint64_t length_ = 0, taken_ = 0;
  Frame frame_;
};

}  // namespace gxy::protocol
