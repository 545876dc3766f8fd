// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/viewer/surface_at.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <optional>

#include "core/data/bricks.h"
#include "core/data/shown_array.h"
#include "core/kernels/twin.h"
#include "core/rays/kernel_cells.h"

namespace gxy::viewer {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

glm::dvec3 unit(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0 ? v / length : glm::dvec3(0);
}

/// One scalar of a block's samples, in true values.
class Field {
 public:
  Field(const Volume& volume, const VolumeBlock& block, std::optional<int> component)
      : volume_(volume), block_(block), bricks_(block.extent.points), component_(component) {}

  struct Sample {
    double value;
    glm::dvec3 gradient;
  };
  /// None outside the grid, where there is no data, and where this block lacks a point next to the cell's.
  std::optional<Sample> at(glm::dvec3 point) const {
    Index3 cell;
    glm::dvec3 w;
    for (int a = 0; a < 3; a++) {
      const double x = (point[a] - volume_.grid.origin[a]) / volume_.grid.spacing[a];
      const int64_t points = volume_.grid.points[size_t(a)];
      constexpr double kSlack = 1e-4;  // cells: what float leaves of a point on the border
      if (!(x >= -kSlack && x <= double(points - 1) + kSlack)) return std::nullopt;
      const int64_t i = std::clamp<int64_t>(int64_t(std::floor(x)), 0, points - 2);
      w[a] = std::clamp(x - double(i), 0.0, 1.0);
      cell[size_t(a)] = i;
      const int64_t first = block_.extent.first[size_t(a)], n = block_.extent.points[size_t(a)];
      if (std::max<int64_t>(i - 1, 0) < first || std::min(i + 2, points - 1) >= first + n)
        return std::nullopt;
    }
    Sample sample{0, glm::dvec3(0)};
    for (int n = 0; n < 8; n++) {
      const Index3 corner{cell[0] + (n & 1), cell[1] + (n >> 1 & 1), cell[2] + (n >> 2)};
      const double weight = (n & 1 ? w.x : 1 - w.x) * (n & 2 ? w.y : 1 - w.y) * (n & 4 ? w.z : 1 - w.z);
      const double value = valueOf(corner);
      if (!std::isfinite(value)) return std::nullopt;
      sample.value += weight * value;
      for (int a = 0; a < 3; a++) sample.gradient[a] += weight * difference(corner, a, value);
    }
    return sample;
  }

 private:
  // Central, one-sided on the grid's border and next to no data.
  double difference(const Index3& point, int axis, double here) const {
    Index3 before = point, after = point;
    before[size_t(axis)]--;
    after[size_t(axis)]++;
    const double lower = valueOf(before), upper = valueOf(after), h = volume_.grid.spacing[axis];
    if (!std::isfinite(lower)) return std::isfinite(upper) ? (upper - here) / h : 0;
    return std::isfinite(upper) ? (upper - lower) / (2 * h) : (here - lower) / h;
  }

  double valueOf(const Index3& point) const {
    Index3 local;
    for (size_t a = 0; a < 3; a++) {
      local[a] = point[a] - block_.extent.first[a];
      if (local[a] < 0 || local[a] >= block_.extent.points[a]) return kNaN;
    }
    const size_t first = bricks_(local[0], local[1], local[2]) * size_t(volume_.components);
    if (component_) return stored(first + size_t(*component_));
    if (volume_.components == 1) return stored(first);
    double squares = 0;
    for (size_t c = 0; c < size_t(volume_.components); c++) squares += stored(first + c) * stored(first + c);
    return std::sqrt(squares);
  }

  double stored(size_t index) const {
    return volume_.shift + volume_.scale * withType(volume_.stored, [&](auto value) {
                             std::memcpy(&value, &block_.samples[index * sizeof value], sizeof value);
                             return double(value);
                           });
  }

  const Volume& volume_;
  const VolumeBlock& block_;
  const Bricks bricks_;
  const std::optional<int> component_;
};

/// Calls found(surface) for the isosurfaces and slices near the point, given the value and the gradient there, and what slices show.
template <class Found>
void foundIn(const Vis& vis, double value, glm::dvec3 gradient, double onSlices, glm::dvec3 point,
             const Found& found) {
  const double slope = glm::length(gradient);
  for (size_t i = 0; i < vis.isovalues.size(); i++)
    if (slope > 0)
      found({std::abs(value - vis.isovalues[i]) / slope, 0, i, vis.isovalues[i], gradient / slope});
  for (size_t i = 0; i < vis.slices.size(); i++) {
    const Plane& slice = vis.slices[i];
    const double length = glm::length(slice.normal);
    found({std::abs(glm::dot(slice.normal, point) - slice.offset) / length, 0, vis.isovalues.size() + i,
           onSlices, slice.normal / length});
  }
}

/// Calls found(surface) for the isosurfaces and slices of a volume near the point.
template <class Found>
void ofVolume(const Vis& vis, const Volume& volume, glm::dvec3 point, const Found& found) {
  for (const auto& [partition, block] : volume.blocks) {
    const auto here = Field(volume, block, vis.component).at(point);
    if (here) foundIn(vis, here->value, here->gradient, here->value, point, found);
  }
}

/// The true value that an operator shows of a point, or a cell, of a mesh, given the stored values of all.
double shownValue(const Mesh& mesh, const std::vector<float>& values, size_t place,
                  std::optional<int> component) {
  const auto components = size_t(mesh.components);
  const auto value = [&](size_t c) {
    return mesh.shift + mesh.scale * double(values[place * components + c]);
  };
  if (component || components == 1) return value(size_t(component.value_or(0)));
  double squares = 0;
  for (size_t c = 0; c < components; c++) squares += value(c) * value(c);
  return std::sqrt(squares);
}

constexpr double kCellSlack = 1e-4;  // of a cell: what float leaves of a point on its border

/// Where a point is in a cell: the value and its gradient there; nothing if it is outside.
struct PlaceInCell {
  double value;
  glm::dvec3 gradient;
};

template <class Point, class Value>
std::optional<PlaceInCell> inTetrahedron(glm::dvec3 point, const Point& corner, const Value& value) {
  const glm::dvec3 origin = corner(0), u = corner(1) - origin, v = corner(2) - origin, w = corner(3) - origin;
  const glm::dvec3 vw = glm::cross(v, w), wu = glm::cross(w, u), uv = glm::cross(u, v), to = point - origin;
  const double volume = glm::dot(u, vw);
  if (volume == 0) return std::nullopt;
  const glm::dvec3 share = glm::dvec3(glm::dot(to, vw), glm::dot(to, wu), glm::dot(to, uv)) / volume;
  if (std::min({share.x, share.y, share.z, 1 - share.x - share.y - share.z}) < -kCellSlack)
    return std::nullopt;
  const double first = value(0);
  const glm::dvec3 rise = glm::dvec3(value(1), value(2), value(3)) - first;
  return PlaceInCell{first + glm::dot(share, rise), (rise.x * vw + rise.y * wu + rise.z * uv) / volume};
}

template <class Point, class Value>
std::optional<PlaceInCell> inHexahedron(glm::dvec3 point, const Point& corner, const Value& value) {
  Box box;
  for (size_t k = 0; k < 8; k++) box.extend(corner(k) - point);
  const glm::dvec3 size = box.hi - box.lo,
                   slack = glm::dvec3(kCellSlack * std::max({size.x, size.y, size.z}));
  for (int a = 0; a < 3; a++)
    if (box.lo[a] > slack[a] || box.hi[a] < -slack[a]) return std::nullopt;
  const auto of = [&](size_t k) { return glm::dvec4(corner(k) - point, value(k)); };
  const twin::Hexahedron cell{of(0), of(1), of(2), of(3), of(4), of(5), of(6), of(7)};
  const glm::dvec3 at = twin::coordinatesOfOrigin(cell);
  const glm::dvec4 there = twin::trilinearIn(cell, at);
  if (glm::length(glm::dvec3(there)) > slack.x) return std::nullopt;
  double volume = 0;
  const glm::dvec3 scaled = twin::scaledGradient(cell, at, volume);
  return PlaceInCell{there.w, scaled / volume};
}

/// Calls found(surface) for the isosurfaces and slices of an unstructured volume in the cells that hold the point.
template <class Found>
void ofMesh(const Vis& vis, const Mesh& mesh, glm::dvec3 point, const Found& found) {
  if (vis.isovalues.empty() && vis.slices.empty()) return;
  for (const auto& entry : mesh.blocks) {
    const MeshBlock& block = entry.second;
    const KernelCells cells = kernelCells(block, hasOnlyTetrahedra(mesh));
    for (size_t cell = 0; cell < cells.size(); cell++) {
      const auto points = cells.pointsOf(cell);
      const auto corner = [&](size_t k) { return block.points[points[k]]; };
      const auto value = [&](size_t k) { return shownValue(mesh, block.values, points[k], vis.component); };
      const auto here =
          cells.corners == 4 ? inTetrahedron(point, corner, value) : inHexahedron(point, corner, value);
      if (!here || !std::isfinite(here->value)) continue;
      const double own = mesh.ofCells ? shownValue(mesh, block.cellValues, cell, vis.component) : here->value;
      if (!std::isfinite(own)) continue;
      foundIn(vis, here->value, here->gradient, vis.cells == CellsShown::Flat ? own : here->value, point,
              found);
    }
  }
}

/// A block of geometry with what an operator shows of it.
struct ShownBlock {
  const GeometryBlock& block;
  const PointField* field = nullptr;  ///< in place of the block's own values
  int component = -1;

  double value(size_t point) const {
    if (field) return double(fieldValue(*field, component, point));
    return block.values.empty() ? kNaN : double(block.values[point]);
  }
  double radius(const Vis& vis, size_t point) const {
    return radiusOf(vis, field && block.radiusValues.empty() ? value(point) : radiusValue(block, point));
  }
};

ShownBlock shownOf(const OwnedGeometry& geometry, const Vis& vis) {
  if (showsOwnValues(geometry, {vis.array, vis.component})) return {geometry.block};
  return {geometry.block, findField(geometry.block.fields, vis.array), vis.component.value_or(-1)};
}

SurfaceAt ofParticle(const Vis& vis, const ShownBlock& shown, size_t p, glm::dvec3 point) {
  const GeometryBlock& block = shown.block;
  const glm::dvec3 out = point - block.points[p];
  const double value = shown.value(p), radius = shown.radius(vis, p);
  if (!(radius > 0)) return {std::numeric_limits<double>::infinity()};
  return {std::abs(glm::length(out) - radius), 0, 0, value, unit(out)};
}

// The ball between its ends that touches the point (core/kernels/roundcone.h).
SurfaceAt ofSegment(const Vis& vis, const ShownBlock& shown, size_t s, glm::dvec3 point) {
  const GeometryBlock& block = shown.block;
  const auto [a, b] = block.segments[s];
  const double va = shown.value(a), vb = shown.value(b);
  const double ra = shown.radius(vis, a), rb = shown.radius(vis, b);
  const glm::dvec3 axis = block.points[b] - block.points[a];
  const double length = glm::length(axis);
  double along = ra >= rb ? 0 : 1;  // where one end holds the other
  if (length > std::abs(ra - rb)) {
    const double slope = (ra - rb) / length;
    const double x = (glm::dot(point - block.points[a], axis) / length - ra * slope) / (1 - slope * slope);
    along = std::clamp(x / length, 0.0, 1.0);
  }
  const double radius = ra + along * (rb - ra);
  if (!(radius > 0)) return {std::numeric_limits<double>::infinity()};
  const glm::dvec3 out = point - (block.points[a] + along * axis);
  return {std::abs(glm::length(out) - radius), 0, 0, va + along * (vb - va), unit(out)};
}

SurfaceAt ofTriangle(const Vis&, const ShownBlock& shown, size_t t, glm::dvec3 point) {
  const GeometryBlock& block = shown.block;
  const auto& [a, b, c] = block.triangles[t];
  const glm::dvec3 origin = block.points[a], ab = block.points[b] - origin, ac = block.points[c] - origin;
  const glm::dvec3 cross = glm::cross(ab, ac);
  const double square = glm::dot(cross, cross);
  if (!(square > 0)) return {std::numeric_limits<double>::infinity()};
  const glm::dvec3 to = point - origin;
  glm::dvec3 w{0, glm::dot(glm::cross(to, ac), cross) / square, glm::dot(glm::cross(ab, to), cross) / square};
  w.x = 1 - w.y - w.z;
  // Beside the triangle the nearest of its points is taken roughly: it is found, but after those that hold the point.
  w = glm::max(w, glm::dvec3(0));
  w /= w.x + w.y + w.z;
  SurfaceAt at{glm::length(to - (w.y * ab + w.z * ac)), 0, 0, kNaN, cross / std::sqrt(square)};
  at.value = w.x * shown.value(a) + w.y * shown.value(b) + w.z * shown.value(c);
  if (!block.normals.empty())
    at.normal = unit(w.x * glm::dvec3(block.normals[a]) + w.y * glm::dvec3(block.normals[b]) +
                     w.z * glm::dvec3(block.normals[c]));
  return at;
}

template <class Found>
void ofGeometry(const Vis& vis, const OperatorData& data, glm::dvec3 point, const Found& found) {
  const GeometryKind kind = data.geometry->kind;
  const auto of = kind == GeometryKind::Particles   ? ofParticle
                  : kind == GeometryKind::PathLines ? ofSegment
                                                    : ofTriangle;
  const auto search = [&](const ShownBlock& shown) {
    for (size_t p = 0; p < shown.block.ids.size(); p++) {
      SurfaceAt at = of(vis, shown, p, point);
      at.id = shown.block.ids[p];
      found(at);
    }
  };
  if (data.owned) return search(shownOf(*data.owned, vis));
  for (const auto& [partition, block] : data.geometry->blocks) search({block});
}

// Within what float leaves of a point on a plane.
bool clipped(const Vis& vis, glm::dvec3 point, double slack) {
  return std::any_of(vis.clipPlanes.begin(), vis.clipPlanes.end(), [&](const Plane& plane) {
    return glm::dot(plane.normal, point) - plane.offset < -slack * glm::length(plane.normal);
  });
}

}  // namespace

std::optional<SurfaceAt> surfaceAt(const CompiledScene& scene, glm::dvec3 point) {
  std::optional<SurfaceAt> nearest;
  const double slack = 1e-6 / scene.space.scale;
  for (size_t i = 0; i < scene.operators.size(); i++) {
    const Vis& vis = scene.operators[i].vis;
    if (vis.opacity == 0 || clipped(vis, point, slack)) continue;
    const auto found = [&](SurfaceAt at) {
      at.vis = int32_t(i);
      if (std::isfinite(at.distance) && (!nearest || at < *nearest)) nearest = at;
    };
    const OperatorData& data = scene.operators[i].data;
    if (data.volume) ofVolume(vis, *data.volume, point, found);
    if (data.mesh) ofMesh(vis, *data.mesh, point, found);
    if (data.geometry) ofGeometry(vis, data, point, found);
  }
  return nearest;
}

}  // namespace gxy::viewer
