// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/field_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "core/comm/error.h"
#include "core/comm/error_text.h"

namespace gxy {
namespace {

constexpr double kEndMargin = 1e-9;  // cells by which a point on the box's end may have been rounded outwards

// Exact at both ends, so that two cells agree on their face.
double mix(double a, double b, double f) { return f < 0.5 ? a + f * (b - a) : b - (1 - f) * (b - a); }

double trilinear(const std::array<double, 8>& c, const glm::dvec3& f) {
  const double x00 = mix(c[0], c[1], f.x), x10 = mix(c[2], c[3], f.x);
  const double x01 = mix(c[4], c[5], f.x), x11 = mix(c[6], c[7], f.x);
  return mix(mix(x00, x10, f.y), mix(x01, x11, f.y), f.z);
}

template <class T>
double sampleAt(const std::byte* point, int component) {
  T stored;
  std::memcpy(&stored, point + size_t(component) * sizeof stored, sizeof stored);
  return double(stored);
}

}  // namespace

FieldReader::FieldReader(const Volume& volume, const Partitioning& partitioning)
    : volume_(volume), partitioning_(partitioning), box_(volume.grid.box()) {
  for (const auto& [partition, block] : volume.blocks)
    blocks_.emplace(partition, Block{&block, Bricks(block.extent.points)});
}

std::optional<GridPlace> FieldReader::place(glm::dvec3 world) const {
  GridPlace place;
  for (int a = 0; a < 3; a++) {
    const double margin = kEndMargin * volume_.grid.spacing[a];
    if (!(world[a] >= box_.lo[a] - margin && world[a] <= box_.hi[a] + margin)) return std::nullopt;
    const double at = (world[a] - volume_.grid.origin[a]) / volume_.grid.spacing[a];
    place.cell[size_t(a)] =
        std::clamp(int64_t(std::floor(at)), int64_t(0), volume_.grid.points[size_t(a)] - 2);
    place.fraction[a] = std::clamp(at - double(place.cell[size_t(a)]), 0.0, 1.0);
  }
  return place;
}

glm::dvec3 FieldReader::worldOf(const GridPlace& place) const {
  glm::dvec3 world;
  for (int a = 0; a < 3; a++)
    world[a] = volume_.grid.origin[a] +
               volume_.grid.spacing[a] * (double(place.cell[size_t(a)]) + place.fraction[a]);
  return world;
}

int FieldReader::partitionOf(const Index3& cell) const {
  return partitioning_.nearest(worldOf({cell, glm::dvec3(0.5)}));
}

FieldReader::Corners FieldReader::corners(int partition, const Index3& cell, int component) const {
  const Block& block = blocks_.at(partition);
  const Index3& first = block.samples->extent.first;
  const size_t pointBytes = bytesOf(volume_.stored) * size_t(volume_.components);
  return withType(volume_.stored, [&](auto type) {
    using T = decltype(type);
    Corners corners;
    double finite = 0;
    for (size_t i = 0; i < 8; i++) {
      const auto at = [&](size_t a, size_t upper) { return cell[a] + int64_t(upper) - first[a]; };
      const std::byte* point =
          &block.samples->samples[block.bricks(at(0, i & 1), at(1, i >> 1 & 1), at(2, i >> 2)) * pointBytes];
      const auto valueOf = [&](int c) { return volume_.shift + volume_.scale * sampleAt<T>(point, c); };
      if (component >= 0) {
        corners[i] = valueOf(component);
      } else {
        double squares = 0;
        for (int c = 0; c < volume_.components; c++) squares += valueOf(c) * valueOf(c);
        corners[i] = std::sqrt(squares);
      }
      finite += corners[i] - corners[i];
    }
    if (!(finite == 0)) corners.fill(std::numeric_limits<double>::quiet_NaN());
    return corners;
  });
}

double FieldReader::value(int partition, const GridPlace& place, int component) const {
  const Corners c = corners(partition, place.cell, component);
  return std::isnan(c[0]) ? c[0] : trilinear(c, place.fraction);
}

glm::dvec3 FieldReader::gradient(int partition, const GridPlace& place, int component) const {
  const Corners c = corners(partition, place.cell, component);
  const glm::dvec3& f = place.fraction;
  const auto along = [&](size_t step, size_t u, size_t v, double fu, double fv) {
    const auto difference = [&](size_t from) { return c[from + step] - c[from]; };
    return mix(mix(difference(0), difference(u), fu), mix(difference(v), difference(u + v), fu), fv);
  };
  return glm::dvec3(along(1, 2, 4, f.y, f.z), along(2, 1, 4, f.x, f.z), along(4, 1, 2, f.x, f.y)) /
         volume_.grid.spacing;
}

int componentOf(int components, const std::string& dataset, std::optional<int> component) {
  if (!component) return components == 1 ? 0 : -1;
  if (*component < components) return *component;
  throw Error(inQuotes(dataset) + ": there is no component " + std::to_string(*component) +
              ", expected 0 to " + std::to_string(components - 1));
}

}  // namespace gxy
