// SPDX-License-Identifier: Apache-2.0
// What lines through unstructured volumes cost beside those through a uniform one. Run by hand:
//
//   mesh_lines_benchmark [cubes]
//
// The same turbulence, sampled at the points of [cubes]^3 cubes, as a uniform volume in Embree's kernels and as meshes; as many lines
// through each. Times are of the processor and of one thread.
#include <malloc.h>

#include <cstdio>
#include <ctime>
#include <string>

#include "backends/embree/embree_backend.h"
#include "tests/analysis/mesh_flows.h"
#include "tests/lines/turbulence.h"

namespace gxy::test {
namespace {

constexpr int kSeeds = 500;
constexpr double kCells = 100;  // of way

double cpuSeconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

void measure(const char* name, const DeviceFields& device, const LineFields& fields,
             const std::vector<glm::dvec3>& seeds, double cell) {
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    double best = 1e30, way = 0;
    Lines lines;
    for (int repeat = 0; repeat < 3; repeat++) {
      const double start = cpuSeconds();
      lines = trace(device, fields, seeds,
                    {.tolerance = tolerance, .length = kCells * cell, .points = PointsMode::Ends});
      best = std::min(best, cpuSeconds() - start);
    }
    for (const LineEnd& e : lines.ends) way += e.length / cell;
    std::printf("%-12s  %9g  %15.3f  %11.0f  %10.2f\n", name, tolerance,
                best * 1e6 / double(lines.counters.steps), best * 1e9 / way,
                double(lines.counters.steps) / way);
    std::fflush(stdout);
  }
}

void run(uint32_t n) {
  const Turbulence turbulence(64, n / 8.0, 7);
  const double cell = 1.0 / n;
  const std::vector<glm::dvec3> seeds = placesIn(glm::dvec3(0.2), glm::dvec3(0.8), kSeeds, 3);
  std::printf("field         tolerance  s a million steps  ns a cube  steps a cube\n");
  {
    const Flow flow(gridOver(glm::dvec3(0), glm::dvec3(1), {n + 1, n + 1, n + 1}), turbulence);
    const auto backend = makeEmbreeBackend();
    const auto device = backend->makeFields(flow.fields, 0);
    measure("uniform", *device, *flow.fields, seeds, cell);
    measure("plain C++", *flow.device, *flow.fields, seeds, cell);
  }
  const auto mesh = [&](const char* name, const MeshPiece& piece) {
    const auto partitioning = std::make_shared<const Partitioning>(Partitioning::single(unitBox()));
    const MeshFields fields({meshInOnePiece(withField(piece, 3, turbulence), unitBox())}, partitioning);
    measure(name, fields, fields, seeds, cell);
  };
  const auto bend = [n](glm::dvec3 p) { return 4.0 / n * bentBy(0.03)(p); };
  mesh("hexahedra", cubeOfHexes(n, bend, noValue));
  mesh("wedges", cubeOfWedges(n, bend, noValue));
  mesh("tetrahedra", cubeOfTets(n, bend, noValue));
  mesh("pyramids", cubeOfPyramids(n, bend, noValue));
}

}  // namespace
}  // namespace gxy::test

int main(int count, char** arguments) {
  // Fresh memory is no part of what is measured.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 2'000'000'000);
  gxy::test::run(count > 1 ? uint32_t(std::stoul(arguments[1])) : 48);
}
