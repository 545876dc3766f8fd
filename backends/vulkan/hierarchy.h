// SPDX-License-Identifier: Apache-2.0
// Bounding volume hierarchies over the geometry of a partition and over shells of meshes, as shaders/geometry.comp and
// shaders/integrate_mesh.comp walk them.
#pragma once
#include <cstdint>
#include <vector>

#include "core/rays/compiled_scene.h"

namespace gxy::vulkan {

/// The nodes and primitives of a hierarchy, as shaders/layout.h describes them; node 0 is the root. Empty if
/// there is no geometry.
struct Hierarchy {
  std::vector<uint32_t> nodes, primitives;
};

/// Builds a hierarchy with Embree (surface area heuristic, 4 children), on all cores, and lays it out in
/// depth-first order, so that the same data give the same bytes. Throws Error if the builder fails, and what
/// `advance` throws.
Hierarchy hierarchyOf(
    const CompiledScene& scene, int partition, const Advance& advance = [](double) {});

/// The same over the shell of the cells that operator `op`, an unstructured volume, has in the partition.
Hierarchy shellHierarchyOf(
    const CompiledScene& scene, int op, int partition, const Advance& advance = [](double) {});

}  // namespace gxy::vulkan
