// SPDX-License-Identifier: Apache-2.0
// Geometry goes from the ranks that own its primitives to the partitions that these touch.
#pragma once
#include <memory>

#include "core/comm/collectives.h"
#include "core/data/geometry.h"
#include "core/data/owned_geometry.h"
#include "core/data/partitioning.h"
#include "core/data/replicate.h"

namespace gxy {

/// Collective. Brings primitives to every partition that they, `radius` thick, touch. If any rank fails, all throw the same
/// Error. Tells ranks.done() how far it is.
std::shared_ptr<Geometry> distribute(const OwnedGeometry& owned, const Partitioning& partitioning,
                                     const RadiusOf& radius, Collectives& ranks);

}  // namespace gxy
