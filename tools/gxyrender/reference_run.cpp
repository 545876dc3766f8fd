// SPDX-License-Identifier: Apache-2.0
#include "reference_run.h"

#include <iostream>

#include "gxy/comm/error.h"
#include "gxy/reference/reference.h"
#include "load.h"
#include "pictures.h"

namespace gxy {

void renderWithReference(const State& state, const std::string& directory, const RenderOptions& options,
                         bool progress) {
  SingleRank alone;
  Ledger ledger;
  RenderOptions whole = options;
  whole.partitions = {1, 1, 1};
  const LoadedState loaded = loadData(state, directory, whole, alone, ledger);
  for (size_t c = 0; c < state.cameras.size(); c++)
    for (size_t v = 0; v < state.visualizations.size(); v++) {
      reference::ReferenceScene scene{state.visualizations[v], {}, state.settings};
      for (size_t i = 0; i < loaded.data[v].size(); i++) {
        const OperatorData& data = loaded.data[v][i];
        if (data.volume) {
          scene.data.emplace_back(data.volume);
        } else {
          scene.data.emplace_back(data.geometry);
          // the reference takes the map's first colour for geometry without values
          if (data.geometry->range.empty())
            scene.visualization.operators[i].colormap = {{ColorPoint{0, data.color}}};
        }
      }
      const std::string name = pictureName(state, options, v, c);
      reference::ReferenceOptions how;
      how.threads = options.threads;
      if (progress)
        how.progress = [&](double f) {
          std::cerr << '\r' << name << ' ' << int(100 * f) << " %" << std::flush;
        };
      reference::ReferencePicture picture = reference::renderReference(scene, state.cameras[c], how);
      if (progress) std::cerr << '\n';
      reference::applyBackground(picture, state.settings.background);
      Picture out{
          picture.width, picture.height, std::vector<float>(picture.rgba.begin(), picture.rgba.end()), {}};
      if (options.depth) out.depth = std::move(picture.depth);
      writePicture(name, options, std::move(out));
    }
}

}  // namespace gxy
