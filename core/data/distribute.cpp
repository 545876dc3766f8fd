// SPDX-License-Identifier: Apache-2.0
#include "core/data/distribute.h"

#include <utility>
#include <vector>

namespace gxy {

std::shared_ptr<Geometry> distribute(const OwnedGeometry& owned, const Partitioning& partitioning,
                                     const RadiusOf& radius, Collectives& ranks) {
  auto geometry = std::make_shared<Geometry>();
  geometry->name = owned.name;
  geometry->kind = owned.kind;
  geometry->box = owned.box;
  geometry->range = owned.range;
  geometry->radiusRange = owned.radiusRange;
  geometry->colored = owned.colored;
  geometry->primitives = owned.primitives;
  geometry->droppedPrimitives = owned.droppedPrimitives;
  std::vector<Bytes> messages;
  agree(ranks, [&] {
    messages =
        packForOwners(owned.block, owned.kind, partitioning, radius, ranks.size(), advanceOf(ranks, 0, 0.5));
  });
  const std::vector<Bytes> received = ranks.allToAll(std::move(messages));
  agree(ranks, [&] {
    geometry->blocks =
        unpackReceived(owned.kind, partitioning, ranks.rank(), received, advanceOf(ranks, 0.5));
  });
  return geometry;
}

}  // namespace gxy
