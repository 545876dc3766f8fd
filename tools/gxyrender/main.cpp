// SPDX-License-Identifier: Apache-2.0
// gxyrender: the batch renderer.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <iostream>
#include <optional>

#include "backends/registry/backends.h"
#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/comm/mpi_environment.h"
#include "core/comm/mpi_transport.h"
#include "core/io/write_dataset.h"
#include "core/look/file_facts.h"
#include "core/render/renderer.h"
#include "core/scene/data_files.h"
#include "core/scene/dataset_type.h"
#include "core/scene/state_file.h"
#include "tools/gxyrender/cinema_run.h"
#include "tools/gxyrender/filter_place.h"
#include "tools/gxyrender/load.h"
#include "tools/gxyrender/options.h"
#include "tools/gxyrender/pictures.h"
#include "tools/gxyrender/reference_run.h"
#include "tools/gxyrender/run.h"
#include "tools/gxyrender/statistics.h"

using namespace gxy;

namespace {

Bytes toBytes(const std::string& s) {
  const auto* p = reinterpret_cast<const std::byte*>(s.data());
  return Bytes(p, p + s.size());
}
std::string toString(const Bytes& b) {
  return std::string(reinterpret_cast<const char*>(b.data()), b.size());
}

// Gives datasets the files that the command line says.
void giveFiles(State& state, const std::map<std::string, std::string>& files) {
  for (const auto& [name, file] : files) {
    const auto d =
        std::find_if(state.datasets.begin(), state.datasets.end(),
                     [&, wanted = name](const DatasetSpec& dataset) { return dataset.name == wanted; });
    if (d == state.datasets.end())
      throw Error("--dataset " + name + "=" + file + ": the state file has no dataset \"" + name + "\"");
    d->filename = std::filesystem::absolute(file).string();
    d->filter.clear();
    d->inputs.clear();
    d->properties.clear();
  }
}

State readStateAlone(const std::string& path, const RenderOptions& options) {
  StateFile file = readStateFile(path, &standardFilters());
  giveFiles(file.state, options.datasets);
  const bool onlyPictures = options.reference || !options.sweepFile.empty();
  if (onlyPictures && !file.state.outputs.empty()) {
    std::cerr << "warning: " << path
              << ": `Outputs` are left out: " << (options.reference ? "--reference" : "--cinema")
              << " makes pictures only\n";
    file.state.outputs.clear();
  }
  for (const std::string& w : file.warnings) std::cerr << "warning: " << w << '\n';
  const auto isFile = [](const OutputSpec& o) { return o.type == OutputSpec::Type::DataFile; };
  for (const OutputSpec& o : file.state.outputs)
    if (!isFile(o))
      std::cerr << "warning: " << path << ": output \"" << o.name << "\" is left out: " << nameOf(o.type)
                << " is what graphs of a server make\n";
  std::erase_if(file.state.outputs, [&](const OutputSpec& o) { return !isFile(o); });
  if (file.state.visualizations.empty() && file.state.outputs.empty())
    throw Error(path + ": there is no visualization to render, and no output of type Data file");
  if (file.state.cameras.empty()) file.state.cameras = {defaultCamera()};
  return std::move(file.state);
}

nlohmann::json readAlone(const RenderOptions& options) {
  const std::string& first = options.files.at(0);
  if (options.files.size() == 1 && filesOf(first).size() == 1 && isStateFile(first)) {
    if (options.looks)
      throw Error(first + ": this is a state file, and --iso, --slice and --array are for data files");
    return {{"state", writeState(readStateAlone(first, options))},
            {"directory", std::filesystem::absolute(first).parent_path().string()}};
  }
  if (!options.datasets.empty())
    throw Error("--dataset " + options.datasets.begin()->first + "=" + options.datasets.begin()->second +
                ": this is for datasets of a state file, and there is none");
  const std::vector<TimeStep> series = stepsOf(options.files);
  for (const std::string& file : series[0].files)
    if (isStateFile(file))
      throw Error(file + ": this is a state file, expected it alone, or data files only");
  nlohmann::json steps;
  for (const TimeStep& step : series)
    steps.push_back({{"files", step.files}, {"time", step.time ? nlohmann::json(*step.time) : nullptr}});
  return {
      {"state", writeState(firstLook(factsOfFiles(series[0].files, options.array, options.look.looksInside()),
                                     options.look))},
      {"steps", steps},
      {"directory", std::filesystem::current_path().string()}};
}

// Read by rank 0, with its map and camera files; the same on all ranks.
Steps readOnAll(const RenderOptions& options, Collective& collective, bool root) {
  const auto read = nlohmann::json::parse(textOfRoot(collective, root, [&] {
    return readAlone(options).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  }));
  Steps steps{
      readState(read.at("state").get<std::string>(), options.files.at(0), ".", &standardFilters()).state,
      {},
      read.at("directory")};
  for (const auto& step : read.value("steps", nlohmann::json::array())) {
    TimeStep& to = steps.series.emplace_back();
    step.at("files").get_to(to.files);
    if (!step.at("time").is_null()) to.time = step.at("time").get<double>();
  }
  options.apply(steps.state);
  if (options.annotate && steps.count() > 1 && steps.state.annotations.text.empty())
    steps.state.annotations.text = steps.time(0) ? "step {step}, time {time}" : "step {step}";
  return steps;
}

// Returns the processor time of writing pictures.
double renderAll(const State& state, const LoadedState& loaded, const RenderOptions& options,
                 Renderer& renderer, const Place& at) {
  std::atomic<double> cpuPictures = 0;
  const std::vector<StatePicture> pictures = picturesOf(state);
  Frames frames;
  frames.count = pictures.size();
  frames.concurrent = options.concurrent;
  frames.request = [&](size_t frame) {
    FrameRequest request;
    request.scene = pictures[frame].visualization;
    request.camera = loaded.camera(pictures[frame]);
    request.depth = options.depth;
    return request;
  };
  frames.take = [&](size_t frame, const FrameRequest&, Picture picture) {
    const double cpu = threadCpuSeconds();
    annotate(picture, state, loaded, options, frame);
    writePicture(pictureName(state, options, frame), options, std::move(picture));
    cpuPictures += threadCpuSeconds() - cpu;
  };
  frames.show = [&](size_t done) {
    if (at.showProgress)
      std::cerr << "\rrendered " << done << " of " << frames.count << (done == frames.count ? "\n" : "")
                << std::flush;
  };
  renderFrames(frames, renderer, at);
  return cpuPictures;
}

// Writes the datasets that the state's outputs name. Files replace others of their names once they are complete.
void writeOutputs(const State& state, const LoadedState& loaded, const Place& at) {
  for (const OutputSpec& output : state.outputs) {
    const Dataset& dataset = *loaded.datasets.at(output.of);
    std::filesystem::path path = fileOfStep(output.to, newestStep(dataset)), partial = path;
    partial.replace_filename(path.stem().string() + ".partial" + path.extension().string());
    agree(at.ranks, [&] { checkFileFor(dataset, path.string(), "dataset \"" + output.of + "\""); });
    const LedgerEntry memory = at.ledger.enter(kTenant, "export", gatheringBytes(dataset, at.root));
    try {
      writeDataset(dataset, at.ranks, partial.string());
    } catch (const Error&) {
      if (at.root) std::filesystem::remove(partial);
      throw;
    }
    agree(at.ranks, [&] {
      if (at.root) std::filesystem::rename(partial, path);
    });
    if (at.showProgress) std::cerr << "wrote " << path.string() << '\n';
  }
}

// Renders all pictures of one step. Returns what its visualizations have shown.
std::vector<ShownSoFar> renderStep(const State& state, const std::string& directory,
                                   const RenderOptions& options, const Place& at,
                                   std::vector<ShownSoFar> shown) {
  Phases phases;
  const double begin = wallSeconds();
  const int64_t residentBefore = processBytes().resident;
  const LoadedState loaded = loadData(state, directory, options, at.ranks, at.ledger, std::move(shown),
                                      standardFilters(), at.services);
  phases.load = wallSeconds() - begin;
  writeOutputs(state, loaded, at);

  Renderer::Options rendering{options.packet, options.raysInFlight, &at.ledger, kTenant};
  rendering.runners = rendering.handOuts = at.transport.threads();
  Renderer renderer(at.transport, rendering);
  SceneBuilder builder(at.backend, at.transport.rank());
  const EnterMemory enter = [&at](const char* purpose, int64_t bytes) {
    return at.ledger.enter(kTenant, purpose, bytes);
  };
  std::vector<BuiltScene> scenes;
  LeftBefore before{loaded.leftOut};
  for (size_t v = 0; v < state.visualizations.size(); v++) {
    const double since = wallSeconds();
    const BuiltScene& scene =
        scenes.emplace_back(builder.build(sceneSource(state, loaded, v, at.ranks), at.ranks, enter));
    before.isoCells += scene.compiled->isoCellsSkipped;
    renderer.addScene(v, scene.compiled, scene.device);
    phases.compileEach.push_back(wallSeconds() - since);
  }
  at.collective.barrier(kRunKey);
  phases.compile = wallSeconds() - begin - phases.load;

  const double start = wallSeconds(), cpu = cpuSeconds();
  phases.cpuPictures = renderAll(state, loaded, options, renderer, at);
  phases.render = wallSeconds() - start;
  phases.cpuRender = cpuSeconds() - cpu;
  phases.total = wallSeconds() - begin;
  if (!options.statsFile.empty()) {
    auto mine =
        statisticsOf(renderer.counters(), at.transport.counters(), phases, before, at.ledger, residentBefore);
    mine["messages"].update(trafficOf(at.transport.traffic(), at.transport.partners()));
    std::vector<Bytes> toRoot(size_t(at.transport.size()));
    toRoot[0] = toBytes(mine.dump());
    std::vector<nlohmann::json> all;
    for (const Bytes& b : at.ranks.allToAll(std::move(toRoot)))
      if (at.root) all.push_back(nlohmann::json::parse(toString(b)));
    agree(at.ranks, [&] {
      if (at.root)
        writeStatistics(options.statsFile,
                        {{"backend", at.backend.name()},
                         {"device", at.backend.device()},
                         {"ranks", at.transport.size()},
                         {"threads per rank", at.transport.threads()},
                         {"partitions", loaded.partitioning->partitions()},
                         {"pictures", picturesOf(state).size()},
                         {"tolerance", state.settings.tolerance},
                         {"step", state.settings.step}},
                        all);
    });
  }
  return loaded.shown;
}

int run(const RenderOptions& options) {
  MpiTransport::Options transportOptions;
  transportOptions.threads = options.threads;
  transportOptions.role = hasDevices(options.backend);  // those that do share them
  MpiTransport transport(transportOptions);
  const bool root = transport.rank() == 0;
  const bool showProgress = root && !options.quiet && isatty(STDERR_FILENO);
  int code = 0;
  {
    Collective collective(transport);
    RankCollectives ranks(collective, transport.rank(), transport.size(), kRunKey);
    try {
      const double begin = wallSeconds();
      const Steps steps = readOnAll(options, collective, root);
      const State& state = steps.state;
      for (const StatePicture& picture : picturesOf(state)) validate(picture.camera);
      Ledger ledger;
      const BackendRegistry registry = allBackends({options.device, transport.rankOnNode()});
      std::unique_ptr<Backend> backend;
      if (!options.reference) agree(ranks, [&] { backend = registry.make(options.backend, &ledger); });
      std::optional<FilterPlace> filterPlace;
      if (backend) filterPlace.emplace(transport, transport.threads(), registry, *backend, ledger);
      if (!options.sweepFile.empty()) {
        runCinema(
            steps, options,
            {transport, collective, ranks, ledger, *backend, filterPlace->services(), root, showProgress});
        return 0;
      }
      std::vector<ShownSoFar> shown;
      RenderOptions numbered = options;
      for (size_t step = 0; step < steps.count(); step++) {
        numbered.time = steps.time(step);
        if (options.reference)
          agree(ranks, [&] {
            if (root)
              shown = renderWithReference(steps.at(step), steps.directory, numbered, showProgress, shown);
          });
        else
          shown = renderStep(
              steps.at(step), steps.directory, numbered,
              {transport, collective, ranks, ledger, *backend, filterPlace->services(), root, showProgress},
              std::move(shown));
        numbered.firstPicture += picturesOf(state).size();
      }
      if (root && !options.quiet && !state.visualizations.empty())
        std::cerr << numbered.firstPicture << " picture(s) " << pictureName(state, options, 0) << "."
                  << options.format << " ... in " << wallSeconds() - begin << " s\n";
    } catch (const std::exception& e) {
      if (root) std::cerr << "gxyrender: error: " << textOf(e) << '\n';
      code = 1;
    }
  }
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  RenderOptions options;
  spdlog::set_default_logger(spdlog::stderr_color_mt("gxyrender"));
  try {
    const char* rank = std::getenv("OMPI_COMM_WORLD_RANK");  // who speaks, before there is a transport
    if (!rank) rank = std::getenv("PMI_RANK");
    if (const auto code = parseOptions(argc, argv, !rank || std::string(rank) == "0", options)) return *code;
    MpiEnvironment mpi;
    return run(options);
  } catch (const std::exception& e) {
    std::cerr << "gxyrender: error: " << textOf(e) << '\n';
    return 1;
  }
}
