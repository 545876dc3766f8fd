// SPDX-License-Identifier: Apache-2.0
#include "multiserver/protocol/wire_message.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "core/comm/error.h"

namespace gxy::protocol {

static_assert(std::endian::native == std::endian::little, "integers go over the wire as they are in memory");

namespace {

template <class T>
T get(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

template <class T>
void put(std::byte* at, T value) {
  std::memcpy(at, &value, sizeof value);
}

bool hasId(MessageChannel channel) {
  return channel == MessageChannel::Request || channel == MessageChannel::Reply ||
         channel == MessageChannel::File;
}

}  // namespace

Bytes bytesOf(std::string_view text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return Bytes(first, first + text.size());
}

WireMessage textMessage(MessageChannel channel, uint32_t id, std::string_view text) {
  return {channel, id, bytesOf(text)};
}

std::array<std::byte, kPreambleBytes> preamble(Purpose purpose) {
  std::array<std::byte, kPreambleBytes> bytes{};
  std::memcpy(bytes.data(), kMagic.data(), kMagic.size());
  put(bytes.data() + kMagic.size(), kVersion);
  put(bytes.data() + kMagic.size() + sizeof kVersion, purpose);
  return bytes;
}

void checkPreamble(std::span<const std::byte, kPreambleBytes> theirs, Purpose purpose) {
  if (std::memcmp(theirs.data(), kMagic.data(), kMagic.size()) != 0)
    throw Error(
        "preamble: the other side does not speak Galaxy's protocol, expected it to begin with GALAXY");
  const auto version = get<uint32_t>(theirs.data() + kMagic.size());
  if (version != kVersion)
    throw Error("preamble: protocol version " + std::to_string(version) + ", expected " +
                std::to_string(kVersion));
  const auto found = get<uint32_t>(theirs.data() + kMagic.size() + sizeof version);
  if (found != uint32_t(purpose))
    throw Error("preamble: a connection for purpose " + std::to_string(found) + ", expected " +
                std::to_string(uint32_t(purpose)) + " at this port");
}

std::array<std::byte, kHeaderBytes> headerOf(const WireMessage& message, uint64_t more) {
  std::array<std::byte, kHeaderBytes> header{};
  put(header.data(), uint64_t(message.payload.size()) + more);
  put(header.data() + 8, uint16_t(message.channel));
  put(header.data() + 12, message.id);
  return header;
}

MessageReader::Rules MessageReader::fromClient(uint64_t requestBytes) {
  Rules rules;
  rules.most[size_t(MessageChannel::Control)] = 4096;
  rules.most[size_t(MessageChannel::Request)] = requestBytes;
  return rules;
}

MessageReader::Rules MessageReader::fromServer() {
  Rules rules;
  for (const auto channel : {MessageChannel::Control, MessageChannel::Reply, MessageChannel::Event,
                             MessageChannel::Pixels, MessageChannel::File})
    rules.most[size_t(channel)] = kMaxServerMessageBytes;
  return rules;
}

MessageReader::Rules MessageReader::ofDataToSimulation() {
  Rules rules;
  rules.most[size_t(MessageChannel::Plan)] = kMaxServerMessageBytes;
  rules.most[size_t(MessageChannel::DataControl)] = 64;
  rules.most[size_t(MessageChannel::Steer)] = rules.most[size_t(MessageChannel::Encode)] = 64 << 10;
  rules.most[size_t(MessageChannel::Bye)] = 4096;
  return rules;
}

MessageReader::Rules MessageReader::ofDataHello() {
  Rules rules;
  rules.most[size_t(MessageChannel::DataHello)] = 64;
  return rules;
}

MessageReader::Rules MessageReader::ofDataToRoot() {
  Rules rules = ofDataToOthers();
  rules.most[size_t(MessageChannel::Describe)] = uint64_t(64) << 20;  // the most blocks, 48 bytes each
  rules.most[size_t(MessageChannel::DataControl)] = 64;
  rules.most[size_t(MessageChannel::Step)] = 64;
  return rules;
}

MessageReader::Rules MessageReader::ofDataToOthers() {
  Rules rules;
  rules.most[size_t(MessageChannel::Piece)] = (uint64_t(1) << 20) + 64;
  rules.most[size_t(MessageChannel::Bye)] = 4096;
  return rules;
}

void MessageReader::readHeader() {
  length_ = get<uint64_t>(header_.data());
  const auto channel = get<uint16_t>(header_.data() + 8), zero = get<uint16_t>(header_.data() + 10);
  const auto id = get<uint32_t>(header_.data() + 12);
  if (channel >= rules_.most.size() || rules_.most[channel] == 0)
    throw Error("message on channel " + std::to_string(channel) + ", on which none may come");
  if (length_ > rules_.most[channel])
    throw Error("message of " + std::to_string(length_) + " bytes on channel " + std::to_string(channel) +
                ", expected at most " + std::to_string(rules_.most[channel]));
  if (zero != 0) throw Error("message with " + std::to_string(zero) + " in its reserved bytes, expected 0");
  if ((id != 0) != hasId(MessageChannel(channel)))
    throw Error("message with id " + std::to_string(id) + " on channel " + std::to_string(channel) +
                ", expected " + (id ? "0" : "one from 1 up"));
  message_ = {MessageChannel(channel), id, std::exchange(spare_, {})};
  message_.skipped = rules_.room && !rules_.room(length_);
  taken_ = 0;
}

void MessageReader::reuse(Bytes payload) { spare_ = std::move(payload); }

std::span<std::byte> MessageReader::room(size_t most) {
  if (headerBytes_ < kHeaderBytes || message_.skipped) return {};
  const auto n = size_t(std::min<uint64_t>(length_ - taken_, most));
  if (message_.payload.size() < taken_ + n) message_.payload.resize(size_t(taken_) + n);
  return std::span(message_.payload).subspan(size_t(taken_), n);
}

std::optional<WireMessage> MessageReader::took(size_t bytes) {
  taken_ += bytes;
  return complete();
}

std::optional<WireMessage> MessageReader::complete() {
  if (taken_ < length_) return std::nullopt;
  headerBytes_ = 0;
  message_.payload.resize(message_.skipped ? 0 : size_t(length_));
  return std::exchange(message_, {});
}

std::optional<WireMessage> MessageReader::take(std::span<const std::byte>& bytes) {
  if (headerBytes_ < kHeaderBytes) {
    const size_t n = std::min(kHeaderBytes - headerBytes_, bytes.size());
    std::copy_n(bytes.begin(), n, header_.begin() + std::ptrdiff_t(headerBytes_));
    headerBytes_ += n;
    bytes = bytes.subspan(n);
    if (headerBytes_ < kHeaderBytes) return std::nullopt;
    readHeader();
  }
  const size_t n = size_t(std::min<uint64_t>(length_ - taken_, bytes.size()));
  if (!message_.skipped) std::copy_n(bytes.begin(), n, room(n).begin());
  bytes = bytes.subspan(n);
  return took(n);
}

}  // namespace gxy::protocol
