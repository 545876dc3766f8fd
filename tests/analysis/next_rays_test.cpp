// SPDX-License-Identifier: Apache-2.0
// Rays that follow others, and samples at equal distances, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>

#include "core/analysis/next_rays.h"
#include "core/analysis/ray_filter.h"
#include "tests/analysis/sampled.h"

namespace gxy::test {
namespace {

using Way = NextRule::Way;
constexpr double kSphere = 0.3;

/// A ray that follows a hit, and the hit.
struct Followed {
  glm::dvec3 at, before, after;  ///< where, and the directions of both rays
  glm::dvec3 from;               ///< where the new ray begins
  uint32_t info, depth;
  uint64_t number;
};

/// Rays from a sphere around the middle of the unit cube towards points near the middle.
std::vector<SampleRay> raysAround(double radius, int count) {
  std::vector<SampleRay> rays;
  for (int i = 0; i < count; i++) {
    const double z = 1 - 2 * (i + 0.5) / count, a = 2.399963 * i, r = std::sqrt(1 - z * z);
    const glm::dvec3 from = 0.5 + radius * glm::dvec3(r * std::cos(a), r * std::sin(a), z);
    const glm::dvec3 to =
        0.5 + 0.7 * kSphere * glm::dvec3(std::sin(1.3 * i), std::cos(2.1 * i), std::sin(0.7 * i)) / 1.8;
    rays.push_back({uint64_t(i), from, to - from});
  }
  return rays;
}

/// What follows the hits of rays, by a rule for all operators, in one partition.
std::vector<Followed> followed(SamplingCase c, const std::vector<SampleRay>& rays, NextRule rule,
                               uint32_t seed = 0) {
  c.met = true;
  SamplingRanks ranks(whole(unitCube()), {});
  std::vector<Followed> all;
  const auto errors = ranks.run(c, [&](int, Sampler& sampler, auto sampling, Collectives& world) {
    const SampleList list =
        sampler.sample(sampling, std::make_shared<GivenRays>(rays, unitCube()), world).list;
    if (rule.way != Way::Stop && rule.field.volume == nullptr && !c.fields.empty())
      rule.field = sampling->compiled->fields[0];
    const NextRays next(*sampling->compiled, list, std::vector<NextRule>(c.operators.size(), rule), seed);
    std::map<uint64_t, size_t> sampleOf;
    for (size_t i = 0; i < list.size(); i++) sampleOf[list.ray[i]] = i;
    const RenderSpace& space = sampling->scene.compiled->space;
    for (size_t k = 0; k < next.chunks(); k++) {
      const RayList made = next.rays(k, space);
      const RayView& v = made.view();
      for (int i = 0; i < made.size(); i++) {
        const uint64_t number = v.pixel[i] | uint64_t(uint32_t(v.sr[i])) << 32;
        const size_t parent = sampleOf.at(number / uint64_t(rule.children()));
        all.push_back({list.position[parent],
                       list.met[parent].direction,
                       {v.dx[i], v.dy[i], v.dz[i]},
                       space.centre + glm::dvec3(v.ox[i], v.oy[i], v.oz[i]) / space.scale,
                       v.info[i],
                       uint32_t(v.sg[i]),
                       number});
      }
    }
  });
  EXPECT_EQ(errors[0], "");
  return all;
}

SamplingCase smallSphere() {
  SamplingCase c = isosurfaceOf(sampled(unitGrid(17), squaredDistance), kSphere * kSphere);
  c.rules[0].hits = 1;
  return c;
}

TEST(NextRays, RefractAtASphereAsSnellSays) {
  NextRule glass;
  glass.way = Way::Refract;
  glass.n1 = 1.5;  // inside, where the squared distance is small
  glass.n2 = 1.1;
  for (const double from : {0.48, 0.05}) {  // from outside, and from inside
    const auto all = followed(smallSphere(), raysAround(from, 400), glass);
    EXPECT_EQ(all.size(), 400u);
    for (const Followed& f : all) {
      const glm::dvec3 n = glm::normalize(f.at - 0.5);
      const bool enters = glm::dot(f.before, n) < 0;
      EXPECT_EQ(enters, from > kSphere);
      const double first = enters ? glass.n2 : glass.n1, second = enters ? glass.n1 : glass.n2;
      EXPECT_LT(glm::length(first * glm::cross(f.before, n) - second * glm::cross(f.after, n)), 1e-6);
      EXPECT_EQ(glm::dot(f.after, n) < 0, enters);
      EXPECT_LT(glm::length(f.from - f.at), 4e-6);
      EXPECT_EQ(f.depth, 1u);
    }
  }
}

TEST(NextRays, AreMirroredWhereNothingIsRefracted) {
  NextRule glass;
  glass.way = Way::Refract;
  glass.n1 = 4;
  glass.n2 = 1;
  int total = 0;
  for (const Followed& f : followed(smallSphere(), raysAround(0.2, 300), glass)) {
    const glm::dvec3 n = glm::normalize(f.at - 0.5);
    if (4 * glm::length(glm::cross(f.before, n)) <= 1) continue;
    total++;
    EXPECT_LT(glm::length(f.after - (f.before - 2 * glm::dot(f.before, n) * n)), 1e-6);
  }
  EXPECT_GT(total, 20);
}

TEST(NextRays, AreMirroredAtAPlane) {
  SamplingCase c = smallSphere();
  c.operators[0].isovalues.clear();
  c.operators[0].slices = {{glm::dvec3(1, 2, -2), 0.6}};
  NextRule mirror;
  mirror.way = Way::Mirror;
  const glm::dvec3 n = glm::dvec3(1, 2, -2) / 3.0;
  const auto all = followed(c, raysAround(0.45, 300), mirror);
  EXPECT_GT(all.size(), 200u);
  for (const Followed& f : all) {
    EXPECT_LT(glm::length(f.after - (f.before - 2 * glm::dot(f.before, n) * n)), 3e-7);
    EXPECT_GT(glm::dot(f.from - f.at, n) * -glm::dot(f.before, n), 0);  // on the side that it came from
  }
}

TEST(NextRays, FollowGradientsAndFields) {
  SamplingCase c = smallSphere();
  c.fields = {{0, 0}};
  NextRule rule;
  for (const Way way : {Way::AlongGradient, Way::AgainstGradient}) {
    rule.way = way;
    const auto all = followed(c, raysAround(0.45, 100), rule);
    EXPECT_EQ(all.size(), 100u);
    for (const Followed& f : all)
      EXPECT_LT(glm::length(f.after - glm::normalize(f.at - 0.5) * (way == Way::AlongGradient ? 1.0 : -1.0)),
                1e-6);
  }
  // A vector field that is trilinear: (y, 1 - x, z / 2 + x y).
  WholeVolume vectors = sampled(unitGrid(9), [](glm::dvec3 p) { return p.y; });
  std::vector<float> values;
  for (int z = 0; z < 9; z++)
    for (int y = 0; y < 9; y++)
      for (int x = 0; x < 9; x++)
        for (const double v : {y / 8.0, 1 - x / 8.0, z / 16.0 + x * y / 64.0}) values.push_back(float(v));
  vectors.components = 3;
  vectors.samples.resize(values.size() * 4);
  std::memcpy(vectors.samples.data(), values.data(), vectors.samples.size());
  c.volumes.push_back(vectors);
  c.fields = {{1, 0}};
  rule.way = Way::AlongField;
  const auto all = followed(c, raysAround(0.45, 100), rule);
  EXPECT_EQ(all.size(), 100u);
  for (const Followed& f : all) {
    const glm::dvec3 p = f.at;
    EXPECT_LT(glm::length(f.after - glm::normalize(glm::dvec3(p.y, 1 - p.x, p.z / 2 + p.x * p.y))), 1e-6);
  }
}

TEST(NextRays, AreSpreadOverAHemisphereOrASphere) {
  NextRule rule;
  rule.way = Way::Spawn;
  rule.rays = 4000;
  struct Expected {
    bool sphere, uniform;
    double cosine, square;  // their means
  };
  for (const Expected& e :
       {Expected{false, false, 2.0 / 3, 0.5}, {false, true, 0.5, 1.0 / 3}, {true, true, 0, 1.0 / 3}}) {
    rule.sphere = e.sphere, rule.uniform = e.uniform;
    const auto all = followed(smallSphere(), raysAround(0.48, 2), rule);
    ASSERT_EQ(all.size(), 8000u);
    double cosine = 0, square = 0;
    glm::dvec3 mean(0);
    for (const Followed& f : all) {
      // The normal of the surface itself, which is trilinear in a cell: that of its squares is the same in all of it.
      const glm::dvec3 n = glm::normalize((glm::floor(f.at * 16.0) + 0.5) / 16.0 - 0.5);
      const double c = glm::dot(f.after, n);
      if (!e.sphere) {
        EXPECT_GT(c, -1e-6);
      }
      cosine += c / 8000, square += c * c / 8000;
      EXPECT_NEAR(glm::length(f.after), 1, 1e-6);
      if (&f < &all[4000]) mean += f.after / 4000.0;
    }
    EXPECT_NEAR(cosine, e.cosine, 5e-3);
    EXPECT_NEAR(square, e.square, 5e-3);
    EXPECT_NEAR(glm::length(mean), e.cosine, 5e-3);  // turned about no axis but the normal
  }
  const auto other = followed(smallSphere(), raysAround(0.48, 2), rule, 1),
             same = followed(smallSphere(), raysAround(0.48, 2), rule, 1),
             first = followed(smallSphere(), raysAround(0.48, 2), rule);
  EXPECT_EQ(other[17].after, same[17].after);
  EXPECT_NE(other[17].after, first[17].after);
}

TEST(NextRays, AreBoundedBeforeTheyBegin) {
  EXPECT_EQ(checkedFollowingRays(10, 10, 3, 3), 10u * (1 + 3 + 9 + 27));
  EXPECT_EQ(checkedFollowingRays(10, UINT64_MAX / 2, 0, 0), 10u);
  EXPECT_THROW(checkedFollowingRays(1 << 20, 1 << 20, 16, 4), Error);
  EXPECT_THROW(checkedFollowingRays(10, uint64_t(1) << 60, 4, 2), Error);
}

/// The larger of the distances from the middle along an axis: its isosurfaces are cubes whose edges are rounded inwards.
const WholeVolume& cubes() {
  static const WholeVolume volume = sampled(unitGrid(21), [](glm::dvec3 p) {
    const glm::dvec3 q = glm::abs(p - 0.5);
    return std::max({q.x, q.y, q.z});
  });
  return volume;
}
const WholeVolume& rising() {
  static const WholeVolume volume = sampled(unitGrid(17), [](glm::dvec3 p) { return p.x; });
  return volume;
}
const WholeVolume& holed() {  // no data where 0.4375 < x < 0.5625
  static const WholeVolume volume = sampled(unitGrid(17), [](glm::dvec3 p) {
    return std::abs(p.x - 0.5) < 0.01 ? std::numeric_limits<double>::quiet_NaN() : p.x;
  });
  return volume;
}

Evaluation rayInputs() {
  Evaluation e;
  e.inputs = {{"cubes", {&cubes()}}, {"x", {&rising()}}, {"holed", {&holed()}}};
  WholeGeometry points;
  for (int i = 0; i < 30; i++) {
    points.block.ids.push_back(uint64_t(i));
    points.block.points.push_back({0.5 + 0.02 * std::sin(1.0 * i), 0.5 + 0.02 * std::cos(3.0 * i), 0.49});
  }
  e.geometry["points"] = points;
  WholeGeometry floor;
  floor.kind = GeometryKind::Triangles;
  floor.block.points = {{0, 0, 0.25}, {1, 0, 0.25}, {1, 1, 0.25}, {0, 1, 0.25}};
  floor.block.triangles = {{0, 1, 2}, {0, 2, 3}};
  floor.block.ids = {0, 1};
  e.geometry["floor"] = floor;
  return e;
}

std::vector<Cut> rayCuts() {
  return {lattice(unitCube(), {2, 2, 1}, 2), kdCut(unitCube(), 7, 3, 5),
          octants(unitCube(), {0.4, 0.55, 0.62}, 4)};
}

/// The same on all cuts.
SampledPoints rayPointsOnAll(const std::string& properties) {
  const SampledPoints all = evaluateOn<RaySampler>(whole(unitCube()), rayInputs(), properties);
  for (const Cut& cut : rayCuts())
    EXPECT_EQ(evaluateOn<RaySampler>(cut, rayInputs(), properties), all) << cut.name;
  return all;
}

TEST(RaysThatFollow, AreAsManyAsTheirAncestorsSpawn) {
  // Rays that start inside a convex surface meet it once, and those that begin there inwards, too.
  const SampledPoints all =
      rayPointsOnAll(R"({"operators":[{"dataset":"cubes","isovalues":[0.287],"next":{"spawn":3}}],
    "points":"points","direction":[1,2,3],"depth":3,"seed":4})");
  EXPECT_EQ(all.points.size(), 30u * (1 + 3 + 9 + 27));
  EXPECT_EQ(all.told.at("rays"), 30);
  EXPECT_EQ(all.told.at("following rays"), 30 * (3 + 9 + 27));
  for (const auto& [id, point] : all.points) {
    const glm::dvec3 q = glm::abs(point.first - 0.5);
    EXPECT_LT(std::max({q.x, q.y, q.z}), 0.287 + 1e-5);
    EXPECT_GT(std::max({q.x, q.y, q.z}), 0.287 - 0.03);
  }
  // Points come by generations, and in each by rays: so the parent of each is known. None has met the surface where it began.
  for (uint64_t parents = 0, of = 30, id = 30; id < 1200; parents += of, of *= 3)
    for (uint64_t child = 0; child < 3 * of; child++, id++)
      EXPECT_GT(glm::length(all.points.at(id).first - all.points.at(parents + child / 3).first), 1e-4) << id;
}

TEST(RaysThatFollow, GoOnFromMirrorsOfPlanesAndTriangles) {
  for (const char* mirror : {R"({"dataset":"x","planes":[[0,0,2,0.5]],"next":{"redirect":"mirror"}})",
                             R"({"dataset":"floor","next":{"redirect":"mirror"}})"}) {
    const SampledPoints all =
        rayPointsOnAll(std::string(R"({"rays":[[0.2,0.3,0.85,0.3,0.2,-1]],"operators":[)") + mirror +
                       R"(,{"dataset":"x","planes":[[0,0,1,0.65]],"hits":9}],"depth":4})");
    // Down through the plane at 0.65 to the mirror at 0.25, and up again.
    ASSERT_EQ(all.points.size(), 3u);
    const glm::dvec3 down = glm::dvec3(0.3, 0.2, -1), up(0.3, 0.2, 1), from(0.2, 0.3, 0.85);
    const glm::dvec3 expected[] = {from + 0.2 * down, from + 0.6 * down, from + 0.6 * down + 0.4 * up};
    for (int i = 0; i < 3; i++)
      EXPECT_LT(glm::length(all.points.at(uint64_t(i)).first - expected[i]), 1e-5) << i;
    EXPECT_EQ(all.told.at("following rays"), 1);
  }
}

TEST(RaysThatFollow, GoAlongGradientsAndGivenDirections) {
  for (const auto& [next, at] :
       {std::pair(R"({"redirect":"gradient","field":"x"})", glm::dvec3(0.75, 0.4, 0.25)),
        {R"({"redirect":"against gradient","field":"x"})", glm::dvec3(0.125, 0.4, 0.25)},
        {R"({"redirect":"direction","direction":[2,-1,0]})", glm::dvec3(0.75, 0.4 - 0.225, 0.25)}}) {
    const SampledPoints all = rayPointsOnAll(
        std::string(R"({"rays":[[0.3,0.4,0.85,0,0,-1]],"operators":[{"dataset":"floor","next":)") + next +
        R"(},{"dataset":"x","isovalues":[0.125,0.75]}]})");
    ASSERT_EQ(all.points.size(), 2u);
    EXPECT_LT(glm::length(all.points.at(1).first - at), 1e-5) << next;
  }
}

TEST(RaysThatFollow, FollowTheFirstOfEqualDistancesUnlessHitsSaysAnother) {
  const auto count = [](const std::string& hits) {
    return rayPointsOnAll(R"({"rays":[[0.3,0.5,0.85,0,0,-1]],"operators":[{"dataset":"x","every":0.2,)" +
                          hits + R"("next":{"redirect":"direction","direction":[1e200,0,0]}}]})");
  };
  // Down to 0.65, and from there along x, where the next place is 0.2 on; the last generation ends there.
  const SampledPoints one = count("");
  ASSERT_EQ(one.points.size(), 2u);
  EXPECT_LT(glm::length(one.points.at(0).first - glm::dvec3(0.3, 0.5, 0.65)), 1e-5);
  EXPECT_LT(glm::length(one.points.at(1).first - glm::dvec3(0.5, 0.5, 0.65)), 1e-5);
  const SampledPoints two = count(R"("hits":2,)");
  ASSERT_EQ(two.points.size(), 4u);
  EXPECT_LT(glm::length(two.points.at(3).first - glm::dvec3(0.7, 0.5, 0.45)), 1e-5);
}

TEST(SamplesAtEqualDistances, AreWhereTheyAreCounted) {
  const auto every = [](const std::string& ray, const std::string& length, const std::string& more = "") {
    return rayPointsOnAll(R"({"rays":[)" + ray + R"(],"values":"x","operators":[{"dataset":"x","every":)" +
                          length + "}" + more + "]}");
  };
  const SampledPoints along = every("[-1,0.5,0.5,2,0,0]", "0.15");
  ASSERT_EQ(along.points.size(), 6u);
  for (int k = 1; k <= 6; k++) {
    EXPECT_NEAR(along.points.at(uint64_t(k - 1)).first.x, 0.15 * k, 1e-6);
    EXPECT_NEAR(along.points.at(uint64_t(k - 1)).second, 0.15 * k, 1e-6);
  }
  const SampledPoints diagonal = every("[0,0,0,1,1,1]", "0.1");
  ASSERT_EQ(diagonal.points.size(), 17u);
  EXPECT_NEAR(diagonal.points.at(16).first.y, 1.7 / std::sqrt(3.0), 1e-6);
  EXPECT_EQ(every("[0.3,0.5,0.5,1,0,0]", "0.2").points.size(), 3u);
  // Until another operator ends the ray.
  const SampledPoints ended = every("[-1,0.5,0.5,1,0,0]", "0.15", R"(,{"dataset":"x","isovalues":[0.5]})");
  ASSERT_EQ(ended.points.size(), 4u);
  EXPECT_NEAR(ended.points.at(3).first.x, 0.5, 1e-6);
}

TEST(SamplesAtEqualDistances, AreWhereThereIsData) {
  const SampledPoints all = rayPointsOnAll(
      R"({"rays":[[0,0.5,0.5,1,0,0]],"values":"x","operators":[{"dataset":"holed","every":0.06}]})");
  EXPECT_EQ(all.points.size(), 14u);  // of 16: not at 0.48 and 0.54
  for (const auto& [id, point] : all.points) EXPECT_GT(std::abs(point.first.x - 0.5), 0.0625);
}

TEST(SamplesAtEqualDistances, CountWhereConditionsHold) {
  const SampledPoints all =
      rayPointsOnAll(R"({"rays":[[0,0.5,0.5,1,0,0]],"operators":[{"dataset":"cubes","every":0.01,
    "conditions":[{"field":"x","range":[0.205,0.405]}],"hits":5}]})");
  ASSERT_EQ(all.points.size(), 5u);
  for (int k = 0; k < 5; k++) EXPECT_NEAR(all.points.at(uint64_t(k)).first.x, 0.21 + 0.01 * k, 1e-6);
}

TEST(RaysFromPoints, GoWhereAFieldPoints) {
  WholeVolume vectors = sampled(unitGrid(3), [](glm::dvec3) { return 0; });
  std::vector<float> values;
  for (int z = 0; z < 3; z++)
    for (int y = 0; y < 3; y++)
      for (int x = 0; x < 3; x++)
        for (const double v : {x / 2.0 - 0.5, y / 2.0 - 0.5, 2.0}) values.push_back(float(v));
  vectors.components = 3;
  vectors.samples.resize(values.size() * 4);
  std::memcpy(vectors.samples.data(), values.data(), vectors.samples.size());
  Evaluation e = rayInputs();
  e.inputs["away"] = {&vectors};
  e.geometry["points"].block.points[7] = {1.5, 0.5, 0.5};  // outside: it has no direction
  const std::string properties =
      R"({"operators":[{"dataset":"x","planes":[[0,0,1,0.99]]}],"points":"points","direction":"away"})";
  const SampledPoints all = evaluateOn<RaySampler>(whole(unitCube()), e, properties);
  EXPECT_EQ(all.told.at("rays"), 29);
  ASSERT_EQ(all.points.size(), 29u);
  for (uint64_t i = 0; i < 29; i++) {
    const glm::dvec3 from = e.geometry["points"].block.points[i < 7 ? i : i + 1];
    // 0.5 up at a slope of (p - 0.5) / 2.
    EXPECT_LT(glm::length(all.points.at(i).first - (from + 0.25 * glm::dvec3(from.x - 0.5, from.y - 0.5, 2))),
              1e-6);
  }
  for (const Cut& cut : rayCuts()) EXPECT_EQ(evaluateOn<RaySampler>(cut, e, properties), all) << cut.name;
}

TEST(RaysThatFollow, RefuseWhatCannotBe) {
  const auto says = [](const std::string& op, const std::string& more, const std::string& what) {
    std::string error = "no error";
    try {
      evaluateOn<RaySampler>(lattice(unitCube(), {2, 1, 1}, 2), rayInputs(),
                             R"({"operators":[)" + op + "]," + more + "}");
    } catch (const Error& e) {
      error = e.what();
    }
    EXPECT_NE(error.find(what), std::string::npos) << error;
  };
  const std::string rays = R"("lines":10)";
  const auto next = [](const std::string& n) {
    return R"({"dataset":"x","isovalues":[0.5],"next":)" + n + "}";
  };
  says(next(R"("on")"), rays, "\"stop\", \"continue\", or an object");
  says(next("{}"), rays, "either `redirect` or `spawn`");
  says(next(R"({"redirect":"mirror","spawn":2})"), rays, "either `redirect` or `spawn`");
  says(next(R"({"redirect":"up"})"), rays, "against gradient");
  says(next(R"({"redirect":"refract","n1":1})"), rays, "`n1` and `n2`");
  says(next(R"({"redirect":"field"})"), rays, "the vector field as `field`");
  says(next(R"({"redirect":"field","field":"x"})"), rays, "which has 1 components, expected 3");
  says(next(R"({"redirect":"gradient","field":"floor"})"), rays, "expected a volume");
  says(next(R"({"redirect":"direction"})"), rays, "a `direction` that is not 0");
  says(next(R"({"spawn":0})"), rays, "integer 1 to 65536");
  says(next(R"({"spawn":2,"over":"cube"})"), rays, "hemisphere or sphere");
  says(next(R"({"spawn":65536})"), rays + R"(,"depth":2)", "expected at most 4294967296");
  says(next("\"stop\""), rays + R"(,"depth":9)", "depth");
  says(R"({"dataset":"x","every":0.1,"next":{"redirect":"mirror"}})", rays, "expected no `every` there");
  says(R"({"dataset":"x","every":1e-6})", rays, "32768th");
  says(R"({"dataset":"x","every":0})", rays, "number > 0");
  says(R"({"dataset":"floor","every":0.1})", rays, "`every` is of \"floor\"");
  says(next("\"stop\""), R"("points":"points","direction":"x")", "which has 1 components, expected 3");
  says(next("\"stop\""), R"("lines":5,"direction":"x")", "no rays begin at `points`");
}

}  // namespace
}  // namespace gxy::test
