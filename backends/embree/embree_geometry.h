// SPDX-License-Identifier: Apache-2.0
// Geometry of a partition, for Embree to find.
#pragma once
#include <span>
#include <vector>

#include "gxy/embree/embree.h"
#include "gxy/embree/occlusion_tree.h"
#include "gxy/kernels/single_views.h"
#include "gxy/rays/compiled_scene.h"
#include "gxy/space/shared_by.h"

namespace gxy {

/// A bounding volume hierarchy over all geometry operators of a partition, whose ids are the operators' indices.
struct GeometryHierarchy {
  embree::Scene scene;
  size_t bytes = 0;  ///< of Embree's; exact if nothing else is built with the device at the same time
};

/// `operators` are read while it is built, not later: searches find them in the scene that they are for.
GeometryHierarchy buildGeometry(const embree::Device& device,
                                std::span<const single::OperatorView> operators);

/// What scenes share of a backend: Embree at work, hierarchies by their primitives, of each operator in turn, and trees.
struct EmbreeShared {
  embree::Device device;
  SharedBy<std::vector<const GeometryPart*>, GeometryHierarchy> hierarchies;
  SharedBy<const GeometryPart*, OcclusionTree> trees;
};

}  // namespace gxy
