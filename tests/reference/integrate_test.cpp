// SPDX-License-Identifier: Apache-2.0
#include "core/reference/integrate.h"

#include <gtest/gtest.h>

#include "tests/reference/samples.h"

namespace gxy::reference {
namespace {

const Ray kAlongX{{-3, 0.1, 0.2}, {1, 0, 0}};

Vis extinctionVis(std::vector<OpacityPoint> points, std::vector<ColorPoint> colours) {
  Vis vis;
  vis.opacitymap = {true, std::move(points)};
  vis.colormap.points = std::move(colours);
  return vis;
}

TEST(Transmittance, UniformSlabMatchesBeerLambert) {
  const Field field(makeVolume(cube(9), [](glm::dvec3) { return 0.5; }), std::nullopt);
  const glm::dvec3 colour(0.2, 0.5, 0.9);
  for (double sigma : {1e-6, 0.1, 1.0, 7.0, 40.0}) {
    const Transfer transfer(extinctionVis({{0, sigma}}, {{0, colour}}), 1);
    const Ray ray{{-2, -0.9, -0.3}, glm::normalize(glm::dvec3(1, 0.3, 0.2))};
    const double length = 2 / ray.direction.x;
    const VolumeTerm term{&field, &transfer};
    const RayIntegral found = integrateRay({&term, 1}, ray);
    const double opacity = -std::expm1(-sigma * length);
    EXPECT_NEAR(1 - found.transmittance, opacity, 1e-12) << sigma;
    for (int c = 0; c < 3; c++) EXPECT_NEAR(found.colour[c], opacity * colour[c], 1e-12) << sigma;
  }
}

TEST(Transmittance, OpacityMapCountsReferenceLengths) {
  const Field field(makeVolume(cube(9), [](glm::dvec3) { return 0.5; }), std::nullopt);
  Vis vis;
  vis.opacitymap.points = {{0, 0.05}};
  const Transfer transfer(vis, field.smallestSpacing());
  const VolumeTerm term{&field, &transfer};
  EXPECT_NEAR(integrateRay({&term, 1}, kAlongX).transmittance, std::pow(0.95, 8), 1e-13);
}

TEST(Transmittance, LinearExtinctionMatchesClosedForm) {
  // s = x on [0, 1], sigma = k x, c = x: T = exp(-k/2), C = sqrt(pi/2k) erf(sqrt(k/2)) - exp(-k/2)
  const Field field(makeVolume(cube(5, 0, 1), [](glm::dvec3 p) { return p.x; }), std::nullopt);
  const Ray ray{{-1, 0.3, 0.4}, {1, 0, 0}};
  for (double k : {0.5, 8.0, 300.0, 2e4}) {
    const Transfer transfer(extinctionVis({{0, 0}, {1, k}}, {{0, glm::dvec3(0)}, {1, glm::dvec3(1)}}), 1);
    const VolumeTerm term{&field, &transfer};
    const RayIntegral found = integrateRay({&term, 1}, ray);
    EXPECT_NEAR(found.transmittance, std::exp(-k / 2), 1e-9) << k;
    const double colour =
        std::sqrt(std::numbers::pi / (2 * k)) * std::erf(std::sqrt(k / 2)) - std::exp(-k / 2);
    EXPECT_NEAR(found.colour.x, colour, 1e-7) << k;
  }
}

TEST(Transmittance, OpacityThatRisesToOneHasTheDepthOfItsLogarithm) {
  // -integral of ln(1 - x) over [0, 1] = 1
  const Field field(makeVolume(cube(5, 0, 1), [](glm::dvec3 p) { return p.x; }), std::nullopt);
  Vis vis;
  vis.opacitymap.points = {{0, 0}, {1, 1}};
  const Transfer transfer(vis, 1);
  const VolumeTerm term{&field, &transfer};
  const Ray ray{{-1, 0.3, 0.4}, {1, 0, 0}};
  EXPECT_NEAR(integrateRay({&term, 1}, ray).transmittance, std::exp(-1.0), 1e-6);
}

TEST(Transmittance, StretchOfFullOpacityEndsTheRayWithTheColourAtItsStart) {
  const Field field(makeVolume(cube(5, 0, 1), [](glm::dvec3 p) { return p.x; }), std::nullopt);
  Vis vis;
  vis.opacitymap.points = {{0, 0}, {0.3, 0}, {0.3, 1}, {1, 1}};
  vis.colormap.points = {{0, glm::dvec3(0)}, {1, glm::dvec3(1)}};
  const Transfer transfer(vis, 1);
  const VolumeTerm term{&field, &transfer};
  const Ray ray{{-1, 0.3, 0.4}, {1, 0, 0}};
  const RayIntegral found = integrateRay({&term, 1}, ray);
  EXPECT_EQ(found.transmittance, 0);
  EXPECT_NEAR(found.colour.x, 0.3, 1e-8);
}

TEST(Transmittance, OverlappingVolumesAddExtinctionAndSource) {
  // Grids that do not align: [-1, 1] with 9 points, [0, 2] with 6.
  const Field first(makeVolume(cube(9), [](glm::dvec3) { return 0; }), std::nullopt);
  const Field second(makeVolume({{0, -1, -1}, glm::dvec3(0.4), {6, 6, 6}}, [](glm::dvec3) { return 0; }),
                     std::nullopt);
  const Transfer red(extinctionVis({{0, 0.7}}, {{0, {1, 0, 0}}}), 1);
  const Transfer blue(extinctionVis({{0, 1.1}}, {{0, {0, 0, 1}}}), 1);
  const VolumeTerm terms[] = {{&first, &red}, {&second, &blue}};
  const RayIntegral found = integrateRay(terms, kAlongX);
  EXPECT_NEAR(found.transmittance, std::exp(-0.7 * 2 - 1.1 * 2), 1e-12);
  const double reached = std::exp(-0.7), both = -std::expm1(-1.8), rest = std::exp(-0.7 - 1.8);
  EXPECT_NEAR(found.colour.x, 1 - reached + reached * both * 0.7 / 1.8, 1e-10);
  EXPECT_NEAR(found.colour.z, reached * both * 1.1 / 1.8 + rest * -std::expm1(-1.1), 1e-10);
}

TEST(Transmittance, CellsWithoutDataAreTransparent) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Grid grid = cube(9);  // cells 0.25 wide; the samples at x = 0 spoil the cells on both sides
  const Field field(makeVolume(grid, [&](glm::dvec3 p) { return p.x == 0 ? nan : 1; }), std::nullopt);
  const Transfer transfer(extinctionVis({{0, 2}}, {{0, glm::dvec3(1)}}), 1);
  const VolumeTerm term{&field, &transfer};
  EXPECT_NEAR(integrateRay({&term, 1}, kAlongX).transmittance, std::exp(-2 * 1.5), 1e-12);
}

TEST(Transmittance, ClipAndStretchCutInsideCells) {
  const Field field(makeVolume(cube(9), [](glm::dvec3) { return 1; }), std::nullopt);
  const Transfer transfer(extinctionVis({{0, 2}}, {{0, glm::dvec3(1)}}), 1);
  const VolumeTerm term{&field, &transfer, {2.3, 3.1}};
  EXPECT_NEAR(integrateRay({&term, 1}, kAlongX).transmittance, std::exp(-2 * 0.8), 1e-12);
  EXPECT_NEAR(integrateRay({&term, 1}, kAlongX, {2.9, 9}).transmittance, std::exp(-2 * 0.2), 1e-12);
}

TEST(Transmittance, StretchesMultiply) {
  const Field field(makeVolume(cube(17), marschnerLobb), std::nullopt);
  const Transfer transfer(extinctionVis({{0.3, 0}, {1, 8}}, {{0, glm::dvec3(0)}, {1, glm::dvec3(1)}}), 1);
  const VolumeTerm term{&field, &transfer};
  const Ray ray{{-3, 0.4, -0.5}, glm::normalize(glm::dvec3(1, -0.1, 0.2))};
  const VolumeRay volumes({&term, 1}, ray);
  const RayIntegral whole = volumes.integrate({0, kInfinity});
  const RayIntegral front = volumes.integrate({0, 2.87}), back = volumes.integrate({2.87, kInfinity});
  EXPECT_NEAR(whole.transmittance, front.transmittance * back.transmittance, 1e-8);
  EXPECT_NEAR(whole.colour.x, front.colour.x + front.transmittance * back.colour.x, 1e-8);
}

/// Midpoint sums over millions of steps, with an interpolation of their own.
RayIntegral bruteForce(const std::vector<double>& s, int n, const Transfer& transfer, const Ray& ray,
                       double t0, double t1, int steps) {
  RayIntegral sum;
  const double dt = (t1 - t0) / steps;
  for (int i = 0; i < steps; i++) {
    const glm::dvec3 x = (ray.at(t0 + (i + 0.5) * dt) + 1.0) * (0.5 * (n - 1));
    const int a = std::clamp(int(x.x), 0, n - 2), b = std::clamp(int(x.y), 0, n - 2),
              c = std::clamp(int(x.z), 0, n - 2);
    double value = 0;
    for (int corner = 0; corner < 8; corner++) {
      const int da = corner & 1, db = corner >> 1 & 1, dc = corner >> 2;
      value += s[((c + dc) * n + b + db) * n + a + da] * (da ? x.x - a : a + 1 - x.x) *
               (db ? x.y - b : b + 1 - x.y) * (dc ? x.z - c : c + 1 - x.z);
    }
    const double opacity = -std::expm1(-transfer.extinction(value) * dt);
    sum.colour += sum.transmittance * opacity * transfer.colour(value);
    sum.transmittance *= 1 - opacity;
  }
  return sum;
}

TEST(Transmittance, PeakedAndSteppedMapsMatchBruteForce) {
  constexpr int n = 12;
  Uniform random(7);
  std::vector<double> samples(n * n * n);
  for (double& s : samples) s = float(random());
  size_t next = 0;
  const Field field(makeVolume(cube(n), [&](glm::dvec3) { return samples[next++]; }), std::nullopt);
  const std::vector<ColorPoint> rainbow{{0, {0, 0, 1}}, {0.4, {0, 1, 0}}, {0.4, {1, 1, 0}}, {1, {1, 0, 0}}};
  const std::vector<std::vector<OpacityPoint>> maps{
      {{0, 0}, {0.44, 0}, {0.45, 60}, {0.46, 0}, {0.61, 0}, {0.62, 60}, {0.63, 0}},  // two spikes
      {{0, 0}, {0.5, 0}, {0.5, 9}, {0.7, 9}, {0.7, 0.1}},                            // steps
      {{0.2, 0}, {1, 200}}};                                                         // nearly opaque
  for (const auto& map : maps) {
    const Transfer transfer(extinctionVis(map, rainbow), 1);
    const VolumeTerm term{&field, &transfer};
    for (int i = 0; i < 3; i++) {
      Ray ray{random.inCube(0.9), {}};
      ray.direction = glm::normalize(random.inCube(1));
      double exit = kInfinity;
      for (int a = 0; a < 3; a++) {
        exit = std::min(exit, ((ray.direction[a] > 0 ? 1 : -1) - ray.origin[a]) / ray.direction[a]);
      }
      const RayIntegral found = integrateRay({&term, 1}, ray);
      const RayIntegral expected = bruteForce(samples, n, transfer, ray, 0, exit, 1000000);
      EXPECT_NEAR(found.transmittance, expected.transmittance, 5e-6);
      for (int c = 0; c < 3; c++) EXPECT_NEAR(found.colour[c], expected.colour[c], 5e-6);
    }
  }
}

TEST(Transmittance, ToleranceIsMetAgainstTheTightestResult) {
  const Field field(makeVolume(cube(33), marschnerLobb), std::nullopt);
  const Transfer transfer(
      extinctionVis({{0.3, 0}, {0.45, 0}, {0.5, 80}, {0.55, 0}, {1, 3}}, {{0, {0, 0, 1}}, {1, {1, 0.5, 0}}}),
      1);
  const VolumeTerm term{&field, &transfer};
  Uniform random(3);
  for (int i = 0; i < 50; i++) {
    const glm::dvec3 origin(-3, random.in(-0.5, 0.5), random.in(-0.5, 0.5));
    const VolumeRay volumes({&term, 1}, {origin, glm::normalize(random.inCube(0.5) - origin)});
    const RayIntegral best = volumes.integrate({0, kInfinity}, 1e-12);
    for (double tolerance : {1e-3, 1e-6}) {
      const RayIntegral found = volumes.integrate({0, kInfinity}, tolerance);
      EXPECT_NEAR(found.colour.x, best.colour.x, tolerance);
      EXPECT_NEAR(found.transmittance, best.transmittance, tolerance);
    }
  }
}

}  // namespace
}  // namespace gxy::reference
