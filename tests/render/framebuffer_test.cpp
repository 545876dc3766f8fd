// SPDX-License-Identifier: Apache-2.0
#include "core/render/framebuffer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "core/comm/random.h"

namespace gxy {
namespace {

constexpr int32_t kOne = int32_t(CONTRIBUTION_ONE);

TEST(Framebuffer, SumsDoNotDependOnTheOrderOfArrival) {
  Random random(3);
  std::vector<Contribution> list;
  std::vector<DepthContribution> depths;
  for (int i = 0; i < 500; i++) {
    const auto value = [&] { return int32_t(random.below(uint64_t(kOne))); };
    list.push_back({uint32_t(random.below(6)), value(), -value(), value(), value()});
    depths.push_back({uint32_t(random.below(6)), double(1 + random.below(1000))});
  }
  Framebuffer forward(3, 2, 500, true), backward(3, 2, 500, true);
  forward.add(list);
  forward.addDepths(depths);
  std::reverse(list.begin(), list.end());
  std::reverse(depths.begin(), depths.end());
  for (const Contribution& c : list) backward.add({&c, 1});
  for (const DepthContribution& d : depths) backward.addDepths({&d, 1});
  const glm::dvec4 background(0.25, 0.5, 0.75, 1);
  EXPECT_EQ(forward.picture(background).rgba, backward.picture(background).rgba);
  EXPECT_EQ(forward.picture(background).depth, backward.picture(background).depth);
}

TEST(Framebuffer, IsTheMeanOfSamplesBeforeTheBackground) {
  Framebuffer f(1, 1, 4, true);
  const Contribution half{0, kOne, kOne / 2, 0, 2 * kOne};  // of four samples: half covered
  f.add({&half, 1});
  const Picture p = f.picture(glm::dvec4{0.5, 0.25, 1, 1});
  EXPECT_EQ(p.rgba, (LargeVector<float>{0.25f + 0.25f, 0.125f + 0.125f, 0.5f, 1.f}));
  EXPECT_EQ(p.depth, std::vector<double>{1e30});
}

TEST(Framebuffer, AnIncompletePixelIsNotNegative) {
  Framebuffer f(1, 1, 1, false);
  const Contribution taken{0, -kOne, -1, -kOne, 0};
  f.add({&taken, 1});
  EXPECT_EQ(f.picture(glm::dvec4{0, 0, 0, 0}).rgba, (LargeVector<float>{0, 0, 0, 0}));
}

TEST(Framebuffer, SumsReachFarBeyondOneContribution) {
  Framebuffer f(1, 1, 1, false);
  const std::vector<Contribution> many(100000, Contribution{0, INT32_MAX, INT32_MIN, 0, 0});
  f.add(many);
  EXPECT_FLOAT_EQ(f.picture(glm::dvec4{0, 0, 0, 0}).rgba[0], float(100000 * (double(INT32_MAX) / kOne)));
}

TEST(Framebuffer, RefusesPixelsOutsideAndThenAddsNothing) {
  Framebuffer f(2, 2, 1, true);
  const std::vector<Contribution> list{{0, kOne, 0, 0, kOne}, {4, kOne, 0, 0, kOne}};
  EXPECT_FALSE(f.add(list));
  const std::vector<DepthContribution> depths{{1, 2.0}, {UINT32_MAX, 1.0}};
  EXPECT_FALSE(f.addDepths(depths));
  const Picture p = f.picture(glm::dvec4{0, 0, 0, 0});
  EXPECT_EQ(p.rgba, LargeVector<float>(16, 0.f));
  EXPECT_EQ(p.depth, std::vector<double>(4, 1e30));
}

TEST(Framebuffer, SumsOfPartsOfTheSamplesMakeThePictureOfAllOfThem) {
  const glm::dvec4 background{0.3, 0.6, 0.1, 0.7};
  Framebuffer whole(1, 1, 3, false), first(1, 1, 1, false), rest(1, 1, 2, false);
  const std::vector<Contribution> each{
      {0, 123456789, -7, 99, kOne / 3}, {0, 1, 2, 3, kOne / 7}, {0, kOne, 5, 0, 17}};
  whole.add(each);
  first.add(std::span(each).first(1));
  rest.add(std::span(each).last(2));
  Picture sum = first.takeSums();
  const Picture others = rest.takeSums();
  for (size_t i = 0; i < 4; i++) sum.sums[i] += others.sums[i];
  EXPECT_EQ(pixelsOf(sum.sums, 3, background, {1, 1}), whole.picture(background).rgba);
}

// Of what nothing is added to no sums are written; memory that was used before does not show.
TEST(Framebuffer, WhereNothingIsAddedThereIsTheBackground) {
  constexpr int kWidth = 500, kHeight = 300;
  constexpr uint32_t kPixels = kWidth * kHeight;
  const std::vector<Contribution> few{{3, kOne, 0, kOne / 2, kOne / 4}, {kPixels - 1, 0, kOne, 0, kOne}};
  const auto fresh = [&] {
    {
      Framebuffer before(kWidth, kHeight, 1, false);
      for (uint32_t i = 0; i < kPixels; i++)
        before.add(std::vector<Contribution>{{i, kOne, kOne, kOne, kOne}});
    }
    auto f = std::make_unique<Framebuffer>(kWidth, kHeight, 1, false);
    f->add(few);
    return f;
  };
  const glm::dvec4 background{0.3, 0.6, 0.1, 0.7};
  const LargeVector<float> rgba = fresh()->picture(background).rgba;
  LargeVector<int64_t> sums(4 * size_t(kPixels), 0);
  for (const Contribution& c : few) {
    const int64_t all[] = {c.r, c.g, c.b, c.a};
    std::copy(std::begin(all), std::end(all), &sums[4 * size_t(c.pixel)]);
  }
  EXPECT_EQ(fresh()->takeSums().sums, sums);
  EXPECT_EQ(rgba, pixelsOf(sums, 1, background, {kWidth, kHeight}));
  EXPECT_EQ(rgba, fresh()->picture(background, true).rgba);
}

TEST(Framebuffer, AGradientIsLinearFromTheLowerEdgeToTheUpperOne) {
  constexpr int kWidth = 37, kHeight = 8;  // rows do not end where blocks of pixels do
  RenderSettings settings;
  settings.background = {1, 0, 0.5, 1};
  settings.backgroundTop = glm::dvec4{0, 0.5, 0.5, 1};
  const Contribution half{3 * kWidth, 0, 0, 0, kOne / 2};
  Framebuffer whole(kWidth, kHeight, 1, false), part(kWidth, kHeight, 1, false);
  whole.add({&half, 1});
  for (uint32_t i = 0; i < uint32_t(kWidth * kHeight); i++)  // so that all blocks have sums
    part.add(std::vector<Contribution>{{i, 0, 0, 0, i == half.pixel ? half.a : 0}});
  const LargeVector<float> rgba = whole.picture(settings).rgba;
  for (int y = 0; y < kHeight; y++)
    for (int x = 0; x < kWidth; x++) {
      const float* const pixel = &rgba[4 * size_t(y * kWidth + x)];
      const double up = (y + 0.5) / kHeight, rest = x == 0 && y == 3 ? 0.5 : 1;
      EXPECT_FLOAT_EQ(pixel[0], float(rest * (1 - up))) << x << " " << y;
      EXPECT_FLOAT_EQ(pixel[1], float(rest * 0.5 * up));
      EXPECT_FLOAT_EQ(pixel[2], float(rest * 0.5));
      EXPECT_EQ(pixel[3], 1.f);
    }
  EXPECT_EQ(rgba, part.picture(settings).rgba);
  EXPECT_EQ(rgba, part.picture(settings, true).rgba);
  EXPECT_EQ(rgba, pixelsOf(part.takeSums().sums, 1, settings, {kWidth, kHeight}));
}

TEST(Framebuffer, AGradientOfOneColourIsThatColourToTheBit) {
  RenderSettings flat, gradient;
  flat.background = gradient.background = {0.1, 0.2, 0.3, 0.7};
  gradient.backgroundTop = gradient.background;
  Framebuffer f(3, 5, 3, false);
  const Contribution some{7, 12345678, 5, 99, kOne / 3};
  f.add({&some, 1});
  EXPECT_EQ(f.picture(flat).rgba, f.picture(gradient).rgba);
}

// Many frames wait at once; memory is that of those which something has been added to.
TEST(Framebuffer, HasMemoryFromItsFirstContributionToItsRelease) {
  std::vector<int64_t> held;
  int64_t now = 0;
  const auto hold = [&](int64_t bytes) {
    held.push_back(bytes);
    now += bytes;
    return std::shared_ptr<void>(nullptr, [&now, bytes](void*) { now -= bytes; });
  };
  const glm::dvec4 background{0.25, 0.5, 0.75, 1};
  Framebuffer f(3, 2, 1, true, hold);
  f.add({});
  f.addDepths({});
  const Picture empty = f.picture(background);
  EXPECT_EQ(held, std::vector<int64_t>{}) << "nothing was added";
  for (size_t i = 0; i < 6; i++) EXPECT_EQ(empty.rgba[4 * i + 2], 0.75f);
  EXPECT_EQ(empty.depth, std::vector<double>(6, 1e30));
  const Contribution full{5, kOne, 0, 0, kOne};
  f.add({&full, 1});
  f.add({&full, 1});
  EXPECT_EQ(held, std::vector<int64_t>{3 * 2 * (32 + 8)});
  EXPECT_EQ(now, held[0]);
  const Picture picture = f.picture(background);
  f.release();
  EXPECT_EQ(now, 0);
  EXPECT_EQ(picture.rgba[4 * 5], 2.f);
  EXPECT_EQ(picture.rgba[4 * 4 + 2], 0.75f);
  EXPECT_EQ(Framebuffer(3, 2, 1, false).takeSums().sums, LargeVector<int64_t>(24, 0));
}

TEST(Framebuffer, TakesNoDepthsUnlessAsked) {
  Framebuffer f(2, 2, 1, false);
  const DepthContribution depth{0, 1.0};
  EXPECT_FALSE(f.addDepths({&depth, 1}));
}

}  // namespace
}  // namespace gxy
