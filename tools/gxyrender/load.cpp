// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyrender/load.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "core/comm/error.h"
#include "core/io/automatic_partitioning.h"
#include "core/io/import_geometry.h"
#include "core/io/import_volume.h"

namespace gxy {

namespace {

GeometryKind kindOf(DatasetType type) {
  if (type == DatasetType::Particles) return GeometryKind::Particles;
  return type == DatasetType::PathLines ? GeometryKind::PathLines : GeometryKind::Triangles;
}

/// The components of each volume that operators show, ascending. Volumes of which one shows the magnitude, and so
/// perhaps all components, are not among them.
std::map<std::string, std::vector<int>> componentsShown(const State& state) {
  std::map<std::string, std::set<int>> shown;
  std::set<std::string> whole;
  for (const Visualization& v : state.visualizations)
    for (const Vis& op : v.operators) {
      if (op.component)
        shown[op.dataset].insert(*op.component);
      else
        whole.insert(op.dataset);
    }
  std::map<std::string, std::vector<int>> components;
  for (const auto& [name, some] : shown)
    if (!whole.count(name)) components[name] = {some.begin(), some.end()};
  return components;
}

}  // namespace

Visualization LoadedState::visualization(const State& state, size_t v) const {
  const Visualization out = withKeptComponents(state.visualizations[v]);
  ShownSoFar known = shown[v];  // which these data do not widen any more
  return resolved(out, factsFor(out), known);
}

std::vector<DataFacts> LoadedState::factsFor(const Visualization& visualization) const {
  std::vector<DataFacts> found;
  for (const Vis& op : visualization.operators) found.push_back(facts.at(op.dataset));
  return found;
}

Visualization LoadedState::withKeptComponents(Visualization out) const {
  for (Vis& op : out.operators) {
    const auto kept = components.find(op.dataset);
    if (kept == components.end()) continue;
    const auto place = std::find(kept->second.begin(), kept->second.end(), op.component);
    if (place == kept->second.end())
      throw Error("dataset \"" + op.dataset + "\": a component is shown that was not loaded");
    op.component = int(place - kept->second.begin());
  }
  return out;
}

LoadedState loadData(const State& state, const std::string& directory, const RenderOptions& options,
                     Collectives& ranks, Ledger& ledger, std::vector<ShownSoFar> shownSoFar) {
  std::map<std::string, const DatasetSpec*> specs;
  for (const DatasetSpec& d : state.datasets) specs[d.name] = &d;
  std::set<std::string> shown;
  for (const Visualization& v : state.visualizations)
    for (const Vis& op : v.operators) {
      if (!specs.count(op.dataset))
        throw Error("an operator shows dataset \"" + op.dataset + "\", which the state file does not define");
      shown.insert(op.dataset);
    }
  auto pathOf = [&](const DatasetSpec& d) {
    const std::filesystem::path p(d.filename);
    return p.is_absolute() ? p.string() : (std::filesystem::path(directory) / p).string();
  };

  const auto valuesWanted = [](const DatasetSpec& d) {
    ValuesWanted wanted(d.array);
    wanted.radii = d.radiusArray;
    return wanted;
  };

  // What is where, before anything is cut: grids, and geometry as each rank has read it.
  Box domain;
  std::optional<Grid> first;
  std::map<std::string, LoadedGeometry> read;
  LeftOut leftOut;
  for (const DatasetSpec& d : state.datasets) {
    if (!shown.count(d.name)) continue;
    if (d.type == DatasetType::Volume) {
      const Grid grid = gridOf(pathOf(d), d.array, ranks);
      domain.extend(grid.box());
      if (!first) first = grid;
    } else {
      const LoadedGeometry& g =
          read.emplace(d.name, loadGeometry(pathOf(d), kindOf(d.type), valuesWanted(d), ranks)).first->second;
      leftOut += g.leftOut;
      domain.extend(g.geometry.box);
    }
  }

  LoadedState loaded;
  loaded.leftOut = leftOut;
  loaded.partitioning =
      automaticPartitioning(domain, first ? &*first : nullptr, options.partitions, ranks.size());
  loaded.components = componentsShown(state);
  std::map<std::string, std::shared_ptr<const Volume>> volumes;
  for (const DatasetSpec& d : state.datasets)
    if (shown.count(d.name) && d.type == DatasetType::Volume) {
      const auto kept = loaded.components.find(d.name);
      auto volume =
          importVolume(pathOf(d), d.array, *loaded.partitioning, kGhostLayers, ranks,
                       kept == loaded.components.end() ? std::vector<int>() : kept->second, &loaded.leftOut);
      loaded.memory.push_back(ledger.enter(kTenant, "volume", bytesOf(*volume)));
      loaded.facts[d.name] = factsOf(*volume);
      volumes[d.name] = std::move(volume);
    }

  std::map<std::string, std::shared_ptr<const OwnedGeometry>> geometry;
  for (auto& [name, g] : read) {
    geometry[name] =
        std::make_shared<const OwnedGeometry>(ownedGeometry(std::move(g), *loaded.partitioning, ranks));
    loaded.facts[name] = factsOf(*geometry[name]);
  }
  loaded.shown = std::move(shownSoFar);
  loaded.shown.resize(state.visualizations.size());

  // Geometry goes to every partition that it touches with the radii that its Vis gives it, once for each.
  SharedGeometry distributed;
  const EnterMemory enter = [&ledger](const char* purpose, int64_t bytes) {
    return ledger.enter(kTenant, purpose, bytes);
  };
  for (size_t v = 0; v < state.visualizations.size(); v++) {
    const Visualization kept = loaded.withKeptComponents(state.visualizations[v]);
    auto& list = loaded.data.emplace_back();
    for (const Vis& op : resolved(kept, loaded.factsFor(kept), loaded.shown[v]).operators) {
      const DatasetSpec& d = *specs[op.dataset];
      OperatorData& data = list.emplace_back();
      data.color = glm::dvec3(d.color);
      if (d.type == DatasetType::Volume) {
        data.volume = volumes[d.name];
      } else {
        loaded.geometry.push_back(
            distributed.get({d.name, geometry.at(d.name)}, op, *loaded.partitioning, ranks, enter));
        data.geometry = loaded.geometry.back()->geometry;
      }
    }
  }
  return loaded;
}

SceneSource sceneSource(const State& state, const LoadedState& loaded, size_t v, Collectives& ranks) {
  SceneSource source;
  agree(ranks, [&] { source.visualization = loaded.visualization(state, v); });
  source.settings = state.settings;
  source.partitioning = loaded.partitioning;
  for (const OperatorData& data : loaded.data[v]) source.data.push_back({data, {}});
  return source;
}

}  // namespace gxy
