// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyrender/reference_run.h"

#include <algorithm>
#include <iostream>
#include <optional>

#include "backends/registry/backends.h"
#include "core/comm/error.h"
#include "core/comm/in_process.h"
#include "tools/gxyrender/filter_place.h"
#include "tools/gxyrender/load.h"
#include "tools/gxyrender/pictures.h"
#include "tools/gxyrender/reference_scene.h"

namespace gxy {

std::vector<ShownSoFar> renderWithReference(const State& state, const std::string& directory,
                                            const RenderOptions& options, bool progress,
                                            std::vector<ShownSoFar> shown) {
  SingleRank alone;
  Ledger ledger;
  RenderOptions whole = options;
  whole.partitions = {1, 1, 1};
  // Filters run on one rank of this process's own.
  InProcessWorld world(1, 0, {.threaded = true, .onError = {}});
  const BackendRegistry registry = allBackends({});
  std::unique_ptr<Backend> backend;
  std::optional<FilterPlace> place;
  if (std::any_of(state.datasets.begin(), state.datasets.end(),
                  [](const DatasetSpec& d) { return !d.filter.empty(); })) {
    backend = registry.forFields()(&ledger);
    place.emplace(world.rank(0), options.threads, registry, *backend, ledger);
  }
  const LoadedState loaded = loadData(state, directory, whole, alone, ledger, std::move(shown),
                                      standardFilters(), place ? place->services() : FilterServices());
  const std::vector<StatePicture> pictures = picturesOf(state);
  for (size_t i = 0; i < pictures.size(); i++) {
    const reference::ReferenceScene scene = referenceScene(state, loaded, pictures[i].visualization);
    const std::string name = pictureName(state, options, i);
    reference::ReferenceOptions how;
    how.threads = options.threads;
    const int aoCount = scene.visualization.lighting.aoCount;
    how.aoHook = occlusionDirections(aoCount, pictures[i].camera.dimensions.x, 0);
    if (progress)
      how.progress = [&](double f) {
        std::cerr << '\r' << name << ' ' << int(100 * f) << " %" << std::flush;
      };
    reference::ReferencePicture picture = reference::renderReference(scene, loaded.camera(pictures[i]), how);
    if (progress) std::cerr << '\n';
    reference::applyBackground(picture, state.settings);
    Picture out{
        picture.width, picture.height, LargeVector<float>(picture.rgba.begin(), picture.rgba.end()), {}};
    if (options.depth) out.depth = std::move(picture.depth);
    annotate(out, state, loaded, options, i);
    writePicture(name, options, std::move(out));
  }
  return loaded.shown;
}

}  // namespace gxy
