// SPDX-License-Identifier: Apache-2.0
// Geometry of a partition, for Embree to find.
#pragma once
#include <span>

#include "gxy/embree/embree.h"
#include "gxy/kernels/single_views.h"

namespace gxy {

/// A bounding volume hierarchy over all geometry operators of a partition, whose ids are the operators' indices; null if
/// none has primitives. `operators` must outlive it and not move.
embree::Scene buildGeometry(const embree::Device& device, std::span<const single::OperatorView> operators);

}  // namespace gxy
