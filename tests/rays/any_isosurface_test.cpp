// SPDX-License-Identifier: Apache-2.0
// Whether a ray meets an isosurface at all, against the first one that it meets.
#include <gtest/gtest.h>

#include <limits>

#include "core/kernels/single.h"
#include "tests/rays/maps.h"
#include "tests/rays/roots.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

struct Interval {
  float tIn, tOut, tAfter;
};

bool meets(const View<float>& view, const single::VolumeRay& ray, const Interval& t, single::IsoStart start,
           bool anyHit, float& at) {
  int cells = 0, skipped = 0;
  at = isosurfaceAlong(*view, ray, t.tIn, t.tOut, t.tAfter, start, anyHit, cells, skipped).t;
  return at < 1e30f;
}

/// An interval of t in which a partition may look: open, cut at random, or cut exactly at `hit`.
Interval randomInterval(Random& random, float hit) {
  Interval t{0, 1e30f, -1};
  const auto cut = [&] { return hit < 1e30f && random.below(3) == 0 ? hit : float(random.in(0, 1.5)); };
  if (random.below(2)) t.tIn = cut();
  if (random.below(2)) t.tOut = std::max(t.tIn, cut());
  if (random.below(4) == 0) t.tAfter = cut();
  return t;
}

// Fields of few integers have plateaus, touched isovalues and hits in corners; one sample in thirty is missing.
Field randomField(Random& random, int scene) {
  const Index3 n{2 + random.below(20), 2 + random.below(20), 2 + random.below(20)};
  if (scene % 2 == 0) return sampled(gridOf(n, random.point(0.3, 1)), turbulence);
  return makeField(gridOf(n), [&](int64_t, int64_t, int64_t, int) {
    return random.below(30) == 0 ? std::numeric_limits<double>::quiet_NaN() : double(random.below(4));
  });
}

TEST(AnyIsosurface, IsMetExactlyWhereTheFirstOneIs) {
  Random random(57);
  int different = 0, met = 0, missed = 0, earlier = 0;
  for (int scene = 0; scene < 40; scene++) {
    const Field f = randomField(random, scene);
    Shown shown;
    shown.isovalues = scene % 2 ? std::vector<float>{1, 2.5f} : std::vector<float>{0.4f, 0.5f, 0.55f};
    const View<float> view(f, shown);
    for (int i = 0; i < sweep(1000); i++) {
      RaySpec spec = randomRay(random, f);
      single::IsoStart start{-1, 0};
      float hit, any;
      if (meets(view, rayIn(view, spec), {0, 1e30f, -1}, start, false, hit) && random.below(2)) {
        // A secondary ray from there.
        for (int a = 0; a < 3; a++) spec.o[a] = float(spec.o[a]) + hit * float(spec.d[a]);
        spec.d = randomRay(random, f).d;
        start = {random.below(2), random.below(2) ? 1 : -1};
        meets(view, rayIn(view, spec), {0, 1e30f, -1}, start, false, hit);
      }
      const auto ray = rayIn(view, spec);
      const Interval t = randomInterval(random, hit);
      const bool first = meets(view, ray, t, start, false, hit);
      different += meets(view, ray, t, start, true, any) != first;
      met += first;
      missed += !first;
      earlier += first && any < hit;
    }
  }
  EXPECT_EQ(different, 0);
  EXPECT_GT(met, sweep(8000));
  EXPECT_GT(missed, sweep(8000));
  EXPECT_GT(earlier, sweep(1000));  // no root was computed
}

}  // namespace
}  // namespace gxy::test
