// SPDX-License-Identifier: Apache-2.0
#include "multiserver/protocol/frame.h"

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

bool hasId(FrameChannel channel) {
  return channel == FrameChannel::Request || channel == FrameChannel::Reply || channel == FrameChannel::File;
}

}  // namespace

Bytes bytesOf(std::string_view text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return Bytes(first, first + text.size());
}

Frame textFrame(FrameChannel channel, uint32_t id, std::string_view text) {
  return {channel, id, bytesOf(text)};
}

std::array<std::byte, kPreambleBytes> preamble() {
  std::array<std::byte, kPreambleBytes> bytes{};
  std::memcpy(bytes.data(), kMagic.data(), kMagic.size());
  put(bytes.data() + kMagic.size(), kVersion);
  return bytes;
}

void checkPreamble(std::span<const std::byte, kPreambleBytes> theirs) {
  if (std::memcmp(theirs.data(), kMagic.data(), kMagic.size()) != 0)
    throw Error(
        "preamble: the other side does not speak Galaxy's protocol, expected it to begin with GALAXY");
  const auto version = get<uint32_t>(theirs.data() + kMagic.size());
  if (version != kVersion)
    throw Error("preamble: protocol version " + std::to_string(version) + ", expected " +
                std::to_string(kVersion));
}

std::array<std::byte, kHeaderBytes> headerOf(const Frame& frame) {
  std::array<std::byte, kHeaderBytes> header{};
  put(header.data(), uint64_t(frame.payload.size()));
  put(header.data() + 8, uint16_t(frame.channel));
  put(header.data() + 12, frame.id);
  return header;
}

FrameReader::Rules FrameReader::fromClient(uint64_t requestBytes) {
  Rules rules;
  rules.most[size_t(FrameChannel::Control)] = 4096;
  rules.most[size_t(FrameChannel::Request)] = requestBytes;
  return rules;
}

FrameReader::Rules FrameReader::fromServer() {
  Rules rules;
  rules.most.fill(kMaxServerFrameBytes);
  rules.most[size_t(FrameChannel::Request)] = 0;
  return rules;
}

void FrameReader::readHeader() {
  length_ = get<uint64_t>(header_.data());
  const auto channel = get<uint16_t>(header_.data() + 8), zero = get<uint16_t>(header_.data() + 10);
  const auto id = get<uint32_t>(header_.data() + 12);
  if (channel >= rules_.most.size() || rules_.most[channel] == 0)
    throw Error("frame on channel " + std::to_string(channel) + ", on which none may come");
  if (length_ > rules_.most[channel])
    throw Error("frame of " + std::to_string(length_) + " bytes on channel " + std::to_string(channel) +
                ", expected at most " + std::to_string(rules_.most[channel]));
  if (zero != 0) throw Error("frame with " + std::to_string(zero) + " in its reserved bytes, expected 0");
  if ((id != 0) != hasId(FrameChannel(channel)))
    throw Error("frame with id " + std::to_string(id) + " on channel " + std::to_string(channel) +
                ", expected " + (id ? "0" : "one from 1 up"));
  frame_ = {FrameChannel(channel), id, {}};
  frame_.skipped = rules_.room && !rules_.room(length_);
  taken_ = 0;
}

std::optional<Frame> FrameReader::take(std::span<const std::byte>& bytes) {
  if (headerBytes_ < kHeaderBytes) {
    const size_t n = std::min(kHeaderBytes - headerBytes_, bytes.size());
    std::copy_n(bytes.begin(), n, header_.begin() + std::ptrdiff_t(headerBytes_));
    headerBytes_ += n;
    bytes = bytes.subspan(n);
    if (headerBytes_ < kHeaderBytes) return std::nullopt;
    readHeader();
  }
  const size_t n = size_t(std::min<uint64_t>(length_ - taken_, bytes.size()));
  if (!frame_.skipped)
    frame_.payload.insert(frame_.payload.end(), bytes.begin(), bytes.begin() + std::ptrdiff_t(n));
  taken_ += n;
  bytes = bytes.subspan(n);
  if (taken_ < length_) return std::nullopt;
  headerBytes_ = 0;
  return std::exchange(frame_, {});
}

}  // namespace gxy::protocol
