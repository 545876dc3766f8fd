// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/pace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace gxy::test {
namespace {

/// A window of 1920 x 1080, and a server and a link of which every pixel takes its share.
struct World {
  double secondsPerPixel, bytesPerPixel, bytesPerSecond;  ///< bytes at quality 70

  double bytes(Detail d) const {
    const double factor = d.quality >= 85 ? 1.5 : d.quality >= 70 ? 1 : d.quality >= 50 ? 0.75 : 0.55;
    return bytesPerPixel * factor * pixels(d);
  }
  static double pixels(Detail d) { return std::ceil(1920.0 / d.scale) * std::ceil(1080.0 / d.scale); }
  double rendering(Detail d) const { return secondsPerPixel * pixels(d); }
  double transfer(Detail d) const { return bytes(d) / bytesPerSecond; }
  /// The details of `frames` frames, one after the other.
  std::vector<Detail> run(Pace& pace, int frames) const {
    std::vector<Detail> details;
    for (int i = 0; i < frames; i++) {
      const Detail d = details.emplace_back(pace.choose());
      pace.take({d, rendering(d), uint64_t(bytes(d)), bytesPerSecond});
    }
    return details;
  }
};

TEST(Pace, AFastServerAndLinkGiveEveryPixelInTheBestQuality) {
  Pace pace;
  EXPECT_EQ((World{1e-9, 0.2, 1e9}).run(pace, 20).back(), (Detail{1, 85}));
}

TEST(Pace, ASlowServerGivesFewerPixelsOfTheBestQuality) {
  Pace pace;
  const World world{4e-7, 0.2, 1e9};  // 0.8 s for all of them
  const Detail d = world.run(pace, 20).back();
  EXPECT_EQ(d, (Detail{4, 85}));
  EXPECT_LE(world.rendering(d), Pace::kFrame);
}

TEST(Pace, ASlowLinkGivesWhatFitsAndGoesOnDownToTheCoarsest) {
  for (const double rate : {2.5e6, 5e5, 1e5, 1e4}) {
    Pace pace;
    const World world{1e-9, 0.2, rate};
    const Detail d = world.run(pace, 20).back();
    if (d == Detail{Pace::kScales.back(), 30}) continue;
    EXPECT_LE(world.transfer(d), Pace::kFrame) << rate;
    EXPECT_GE(world.transfer({d.scale, 50}) * 4, 0.6 * Pace::kFrame) << rate << ": it could be finer";
  }
  Pace pace;
  EXPECT_EQ((World{1e-9, 0.2, 1e3}).run(pace, 20).back(), (Detail{Pace::kScales.back(), 30}));
}

TEST(Pace, ALinkThatGetsSlowerIsFollowedWithinAFewFramesAndBack) {
  Pace pace;
  const World fast{1e-9, 0.2, 1e9}, slow{1e-9, 0.2, 5e5};
  fast.run(pace, 20);
  const Detail d = slow.run(pace, 15).back();
  EXPECT_LE(slow.transfer(d), Pace::kFrame);
  EXPECT_EQ(fast.run(pace, 15).back(), (Detail{1, 85}));
}

TEST(Pace, WhatStaysAsItIsIsSeldomTriedFiner) {
  for (double cost = 1e-9; cost < 1e-5; cost *= 1.17) {
    Pace pace;
    const World world{cost, 0.2, 2.5e6};
    const std::vector<Detail> details = world.run(pace, 600);
    int changes = 0;
    for (size_t i = 100; i < details.size(); i++) changes += details[i] != details[i - 1];
    EXPECT_LE(changes, 20) << cost;  // each try is two
  }
}

TEST(Pace, ALargerWindowIsRenderedCoarserAtOnce) {
  Pace pace;
  World{1e-8, 0.01, 1e9}.run(pace, 20);
  EXPECT_EQ(pace.choose().scale, 1u);
  pace.resized(4);
  EXPECT_EQ(pace.choose().scale, 2u);
}

}  // namespace
}  // namespace gxy::test
