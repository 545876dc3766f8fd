// SPDX-License-Identifier: Apache-2.0
// A hierarchy of boxes over the geometry of a partition, as shaders/geometry.comp walks it.
#pragma once
#include <cstdint>
#include <vector>

#include "core/rays/compiled_scene.h"

namespace gxy::vulkan {

/// See shaders/layout.h for nodes and primitives; node 0 is the root. Empty where there is no geometry.
struct Hierarchy {
  std::vector<uint32_t> nodes, primitives;
};

/// Built by Embree's builder (surface area heuristic, 4 children), on all cores, and laid out in depth-first order: the
/// same data give the same bytes. Throws Error if the builder fails, and what `advance` throws.
Hierarchy hierarchyOf(
    const CompiledScene& scene, int partition, const Advance& advance = [](double) {});

/// Points per primitive.
int cornersOf(VisType type);

}  // namespace gxy::vulkan
