// SPDX-License-Identifier: Apache-2.0
// Prints the processor time that derived fields and their numbers take, in ns a point. derive_vtk.py measures VTK.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <functional>
#include <iostream>
#include <memory>
#include <string>

#include "core/analysis/evaluate.h"
#include "core/analysis/statistics.h"
#include "core/data/complete_volume.h"

namespace {

using namespace gxy;

std::shared_ptr<const Volume> made(const Grid& grid, const Partitioning& cut, int components,
                                   Collectives& ranks) {
  auto volume = std::make_shared<Volume>();
  volume->grid = grid;
  volume->components = components;
  VolumeBlock& block = volume->blocks[0];
  block.extent = {{0, 0, 0}, grid.points};
  const auto values = size_t(block.extent.count()) * size_t(components);
  block.samples.resize(values * sizeof(float));
  for (size_t i = 0; i < values; ++i) {
    const auto point = i / size_t(components), c = i % size_t(components);
    const auto value = float(std::sin(0.001 * double(point % 100003) + double(c)));
    std::memcpy(block.samples.data() + i * sizeof value, &value, sizeof value);
  }
  completeVolume(*volume, cut, ranks);
  return volume;
}

/// Prints the least time of three calls.
void measure(const std::string& what, int64_t points, const std::function<void()>& call) {
  double least = INFINITY;
  for (int i = 0; i < 3; ++i) {
    const std::clock_t start = std::clock();
    call();
    least = std::min(least, double(std::clock() - start) / CLOCKS_PER_SEC);
  }
  std::cout << what << ": " << least * 1e9 / double(points) << " ns a point" << std::endl;
}

}  // namespace

int main(int argc, char** argv) {
  const int64_t n = argc > 1 ? std::atoll(argv[1]) : 256, points = n * n * n;
  const Grid grid{{0, 0, 0}, glm::dvec3(1 / double(n - 1)), {n, n, n}};
  const auto cut = std::make_shared<const Partitioning>(Partitioning::single(grid.box()));
  SingleRank ranks;
  const FieldInput inputs[] = {{"s", made(grid, *cut, 1, ranks), cut},
                               {"v", made(grid, *cut, 3, ranks), cut}};
  for (const char* text : {"curl(v)", "div(v)", "curl(v) * div(v)", "sqrt(s*s+1)*sin(s)+mag(v)", "mag(v)",
                           "s+1", "grad(s)", "q(v)", "lambda2(v)"}) {
    const Expression expression{text};
    measure(text, points, [&] { derive(expression, inputs, ranks); });
    if (std::strstr(text, "curl") || std::strstr(text, "sqrt")) {
      const DerivedField field = derive(expression, inputs, ranks);
      measure("  of this, what completeBricks() takes", points, [&] {
        Volume& volume = *field.volume;
        for (auto& entry : volume.blocks) entry.second.summaries.clear();
        completeBricks(volume, *cut, ranks, {volume.ranges, volume.noDataSamples}, volume.components);
      });
    }
  }
  measure("statistics", points, [&] { fieldStatistics(*inputs[0].volume, *cut, ranks); });
  StatisticsOptions options;
  options.bins = 100;
  options.quantiles = {0.5, 0.9};
  measure("statistics, 100 bins, 2 quantiles", points,
          [&] { fieldStatistics(*inputs[0].volume, *cut, ranks, options); });
}
