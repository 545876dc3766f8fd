// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/made_geometry.h"

#include "core/io/import_geometry.h"

namespace gxy {

std::shared_ptr<Dataset> madeGeometry(FilterRun& run, const std::string& name, GeometryKind kind,
                                      GeometryBlock block, std::shared_ptr<const Partitioning> partitioning,
                                      LedgerEntry memory, const std::string& array) {
  LoadedGeometry loaded;
  OwnedGeometry& geometry = loaded.geometry;
  geometry.name = name;
  geometry.kind = kind;
  geometry.array = array;
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

nlohmann::json toldOfPoints(const OwnedGeometry& geometry) {
  std::vector<PointFieldInfo> all;
  if (!geometry.array.empty()) all.push_back({geometry.array, 1, {geometry.range}});
  all.insert(all.end(), geometry.fields.begin(), geometry.fields.end());
  return toldOf(all);
}

nlohmann::json toldOf(std::span<const PointFieldInfo> fields) {
  nlohmann::json told = nlohmann::json::array();
  for (const PointFieldInfo& f : fields) {
    const Range& range = f.ranges.back();
    nlohmann::json one{{"name", f.name}, {"components", f.components}, {"range", nullptr}};
    if (!range.empty()) one["range"] = {range.min, range.max};
    told.push_back(std::move(one));
  }
  return told;
}

}  // namespace gxy
