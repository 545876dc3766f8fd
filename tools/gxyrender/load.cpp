// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyrender/load.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include "core/comm/error.h"
#include "core/data/geometry_bytes.h"
#include "core/io/automatic_partitioning.h"
#include "core/io/import_geometry.h"
#include "core/io/import_mesh.h"
#include "core/io/import_volume.h"
#include "core/rays/compiled_mesh.h"
#include "core/scene/dataset_type.h"

namespace gxy {

namespace {

/// The components of each volume that operators show, ascending. Volumes of which one shows the magnitude, and so
/// perhaps all components, are not among them.
std::map<std::string, std::vector<int>> componentsShown(const State& state) {
  std::map<std::string, std::set<int>> shown;
  std::set<std::string> whole;
  for (const Visualization& v : state.visualizations)
    for (const Vis& op : v.operators) {
      if (op.type != VisType::Volume) continue;
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

namespace {

/// Loads the data of one state, step by step, on all ranks together.
class Loader {
 public:
  Loader(const State& state, std::string directory, Collectives& ranks, Ledger& ledger)
      : state_(state), directory_(std::move(directory)), ranks_(ranks), ledger_(ledger) {
    for (const DatasetSpec& d : state.datasets) specs_[d.name] = &d;
    need();
  }

  /// Finds out what is where, before anything is cut: reads grids, and geometry as each rank gets it.
  void open(LeftOut& leftOut) {
    findMeshes();
    for (const DatasetSpec& d : state_.datasets) {
      if (!isRead(d)) continue;
      if (isMesh(d)) {
        const LoadedMesh& m = meshes_[d.name] = loadMesh(pathOf(d), d.array, ranks_);
        leftOut += m.leftOut;
        domain_.extend(m.box);
      } else if (d.type == DatasetType::Volume) {
        const Grid grid = gridOf(pathOf(d), d.array, ranks_);
        domain_.extend(grid.box());
        if (!first_) first_ = grid;
      } else {
        ValuesWanted wanted(d.array);
        wanted.radii = d.radiusArray;
        wanted.fields = d.fields;
        const LoadedGeometry& g =
            read_.emplace(d.name, loadGeometry(pathOf(d), *geometryKindOf(d.type), wanted, ranks_))
                .first->second;
        leftOut += g.leftOut;
        domain_.extend(g.geometry.box);
      }
    }
  }

  void cut(const std::array<int, 3>& partitions) {
    partitioning_ = automaticPartitioning(domain_, first_ ? &*first_ : nullptr, partitions, ranks_.size());
  }

  /// Reads volumes, of those that only operators show only the components that these show.
  void readVolumes(const std::map<std::string, std::vector<int>>& components, LeftOut& leftOut) {
    for (const DatasetSpec& d : state_.datasets)
      if (isRead(d) && d.type == DatasetType::Volume && !isMesh(d)) {
        const auto kept = components.find(d.name);
        const auto dataset = newDataset(d);
        dataset->volume =
            importVolume(pathOf(d), d.array, *partitioning_, kGhostLayers, ranks_,
                         kept == components.end() ? std::vector<int>() : kept->second, &leftOut);
        dataset->memory = ledger_.enter(kTenant, "volume", bytesOf(*dataset->volume));
        datasets_[d.name] = dataset;
      }
  }

  bool isMesh(const DatasetSpec& d) const { return meshes_.count(d.name) > 0; }

  void distributeMeshes() {
    for (auto& [name, m] : meshes_) {
      const auto dataset = newDataset(*specs_.at(name));
      dataset->mesh = meshOf(std::move(m), *partitioning_, ranks_);
      dataset->memory = ledger_.enter(kTenant, "volume", bytesOf(*dataset->mesh));
      datasets_[name] = dataset;
    }
  }

  void keepGeometry() {
    for (auto& [name, g] : read_) {
      const auto dataset = newDataset(*specs_.at(name));
      dataset->geometry =
          std::make_shared<const OwnedGeometry>(ownedGeometry(std::move(g), *partitioning_, ranks_));
      dataset->memory = ledger_.enter(kTenant, "geometry", bytesOf(dataset->geometry->block));
      datasets_[name] = dataset;
    }
  }

  /// Evaluates filters, each after those of its inputs.
  void makeOthers(const Filters& filters, const FilterServices& given) {
    FilterServices services = given;
    if (!services.takeMemory)
      services.takeMemory = [this](const std::string& purpose, int64_t bytes) {
        return ledger_.enter(kTenant, purpose, bytes);
      };
    for (const size_t i : evaluationOrder(state_.datasets)) {
      const DatasetSpec& d = state_.datasets[i];
      if (!needed_.count(d.name)) continue;
      FilterRun::Inputs inputs;
      for (const FilterInput& input : d.inputs)
        for (const std::string& name : input.datasets)
          inputs[input.input].push_back({name, Key{keys_.at(name)}, 1, datasets_.at(name)});
      FilterRun run(ranks_, std::move(inputs), services);
      try {
        datasets_[d.name] = evaluate(*filters.get(d.filter), run, d.properties).dataset;
        agree(ranks_, [&] {
          if (!datasets_[d.name])
            throw Error("filter " + d.filter + " makes no dataset, which is needed here");
        });
      } catch (const Error& e) {
        throw Error("dataset \"" + d.name + "\": " + e.what());
      }
      keys_.emplace(d.name, keys_.size() + 1);
    }
  }

  const Dataset& dataset(const std::string& name) const { return *datasets_.at(name); }
  std::shared_ptr<const Dataset> sharedDataset(const std::string& name) const { return datasets_.at(name); }
  const std::set<std::string>& needed() const { return needed_; }
  /// Whether a filter reads it, or a file is made of it, and so perhaps all its components are needed.
  bool isInput(const std::string& name) const { return inputs_.count(name) > 0; }
  const DatasetSpec& spec(const std::string& name) const { return *specs_.at(name); }
  const std::shared_ptr<const Partitioning>& partitioning() const { return partitioning_; }

 private:
  bool isRead(const DatasetSpec& d) const { return needed_.count(d.name) && d.filter.empty(); }
  std::string pathOf(const DatasetSpec& d) const {
    const std::filesystem::path p(d.filename);
    return p.is_absolute() ? p.string() : (std::filesystem::path(directory_) / p).string();
  }

  /// Finds out which volumes to be read are unstructured. What rank 0 finds counts.
  void findMeshes() {
    std::vector<uint8_t> found(state_.datasets.size(), 0);
    agree(ranks_, [&] {
      for (size_t i = 0; i < found.size(); i++) {
        const DatasetSpec& d = state_.datasets[i];
        found[i] = isRead(d) && d.type == DatasetType::Volume && isMeshFile(pathOf(d));
      }
    });
    found = gatherValues(ranks_, std::span<const uint8_t>(found)).at(0);
    for (size_t i = 0; i < found.size(); i++)
      if (found[i]) meshes_[state_.datasets[i].name];
  }

  /// Collects what operators show, what becomes files, and what these are made of.
  void need() {
    std::vector<std::string> wanted;
    for (const Visualization& v : state_.visualizations)
      for (const Vis& op : v.operators) {
        if (!specs_.count(op.dataset))
          throw Error("an operator shows dataset \"" + op.dataset +
                      "\", which the state file does not define");
        wanted.push_back(op.dataset);
      }
    for (const OutputSpec& output : state_.outputs) {
      if (output.type != OutputSpec::Type::DataFile) continue;
      if (!specs_.count(output.of))
        throw Error("output \"" + output.name + "\" is of dataset \"" + output.of +
                    "\", which the state file does not define");
      inputs_.insert(output.of);
      wanted.push_back(output.of);
    }
    while (!wanted.empty()) {
      const std::string name = std::move(wanted.back());
      wanted.pop_back();
      if (!needed_.insert(name).second) continue;
      const DatasetSpec& d = *specs_.at(name);
      if (d.isLive())
        throw Error("dataset \"" + name +
                    "\": its entry has neither `filename` nor `filter`; expected `--dataset " + name +
                    "=FILE` on the command line");
      for (const FilterInput& input : d.inputs)
        for (const std::string& other : input.datasets) {
          if (!specs_.count(other))
            throw Error("dataset \"" + name + "\": input `" + input.input + "` is dataset \"" + other +
                        "\", which the state file does not define");
          inputs_.insert(other);
          wanted.push_back(other);
        }
    }
  }

  std::shared_ptr<Dataset> newDataset(const DatasetSpec& d) {
    const auto dataset = std::make_shared<Dataset>();
    dataset->file = pathOf(d);
    dataset->array = d.array;
    dataset->partitioning = partitioning_;
    const uint64_t key = keys_.emplace(d.name, keys_.size() + 1).first->second;
    dataset->origins = {{key, 1}};
    return dataset;
  }

  const State& state_;
  const std::string directory_;
  Collectives& ranks_;
  Ledger& ledger_;
  std::map<std::string, const DatasetSpec*> specs_;
  std::set<std::string> needed_, inputs_;
  Box domain_;
  std::optional<Grid> first_;
  std::map<std::string, LoadedGeometry> read_;
  std::map<std::string, LoadedMesh> meshes_;  ///< what has been read of unstructured volumes
  std::shared_ptr<const Partitioning> partitioning_;
  std::map<std::string, uint64_t> keys_;  ///< of objects, as a server would have them
  std::map<std::string, std::shared_ptr<const Dataset>> datasets_;
};

}  // namespace

LoadedState loadData(const State& state, const std::string& directory, const RenderOptions& options,
                     Collectives& ranks, Ledger& ledger, std::vector<ShownSoFar> shownSoFar,
                     const Filters& filters, const FilterServices& services) {
  Loader loader(state, directory, ranks, ledger);
  LoadedState loaded;
  loader.open(loaded.leftOut);
  loader.cut(options.partitions);
  loaded.partitioning = loader.partitioning();
  loaded.components = componentsShown(state);
  std::erase_if(loaded.components, [&](const auto& kept) {
    const DatasetSpec& d = loader.spec(kept.first);
    return loader.isInput(kept.first) || !d.filter.empty() || loader.isMesh(d);
  });
  loader.readVolumes(loaded.components, loaded.leftOut);
  loader.distributeMeshes();
  loader.keepGeometry();
  loader.makeOthers(filters, services);
  for (const std::string& name : loader.needed()) {
    const Dataset& d = loader.dataset(name);
    loaded.facts[name] = factsOf(d);
    loaded.datasets[name] = loader.sharedDataset(name);
  }
  loaded.shown = std::move(shownSoFar);
  loaded.shown.resize(state.visualizations.size());

  // Geometry is compiled in every partition that it touches with the radii that its Vis gives it, once for each.
  SharedGeometry distributed;
  std::vector<LedgerEntry> compiled;
  const EnterMemory enter = [&ledger](const char* purpose, int64_t bytes) {
    return ledger.enter(kTenant, purpose, bytes);
  };
  std::set<std::string> told;
  for (size_t v = 0; v < state.visualizations.size(); v++) {
    const Visualization kept = loaded.withKeptComponents(state.visualizations[v]);
    auto& list = loaded.data.emplace_back();
    for (const Vis& op : resolved(kept, loaded.factsFor(kept), loaded.shown[v]).operators) {
      const Dataset& d = loader.dataset(op.dataset);
      OperatorData& data = list.emplace_back();
      data.color = glm::dvec3(loader.spec(op.dataset).color);
      if (d.volume) {
        data.volume = d.volume;
      } else if (d.mesh) {
        data.mesh = d.mesh;
        const auto warning = warningOf(op, *d.mesh);
        if (warning && ranks.rank() == 0 && told.insert(*warning).second) spdlog::warn("{}", *warning);
      } else {
        loaded.geometry.push_back(
            distributed.get({op.dataset, d.geometry}, op, *loaded.partitioning, ranks, enter, compiled));
        data.geometry = loaded.geometry.back()->geometry;
        data.primitives = loaded.geometry.back()->primitives;
        data.owned = d.geometry;
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
