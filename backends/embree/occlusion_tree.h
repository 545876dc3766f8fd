// SPDX-License-Identifier: Apache-2.0
// What rays of ambient occlusion walk through, one by one, to find whether anything is in their way (occlusion.ispc).
#pragma once
#include <cstdint>

#include "gxy/rays/compiled_scene.h"
#include "gxy/space/large_vector.h"

namespace gxy {

/// A hierarchy of boxes with as many children to a node, and up to as many primitives to a leaf, as a gang has lanes, so that a
/// step tests a ray against all of them. Leaves hold copies of what is tested, as rays that go each its own way mostly wait for
/// memory. occlusion_layout.h says how it lies.
struct OcclusionTree {
  LargeVector<uint32_t> nodes;
  LargeVector<float> leaves;

  size_t bytes() const { return nodes.size() * sizeof(uint32_t) + leaves.size() * sizeof(float); }
};

/// As the kernels see it.
struct OcclusionTreeView {
  const uint32_t* nodes = nullptr;  ///< null: there is none
  const float* leaves = nullptr;
};

/// Over the primitives of a part, of KIND_PARTICLES, _PATHLINES or _TRIANGLES, for gangs of 4, 8 or 16. Built by Embree's builder,
/// on all cores. Throws Error if that fails.
OcclusionTree buildOcclusionTree(int kind, const GeometryPart& part, int lanes);

}  // namespace gxy
