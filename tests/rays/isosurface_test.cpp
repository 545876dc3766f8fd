// SPDX-License-Identifier: Apache-2.0
// The first isosurface along a ray, against all roots of all cells in double.
#include <gtest/gtest.h>

#include <cfloat>

#include "core/kernels/single.h"
#include "core/rays/iso_mask.h"
#include "tests/rays/maps.h"
#include "tests/rays/roots.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using Hit = single::IsoHit;
constexpr single::IsoStart kNowhere{-1, 0};

Hit firstHit(const View<float>& view, const single::VolumeRay& ray, float tIn = 0, float tOut = 1e30f,
             float tAfter = -1, single::IsoStart start = kNowhere) {
  int cells = 0, skipped = 0;
  return firstIsosurface(*view, ray, tIn, tOut, tAfter, start, cells, skipped);
}

struct Score {
  int rays = 0, hits = 0, missed = 0, wrong = 0, imprecise = 0, tangential = 0, tangentialOff = 0;
  double worst = 0;  // |dt| in cells beyond 2 ulp(t), where the slope is steep enough
};

// Compares one ray. A hit must be a root; none that is steep may be passed over.
void compare(const Field& f, const View<float>& view, const RaySpec& spec, double iso, Score& score) {
  const auto ray = rayIn(view, spec);
  const IndexRay exact = indexRay(ray, f);
  const Hit hit = firstHit(view, ray);
  const std::vector<Root> roots = rootsAlong(f, exact, iso);
  const double cells = glm::length(exact.d);
  score.rays++;
  score.hits += hit.t < 1e30f;
  const auto steep = [](const Root& r) { return std::abs(r.slope) >= 1e-3 * r.range; };
  const auto crosses = [&](const Root& r) {  // not only touches, to rounding
    const double before = fieldAt(f, exact, r.t - 2e-3 / cells) - iso,
                 after = fieldAt(f, exact, r.t + 2e-3 / cells) - iso;
    return std::min(std::abs(before), std::abs(after)) > 1e-6 * r.range && (before < 0) != (after < 0);
  };
  const float at = std::min(hit.t, float(exact.t1));  // without a hit, every root was passed over
  const double slack = 1e-3 / cells + 4 * double(std::nextafter(at, 2e30f) - at);
  const Root* nearest = nullptr;
  for (const Root& r : roots) {
    if (steep(r) && r.t > exact.t0 + slack && r.t < exact.t1 - slack && r.t < hit.t - slack && crosses(r)) {
      score.missed++;
      return;
    }
    if (!nearest || std::abs(r.t - hit.t) < std::abs(nearest->t - hit.t)) nearest = &r;
  }
  if (!(hit.t < 1e30f)) return;
  if (nearest && steep(*nearest) && std::abs(nearest->t - hit.t) < slack) {
    const double off =
        (std::abs(hit.t - nearest->t) - 2 * double(std::nextafter(hit.t, 2e30f) - hit.t)) * cells;
    score.worst = std::max(score.worst, off);
    score.imprecise += off > 1e-4;
    return;
  }
  // tangential: the value there is the isovalue to rounding
  score.tangential++;
  const double ulp = double(std::nextafter(float(std::abs(iso)), FLT_MAX)) - std::abs(iso);
  const Cell cell(f, exact, hit.t, hit.t);
  const double off = std::abs(fieldAt(f, exact, hit.t) - iso);
  score.tangentialOff += off > 8 * ulp;
  score.wrong += off > 1e-4 * (cell.hi - cell.lo);
}

TEST(Isosurface, MarschnerLobbHasNoMissedRootAndNoWrongSheet) {
  const Field f = cube(41, marschnerLobb);
  Shown shown;
  shown.isovalues = {0.5f};
  const View<float> view(f, shown);
  Random random(31);
  Score s;
  for (int i = 0; i < sweep(100000); i++) compare(f, view, randomRay(random, f), 0.5, s);
  EXPECT_EQ(s.missed, 0);
  EXPECT_EQ(s.wrong, 0);
  EXPECT_EQ(s.imprecise, 0);
  EXPECT_EQ(s.tangentialOff, 0);
  EXPECT_GT(s.hits, sweep(20000));
  testing::Test::RecordProperty("hits", s.hits);
  testing::Test::RecordProperty("tangential", s.tangential);
  testing::Test::RecordProperty("worstCells", std::to_string(s.worst));
}

Score scoreOf(const Field& f, float iso, int rays, uint64_t seed) {
  Shown shown;
  shown.isovalues = {iso};
  const View<float> view(f, shown);
  Random random(seed);
  Score s;
  for (int i = 0; i < rays; i++) compare(f, view, randomRay(random, f), iso, s);
  return s;
}

// The side of the extrema decides, and they do not depend on the unit of the values.
TEST(Isosurface, BracketsAreTheSameAtAnyScaleOfTheValues) {
  Random random(39);
  single::RootQuery query{};
  query.tOut = 1e30f;
  query.tAfter = -1;
  int bracketed = 0;
  for (int i = 0; i < 2000; i++) {
    const single::vec4 b{float(random.in(-1, 1)), float(random.in(-2, 2)), float(random.in(-2, 2)),
                         float(random.in(-1, 1))};
    const single::Bracket one = firstBracket(b, 1, 0, query);
    bracketed += one.lo <= one.hi;
    for (int power = -90; power <= 120; power += 7) {
      const float s = std::ldexp(1.f, power);
      const single::Bracket other = firstBracket({s * b.x, s * b.y, s * b.z, s * b.w}, 1, 0, query);
      ASSERT_EQ(other.lo, one.lo) << power;
      ASSERT_EQ(other.hi, one.hi) << power;
    }
  }
  EXPECT_GT(bracketed, 800);
}

// Values are mixed as differences to the isovalue, so an offset of 1000 spans costs no digits: mixed as they are, 187 roots
// would be missed.
TEST(Isosurface, SamplesFarFromZeroAreHitAsPrecisely) {
  const Field f = cube(41, [](glm::dvec3 p) { return double(float(1000 + marschnerLobb(p))); });
  const Score s = scoreOf(f, 1000.5f, sweep(20000), 33);
  EXPECT_EQ(s.missed, 0);
  EXPECT_EQ(s.wrong, 0);
  EXPECT_LE(s.imprecise, 1);  // little steeper than what counts as tangential
  EXPECT_GT(s.hits, sweep(4000));
}

Field randomIntegers(Random& random, const Index3& n, int below) {
  return makeField(gridOf(n), [&](int64_t, int64_t, int64_t, int) { return double(random.below(below)); });
}

TEST(Isosurface, RandomCellsHaveNoMissedRootAndNoWrongSheet) {
  Random random(32);
  for (int i = 0; i < 200; i++) {
    const Index3 n{2 + random.below(5), 2 + random.below(5), 2 + random.below(5)};
    const Field f = makeField(gridOf(n, random.point(0.2, 1)),
                              [&](int64_t, int64_t, int64_t, int) { return random.unit(); });
    const Score s = scoreOf(f, float(random.in(0.2, 0.8)), 200, uint64_t(i));
    EXPECT_EQ(s.missed + s.wrong, 0) << i;
  }
}

TEST(Isosurface, IsovaluesEqualToSamplesMissNoCrossing) {
  Random random(33);
  for (int i = 0; i < 200; i++) {
    const Field f =
        randomIntegers(random, {2 + random.below(5), 2 + random.below(5), 2 + random.below(5)}, 3);
    for (float iso : {0.f, 1.f, 2.f}) {
      const Score s = scoreOf(f, iso, 100, uint64_t(i));
      EXPECT_EQ(s.missed + s.wrong, 0) << i << " isovalue " << iso;
    }
  }
}

TEST(Isosurface, ConstantFieldIsHitWhereTheRayEntersItOnlyAtItsOwnValue) {
  const Field f = makeField(gridOf({5, 6, 7}), [](int64_t, int64_t, int64_t, int) { return 0.3; });
  Random random(34);
  for (float iso : {0.3f, std::nextafter(0.3f, 0.f), std::nextafter(0.3f, 1.f)}) {
    Shown shown;
    shown.isovalues = {iso};
    const View<float> view(f, shown);
    for (int i = 0; i < 500; i++) {
      const auto ray = rayIn(view, randomRay(random, f));
      if (!(ray.t0 < ray.t1)) continue;
      const Hit hit = firstHit(view, ray);
      if (iso == 0.3f)
        EXPECT_EQ(hit.t, ray.t0);
      else
        EXPECT_EQ(hit.index, -1);
    }
  }
}

// Values 0 below x = 2, `iso` on [2, 4], 1 above; NaN at x = 0 and 1 if `hole`.
Field plateau(bool hole) {
  return makeField(gridOf({7, 4, 4}), [=](int64_t i, int64_t, int64_t, int) {
    if (hole && i < 2) return double(NAN);
    return i < 2 ? 0.0 : i <= 4 ? 0.5 : 1.0;
  });
}

TEST(Isosurface, PlateauIsHitOnceWhereTheRayEntersIt) {
  for (bool hole : {false, true}) {
    const Field f = plateau(hole);
    Shown shown;
    shown.isovalues = {0.5f};
    const View<float> view(f, shown);
    for (int backward = 0; backward < 2; backward++) {
      const double sign = backward ? -1 : 1;
      const auto ray = rayIn(view, {{-0.75 * sign, 0.01, 0.02}, {sign, 0, 0}});
      const Hit hit = firstHit(view, ray);
      const double entered = (0.75 + (backward ? 4 - 3 : 2 - 3) / 6.0 * sign);
      EXPECT_NEAR(double(hit.t), entered, 1e-6) << "hole " << hole << " backward " << backward;
      EXPECT_EQ(firstHit(view, ray, 0, 1e30f, hit.t).index, -1);
    }
    EXPECT_EQ(firstHit(view, rayIn(view, {{0, 0, 0}, {1, 0, 0}})).t, 0);
  }
}

TEST(Isosurface, PlateauOfAnyValueIsHitOnceAlongAnyRay) {
  Random random(38);
  int inside = 0, outside = 0;
  for (int scene = 0; scene < 40; scene++) {
    const float iso = float(random.scale(1e-3, 1e3) * (scene % 2 ? 1 : -1));
    // the isovalue at points 3 to 7, less around them
    const auto on = [](int64_t i) { return i >= 3 && i <= 7; };
    const Field f = makeField(gridOf({11, 11, 11}), [&](int64_t i, int64_t j, int64_t k, int) {
      return on(i) && on(j) && on(k) ? double(iso) : iso - std::abs(iso) * random.in(0.1, 1);
    });
    Shown shown;
    shown.isovalues = {iso};
    const View<float> view(f, shown);
    for (int i = 0; i < 200; i++) {
      const RaySpec spec = randomRay(random, f);
      const auto ray = rayIn(view, spec);
      const IndexRay exact = indexRay(ray, f);
      double t0 = 0, t1 = 1e30;  // in the box of the plateau
      bool inFace = false;
      for (int a = 0; a < 3; a++) {
        inFace = inFace || (exact.d[a] == 0 && (exact.o[a] == 3 || exact.o[a] == 7));
        const double x = (3 - exact.o[a]) / exact.d[a], y = (7 - exact.o[a]) / exact.d[a];
        t0 = std::max(t0, std::min(x, y)), t1 = std::min(t1, std::max(x, y));
      }
      const double cells = (t1 - t0) * glm::length(exact.d);
      if (inFace || !(std::abs(cells) > 0.01)) continue;  // or past an edge
      int hits = 0;
      for (Hit hit = firstHit(view, ray); hit.t < 1e30f && hits < 9; hits++)
        hit = firstHit(view, ray, 0, 1e30f, hit.t);
      EXPECT_EQ(hits, cells > 0 ? 1 : 0) << "scene " << scene << " ray " << i;
      (cells > 0 ? inside : outside)++;
    }
  }
  EXPECT_GT(inside, 1000);
  EXPECT_GT(outside, 1000);
}

TEST(Isosurface, NoDataCellsHoldNoSurface) {
  Random random(35);
  for (int i = 0; i < 100; i++) {
    const Field f = makeField(gridOf({6, 6, 6}), [&](int64_t, int64_t, int64_t, int) {
      const int kind = random.below(30);
      return kind == 0 ? double(NAN) : kind == 1 ? double(INFINITY) : random.unit();
    });
    const Score s = scoreOf(f, 0.5f, 200, uint64_t(i));
    EXPECT_EQ(s.missed + s.wrong, 0) << i;
  }
}

std::vector<std::pair<float, int>> allHits(const View<float>& view, const single::VolumeRay& ray, float tIn,
                                           float tOut) {
  std::vector<std::pair<float, int>> hits;
  float after = -1;
  for (int n = 0; n < 100; n++) {
    const Hit hit = firstHit(view, ray, tIn, tOut, after);
    if (!(hit.t < 1e30f)) break;
    hits.push_back({hit.t, hit.index});
    after = hit.t;
  }
  return hits;
}

TEST(Isosurface, EachHitIsInExactlyOneIntervalWithTheSameBits) {
  Random random(36);
  int different = 0, found = 0, cutAtHits = 0;
  for (int scene = 0; scene < 40; scene++) {
    const Index3 n{2 + random.below(20), 2 + random.below(20), 2 + random.below(20)};
    const Field f =
        scene % 2 ? randomIntegers(random, n, 4) : sampled(gridOf(n, random.point(0.3, 1)), turbulence);
    Shown shown;
    shown.isovalues = scene % 2 ? std::vector<float>{1, 2.5f} : std::vector<float>{0.4f, 0.5f, 0.55f};
    const View<float> view(f, shown);
    for (int i = 0; i < 150; i++) {
      const auto ray = rayIn(view, randomRay(random, f));
      const auto whole = allHits(view, ray, 0, 1e30f);
      std::vector<float> cuts{0};
      for (int c = random.below(12); c > 0; c--) {
        const int axis = random.below(3);
        const float crossing = (float(random.below(20)) - ray.g.po[axis]) * ray.g.rpd[axis];
        cuts.push_back(random.below(2) ? crossing : float(random.in(0, 2)));
        if (!whole.empty() && random.below(4) == 0)
          cuts.back() = whole[size_t(random.below(int(whole.size())))].first, cutAtHits++;
      }
      std::erase_if(cuts, [](float t) { return !(t >= 0 && t < 100); });
      std::sort(cuts.begin(), cuts.end());
      cuts.push_back(1e30f);
      std::vector<std::pair<float, int>> split;
      for (size_t k = 0; k + 1 < cuts.size(); k++)
        for (const auto& h : allHits(view, ray, cuts[k], cuts[k + 1])) split.push_back(h);
      different += split != whole;
      found += int(whole.size());
    }
  }
  EXPECT_EQ(different, 0);
  EXPECT_GT(found, 3000);
  EXPECT_GT(cutAtHits, 1000);
}

TEST(Isosurface, TheNearestOfSeveralIsovaluesWins) {
  const Field f = cube(24, turbulence);
  Shown all;
  all.isovalues = {0.55f, 0.4f, 0.5f, 0.5f};
  const View<float> view(f, all);
  Random random(37);
  for (int i = 0; i < sweep(2000); i++) {
    const RaySpec spec = randomRay(random, f);
    Hit nearest{1e30f, -1};
    for (int k = 0; k < 4; k++) {
      Shown one;
      one.isovalues = {all.isovalues[size_t(k)]};
      const View<float> single(f, one);
      const Hit hit = firstHit(single, rayIn(single, spec));
      if (hit.t < nearest.t) nearest = {hit.t, k};
    }
    const Hit hit = firstHit(view, rayIn(view, spec));
    EXPECT_EQ(hit.t, nearest.t);
    EXPECT_EQ(hit.index, nearest.index);
  }
}

// Starts rays at hits, on the side from which they were hit; `again` counts those that see their own surface, `lost` those
// that pass the next crossing: one that leaves the side they are on, or any where gaps without data lie between.
void startRays(const Field& f, float iso, uint64_t seed, int rays, int& started, int& again, int& lost,
               bool gaps = false) {
  Shown shown;
  shown.isovalues = {iso};
  const View<float> view(f, shown);
  Random random(seed);
  for (int i = 0; i < rays; i++) {
    const RaySpec spec = randomRay(random, f);
    const auto ray = rayIn(view, spec);
    const Hit hit = firstHit(view, ray);
    if (!(hit.t < 1e30f) || hit.t == ray.t0) continue;
    const glm::vec3 point = glm::vec3(spec.o) + hit.t * glm::vec3(spec.d);
    const glm::dvec3 at(pointAt(ray.g, hit.t));
    const IndexRay first = indexRay(ray, f);
    glm::vec3 normal(glm::normalize(Cell(f, first, hit.t, hit.t).gradient(at) / f.grid.spacing));
    const bool outside = glm::dot(normal, glm::vec3(spec.d)) < 0;  // it came from the side of larger values
    if (!outside) normal = -normal;
    const single::IsoStart start{0, outside ? 1 : -1};
    const glm::vec3 origin = single::offsetOrigin(point, normal, 0.5f);
    glm::dvec3 d = random.direction();
    if (glm::dot(d, glm::dvec3(normal)) < 0) d = -d;
    if (glm::dot(d, glm::dvec3(normal)) < 0.02) continue;  // grazing: a curved surface may truly be met again
    const auto second = rayIn(view, {origin, d});
    const IndexRay exact = indexRay(second, f);
    const double cells = glm::length(exact.d);
    // in a crease between cells the ray may go straight into the neighbour's part of the surface
    const glm::dvec3 ahead = Cell(f, exact, 0, 2e-3 / cells).gradient(exact.o) / f.grid.spacing;
    if (glm::dot(ahead, d) * (outside ? 1 : -1) < 0.02 * glm::length(ahead)) continue;
    const Hit next = firstHit(view, second, 0, 1e30f, -1, start);
    started++;
    // what it should meet: the first crossing in double that leaves the side on which it starts
    double expected = 1e30;
    bool real = false;  // the surface bends so much that it is met again within a hundredth of a cell
    for (const Root& r : rootsAlong(f, exact, iso))
      real = real || (r.rising == !outside && r.t * cells > 1e-4 && std::abs(r.t - next.t) * cells < 1e-3);
    again += next.t * cells < 1e-2 && !real;
    for (const Root& r : rootsAlong(f, exact, iso))
      if ((gaps || r.rising == !outside) && r.t * cells > 1e-2 && std::abs(r.slope) > 1e-3 * r.range) {
        expected = r.t;
        break;
      }
    lost += next.t > expected + 1e-3 / cells && expected < exact.t1 - 1e-3 / cells;
  }
}

TEST(Isosurface, SecondaryRaysNeverMeetTheirOwnStart) {
  int started = 0, again = 0, lost = 0;
  startRays(cube(33, [](glm::dvec3 p) { return glm::length(p); }), 0.6f, 41, sweep(60000), started, again,
            lost);
  startRays(cube(41, marschnerLobb), 0.5f, 42, sweep(80000), started, again, lost);
  startRays(sampled(gridOf({20, 90, 60}, {3, 0.5, 1}), turbulence), 0.5f, 43, sweep(80000), started, again,
            lost);
  startRays(cube(200, [](glm::dvec3 p) { return glm::length(p); }), 0.6f, 44, sweep(60000), started, again,
            lost);
  EXPECT_EQ(again, 0);
  EXPECT_EQ(lost, 0);
  EXPECT_GT(started, sweep(100000));
  testing::Test::RecordProperty("started", started);
}

TEST(Isosurface, SecondaryRaysMeetASurfaceBehindAGapFromItsOtherSide) {
  // along x: a surface at 1.5, no data between 4 and 6, then the other side until 8.5
  for (int side : {-1, 1}) {
    const Field f = makeField(gridOf({11, 4, 4}), [=](int64_t i, int64_t, int64_t, int) {
      return i == 5 ? double(NAN) : i < 2 || (i > 5 && i < 9) ? -side : side;
    });
    Shown shown;
    shown.isovalues = {0};
    const View<float> view(f, shown);
    const auto ray = rayIn(view, {{(1.50001 - 5) / 10, 0.01, 0.02}, {1, 0, 0}});
    const Hit hit = firstHit(view, ray, 0, 1e30f, -1, {0, side});
    EXPECT_NEAR(double(hit.t), 0.7, 1e-5) << side;
    EXPECT_EQ(firstHit(view, ray, 0.6f, 1e30f, -1, {0, side}).t, hit.t) << "from the next partition";
  }
}

TEST(Isosurface, SecondaryRaysLoseHardlyACrossingAmongGaps) {
  Random random(45);
  int started = 0, again = 0, lost = 0;
  for (int i = 0; i < sweep(200); i++) {
    const Field f = makeField(gridOf({8, 8, 8}), [&](int64_t, int64_t, int64_t, int) {
      return random.below(25) == 0 ? double(NAN) : random.unit();
    });
    startRays(f, 0.5f, uint64_t(i), 400, started, again, lost, true);
  }
  EXPECT_LE(lost, 1);  // where the first quarter of a cell cuts the corner of a gap
  EXPECT_GT(started, sweep(20000));
  testing::Test::RecordProperty("started", started);
}

Index3 macrocellOf(const Field& f, size_t i) {
  const Index3& n = f.block.macrocells;
  const int64_t at = int64_t(i);
  return {f.block.firstMacrocell[0] + at % n[0], f.block.firstMacrocell[1] + at / n[0] % n[1],
          f.block.firstMacrocell[2] + at / n[0] / n[1]};
}

// Whether the block holds the cell, and one of the isovalues lies in the range of its corners.
bool straddles(const Field& f, const Index3& cell, const std::vector<float>& isovalues) {
  const Extent& e = f.block.extent;
  for (int a = 0; a < 3; a++)
    if (cell[a] < e.first[a] || cell[a] + 1 >= e.first[a] + e.points[a]) return false;
  for (float iso : isovalues) {
    bool below = false, above = false;
    for (int c = 0; c < 8; c++) {
      const float s = float(f.at(cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2)));
      below = below || s <= iso;
      above = above || s >= iso;
    }
    if (below && above) return true;
  }
  return false;
}

TEST(IsoMask, BitsAreOfTheCellsThatAnIsovaluePassesThrough) {
  Random random(51);
  for (int scene = 0; scene < 60; scene++) {
    const Index3 n{2 + random.below(40), 2 + random.below(30), 2 + random.below(30)};
    Extent part;
    for (int a = 0; a < 3; a++) {
      part.first[a] = random.below(int(n[a]) / 2);
      part.points[a] = 2 + random.below(int(n[a] - part.first[a]) - 1);
    }
    const ScalarType stored = scene % 3 == 0   ? ScalarType::Float32
                              : scene % 3 == 1 ? ScalarType::UInt8
                                               : ScalarType::Int16;
    const int components = scene % 4 == 0 ? 3 : 1, component = scene % 8 == 0 ? -1 : components - 1;
    const double quiet = random.in(0, 12);  // where it is quiet, macrocells hold no isovalue
    const Field f = makeField(
        gridOf(n),
        [&](int64_t i, int64_t j, int64_t, int c) {
          if (stored == ScalarType::Float32 && random.below(200) == 0) return double(NAN);
          return double(i) < quiet || j > 20 ? 0.0 : double(random.below(30) + c);
        },
        stored, components, component, part);
    const std::vector<float> isovalues =
        scene % 2 ? std::vector<float>{5.5f} : std::vector<float>{25, 0.5f, 7};
    const auto plan = isoMask(f.block, stored, components, component, f.macrocells(), isovalues);
    for (size_t m = 0; m < f.macrocells().size(); m++) {
      const Index3 at = macrocellOf(f, m);
      for (int c = 0; c < 512; c++) {
        const Index3 cell{8 * at[0] + c % 8, 8 * at[1] + c / 8 % 8, 8 * at[2] + c / 64};
        const bool bit = plan[m] > 0 && (plan.at(size_t(plan[m]) + size_t(c) / 32) >> c % 32 & 1);
        ASSERT_EQ(bit, straddles(f, cell, isovalues))
            << "scene " << scene << " macrocell " << m << " cell " << c;
      }
    }
  }
}

// A small sphere, in the middle of nothing.
Field mostlyEmpty() {
  return sampled(gridOf({150, 90, 131}),
                 [](glm::dvec3 p) { return std::min(0.2, glm::length(p - glm::dvec3(0.3, -0.1, 0.2))); });
}

TEST(IsoMask, LevelsAreOfTheLargestEmptyCubes) {
  const Field f = mostlyEmpty();
  const auto plan = isoMask(f.block, f.stored, 1, 0, f.macrocells(), std::vector<float>{0.15f});
  const Index3& n = f.block.macrocells;
  int most = 0;
  for (size_t m = 0; m < f.macrocells().size(); m++) {
    if (plan[m] > 0) continue;
    const Index3 at = macrocellOf(f, m);
    int level = 0;
    for (int k = 1; k <= 3; k++) {
      bool empty = true;
      for (size_t o = 0; o < f.macrocells().size(); o++) {
        const Index3 other = macrocellOf(f, o);
        const bool same =
            at[0] >> k == other[0] >> k && at[1] >> k == other[1] >> k && at[2] >> k == other[2] >> k;
        empty = empty && !(same && plan[o] > 0);
      }
      if (empty) level = k;
    }
    EXPECT_EQ(plan[m], -level) << m;
    most += level == 3;
  }
  EXPECT_GT(most, int(n[0] * n[1] * n[2]) / 3);
}

TEST(IsoMask, WhatItSkipsHoldsNoHit) {
  const Field empty = mostlyEmpty(), full = cube(70, turbulence);
  for (const Field* f : {&empty, &full}) {
    Shown shown;
    shown.isovalues = {f == &empty ? 0.15f : 0.5f};
    const View<float> view(*f, shown);
    auto all = *view;  // every cell of every macrocell may hold a hit
    const std::vector<int32_t> everywhere = everyCell(f->macrocells().size());
    all.isoMask = everywhere.data();
    auto few = *view;  // room for the bits of two macrocells
    const size_t most = (f->macrocells().size() + 15) / 16 * 16 + 3 * kIsoWords;
    const auto limited = isoMask(f->block, f->stored, 1, 0, f->macrocells(), shown.isovalues, most);
    EXPECT_EQ(limited.size(), most);
    few.isoMask = limited.data();
    Random random(52);
    int hits = 0;
    for (int i = 0; i < sweep(20000); i++) {
      const auto ray = rayIn(view, randomRay(random, *f));
      const Hit hit = firstHit(view, ray);
      int cells = 0, skipped = 0;
      EXPECT_EQ(firstIsosurface(all, ray, 0.f, 1e30f, -1.f, kNowhere, cells, skipped).t, hit.t);
      EXPECT_EQ(firstIsosurface(few, ray, 0.f, 1e30f, -1.f, kNowhere, cells, skipped).t, hit.t);
      hits += hit.t < 1e30f;
    }
    EXPECT_GT(hits, sweep(400));
  }
}

}  // namespace
}  // namespace gxy::test
