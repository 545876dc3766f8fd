// SPDX-License-Identifier: Apache-2.0
#include "tests/support/difference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <sstream>

#include "core/image/image.h"
#include "tests/support/close_pictures.h"
#include "tests/support/frames.h"

namespace gxy::test {

namespace {

constexpr size_t kShown = 4;     ///< number of pixels that are named
constexpr int kMostWritten = 8;  ///< number of differences that a program writes as files

/// Writes the pictures. Returns text that says where they are, or why they could not be written.
std::string written(const Picture& expected, const Picture& found) {
  static std::atomic<int> before = 0;
  const int number = before++;
  if (number >= kMostWritten) return "";
  std::string name = "picture";
  if (const auto* test = testing::UnitTest::GetInstance()->current_test_info())
    name = std::string(test->test_suite_name()) + "." + test->name();
  for (char& c : name)
    if (c == '/') c = '_';
  const std::string prefix = testing::TempDir() + name + "-" + std::to_string(number);
  // Differences are divided by the largest, as they may be of one bit. Pixels where only the depth
  // differs are blue.
  LargeVector<float> difference(expected.rgba.size());
  float largest = 0;
  for (size_t i = 0; i < difference.size(); i++) {
    difference[i] = i % 4 == 3 ? 0 : std::abs(expected.rgba[i] - found.rgba[i]);
    largest = std::max(largest, difference[i]);
  }
  for (size_t i = 0; i < difference.size(); i++) {
    difference[i] = i % 4 == 3 ? 1 : largest > 0 ? difference[i] / largest : 0;
    const bool sameColor = i % 4 == 2 && difference[i - 2] + difference[i - 1] + difference[i] == 0;
    if (sameColor && !expected.depth.empty() && expected.depth[i / 4] != found.depth[i / 4])
      difference[i] = 1;
  }
  try {
    writeImage(prefix + "_expected.png", {expected.width, expected.height, expected.rgba});
    writeImage(prefix + "_found.png", {found.width, found.height, found.rgba});
    writeImage(prefix + "_difference.png", {found.width, found.height, std::move(difference)});
  } catch (const std::exception& e) {
    return std::string("; ") + e.what();
  }
  return "; see " + prefix + "_*.png";
}

}  // namespace

std::string difference(const Picture& expected, const Picture& found, Sameness asked) {
  if (expected.width != found.width || expected.height != found.height ||
      expected.depth.size() != found.depth.size())
    return "the sizes differ";
  size_t pixels = 0;
  std::ostringstream first;
  first.precision(9);
  for (size_t p = 0; p < size_t(expected.width) * size_t(expected.height); p++) {
    const bool color = std::memcmp(&expected.rgba[4 * p], &found.rgba[4 * p], 4 * sizeof(float)) != 0;
    const bool depth =
        !expected.depth.empty() && std::memcmp(&expected.depth[p], &found.depth[p], sizeof(double)) != 0;
    if (!color && !depth) continue;
    if (pixels++ >= kShown) continue;
    first << "\n  pixel " << p % size_t(expected.width) << ", " << p / size_t(expected.width) << ":";
    for (const Picture* x : {&expected, &found}) {
      for (int k = 0; k < 4; k++) first << ' ' << x->rgba[4 * p + size_t(k)];
      if (!x->depth.empty()) first << " depth " << x->depth[p];
      if (x == &expected) first << " against";
    }
  }
  if (pixels == 0) return "";
  std::string far;
  if (asked == Sameness::Close) {
    const Closeness c = closenessOf(expected, found);
    if (c.agrees()) return "";
    far = " of " + std::to_string(c.pixels) + ", " + std::to_string(c.far) + " by more than 1/255, and " +
          std::to_string(c.hitsFar) + " of " + std::to_string(c.hits) + " hits by more than 4 ulp";
  }
  return std::to_string(pixels) + " pixels differ" + far + written(expected, found) + first.str();
}

Picture wholeOnTested(const TestScene& scene) {
  const Picture expected = wholeOnEmbree(scene);
  if (testedSameness() == Sameness::Bits) return expected;
  const Picture own = render(scene, whole(scene.domain));
  EXPECT_EQ(difference(expected, own), "") << scene.name << " in one piece";
  return own;
}

}  // namespace gxy::test
