// SPDX-License-Identifier: Apache-2.0
// What lines cost at which error, in turbulence. Run by hand, with vtk_lines.py in one window of time:
//
//   lines_benchmark FOLDER [points]          writes field and seeds to FOLDER, and prints Galaxy's rows
//   vtk_lines.py FOLDER                      traces the same lines with VTK, and prints its rows
//   lines_benchmark FOLDER [points] --vtk    prints how far VTK's ends are from the true lines
//
// Times are of the processor and of one thread, in nanoseconds per cell length of way. The errors of Galaxy are distances at
// the same time; those of VTK are distances from the whole line, since its times are of low order.
#include <malloc.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <string>

#include "backends/embree/embree_backend.h"
#include "core/reference/streamline.h"
#include "tests/lines/flow_fields.h"
#include "tests/lines/turbulence.h"

namespace gxy::test {
namespace {

constexpr int kSeeds = 2000, kJudged = 100;
constexpr double kCells = 150;  // of way

double cpuSeconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

// Counts the processor's time in another device.
class Timed final : public DeviceFields {
 public:
  explicit Timed(const DeviceFields& inner) : inner_(inner) {}
  void advance(int partition, HeadList heads, const TraceOptions& options, Done done) const override {
    AdvanceResult result;
    const double start = cpuSeconds();
    inner_.advance(partition, std::move(heads), options, [&](AdvanceResult r) { result = std::move(r); });
    seconds += cpuSeconds() - start;
    done(std::move(result));
  }
  size_t bytes() const override { return 0; }
  mutable double seconds = 0;

 private:
  const DeviceFields& inner_;
};

struct Errors {
  double median, high, most;
};
Errors errorsOf(std::vector<double> e) {
  std::sort(e.begin(), e.end());
  return {e[e.size() / 2], e[e.size() * 9 / 10], e.back()};
}

Errors judge(const Lines& lines, const reference::Streamlines& truth, const std::vector<glm::dvec3>& seeds,
             double cell) {
  std::vector<double> errors;
  for (const LineEnd& e : lines.ends) {
    if (e.line >= kJudged) continue;
    reference::StreamlinePlace place = truth.start(seeds[e.line]);
    truth.follow(place, e.time);
    errors.push_back(glm::length(truth.world(place) - e.position) / cell);
  }
  return errorsOf(errors);
}

void measure(const Flow& flow, const reference::Streamlines& truth, const std::vector<glm::dvec3>& seeds) {
  const auto backend = makeEmbreeBackend();
  const auto device = backend->makeFields(flow.fields, 0);
  const double cell = flow.fields->grid().spacing.x;
  std::printf("Galaxy (%s)\ntolerance  points  ns/cell  steps/cell  error: median  90 %%  largest (cells)\n",
              backend->device().c_str());
  for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-4})
    for (const PointsMode points : {PointsMode::Ends, PointsMode::Cells}) {
      const TraceOptions options{.tolerance = tolerance, .length = kCells * cell, .points = points};
      double best = 1e30, way = 0;
      Lines lines;
      for (int repeat = 0; repeat < 5; repeat++) {
        const Timed timed(*device);
        lines = trace(timed, *flow.fields, seeds, options);
        best = std::min(best, timed.seconds);
      }
      for (const LineEnd& e : lines.ends) way += e.length / cell;
      const Errors e = judge(lines, truth, seeds, cell);
      std::printf("%9g  %6s  %7.1f  %10.2f  %.2g  %.2g  %.2g\n", tolerance,
                  points == PointsMode::Ends ? "ends" : "cells", best * 1e9 / way,
                  double(lines.counters.steps) / way, e.median, e.high, e.most);
      std::fflush(stdout);
    }
}

// Distances of VTK's ends from the true lines: the least distance from any of their crossings' chords.
void judgeVtk(const std::string& file, const reference::Streamlines& truth,
              const std::vector<glm::dvec3>& seeds, double cell) {
  std::ifstream in(file);
  std::vector<double> errors;
  size_t line;
  for (glm::dvec3 end; in >> line >> end.x >> end.y >> end.z;) {
    if (line >= kJudged) continue;
    reference::StreamlinePlace place = truth.start(seeds[line]);
    double least = 1e30;
    const double dt = 0.02 * cell / glm::length(truth.velocity(place));
    for (int i = 0; i < 100000 && place.length < 1.1 * kCells * cell; i++) {
      const glm::dvec3 from = truth.world(place);
      if (truth.follow(place, dt) == reference::Streamlines::End::Left) break;
      const glm::dvec3 way = truth.world(place) - from;
      const double u = std::clamp(glm::dot(end - from, way) / std::max(glm::dot(way, way), 1e-300), 0.0, 1.0);
      least = std::min(least, glm::length(from + u * way - end) / cell);
    }
    errors.push_back(least);
  }
  const Errors e = errorsOf(errors);
  std::printf("%s  %.2g  %.2g  %.2g\n", file.c_str(), e.median, e.high, e.most);
}

int run(const std::string& folder, int64_t n, bool vtk) {
  const Turbulence turbulence(60, double(n) / 11, 5);
  const Flow flow(gridOver(glm::dvec3(0), glm::dvec3(1), {n, n, n}),
                  [&](glm::dvec3 p) { return turbulence(p); });
  const reference::Streamlines truth(flow.volume, 48);
  Random random(3);
  std::vector<glm::dvec3> seeds;
  for (int i = 0; i < kSeeds; i++) seeds.push_back(random.point(0.2, 0.8));
  const double cell = flow.fields->grid().spacing.x;
  if (vtk) {
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".ends") judgeVtk(entry.path().string(), truth, seeds, cell);
    return 0;
  }
  std::ofstream field(folder + "/field.raw", std::ios::binary), text(folder + "/seeds.txt");
  for (int64_t k = 0; k < n; k++)
    for (int64_t j = 0; j < n; j++)
      for (int64_t i = 0; i < n; i++) {
        const glm::vec3 v(turbulence(flow.fields->grid().spacing * glm::dvec3(i, j, k)));
        field.write(reinterpret_cast<const char*>(&v), sizeof v);
      }
  text.precision(17);
  text << n << " " << kCells << "\n";
  for (const glm::dvec3& s : seeds) text << s.x << " " << s.y << " " << s.z << "\n";
  measure(flow, truth, seeds);
  return 0;
}

}  // namespace
}  // namespace gxy::test

int main(int count, char** arguments) {
  if (count < 2) {
    std::fprintf(stderr, "usage: lines_benchmark FOLDER [points] [--vtk]\n");
    return 1;
  }
  // Fresh memory is no part of what is measured.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 2'000'000'000);
  const bool vtk = std::string(arguments[count - 1]) == "--vtk";
  return gxy::test::run(arguments[1], count > (vtk ? 3 : 2) ? std::stoll(arguments[2]) : 128, vtk);
}
