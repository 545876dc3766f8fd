// SPDX-License-Identifier: Apache-2.0
#include "core/rays/ray_list.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "core/comm/random.h"

namespace gxy {
namespace {

// All fields random bits.
RayList randomRays(int n, uint64_t seed) {
  Random random(seed);
  RayList rays(n);
  rays.resize(n);
  for (int i = 0; i < n; i++) {
    uint32_t bits;
#define GXY_FILL(type, name, primary, secondary) \
  bits = uint32_t(random.next());                \
  std::memcpy(rays.view().name + i, &bits, 4);
    GXY_RAY_FIELDS(GXY_FILL)
#undef GXY_FILL
  }
  return rays;
}

// Which fields (in order of the list) have the same bits in ray i of a and ray k of b.
std::vector<bool> sameFields(const RayList& a, int i, const RayList& b, int k) {
  std::vector<bool> same;
#define GXY_SAME(type, name, primary, secondary) \
  same.push_back(std::memcmp(a.view().name + i, b.view().name + k, 4) == 0);
  GXY_RAY_FIELDS(GXY_SAME)
#undef GXY_SAME
  return same;
}

std::vector<bool> fieldsOnWire(bool primaries) {
  std::vector<bool> on;
#define GXY_ON(type, name, primary, secondary) on.push_back(primaries ? primary : secondary);
  GXY_RAY_FIELDS(GXY_ON)
#undef GXY_ON
  return on;
}

TEST(RayList, PrimariesTakeAtMost32BytesOnTheWire) {
  EXPECT_LE(RayList::wireBytes(true), 32);
  EXPECT_GT(RayList::wireBytes(false), RayList::wireBytes(true));
}

TEST(RayList, WireFormKeepsTheFieldsThatTravelBitForBit) {
  for (bool primary : {true, false}) {
    const RayList rays = randomRays(37, 5);
    const std::vector<int> which{0, 36, 7, 7, 21};
    Bytes bytes(3, std::byte(0xab));  // appended to what is there
    rays.write(which, primary, bytes);
    ASSERT_EQ(bytes.size(), 3 + which.size() * size_t(RayList::wireBytes(primary)));
    const RayList back = RayList::read(std::span(bytes).subspan(3), int(which.size()), primary);
    ASSERT_EQ(back.size(), int(which.size()));
    const std::vector<bool> on = fieldsOnWire(primary);
    for (size_t k = 0; k < which.size(); k++) {
      const std::vector<bool> same = sameFields(rays, which[k], back, int(k));
      for (size_t f = 0; f < on.size(); f++)
        EXPECT_TRUE(same[f] || !on[f]) << "field " << f << " of ray " << k;
    }
  }
}

TEST(RayList, SplitsInOrderAndLosesNothingThatTravels) {
  std::vector<bool> travels = fieldsOnWire(true);
  const std::vector<bool> secondary = fieldsOnWire(false);
  for (size_t f = 0; f < travels.size(); f++) travels[f] = travels[f] || secondary[f];
  for (int n : {1, 15, 16, 17, 100}) {
    const RayList rays = randomRays(n, uint64_t(n));
    int at = 0;
    for (const RayList& part : rays.split(16)) {
      EXPECT_EQ(part.size(), std::min(16, n - at));
      for (int i = 0; i < part.size(); i++, at++) {
        const std::vector<bool> same = sameFields(rays, at, part, i);
        for (size_t f = 0; f < same.size(); f++)
          EXPECT_TRUE(same[f] || !travels[f]) << "field " << f << " of ray " << at;
      }
    }
    EXPECT_EQ(at, n);
  }
}

TEST(RayList, OfRaysThatADeviceKeepsSplitsTheirPlaces) {
  const auto kept = std::make_shared<DeviceRays>();
  const std::weak_ptr<DeviceRays> watched = kept;
  std::vector<RayList> parts;
  {
    const RayList rays(kept, {5, 3, 9, 0, 7});
    EXPECT_EQ(rays.size(), 5);
    EXPECT_EQ(rays.bytes(), 20);
    parts = rays.split(2);
  }
  ASSERT_EQ(parts.size(), 3u);
  std::vector<uint32_t> places;
  for (const RayList& part : parts) {
    EXPECT_EQ(part.kept(), kept.get());
    places.insert(places.end(), part.places().begin(), part.places().end());
  }
  EXPECT_EQ(places, (std::vector<uint32_t>{5, 3, 9, 0, 7}));
  EXPECT_EQ(watched.use_count(), 4);  // each part holds them
  parts.clear();
  EXPECT_EQ(watched.use_count(), 1);
}

TEST(RayList, ArraysAreAlignedForTheWidestGang) {
  const RayList rays(5);
#define GXY_ALIGNED(type, name, primary, secondary) \
  EXPECT_EQ(reinterpret_cast<uintptr_t>(rays.view().name) % 64, 0u);
  GXY_RAY_FIELDS(GXY_ALIGNED)
#undef GXY_ALIGNED
}

}  // namespace
}  // namespace gxy
