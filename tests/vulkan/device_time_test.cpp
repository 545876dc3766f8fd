// SPDX-License-Identifier: Apache-2.0
// What counts as a device's idle time (docs/statistics.md), without a device.
#include "backends/vulkan/device_time.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace gxy::vulkan {
namespace {

struct Work {
  uint64_t frame, began, ended;
};

DeviceTime::Spent sumOf(DeviceTime& time, const std::vector<Work>& works) {
  DeviceTime::Spent sum;
  for (const Work& w : works) {
    const DeviceTime::Spent s = time.worked(w.frame, w.began, w.ended);
    sum.busy += s.busy;
    sum.idle += s.idle;
  }
  return sum;
}

DeviceTime::Spent sumOf(const std::vector<Work>& works) {
  DeviceTime time;
  return sumOf(time, works);
}

void expectSpent(const DeviceTime::Spent& s, int64_t busy, int64_t idle) {
  EXPECT_EQ(s.busy, busy);
  EXPECT_EQ(s.idle, idle);
}

TEST(IdleTime, IsAGapInsideAFrame) {
  expectSpent(sumOf({{1, 100, 110}, {1, 115, 120}, {1, 120, 130}}), 25, 5);
}

TEST(IdleTime, IsNotAGapBetweenFrames) {
  expectSpent(sumOf({{1, 100, 110}, {2, 150, 160}, {3, 161, 165}}), 24, 0);
}

TEST(IdleTime, OfAlternatingFramesIsEachGapOnce) {
  // both frames are under way from 20 to 50; 1 alone before, 2 alone behind
  expectSpent(sumOf({{1, 0, 10}, {2, 20, 30}, {1, 40, 50}, {2, 60, 70}}), 40, 30);
}

TEST(IdleTime, OfAFrameInsideAnother) {
  expectSpent(sumOf({{1, 0, 10}, {2, 20, 30}, {2, 35, 40}, {1, 50, 60}}), 35, 25);
}

TEST(IdleTime, IsToldWhenTheFrameGoesOn) {
  DeviceTime time;
  expectSpent(time.worked(1, 0, 10), 10, 0);
  expectSpent(time.worked(2, 30, 40), 10, 0);
  expectSpent(time.worked(1, 40, 50), 10, 20);
}

TEST(IdleTime, OfOverlappingBatchesIsNone) {
  expectSpent(sumOf({{1, 0, 10}, {1, 5, 15}, {2, 12, 20}, {1, 20, 30}}), 30, 0);
  expectSpent(sumOf({{1, 0, 30}, {2, 10, 20}, {1, 30, 40}}), 40, 0);
}

TEST(IdleTime, IsNotWhatFollowsACancelledFrame) {
  DeviceTime time;
  expectSpent(sumOf(time, {{1, 0, 10}, {1, 12, 20}, {2, 20, 25}}), 23, 2);
  time.over(1);
  expectSpent(sumOf(time, {{3, 40, 50}}), 10, 0);
  time.over(3);
  time.over(4);  // never had any
  expectSpent(sumOf(time, {{2, 60, 65}}), 5, 25);
}

TEST(IdleTime, OfWorkThatIsToldLateIsTakenBack) {
  DeviceTime time;
  expectSpent(sumOf(time, {{1, 0, 10}, {1, 50, 60}}), 20, 40);
  expectSpent(time.worked(2, 20, 45), 25, -25);
  expectSpent(time.worked(2, 45, 50), 5, -5);
}

TEST(IdleTime, GoesOnWhereTheClockBeginsAnew) {
  DeviceTime time(1000);
  expectSpent(sumOf(time, {{1, 900, 950}, {1, 960, 990}, {1, 995, 5}, {1, 20, 30}}), 100, 30);
  expectSpent(time.worked(2, 985, 1000 - 8), 2, -2);  // told late
  time.over(1);
  time.over(2);
  // frames of half a round, round after round
  uint64_t now = 1100;
  int64_t idle = 0;
  for (uint64_t frame = 3; frame < 50; frame++)
    for (int i = 0; i < 4; i++, now += 140) idle += time.worked(frame, now % 1000, (now + 100) % 1000).idle;
  EXPECT_EQ(idle, 47 * 3 * 40);
}

TEST(IdleTime, WithoutAClockIsNone) { expectSpent(sumOf({{1, 0, 0}, {1, 0, 0}}), 0, 0); }

TEST(IdleTime, DoesNotDependOnTheOrderInWhichWorkIsTold) {
  std::mt19937 random(7);
  std::vector<Work> works;
  uint64_t now = 0;
  std::vector<bool> busy(4000), underWay(4000);
  std::vector<std::pair<uint64_t, uint64_t>> spans(12, {UINT64_MAX, 0});
  for (int i = 0; i < 200; i++) {
    const uint64_t frame = now / 400 + random() % 3, began = now + random() % 15,
                   ended = began + 1 + random() % 10;
    works.push_back({frame, began, ended});
    std::fill(busy.begin() + long(began), busy.begin() + long(ended), true);
    spans[frame] = {std::min(spans[frame].first, began), std::max(spans[frame].second, ended)};
    now = began + random() % 8;
  }
  for (const auto& [began, ended] : spans)
    if (began < ended) std::fill(underWay.begin() + long(began), underWay.begin() + long(ended), true);
  const auto expectedBusy = std::count(busy.begin(), busy.end(), true);
  const auto expectedIdle = std::count(underWay.begin(), underWay.end(), true) - expectedBusy;
  EXPECT_GT(expectedIdle, 100);
  for (int order = 0; order < 20; order++) {
    expectSpent(sumOf(works), expectedBusy, expectedIdle);
    std::shuffle(works.begin(), works.end(), random);
  }
}

TEST(DeviceTime, RemembersLittleOfWhatIsOver) {
  DeviceTime time;
  int64_t idle = 0;
  for (uint64_t frame = 1; frame <= 10'000; frame++) {
    idle += sumOf(time, {{frame, 100 * frame, 100 * frame + 10}, {frame, 100 * frame + 20, 100 * frame + 50}})
                .idle;
    time.over(frame);
  }
  EXPECT_EQ(idle, 100'000);
  EXPECT_LE(time.remembered(), 64u);
}

}  // namespace
}  // namespace gxy::vulkan
