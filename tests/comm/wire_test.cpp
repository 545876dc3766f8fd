// SPDX-License-Identifier: Apache-2.0
#include "core/comm/wire.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/comm/random.h"

using namespace gxy;

namespace {

struct Sample {
  double x;
  int32_t i[2];
};

Bytes sampleMessage() {
  Writer writer;
  writer.write(true).write(uint64_t(1) << 63).write("text").write(std::vector<float>{1.5f, -0.f});
  writer.write(Sample{std::numeric_limits<double>::infinity(), {-1, 7}}).write(std::vector<Sample>(3));
  return writer.take();
}

void readSample(Reader& reader) {
  reader.read<bool>();
  reader.read<uint64_t>();
  reader.readString();
  reader.readVector<float>();
  reader.read<Sample>();
  reader.readVector<Sample>();
  reader.expectEnd();
}

}  // namespace

TEST(Wire, WhatIsWrittenIsRead) {
  const Bytes message = sampleMessage();
  Reader reader(message, "sample");
  EXPECT_TRUE(reader.read<bool>());
  EXPECT_EQ(reader.read<uint64_t>(), uint64_t(1) << 63);
  EXPECT_EQ(reader.readString(), "text");
  const auto floats = reader.readVector<float>();
  ASSERT_EQ(floats.size(), 2u);
  EXPECT_TRUE(std::signbit(floats[1]));
  const auto sample = reader.read<Sample>();
  EXPECT_EQ(sample.x, std::numeric_limits<double>::infinity());
  EXPECT_EQ(sample.i[1], 7);
  EXPECT_EQ(reader.readVector<Sample>().size(), 3u);
  EXPECT_NO_THROW(reader.expectEnd());
}

TEST(Wire, EveryTruncationIsAnError) {
  const Bytes message = sampleMessage();
  for (size_t size = 0; size < message.size(); ++size) {
    Reader reader(std::span<const std::byte>(message).first(size), "sample");
    EXPECT_THROW(readSample(reader), Error) << size;
  }
}

TEST(Wire, TrailingBytesAreAnError) {
  Bytes message = sampleMessage();
  message.push_back({});
  Reader reader(message, "sample");
  EXPECT_THROW(readSample(reader), Error);
}

TEST(Wire, ALengthBeyondTheMessageAllocatesNothing) {
  for (const uint64_t count : {uint64_t(2), uint64_t(1) << 40, uint64_t(1) << 61, ~uint64_t(0)}) {
    Writer writer;
    const Bytes message = writer.write(count).write(1.0).take();
    Reader reader(message, "list");
    EXPECT_THROW(reader.readVector<double>(), Error) << count;
  }
}

TEST(Wire, TheErrorSaysWhatWhereAndWhatWasExpected) {
  Writer writer;
  const Bytes message = writer.write(uint16_t(1)).take();
  Reader reader(message, "frame start");
  try {
    reader.read<uint64_t>();
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "malformed message 'frame start': it ends after 2 more bytes, expected 8");
  }
}

TEST(Wire, FlippedBytesAreReadOrRefusedButNeverOutOfBounds) {
  const Bytes message = sampleMessage();
  Random random(7);
  int refused = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes broken = message;
    for (uint64_t n = 1 + random.below(4); n > 0; --n)
      broken[random.below(broken.size())] = std::byte(random.next());
    Reader reader(broken, "sample");
    try {
      readSample(reader);
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
}
