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
  float lo[3], hi[3];
};

/// The bounds of primitive `i` with 1 (a sphere), 2 (a tube), 3 (a triangle) or 4 corners. `points` are x y z
/// radius; `indices` are not read for spheres. The box is so wide that a traversal in float loses no
/// candidate to rounding. It is finite and within 1.8e18: builders of hierarchies accept numbers below
/// 1.844e18, and rays come no farther (meetsGeometry in clip.h).
inline PrimitiveBounds primitiveBounds(int corners, const float* points, const uint32_t* indices, size_t i) {
  constexpr float kSlack = 2e-6f, kLargest = 1.8e18f, kInfinity = std::numeric_limits<float>::infinity();
  PrimitiveBounds b{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (int c = 0; c < corners; c++) {
    const float* p = points + 4 * (corners == 1 ? i : size_t(indices[size_t(corners) * i + size_t(c)]));
    const float r = std::max(p[3], 0.f);
    for (int k = 0; k < 3; k++) {
      b.lo[k] = std::min(b.lo[k], p[k] - r);
      b.hi[k] = std::max(b.hi[k], p[k] + r);
    }
  }
  float largest = 0;
  for (int k = 0; k < 3; k++) largest = std::max({largest, std::abs(b.lo[k]), std::abs(b.hi[k])});
  for (int k = 0; k < 3; k++) {
    b.lo[k] = std::clamp(b.lo[k] - largest * kSlack, -kLargest, kLargest);
    b.hi[k] = std::clamp(b.hi[k] + largest * kSlack, -kLargest, kLargest);
  }
  return b;
}

/// The bounds of primitive `i` of a part of this kind (KIND_*).
inline PrimitiveBounds primitiveBounds(int kind, const GeometryInPartition& part, size_t i) {
  if (kind < KIND_MESH)
    return primitiveBounds(cornersOfKind(kind), part.points.data(), part.indices.data(), i);
  float points[32] = {};  // without radii
  constexpr uint32_t kAll[] = {0, 1, 2, 3, 4, 5, 6, 7};
  int n = 0;
  if (kind == KIND_MESH || kind == KIND_HEX_MESH) {
    const int corners = kind == KIND_MESH ? 4 : 8;
    for (; n < corners; n++)
      std::copy_n(&part.points[4 * (size_t(corners) * i + size_t(n))], 3, points + 4 * n);
    return primitiveBounds(corners, points, kAll, 0);
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
