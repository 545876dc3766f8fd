// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/io/write_geometry.h"
#include "tools/gxydata/commands.h"

namespace gxy::data_tool {
namespace {

using std::numbers::pi;

/// Writes the block make(phase) for each time step.
template <class Make>
void writeSteps(const Options& options, GeometryKind kind, const char* array, Make make) {
  const int steps = std::max(options.steps, 1);
  Progress progress("making " + options.out, steps);
  for (int step = 0; step < steps; ++step, progress.advance()) {
    GeometryBlock block = make(double(step) / steps);
    block.ids.resize(kind == GeometryKind::Particles   ? block.points.size()
                     : kind == GeometryKind::PathLines ? block.segments.size()
                                                       : block.triangles.size());
    std::iota(block.ids.begin(), block.ids.end(), uint64_t(0));
    writeGeometry(stepName(options, step), block, kind, array);
  }
}

/// Returns a point of the isotropic normal distribution, by three deviates of Box and Muller.
glm::dvec3 gaussian(uint64_t seed, uint64_t n) {
  glm::dvec3 g;
  for (int a = 0; a < 3; ++a) {
    const double u = std::max(uniform(seed, 6 * n + 2 * uint64_t(a)), 1e-12);
    g[a] = std::sqrt(-2 * std::log(u)) * std::cos(2 * pi * uniform(seed, 6 * n + 2 * uint64_t(a) + 1));
  }
  return g;
}

}  // namespace

/// Three quarters of the points lie in clusters that are dense towards their middle. The value is the
/// distance from the middle in cluster radii, and 4 for the other points.
void makeParticles(const Options& options) {
  const uint64_t count = uint64_t(options.count > 0 ? options.count : 10000), seed = options.seed;
  constexpr uint64_t clusters = 24;
  writeSteps(options, GeometryKind::Particles, "distance", [&](double phase) {
    GeometryBlock block;
    block.points.resize(count);
    block.values.resize(count);
    const auto make = [&](uint64_t i) {
      const auto random = [&](uint64_t k) { return uniform(seed ^ 0x9a47, 8 * i + k); };
      glm::dvec3 p = 2.0 * glm::dvec3(random(0), random(1), random(2)) - 1.0;
      double value = 4;
      if (random(3) < 0.75) {
        const uint64_t c = uint64_t(random(4) * double(clusters));
        const auto place = [&](uint64_t k) { return 1.4 * uniform(seed, 4 * c + k) - 0.7; };
        const double radius = 0.02 + 0.06 * uniform(seed, 4 * c + 3), turn = 2 * pi * phase;
        const glm::dvec3 g = gaussian(seed ^ 0x77, i) * random(5);
        const glm::dvec3 centre(place(0) * std::cos(turn) - place(2) * std::sin(turn), place(1),
                                place(0) * std::sin(turn) + place(2) * std::cos(turn));
        p = centre + radius * g;
        value = std::min(glm::length(g), 4.0);
      }
      block.points[i] = p;
      block.values[i] = float(value);
    };
    parallelFor(uint64_t(0), count, make, [](double) {});
    return block;
  });
}

/// The mesh has `count` rows of latitude and twice as many meridians. The value is the height of the
/// bumps, from -1 to 1.
void makeSphereMesh(const Options& options) {
  const uint32_t rows = uint32_t(options.count > 0 ? options.count : 64), columns = 2 * rows;
  writeSteps(options, GeometryKind::Triangles, "height", [&](double phase) {
    const auto height = [&](double polar, double azimuth) {
      return std::sin(polar) * std::sin(6 * polar) * std::cos(8 * azimuth + 2 * pi * phase);
    };
    const auto point = [&](double polar, double azimuth) {
      const double r = 1 + options.displacement * height(polar, azimuth);
      return r * glm::dvec3(std::sin(polar) * std::cos(azimuth), std::cos(polar),
                            std::sin(polar) * std::sin(azimuth));
    };
    GeometryBlock block;
    const size_t points = size_t(rows - 1) * columns + 2;
    block.points.resize(points);
    block.normals.resize(points);
    block.values.resize(points);
    const auto set = [&](size_t n, double polar, double azimuth) {
      const double h = 1e-5;
      glm::dvec3 normal = glm::cross(point(polar, azimuth + h) - point(polar, azimuth - h),
                                     point(polar + h, azimuth) - point(polar - h, azimuth));
      const glm::dvec3 p = point(polar, azimuth);
      if (polar == 0 || polar == pi) normal = p;  // Meridians meet here.
      block.points[n] = p;
      block.normals[n] = glm::vec3(glm::normalize(normal));
      block.values[n] = float(height(polar, azimuth));
    };
    const uint32_t last = uint32_t(points) - 1;
    set(0, 0, 0);
    const auto setOneOfRows = [&](uint32_t n) {
      set(n, pi * ((n - 1) / columns + 1) / rows, 2 * pi * ((n - 1) % columns) / columns);
    };
    parallelFor(uint32_t(1), last, setOneOfRows, [](double) {});
    set(last, pi, 0);
    const auto at = [&](uint32_t j, uint32_t i) { return 1 + (j - 1) * columns + i % columns; };
    block.triangles.reserve(size_t(rows - 1) * columns * 2);
    for (uint32_t i = 0; i < columns; ++i) {
      block.triangles.push_back({0, at(1, i + 1), at(1, i)});
      for (uint32_t j = 1; j + 1 < rows; ++j) {
        block.triangles.push_back({at(j, i), at(j, i + 1), at(j + 1, i + 1)});
        block.triangles.push_back({at(j, i), at(j + 1, i + 1), at(j + 1, i)});
      }
      block.triangles.push_back({last, at(rows - 1, i), at(rows - 1, i + 1)});
    }
    return block;
  });
}

/// Coils around the y axis. Each is sampled at equal time steps while its speed changes.
void makeHelix(const Options& options) {
  const int lines = int(options.count > 0 ? options.count : 8);
  constexpr int samples = 256;
  constexpr double turns = 3;
  writeSteps(options, GeometryKind::PathLines, "speed", [&](double phase) {
    GeometryBlock block;
    for (int line = 0; line < lines; ++line) {
      const double radius = 0.3 + 0.5 * uniform(options.seed, uint64_t(line));
      const double start = 2 * pi * (double(line) / lines + phase);
      const uint32_t first = uint32_t(block.points.size());
      for (int i = 0; i <= samples; ++i) {
        const double time = double(i) / samples;
        const double way = time - 0.4 * std::sin(2 * pi * time) / (2 * pi);
        const double angle = start + 2 * pi * turns * way;
        block.points.push_back({radius * std::cos(angle), 2 * way - 1, radius * std::sin(angle)});
        block.values.push_back(
            float((1 - 0.4 * std::cos(2 * pi * time)) * std::hypot(2 * pi * turns * radius, 2)));
      }
      for (uint32_t i = 0; i < samples; ++i) {
        block.segments.push_back({first + i, first + i + 1});
        block.neighbours.push_back({first + (i > 0 ? i - 1 : 0), first + std::min(i + 2, uint32_t(samples))});
      }
    }
    return block;
  });
}

}  // namespace gxy::data_tool
