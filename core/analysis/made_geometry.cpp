// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/made_geometry.h"

#include "core/io/import_geometry.h"

namespace gxy {

std::shared_ptr<Dataset> madeGeometry(FilterRun& run, const std::string& name, GeometryKind kind,
                                      GeometryBlock block, std::shared_ptr<const Partitioning> partitioning,
                                      LedgerEntry memory) {
  LoadedGeometry loaded;
  OwnedGeometry& geometry = loaded.geometry;
  geometry.name = name;
  geometry.kind = kind;
  uint64_t dropped = 0;
  agree(run.ranks, [&] {
    validate(block, kind);
    dropped = uint64_t(dropUnusable(block, kind));
    geometry.block = std::move(block);
  });
  geometry.primitives = sumOfCounts(run.ranks, geometry.block.ids.size());
  geometry.droppedPrimitives = sumOfCounts(run.ranks, dropped);
  measureGeometry(loaded, run.ranks);
  return run.made(std::make_shared<const OwnedGeometry>(std::move(geometry)), std::move(partitioning),
                  std::move(memory));
}

}  // namespace gxy
