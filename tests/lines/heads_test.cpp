// SPDX-License-Identifier: Apache-2.0
// Heads of lines as items of flights: their lists, their wire form, and what is refused.
#include "core/rays/heads.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "core/rays/device_fields.h"
#include "core/render/flight.h"
#include "tests/kernels/random.h"

namespace gxy::test {
namespace {

static_assert(ItemList<HeadList>);
static_assert(ItemResult<AdvanceResult>);

const Extent kBlock{{3, 4, 5}, {10, 11, 12}};

HeadList randomHeads(Random& random, int n) {
  HeadList heads(7, n);
  for (int i = 0; i < n; i++) {
    const float f[3] = {float(random.unit()), float(random.unit()), 1.0f};
    heads.start(i, random.bits() & kLastLine, random.below(2) == 1,
                {3 + random.below(9), 4 + random.below(10), 5 + random.below(11)}, f);
    const HeadView& h = heads.view();
    h.time[i] = float(random.in(0, 10)), h.timeRest[i] = float(random.in(-1e-7, 1e-7));
    h.length[i] = float(random.in(0, 10)), h.lengthRest[i] = float(random.in(-1e-7, 1e-7));
    h.steps[i] = random.below(1000), h.points[i] = random.below(1000), h.stalled[i] = random.below(9);
    h.way[i] = float(random.in(0, 1e-5));
  }
  return heads;
}

void expectSame(const HeadList& a, int i, const HeadList& b, int k) {
#define GXY_SAME(type, name, sent) \
  EXPECT_TRUE(!sent || std::memcmp(a.view().name + i, b.view().name + k, 4) == 0) << #name;
  GXY_HEAD_FIELDS(GXY_SAME)
#undef GXY_SAME
}

TEST(HeadList, ComesBackFromItsWireFormWithTheSameBits) {
  Random random(1);
  for (int n : {0, 1, 15, 16, 17, 100}) {
    const HeadList heads = randomHeads(random, n);
    Bytes message(3);
    heads.write(message);
    ASSERT_EQ(message.size(), size_t(3 + n * HeadList::wireBytes(0)));
    const HeadList read = HeadList::read(7, std::span(message).subspan(3), n);
    ASSERT_EQ(read.size(), n);
    EXPECT_EQ(read.partition, 7);
    for (int i = 0; i < n; i++) expectSame(heads, i, read, i);
    EXPECT_EQ(wrongIn(read, kBlock), nullptr);
  }
}

TEST(HeadList, OfMeshesComesBackFromItsWireFormWithTheSameBits) {
  Random random(4);
  HeadList heads(7, 33, kMeshHeads);
  for (int i = 0; i < heads.size(); i++) {
    heads.clear(i, random.bits() & kLastLine, random.below(2) == 1);
    heads.view().gx[i] = uint32_t(random.bits()), heads.view().gy[i] = uint32_t(random.bits());
    heads.view().nearZ[i] = float(random.unit()), heads.view().step[i] = float(random.unit());
  }
  Bytes message;
  heads.split(20).at(1).write(message);
  const HeadList read = HeadList::read(7, message, 13, kMeshHeads);
  EXPECT_EQ(read.kind(), uint32_t(kMeshHeads));
  for (int i = 0; i < read.size(); i++) {
    expectSame(heads, 20 + i, read, i);
    EXPECT_EQ(heads.view().gx[20 + i], read.view().gx[i]);
    EXPECT_EQ(heads.view().gy[20 + i], read.view().gy[i]);
    EXPECT_EQ(heads.view().nearZ[20 + i], read.view().nearZ[i]);
    EXPECT_EQ(heads.view().step[20 + i], read.view().step[i]);
  }
}

TEST(HeadList, TakesLessThan96BytesOnTheWireAndHasTwoKinds) {
  EXPECT_LE(HeadList::wireBytes(kGridHeads), 64);
  EXPECT_LE(HeadList::wireBytes(kMeshHeads), 96);
  EXPECT_EQ(HeadList::wireBytes(kHeadKinds), 0);
}

TEST(HeadList, SplitsInOrder) {
  Random random(2);
  const HeadList heads = randomHeads(random, 100);
  const std::vector<HeadList> parts = heads.split(33);
  ASSERT_EQ(parts.size(), 4u);
  int i = 0;
  for (const HeadList& part : parts) {
    EXPECT_LE(part.size(), 33);
    EXPECT_EQ(part.partition, 7);
    for (int k = 0; k < part.size(); k++) expectSame(heads, i++, part, k);
  }
  EXPECT_EQ(i, 100);
}

TEST(HeadList, KeepsLineNumbersOfFortyBits) {
  HeadList heads(0, 2);
  const float f[3] = {0, 0.5f, 1};
  heads.start(0, kLastLine, true, {0, 0, 0}, f);
  heads.start(1, uint64_t(1) << 32, false, {0, 0, 0}, f);
  EXPECT_EQ(heads.line(0), kLastLine);
  EXPECT_TRUE(heads.backward(0));
  EXPECT_EQ(heads.line(1), uint64_t(1) << 32);
  EXPECT_FALSE(heads.backward(1));
}

TEST(HeadList, HeadsThatNoRankWouldSendAreRefused) {
  const auto refused = [](auto spoil) {
    Random random(3);
    const HeadList heads = randomHeads(random, 20);
    spoil(heads.view());
    return wrongIn(heads, kBlock) != nullptr;
  };
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(refused([](const HeadView&) {}));
  EXPECT_TRUE(refused([](const HeadView& h) { h.info[19] |= 512; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.cellX[5] = 2; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.cellX[5] = 12; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.cellY[5] = -1; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.cellZ[5] = std::numeric_limits<int>::max(); }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.fx[5] = -1e-6f; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.fy[5] = 1.00001f; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.fz[5] = kNaN; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.time[5] = kInfinity; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.timeRest[5] = kNaN; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.length[5] = -1; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.way[5] = kNaN; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.steps[5] = -1; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.points[5] = kMostPoints + 1; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.stalled[5] = -1; }));
  EXPECT_TRUE(refused([](const HeadView& h) { h.stalled[5] = std::numeric_limits<int>::max(); }));
}

}  // namespace
}  // namespace gxy::test
