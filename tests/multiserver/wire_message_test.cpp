// SPDX-License-Identifier: Apache-2.0
#include "multiserver/protocol/wire_message.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "core/comm/error.h"
#include "multiserver/protocol/handshake.h"
#include "multiserver/protocol/json.h"
#include "multiserver/protocol/pixel_record.h"

namespace gxy::protocol {
namespace {

Bytes wire(const WireMessage& message) {
  const auto header = headerOf(message);
  Bytes bytes(header.size() + message.payload.size());
  std::copy(header.begin(), header.end(), bytes.begin());
  std::copy(message.payload.begin(), message.payload.end(), bytes.begin() + std::ptrdiff_t(header.size()));
  return bytes;
}

TEST(WireMessages, HaveTheBytesThatTheProtocolSays) {
  const Bytes bytes = wire(textMessage(MessageChannel::Request, 0x01020304, "list"));
  const unsigned char expected[] = {4, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 4, 3, 2, 1, 'l', 'i', 's', 't'};
  ASSERT_EQ(bytes.size(), sizeof expected);
  EXPECT_EQ(std::memcmp(bytes.data(), expected, sizeof expected), 0);
  const unsigned char hello[] = {0x47, 0x41, 0x4C, 0x41, 0x58, 0x59, 0x0D, 0x0A, 1, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(std::memcmp(preamble().data(), hello, sizeof hello), 0);
}

TEST(WireMessages, ComeOutOfAStreamHoweverItIsCut) {
  Bytes stream;
  std::vector<std::string> texts;
  for (int i = 0; i < 50; i++) {
    texts.push_back(std::string(size_t(i * i), char('a' + i % 26)));
    const Bytes bytes = wire(textMessage(MessageChannel::Request, uint32_t(i + 1), texts.back()));
    stream.insert(stream.end(), bytes.begin(), bytes.end());
  }
  for (uint32_t seed = 1; seed <= 20; seed++) {
    std::mt19937 random(seed);
    MessageReader reader(MessageReader::fromClient(1 << 20));
    std::vector<std::string> got;
    const auto keep = [&](std::optional<WireMessage> message) {
      if (!message) return;
      got.emplace_back(message->text());
      if (random() % 2) reader.reuse(std::move(message->payload));
    };
    for (size_t at = 0; at < stream.size();) {
      if (random() % 2) {  // read to where the payload stays
        const std::span<std::byte> room = reader.room(1 + random() % 400);
        const size_t n = std::min({room.size(), stream.size() - at, size_t(random() % 401)});
        std::copy_n(&stream[at], n, room.begin());
        at += n;
        if (!room.empty()) keep(reader.took(n));
        continue;
      }
      const size_t n = std::min<size_t>(1 + random() % 200, stream.size() - at);
      std::span<const std::byte> some(&stream[at], n);
      at += n;
      while (!some.empty()) keep(reader.take(some));
    }
    EXPECT_EQ(got, texts) << seed;
  }
}

TEST(WireMessages, ForWhichThereIsNoRoomArePassedOver) {
  Bytes stream;
  for (uint32_t id = 1; id <= 4; id++) {
    const Bytes bytes = wire(textMessage(MessageChannel::Request, id, std::string(id % 2 ? 5 : 50, 'x')));
    stream.insert(stream.end(), bytes.begin(), bytes.end());
  }
  for (size_t step : {1, 7, 1000}) {
    MessageReader::Rules rules = MessageReader::fromClient(1000);
    rules.room = [](uint64_t bytes) { return bytes <= 5; };
    MessageReader reader(std::move(rules));
    std::vector<std::pair<uint32_t, std::string>> got;
    for (size_t at = 0; at < stream.size(); at += step) {
      std::span<const std::byte> some(&stream[at], std::min(step, stream.size() - at));
      while (!some.empty())
        if (const auto message = reader.take(some))
          got.emplace_back(message->id, message->skipped ? "no room" : std::string(message->text()));
    }
    const std::vector<std::pair<uint32_t, std::string>> expected{
        {1, "xxxxx"}, {2, "no room"}, {3, "xxxxx"}, {4, "no room"}};
    EXPECT_EQ(got, expected) << step;
  }
}

TEST(WireMessages, ThatBreakTheRulesAreRefusedByTheirHeader) {
  const auto refused = [](const WireMessage& message, uint64_t announced, uint16_t channel) {
    auto header = headerOf(message);
    std::memcpy(header.data(), &announced, 8);
    std::memcpy(header.data() + 8, &channel, 2);
    MessageReader reader(MessageReader::fromClient(1000));
    std::span<const std::byte> bytes(header);
    try {
      reader.take(bytes);
      return false;
    } catch (const Error&) {
      return true;
    }
  };
  const WireMessage request = textMessage(MessageChannel::Request, 1, "");
  EXPECT_FALSE(refused(request, 1000, 1));
  EXPECT_TRUE(refused(request, 1001, 1)) << "too long";
  EXPECT_TRUE(refused(request, ~uint64_t(0), 1)) << "negative, were it signed";
  EXPECT_TRUE(refused(request, 0, 2)) << "a reply from a client";
  EXPECT_TRUE(refused(request, 0, 6)) << "no such channel";
  EXPECT_TRUE(refused(request, 0, 0)) << "control has no id";
  EXPECT_TRUE(refused(textMessage(MessageChannel::Request, 0, ""), 0, 1)) << "requests have one";
}

TEST(Preamble, OfAnotherProgramOrVersionIsRefused) {
  auto theirs = preamble();
  checkPreamble(theirs);
  theirs[8] = std::byte(2);
  EXPECT_THROW(checkPreamble(theirs), Error);
  theirs = preamble();
  theirs[0] = std::byte('X');
  EXPECT_THROW(checkPreamble(theirs), Error);
}

TEST(Handshake, SurvivesItsWayOverTheWire) {
  const Hello hello = parseHello(helloText({"secret", "a \"client\"", "ann"}));
  EXPECT_EQ(hello.token, "secret");
  EXPECT_EQ(hello.client, "a \"client\"");
  EXPECT_EQ(hello.tenant, "ann");
  Welcome sent{"gxyserver", "ann", 7, true, true, 4, {}};
  sent.limits.pixels = 123456789012;
  sent.token = "the one of a ticket";
  const Welcome got = parseWelcome(welcomeText(sent));
  EXPECT_EQ(got.token, sent.token);
  EXPECT_EQ(got.session, 7u);
  EXPECT_TRUE(got.administrator);
  EXPECT_TRUE(got.viewOnly);
  EXPECT_EQ(got.ranks, 4);
  EXPECT_EQ(got.limits.pixels, 123456789012u);
  for (const char* wrong :
       {"", "hello", "hello {", "hello []", "hello {\"token\": 3}", "helloX {}", "ping 3"})
    EXPECT_THROW(parseHello(wrong), Error) << wrong;
}

TEST(PixelRecords, AreCheckedBeforeTheyAreUsed) {
  PixelHeader header;
  header.width = 300;
  header.height = 200;
  header.x = 256;
  header.w = 44;
  header.h = 200;
  const Bytes good = pixelRecord(header, Bytes(10));
  EXPECT_EQ(pixelHeader(good).size, 10u);
  const auto refused = [&](auto change) {
    PixelHeader wrong = header;
    change(wrong);
    try {
      pixelHeader(pixelRecord(wrong, Bytes(10)));
      return false;
    } catch (const Error&) {
      return true;
    }
  };
  EXPECT_TRUE(refused([](PixelHeader& h) { h.w = 45; })) << "beyond the picture";
  EXPECT_TRUE(refused([](PixelHeader& h) { h.x = ~0u; })) << "beyond the picture, were it signed";
  EXPECT_TRUE(refused([](PixelHeader& h) { h.w = 0; }));
  EXPECT_TRUE(refused([](PixelHeader& h) { h.kind = PixelKind(9); }));
  EXPECT_TRUE(refused([](PixelHeader& h) { h.kind = PixelKind::EndOfPass; })) << "has no tile";
  EXPECT_THROW(pixelHeader(std::span(good).first(63)), Error);
  EXPECT_THROW(pixelHeader(std::span(good).first(70)), Error);
}

TEST(Utf8, IsWhatTheStandardSays) {
  for (const char* good : {"", "list", "\xC3\xA9", "\xE2\x82\xAC", "\xF0\x9F\x8C\x8C"})
    EXPECT_TRUE(isUtf8(good));
  for (const char* bad :
       {"\x80", "\xC3", "\xC0\xAF", "\xE0\x80\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xFF"})
    EXPECT_FALSE(isUtf8(bad));
}

}  // namespace
}  // namespace gxy::protocol
