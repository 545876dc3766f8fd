// SPDX-License-Identifier: Apache-2.0
#include "core/render/scene_builder.h"

#include <algorithm>

#include "core/data/distribute.h"
#include "core/data/shown_array.h"
#include "core/space/freed_memory.h"

namespace gxy {

namespace {

/// Whether `here` is true on every rank.
bool everywhere(bool here, Collectives& ranks) {
  auto all = uint8_t(here);
  reduceValues(ranks, std::span(&all, 1), std::bit_and<uint8_t>());
  return all != 0;
}

/// Each rank has compiled its own partitions. A partition is visible if one rank says so.
void mergeVisible(CompiledScene& scene, Collectives& ranks) {
  reduceValues(ranks, std::span(scene.visible), std::bit_or<uint8_t>());
}

}  // namespace

std::shared_ptr<Geometry> distributed(std::shared_ptr<const OwnedGeometry> owned, const Vis& vis,
                                      const Partitioning& partitioning, Collectives& ranks,
                                      const EnterMemory& enter) {
  const ShownArray shown{vis.array, vis.component};
  LedgerEntry copy;
  agree(ranks, [&] {
    if (const int64_t bytes = bytesToShow(*owned, shown)) copy = enter("geometry", bytes);
    owned = geometryToShow(std::move(owned), shown, vis.dataset);
  });
  return distribute(
      *owned, partitioning,
      [&vis](double value) { return vis.type == VisType::Triangles ? 0.0 : radiusOf(vis, value); }, ranks);
}

DistributedGeometryPtr SharedGeometry::get(const GeometrySource& source, const Vis& vis,
                                           const Partitioning& partitioning, Collectives& ranks,
                                           const EnterMemory& enter, std::vector<LedgerEntry>& compiled) {
  const RenderSpace space = renderSpaceOf(partitioning);
  const Distribution distribution{source.name,
                                  radiiOf(vis),
                                  vis.array,
                                  vis.component.value_or(-1),
                                  {space.centre.x, space.centre.y, space.centre.z, space.scale}};
  DistributedGeometryPtr known = known_.find(distribution);
  if (everywhere(known != nullptr, ranks)) return known;  // a rank may have forgotten it
  const std::shared_ptr<Geometry> geometry = distributed(source.owned, vis, partitioning, ranks, enter);
  CompiledGeometry primitives;
  agree(ranks, [&] {
    const LedgerEntry blocks = enter("geometry", bytesOf(*geometry));
    while (!geometry->blocks.empty()) {
      const auto block = geometry->blocks.extract(geometry->blocks.begin());
      if (block.mapped().ids.empty()) continue;
      auto& part = primitives[block.key()];
      part =
          compilePrimitives(block.mapped(), geometry->kind, vis, space, [&ranks](double) { ranks.check(); });
      compiled.push_back(enter("scene", int64_t(part->bytes())));
    }
  });
  return known_.get(distribution, [&] {
    return DistributedGeometry{geometry, std::make_shared<const CompiledGeometry>(std::move(primitives))};
  });
}

MeshGradientsPtr SharedGradients::get(std::shared_ptr<const Mesh> mesh, const Vis& vis,
                                      const Partitioning& partitioning, Collectives& ranks,
                                      const EnterMemory& enter) {
  const std::pair key{mesh.get(), vis.component.value_or(-1)};
  MeshGradientsPtr known = known_.find(key);
  if (everywhere(known != nullptr, ranks)) return known;  // a rank may have forgotten it
  MeshGradients mine{std::move(mesh), {}, {}};
  mine.gradients = pointGradients(*mine.mesh, vis.component, partitioning, ranks);
  agree(ranks, [&] { mine.memory = enter("geometry", bytesOf(mine.gradients)); });
  return known_.get(key, [&] { return std::move(mine); });
}

std::vector<std::shared_ptr<const CompiledScene>> SceneBuilder::others() {
  std::vector<std::shared_ptr<const CompiledScene>> others;
  const std::lock_guard lock(mutex_);
  std::erase_if(scenes_, [](const auto& scene) { return scene.expired(); });
  for (const auto& scene : scenes_)
    if (auto other = scene.lock()) others.push_back(std::move(other));
  return others;
}

BuiltScene SceneBuilder::build(SceneSource source, Collectives& ranks, const EnterMemory& enter,
                               const OnItem& onItem) {
  const int64_t of = 2 + std::count_if(source.data.begin(), source.data.end(),
                                       [](const OperatorSource& o) { return o.geometry.has_value(); });
  int64_t item = 0;
  BuiltScene built;
  std::vector<LedgerEntry> compiled;  // until the scene has its own entries
  std::vector<OperatorData> data;
  for (size_t i = 0; i < source.data.size(); i++) {
    OperatorSource& from = source.data[i];
    if (from.geometry) {
      const Vis& vis = source.visualization.operators[i];
      onItem(item++, of, "distributing " + vis.dataset);
      built.geometry.push_back(
          geometry_.get(*from.geometry, vis, *source.partitioning, ranks, enter, compiled));
      from.data.geometry = built.geometry.back()->geometry;
      from.data.primitives = built.geometry.back()->primitives;
      from.data.owned = from.geometry->owned;
    }
    if (const Vis& vis = source.visualization.operators[i];
        from.data.mesh && !vis.isovalues.empty() && !source.sampled) {
      built.gradients.push_back(gradients_.get(from.data.mesh, vis, *source.partitioning, ranks, enter));
      from.data.gradients = {built.gradients.back(), &built.gradients.back()->gradients};
    }
    data.push_back(std::move(from.data));
  }
  onItem(item++, of, "compiling the scene");
  std::shared_ptr<CompiledScene> scene;
  agree(ranks, [&] {
    scene = compileScene(source.visualization, std::move(data), source.partitioning, source.settings,
                         others(), advanceOf(ranks));
    scene->sampled = source.sampled;
  });
  mergeVisible(*scene, ranks);
  built.compiled = scene;
  onItem(item++, of, "building the scene");
  agree(ranks, [&] {
    built.device = backend_.makeScene(scene, rank_, advanceOf(ranks));
    compiled.clear();
    built.memory = memory_.enter(*scene, *built.device, [&](int64_t bytes) { return enter("scene", bytes); });
    const std::lock_guard lock(mutex_);
    scenes_.push_back(scene);
  });
  returnFreedMemory();
  return built;
}

}  // namespace gxy
