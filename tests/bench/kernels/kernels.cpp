// SPDX-License-Identifier: Apache-2.0
// How fast the kernels are by themselves, on one thread: `kernel_benchmarks --benchmark_filter=Trilinear`.
// Rates count samples, cells, roots, tests, rays or pixels, as the name says.
#include <benchmark/benchmark.h>

#include <glm/geometric.hpp>
#include <numeric>

#include "core/rays/ray_list.h"
#include "core/render/framebuffer.h"
#include "core/space/large_vector.h"
#include "kernels_ispc.h"
#include "tests/rays/field.h"

namespace gxy::test {
namespace {

constexpr int kRays = 64;        // a side of the grid of rays
constexpr int kPrimitives = 64;  // of a leaf
constexpr int kSide = 192;       // points of the volume

Shown shown(const Field& field, const std::vector<OpacityPoint>& points, float isovalue) {
  Shown s;
  const ColorMap colors{{{0, {0, 0, 1}}, {0.5, {1, 1, 1}}, {1, {1, 0, 0}}}};
  const OpacityMap opacity{false, points};
  s.map = CompiledMap(colors, &opacity, {0, 1, 1, field.shortestCell()});
  s.plan = stepPlan(field.macrocells(), s.map, field.shortestCell(), 1.0 / 512, 0);
  s.isovalues = {isovalue};
  return s;
}

/// A turbulent volume under a ramp, or under eight narrow peaks, with isovalue 0.5 or one that no sample
/// reaches.
struct Volumes {
  Field field = cube(kSide, turbulence);
  Shown ramp = shown(field, {{0, 0}, {0.3, 0}, {1, 0.06}}, 0.5f);
  Shown peaks = shown(field, peakPoints(), 9);
  View<float> rampView{field, ramp}, peaksView{field, peaks};

  static const Volumes& get() {
    static const Volumes volumes;
    return volumes;
  }

 private:
  static std::vector<OpacityPoint> peakPoints() {
    std::vector<OpacityPoint> points;
    for (int i = 0; i < 8; i++)
      for (int part = 0; part < 3; part++)
        points.push_back({0.1 + 0.1 * i + 0.01 * part, part == 1 ? 0.4 : 0});
    return points;
  }
};

/// side^2 parallel rays through the unit box around 0, in tiles of 4 x 4 so that a gang is coherent.
std::vector<float> raysAlong(glm::dvec3 direction, int side = kRays, double apart = 1.0 / kRays) {
  const glm::dvec3 d = glm::normalize(direction);
  const glm::dvec3 u =
      glm::normalize(glm::cross(d, std::abs(d.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0)));
  const glm::dvec3 w = glm::cross(d, u);
  std::vector<float> rays;
  for (int i = 0; i < side * side; i++) {
    const int tile = i / 16, x = 4 * (tile % (side / 4)) + i % 4, y = 4 * (tile / (side / 4)) + i / 4 % 4;
    const glm::dvec3 o = (x + 0.5 - side / 2) * apart * u + (y + 0.5 - side / 2) * apart * w - 1.5 * d;
    for (const glm::dvec3& v : {o, d})
      for (int a = 0; a < 3; a++) rays.push_back(float(v[a]));
  }
  return rays;
}

const glm::dvec3 kDirections[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1},        {-1, 0, 0}, {1, 1, 0},
                                  {0, 1, 1}, {1, 1, 1}, {0.3, -0.5, 0.8}, {1, 0, 1}};

void eachDirection(benchmark::internal::Benchmark* b) {
  for (size_t i = 0; i < std::size(kDirections); i++) b->Arg(int64_t(i));
}
std::string labelOf(const benchmark::State& state) {
  const glm::dvec3 d = kDirections[state.range(0)];
  char label[64];
  std::snprintf(label, sizeof label, "along %g %g %g", d.x, d.y, d.z);
  return label;
}
std::vector<float> raysOf(benchmark::State& state) {
  state.SetLabel(labelOf(state));
  return raysAlong(kDirections[state.range(0)]);
}

std::vector<float> results() { return std::vector<float>(kRays * kRays); }

void TrilinearSamples(benchmark::State& state) {
  const auto rays = raysOf(state);
  auto out = results();
  constexpr int steps = 256;
  const auto& view = *Volumes::get().rampView;
  for (auto _ : state) ispc::sampleRays(&view, rays.data(), kRays * kRays, steps, out.data());
  state.SetItemsProcessed(state.iterations() * kRays * kRays * steps);
}
BENCHMARK(TrilinearSamples)->Apply(eachDirection);

/// Rays half a cell apart through the middle of a volume whose points lie in memory in one order or another.
void SamplesByLayout(benchmark::State& state) {
  constexpr int steps = 384, points = 384, mortonPoints = 512, side = 256;
  static const Field field = cube(points, [](glm::dvec3 p) { return p.x + p.y * p.z; });
  static const Shown transparent = shown(field, {{0, 0}, {1, 0}}, 9);
  static const View<float> view{field, transparent};
  static int arrangedAs = -1;
  static LargeVector<float> arranged(size_t(mortonPoints) * mortonPoints * mortonPoints);
  const char* names[] = {"row by row", "bricks of 2", "bricks of 4", "bricks of 8", "Morton"};
  const int layout = int(state.range(1));
  state.SetLabel(names[layout] + (", " + labelOf(state)));
  if (layout != arrangedAs) ispc::arrangePoints(points, layout, arranged.data());
  arrangedAs = layout;
  const auto rays = raysAlong(kDirections[state.range(0)], side, 0.5 / points);
  std::vector<float> out(side * side);
  for (auto _ : state)
    ispc::sampleArranged(&*view, arranged.data(), points, layout, rays.data(), side * side, steps,
                         out.data());
  state.SetItemsProcessed(state.iterations() * side * side * steps);
}
BENCHMARK(SamplesByLayout)->ArgsProduct({{0, 1, 2, 4, 5, 6, 7, 8}, {0, 1, 2, 3, 4}});

/// Isovalue 0.5; the cells are those whose corners are looked at.
void IsosurfaceCells(benchmark::State& state) {
  const auto rays = raysOf(state);
  auto out = results();
  const auto& view = *Volumes::get().rampView;
  int64_t cells = 0;
  for (auto _ : state) cells += ispc::findIsosurface(&view, rays.data(), kRays * kRays, out.data());
  state.SetItemsProcessed(cells);
}
BENCHMARK(IsosurfaceCells)->Apply(eachDirection);

/// No macrocell holds the isovalue: the walk without its cells.
void IsosurfaceSkippedRays(benchmark::State& state) {
  const auto rays = raysOf(state);
  auto out = results();
  const auto& view = *Volumes::get().peaksView;
  for (auto _ : state) ispc::findIsosurface(&view, rays.data(), kRays * kRays, out.data());
  state.SetItemsProcessed(state.iterations() * kRays * kRays);
}
BENCHMARK(IsosurfaceSkippedRays)->Arg(6)->Arg(7);

void MarchedRays(benchmark::State& state) {
  const auto rays = raysAlong(kDirections[7]);
  auto out = results();
  const auto& shown = state.range(0) ? Volumes::get().peaksView : Volumes::get().rampView;
  state.SetLabel(state.range(0) ? "eight peaks" : "ramp");
  for (auto _ : state) ispc::marchRays(&shown.map(), &*shown, rays.data(), kRays * kRays, out.data());
  state.SetItemsProcessed(state.iterations() * kRays * kRays);
}
BENCHMARK(MarchedRays)->Arg(0)->Arg(1);

/// Cubics with a root in three of four.
void FirstRoots(benchmark::State& state) {
  Random random(1);
  std::vector<float> cubics;
  for (int i = 0; i < kRays * kRays; i++) {
    cubics.push_back(float(random.in(-1, 0)));
    for (int k = 1; k < 4; k++) cubics.push_back(float(random.in(-1, 1)));
  }
  auto out = results();
  for (auto _ : state) ispc::findRoots(cubics.data(), kRays * kRays, out.data());
  state.SetItemsProcessed(state.iterations() * kRays * kRays);
}
BENCHMARK(FirstRoots);

std::vector<float> mapValues() {
  Random random(2);
  std::vector<float> values;
  for (int i = 0; i < kRays * kRays; i++) values.push_back(float(random.in(0, 1)));
  return values;
}

void MapEvaluations(benchmark::State& state) {
  const auto values = mapValues();
  auto out = results();
  const auto& shown = state.range(0) ? Volumes::get().peaksView : Volumes::get().rampView;
  state.SetLabel(state.range(0) ? "eight peaks" : "ramp");
  for (auto _ : state) ispc::evaluateMap(&shown.map(), values.data(), int(values.size()), out.data());
  state.SetItemsProcessed(state.iterations() * int64_t(values.size()));
}
BENCHMARK(MapEvaluations)->Arg(0)->Arg(1);

void MapIntegrals(benchmark::State& state) {
  const auto values = mapValues();
  auto out = results();
  const auto& shown = state.range(0) ? Volumes::get().peaksView : Volumes::get().rampView;
  state.SetLabel(state.range(0) ? "eight peaks" : "ramp");
  for (auto _ : state) ispc::integrateMap(&shown.map(), values.data(), int(values.size()), out.data());
  state.SetItemsProcessed(state.iterations() * int64_t(values.size()));
}
BENCHMARK(MapIntegrals)->Arg(0)->Arg(1);

/// Two points, each with a radius: a box, a sphere with one of them, a tube, or a triangle.
std::vector<float> primitives() {
  Random random(3);
  std::vector<float> all;
  for (int i = 0; i < kPrimitives; i++) {
    const glm::dvec3 a = random.point(-0.5, 0.4), b = a + 0.1 + random.point(0, 0.1);
    for (const glm::dvec3& p : {a, b})
      for (double x : {p.x, p.y, p.z, random.in(0.01, 0.05)}) all.push_back(float(x));
  }
  return all;
}

using HitAll = void (*)(const float*, int32_t, const float*, int32_t, float*);

void PrimitiveTests(benchmark::State& state, HitAll hitAll) {
  const auto rays = raysAlong(kDirections[7]), all = primitives();
  auto out = results();
  for (auto _ : state) hitAll(rays.data(), kRays * kRays, all.data(), kPrimitives, out.data());
  state.SetItemsProcessed(state.iterations() * kRays * kRays * kPrimitives);
}
BENCHMARK_CAPTURE(PrimitiveTests, boxes, HitAll(ispc::hitBoxes));
BENCHMARK_CAPTURE(PrimitiveTests, spheres, HitAll(ispc::hitSpheres));
BENCHMARK_CAPTURE(PrimitiveTests, tubes, HitAll(ispc::hitTubes));
BENCHMARK_CAPTURE(PrimitiveTests, triangles, HitAll(ispc::hitTriangles));

/// 1024 rays, of which every other one leaves.
struct Packet {
  RayList rays{1024};
  std::vector<int> leaving;
  Packet() {
    rays.resize(rays.capacity());
    const RayView& v = rays.view();
    for (int i = 0; i < rays.size(); i++) {
#define GXY_FIELD(type, name, primary, secondary) v.name[i] = type(i);
      GXY_RAY_FIELDS(GXY_FIELD)
#undef GXY_FIELD
      if (i % 2) leaving.push_back(i);
    }
  }
};

void GatheredRays(benchmark::State& state) {
  const Packet packet;
  for (auto _ : state) benchmark::DoNotOptimize(packet.rays.gather(packet.leaving).view().pixel);
  state.SetItemsProcessed(state.iterations() * int64_t(packet.leaving.size()));
}
BENCHMARK(GatheredRays);

void RaysToTheWire(benchmark::State& state) {
  const Packet packet;
  const bool primary = state.range(0) != 0;
  state.SetLabel(primary ? "primaries" : "secondaries");
  Bytes wire;
  for (auto _ : state) {
    wire.clear();
    packet.rays.write(packet.leaving, primary, wire);
    benchmark::DoNotOptimize(wire.data());
  }
  state.SetItemsProcessed(state.iterations() * int64_t(packet.leaving.size()));
  state.SetBytesProcessed(state.iterations() * int64_t(wire.size()));
}
BENCHMARK(RaysToTheWire)->Arg(1)->Arg(0);

void RaysFromTheWire(benchmark::State& state) {
  const Packet packet;
  const bool primary = state.range(0) != 0;
  state.SetLabel(primary ? "primaries" : "secondaries");
  Bytes wire;
  packet.rays.write(packet.leaving, primary, wire);
  const int n = int(packet.leaving.size());
  for (auto _ : state) benchmark::DoNotOptimize(RayList::read(wire, n, primary).view().pixel);
  state.SetItemsProcessed(state.iterations() * n);
}
BENCHMARK(RaysFromTheWire)->Arg(1)->Arg(0);

/// A tile's contributions at a time.
void AccumulatedContributions(benchmark::State& state) {
  constexpr int side = 512, tile = 1024;
  Framebuffer framebuffer(side, side, 1, false);
  std::vector<Contribution> contributions;
  for (int i = 0; i < side * side; i++) contributions.push_back({uint32_t(i), i, i + 1, i + 2, i + 3});
  size_t at = 0;
  for (auto _ : state) {
    framebuffer.add(std::span(contributions).subspan(at, tile));
    at = (at + tile) % contributions.size();
  }
  state.SetItemsProcessed(state.iterations() * tile);
}
BENCHMARK(AccumulatedContributions);

}  // namespace
}  // namespace gxy::test

BENCHMARK_MAIN();
