// SPDX-License-Identifier: Apache-2.0
// Messages of the protocol: a header of 16 bytes and a payload (docs/protocol.md, section 2). This code
// uses no sockets.
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
inline constexpr uint64_t kMaxServerMessageBytes = uint64_t(1) << 30;

enum class MessageChannel : uint16_t {
  Control = 0,
  Request = 1,
  Reply = 2,
  Event = 3,
  Pixels = 4,
  File = 5,
  // The data connections of simulations (insitu/plan/records.h).
  DataHello = 16,
  Describe = 17,
  Plan = 18,
  DataControl = 19,
  Step = 20,
  Piece = 21,
  Steer = 22,
  Bye = 23,  ///< the reason why a data connection ends, as text
  Encode = 24,
};

/// What a connection is for. It stands in the preamble.
enum class Purpose : uint32_t { Client = 0, Data = 1 };

struct WireMessage {
  MessageChannel channel = MessageChannel::Control;
  uint32_t id = 0;  ///< id of the request on channels 1, 2 and 5; else 0
  Bytes payload;
  bool skipped = false;  ///< Rules::room refused the payload, so it was discarded

  /// The payload as text.
  std::string_view text() const { return {reinterpret_cast<const char*>(payload.data()), payload.size()}; }
};

/// Returns a text as bytes.
Bytes bytesOf(std::string_view text);
WireMessage textMessage(MessageChannel channel, uint32_t id, std::string_view text);

std::array<std::byte, kPreambleBytes> preamble(Purpose purpose = Purpose::Client);
/// Throws Error if the magic, the version or the purpose is another.
void checkPreamble(std::span<const std::byte, kPreambleBytes> theirs, Purpose purpose = Purpose::Client);

/// Returns the header of a message whose payload goes on with `more` bytes that stand elsewhere.
std::array<std::byte, kHeaderBytes> headerOf(const WireMessage& message, uint64_t more = 0);

/// Cuts a stream of bytes into messages. It allocates memory for the bytes of the current message that have come or that room()
/// was asked for, never for the size that its header announces. One thread at a time may use it.
class MessageReader {
 public:
  /// The messages that are accepted. Only messages on channels that have ids may have an id other than 0.
  struct Rules {
    std::array<uint64_t, 25> most{};       ///< largest payload in bytes, by channel; 0: no messages
    std::function<bool(uint64_t)> room{};  ///< whether a payload of this size may be kept; empty: always
  };
  static Rules fromClient(uint64_t requestBytes);
  static Rules fromServer();
  /// What a server says on a data connection, and what a simulation does: before its hello is known, and then to rank 0 and to
  /// the other ranks.
  static Rules ofDataToSimulation();
  static Rules ofDataHello();
  static Rules ofDataToRoot();
  static Rules ofDataToOthers();

  explicit MessageReader(Rules rules) : rules_(std::move(rules)) {}

  /// Sets other rules from the next message on.
  void setRules(Rules rules) { rules_ = std::move(rules); }

  /// Takes bytes from the front of `bytes`. Returns a message as soon as one is complete, or nothing when all
  /// bytes have been taken. Throws Error if a header breaks the rules; the reader must not be used afterwards.
  std::optional<WireMessage> take(std::span<const std::byte>& bytes);
  /// Returns where the next bytes of the payload that is under way may be read to, at most `most` of them, so that they need not be
  /// copied. It is empty if a header comes next, or if the payload is not kept. Valid until the next call.
  std::span<std::byte> room(size_t most);
  /// Takes bytes that have been read to the front of room(). Returns the message if it is complete.
  std::optional<WireMessage> took(size_t bytes);
  /// Takes the memory of a payload back, for the next message.
  void reuse(Bytes payload);

 private:
  void readHeader();
  std::optional<WireMessage> complete();

  Rules rules_;
  std::array<std::byte, kHeaderBytes> header_{};
  size_t headerBytes_ = 0;
  uint64_t length_ = 0, taken_ = 0;
  WireMessage message_;  ///< its payload may be longer than taken_, and is cut to length_ in the end
  Bytes spare_;          ///< memory for the next payload
};

}  // namespace gxy::protocol
