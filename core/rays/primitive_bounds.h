// SPDX-License-Identifier: Apache-2.0
// Bounding boxes of primitives, from which hierarchies are built.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/kernels/single_views.h"
#include "core/rays/compiled_scene.h"

namespace gxy {

/// The number of points of a primitive of KIND_PARTICLES, KIND_PATHLINES or KIND_TRIANGLES.
inline int cornersOfKind(int kind) { return kind == KIND_PARTICLES ? 1 : kind == KIND_PATHLINES ? 2 : 3; }

struct PrimitiveBounds {
  static constexpr float kNone = std::numeric_limits<float>::infinity();
  float lo[3] = {kNone, kNone, kNone}, hi[3] = {-kNone, -kNone, -kNone};

  /// Makes the box hold a sphere.
  void hold(float x, float y, float z, float radius) {
    const float centre[] = {x, y, z}, r = std::max(radius, 0.f);
    for (int k = 0; k < 3; k++) {
      lo[k] = std::min(lo[k], centre[k] - r);
      hi[k] = std::max(hi[k], centre[k] + r);
    }
  }

  /// The box made so wide that a traversal in float loses no candidate to rounding. It is finite and within 1.8e18: builders of
  /// hierarchies accept numbers below 1.844e18, and rays come no farther (meetsGeometry in clip.h).
  PrimitiveBounds widened() const {
    constexpr float kSlack = 2e-6f, kLargest = 1.8e18f;
    PrimitiveBounds b = *this;
    float largest = 0;
    for (int k = 0; k < 3; k++) largest = std::max({largest, std::abs(lo[k]), std::abs(hi[k])});
    for (int k = 0; k < 3; k++) {
      b.lo[k] = std::clamp(lo[k] - largest * kSlack, -kLargest, kLargest);
      b.hi[k] = std::clamp(hi[k] + largest * kSlack, -kLargest, kLargest);
    }
    return b;
  }
};

/// The bounds of primitive `i` with 1 (a sphere), 2 (a tube), 3 (a triangle) or 4 corners. `points` are x y z radius; `indices` are not
/// read for spheres.
inline PrimitiveBounds primitiveBounds(int corners, const float* points, const uint32_t* indices, size_t i) {
  PrimitiveBounds b;
  for (int c = 0; c < corners; c++) {
    const float* p = points + 4 * (corners == 1 ? i : size_t(indices[size_t(corners) * i + size_t(c)]));
    b.hold(p[0], p[1], p[2], p[3]);
  }
  return b.widened();
}

/// The bounds of the surface in a tetrahedron (cell_surface.h), whose four corners are x y z level: of all places in it where the level is
/// 0 but for the rounding errors of a ray's levels. They are convex, so their own corners are enough.
inline PrimitiveBounds surfaceBounds(const float* corners) {
  const auto corner = [&](int k) { return corners + 4 * k; };
  float largest = 0;
  for (int k = 0; k < 4; k++) largest = std::max(largest, std::abs(corner(k)[3]));
  PrimitiveBounds b;
  const double zero = 2e-6 * double(largest);
  for (int k = 0; k < 4; k++) {
    const float* p = corner(k);
    if (std::abs(double(p[3])) <= zero) b.hold(p[0], p[1], p[2], 0);
    for (int j = k + 1; j < 4; j++) {
      const float* q = corner(j);
      for (const double level : {-zero, zero}) {
        if ((double(p[3]) < level) == (double(q[3]) < level)) continue;
        const double along = (level - double(p[3])) / (double(q[3]) - double(p[3]));
        const auto at = [&](int a) { return float(std::lerp(double(p[a]), double(q[a]), along)); };
        b.hold(at(0), at(1), at(2), 0);
      }
    }
  }
  return b.widened();
}

/// The bounds of primitive `i` of a part of this kind (KIND_*).
inline PrimitiveBounds primitiveBounds(int kind, const GeometryInPartition& part, size_t i) {
  if (kind < KIND_MESH)
    return primitiveBounds(cornersOfKind(kind), part.points.data(), part.indices.data(), i);
  if (kind == KIND_MESH) return surfaceBounds(&part.points[16 * i]);
  float points[32] = {};  // without radii
  constexpr uint32_t kAll[] = {0, 1, 2, 3, 4, 5, 6, 7};
  int n = 0;
  if (kind == KIND_HEX_MESH) {
    for (; n < 8; n++) std::copy_n(&part.points[4 * (8 * i + size_t(n))], 3, points + 4 * n);
    return primitiveBounds(8, points, kAll, 0);
  }
  const FaceId face = part.shell[i];
  const GeometryInPartition& cells = part.arrays();
  if (kind == KIND_HEX_SHELL) {
    const uint32_t corners = single::sideCorners(uint32_t(faceOf(face)));
    for (; n < 4; n++)
      std::copy_n(&cells.points[4 * size_t(cells.indices[8 * size_t(cellOf(face)) + (corners >> 4 * n & 7)])],
                  3, points + 4 * n);
    return primitiveBounds(4, points, kAll, 0);
  }
  for (int k = 0; k < 4; k++) {
    if (k == faceOf(face)) continue;
    std::copy_n(&cells.points[4 * size_t(cells.indices[4 * size_t(cellOf(face)) + size_t(k)])], 3,
                points + 4 * n++);
  }
  return primitiveBounds(3, points, kAll, 0);
}

}  // namespace gxy
