// SPDX-License-Identifier: Apache-2.0
// Random numbers by counters, and lines that are drawn from them.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/kernels/single.h"
#include "core/kernels/twin.h"

namespace gxy {
namespace {

std::array<uint32_t, 4> philox(uint32_t key0, uint32_t key1, std::array<uint32_t, 4> counter) {
  single::philox4x32(key0, key1, counter[0], counter[1], counter[2], counter[3]);
  return counter;
}

// From the authors' own list of known answers (Random123, kat_vectors).
TEST(Philox, GivesItsAuthorsNumbers) {
  EXPECT_EQ(philox(0, 0, {}), (std::array<uint32_t, 4>{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox(0xffffffff, 0xffffffff, {0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}),
            (std::array<uint32_t, 4>{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox(0xa4093822, 0x299f31d0, {0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}),
            (std::array<uint32_t, 4>{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

constexpr int kLines = 200'000;
const glm::vec3 kSize(0.5f, 0.25f, 1);

template <class Each>
void forEachLine(Each each) {
  for (uint32_t i = 0; i < kLines; i++) {
    glm::vec3 start, direction;
    single::randomLine(3, 4, i, 0, kSize, start, direction);
    each(start, direction);
  }
}

// The face on which a line starts: 2 * axis, and 1 more for the upper one.
int faceOf(const glm::vec3& start) {
  for (int a = 0; a < 3; a++)
    for (int upper = 0; upper < 2; upper++)
      if (start[a] == (upper ? kSize[a] : 0.0f)) return 2 * a + upper;
  return -1;
}

TEST(RandomLine, StartsOnEachFaceAsOftenAsItIsLarge) {
  int lines[6] = {};
  forEachLine([&](const glm::vec3& start, const glm::vec3&) {
    const int face = faceOf(start);
    ASSERT_GE(face, 0);
    lines[face]++;
  });
  const double areas[3] = {0.25, 0.5, 0.125}, all = 2 * (0.25 + 0.5 + 0.125);
  for (int f = 0; f < 6; f++) {
    const double share = areas[f / 2] / all;
    EXPECT_NEAR(lines[f], kLines * share, 4 * std::sqrt(kLines * share * (1 - share))) << f;
  }
}

TEST(RandomLine, GoesInwardsWithTheCosineOfItsAngle) {
  double sum = 0, squares = 0;
  forEachLine([&](const glm::vec3& start, const glm::vec3& direction) {
    const int face = faceOf(start);
    const double cosine = face % 2 ? -direction[face / 2] : direction[face / 2];
    ASSERT_GT(cosine, 0);
    ASSERT_NEAR(glm::length(direction), 1, 1e-6);
    sum += cosine;
    squares += cosine * cosine;
  });
  EXPECT_NEAR(sum / kLines, 2.0 / 3, 4 * std::sqrt(1.0 / 18 / kLines));
  EXPECT_NEAR(squares / kLines, 1.0 / 2, 4 * std::sqrt(1.0 / 12 / kLines));
}

// The mean length of the chords of a convex body is four times its volume over its surface (Cauchy).
TEST(RandomLine, HasTheMeanChordOfCauchy) {
  double sum = 0, squares = 0;
  forEachLine([&](const glm::vec3& start, const glm::vec3& direction) {
    double chord = 1e30;
    for (int a = 0; a < 3; a++) {
      const double room = direction[a] > 0 ? kSize[a] - start[a] : start[a];
      if (direction[a] != 0) chord = std::min(chord, room / std::abs(double(direction[a])));
    }
    sum += chord;
    squares += chord * chord;
  });
  const double mean = sum / kLines, error = std::sqrt((squares / kLines - mean * mean) / kLines);
  EXPECT_NEAR(mean, 4 * 0.125 / 1.75, 4 * error);
}

TEST(RandomLine, IsThatOfTheTwinUpToRounding) {
  for (uint32_t i = 0; i < 2000; i++) {
    glm::vec3 start, direction;
    glm::dvec3 twinStart, twinDirection;
    single::randomLine(1, 2, i, 5, kSize, start, direction);
    twin::randomLine(1, 2, i, 5, glm::dvec3(kSize), twinStart, twinDirection);
    for (int a = 0; a < 3; a++) {
      ASSERT_NEAR(start[a], twinStart[a], 1e-7);
      ASSERT_NEAR(direction[a], twinDirection[a], 1e-6);
    }
  }
}

}  // namespace
}  // namespace gxy
