// SPDX-License-Identifier: Apache-2.0
// Shading gradients.
#include <gtest/gtest.h>

#include "tests/rays/maps.h"

namespace gxy::test {
namespace {

TEST(Gradient, IsWithinOneDegreeOnASphere) {
  const Field f = cube(64, [](glm::dvec3 p) { return glm::length(p); });
  const View<float> view(f, {});
  Random random(71);
  double worst = 0;
  for (int i = 0; i < 20000; i++) {
    const glm::dvec3 n = random.direction();
    const glm::dvec3 p = (0.5 * random.in(0.3, 0.95) * n - f.grid.origin) / f.grid.spacing;
    const glm::dvec3 g(gradientAt(*view, glm::vec3(p)));
    worst = std::max(worst, std::acos(std::min(1.0, glm::dot(glm::normalize(g), n))));
  }
  EXPECT_LT(worst * 180 / std::numbers::pi, 1);
}

TEST(Gradient, OfALinearFieldIsExactUpToItsBorder) {
  const glm::dvec3 slope(2, -3, 0.5);
  for (const glm::dvec3 aspect : {glm::dvec3(1), glm::dvec3(1, 0.1, 1e-3)}) {
    const Field f =
        sampled(gridOf({9, 10, 11}, aspect), [&](glm::dvec3 p) { return glm::dot(slope, 0.5 * p); });
    const View<double> view(f, {});
    Random random(72);
    for (int i = 0; i < 2000; i++) {
      const glm::dvec3 p = random.below(2) ? glm::dvec3{random.below(9), random.below(10), random.below(11)}
                                           : glm::dvec3{random.in(0, 8), random.in(0, 9), random.in(0, 10)};
      const glm::dvec3 g = gradientAt(*view, p);
      for (int k = 0; k < 3; k++)
        EXPECT_NEAR(g[k], slope[k], 3e-7 / f.grid.spacing[k]) << p.x << " " << p.y << " " << p.z;
    }
  }
}

TEST(Gradient, IsOneSidedBesideNoData) {
  const Field f = makeField(gridOf({6, 6, 6}), [](int64_t i, int64_t, int64_t, int) {
    return i < 2 ? double(NAN) : 3.0 * double(i * i);
  });
  const View<float> view(f, {});
  const glm::vec3 g = gradientAt(*view, glm::vec3(2, 3, 3));
  EXPECT_FLOAT_EQ(g.x * float(f.grid.spacing.x), 15);  // 27 - 12, not half of (27 - NaN)
  EXPECT_EQ(g.y, 0);
}

}  // namespace
}  // namespace gxy::test
