// SPDX-License-Identifier: Apache-2.0
// What rays walk through to find the geometry that they meet (geometry.ispc).
#pragma once
#include <cstdint>

#include "core/rays/compiled_scene.h"
#include "core/space/large_vector.h"

namespace gxy {

/// A hierarchy of boxes with as many children to a node, and up to as many primitives to a leaf, as a gang has lanes, so that a
/// step tests a ray against all of them. Leaves hold copies of what is tested, as rays that go each its own way mostly wait for
/// memory. tree_layout.h says how it lies.
struct GeometryTree {
  LargeVector<uint32_t> nodes;
  LargeVector<float> leaves;

  size_t bytes() const { return nodes.size() * sizeof(uint32_t) + leaves.size() * sizeof(float); }
};

/// As the kernels see it.
struct GeometryTreeView {
  const uint32_t* nodes = nullptr;  ///< null: there is none
  const float* leaves = nullptr;
};

/// Over the primitives of a part, of KIND_PARTICLES, _PATHLINES or _TRIANGLES, for gangs of 4, 8 or 16. Built by Embree's builder,
/// on all cores. Throws Error if that fails.
GeometryTree buildGeometryTree(
    int kind, const GeometryPart& part, int lanes, const Advance& advance = [](double) {});

}  // namespace gxy
