// SPDX-License-Identifier: Apache-2.0
// The trees through which rays find the geometry that they hit (geometry.ispc).
#pragma once
#include <cstdint>

#include "core/rays/compiled_scene.h"
#include "core/space/large_vector.h"

namespace gxy {

/// A hierarchy of boxes. A node has as many children, and a leaf up to as many primitives, as a gang has
/// lanes, so that a step tests a ray against all of them. Leaves hold copies of the data that is tested,
/// because rays that go different ways mostly wait for memory. tree_layout.h describes the memory layout.
struct GeometryTree {
  LargeVector<uint32_t> nodes;
  LargeVector<float> leaves;

  size_t bytes() const { return nodes.size() * sizeof(uint32_t) + leaves.size() * sizeof(float); }
};

/// A tree as the kernels see it.
struct GeometryTreeView {
  const uint32_t* nodes = nullptr;  ///< null: there is no tree
  const float* leaves = nullptr;
};

/// Builds a tree over the primitives of a part, of KIND_PARTICLES, KIND_PATHLINES, KIND_TRIANGLES, or of meshes, for
/// gangs of 4, 8 or 16 lanes. It is built by Embree on all cores. Throws Error if that fails.
GeometryTree buildGeometryTree(
    int kind, const GeometryInPartition& part, int lanes, const Advance& advance = [](double) {});

}  // namespace gxy
