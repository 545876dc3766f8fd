// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/io/write_geometry.h"
#include "tools/gxydata/commands.h"

namespace gxy::data_tool {
namespace {

using std::numbers::pi;
constexpr uint8_t kVtkTetrahedron = 10, kVtkHexahedron = 12;

/// Moves a point inside [-1, 1]^3 by up to `far` along each axis, so that faces of cells are not flat. Points of the border stay.
glm::dvec3 bent(glm::dvec3 p, double far) {
  const double inside = (1 - p.x * p.x) * (1 - p.y * p.y) * (1 - p.z * p.z);
  return p + far * inside *
                 glm::dvec3(std::sin(pi * p.y) * std::cos(0.7 * pi * p.z),
                            std::sin(pi * p.z + 0.4) * std::cos(0.6 * pi * p.x),
                            std::sin(pi * p.x - 0.3) * std::cos(0.8 * pi * p.y));
}

/// The cells of a grid of so many points: hexahedra, or six tetrahedra around a diagonal of each.
void addCells(const std::array<int64_t, 3>& points, bool tetrahedra, GatheredMesh& mesh) {
  constexpr std::array<int, 6> kAround{1, 2, 3, 7, 4, 5};
  const int64_t nx = points[0], ny = points[1], nz = points[2];
  const auto add = [&](uint8_t type, std::span<const uint32_t> corners) {
    mesh.types.push_back(type);
    mesh.offsets.push_back(mesh.connectivity.size());
    mesh.connectivity.insert(mesh.connectivity.end(), corners.begin(), corners.end());
  };
  for (int64_t k = 0; k + 1 < nz; k++)
    for (int64_t j = 0; j + 1 < ny; j++)
      for (int64_t i = 0; i + 1 < nx; i++) {
        const auto at = [&](int64_t a, int64_t b, int64_t c) {
          return uint32_t(i + a + nx * (j + b + ny * (k + c)));
        };
        const std::array<uint32_t, 8> c{at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0),
                                        at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)};
        if (!tetrahedra) add(kVtkHexahedron, c);
        for (size_t n = 0; tetrahedra && n < 6; n++)
          add(kVtkTetrahedron,
              std::array{c[0], c[size_t(kAround[n])], c[size_t(kAround[(n + 1) % 6])], c[6]});
      }
  mesh.offsets.push_back(mesh.connectivity.size());
}

}  // namespace

void makeCells(const Field& field, const Options& options) {
  const auto& n = options.resolution;
  for (const int64_t points : n)
    if (points < 2 || points > 1024)
      throw Error("cells of a grid of " + std::to_string(n[0]) + " x " + std::to_string(n[1]) + " x " +
                  std::to_string(n[2]) + " points, expected 2 to 1024 on each axis");
  const int steps = std::max(options.steps, 1);
  Progress progress("making " + options.out, steps);
  GatheredMesh mesh;
  mesh.points.resize(size_t(n[0] * n[1] * n[2]));
  parallelFor(int64_t(0), n[2], [&](int64_t k) {
    size_t at = size_t(k * n[0] * n[1]);
    for (int64_t j = 0; j < n[1]; j++)
      for (int64_t i = 0; i < n[0]; i++)
        mesh.points[at++] = bent(2.0 * glm::dvec3(double(i), double(j), double(k)) /
                                         glm::dvec3(double(n[0] - 1), double(n[1] - 1), double(n[2] - 1)) -
                                     1.0,
                                 options.displacement);
  });
  addCells(n, options.cells == "tetrahedra", mesh);
  mesh.values.resize(mesh.points.size() * sizeof(float));
  for (int step = 0; step < steps; ++step, progress.advance()) {
    const double phase = double(step) / steps;
    parallelFor(size_t(0), mesh.points.size(), [&](size_t i) {
      const float value = field.value(mesh.points[i], phase);
      std::memcpy(&mesh.values[i * sizeof value], &value, sizeof value);
    });
    writeMesh(stepName(options, step), mesh, field.name, ScalarType::Float32, 1, false);
  }
}

}  // namespace gxy::data_tool
