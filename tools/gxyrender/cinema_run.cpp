// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyrender/cinema_run.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/annotate/annotations.h"
#include "core/comm/error.h"
#include "core/image/image.h"
#include "core/image/replace_file.h"
#include "core/render/renderer.h"
#include "core/scene/state_file.h"
#include "core/scene/swept_pictures.h"
#include "tools/gxyrender/cinema_database.h"
#include "tools/gxyrender/load.h"
#include "tools/gxyrender/statistics.h"

namespace gxy {

namespace {

using nlohmann::json;

/// Made by the root, which alone reads the sweep and the files that it names.
json sweptByRoot(const Steps& steps, const RenderOptions& options) {
  const Sweep sweep = readSweepFile(options.sweepFile);
  for (const std::string& w : sweep.warnings) std::cerr << "warning: " << w << '\n';
  if (steps.count() > 1 && !sweep.hasTime())
    throw Error(options.sweepFile + ": it has no axis \"time\", expected one for " +
                std::to_string(steps.count()) + " time steps");
  const SweptPictures swept = sweptPictures(sweep, steps.state, [&](const std::string& text) {
    return readState(text, "state", steps.directory, &standardFilters());
  });
  json all{{"columns", swept.columns}, {"time", swept.time ? json(*swept.time) : json()}};
  for (const SweptScene& scene : swept.scenes) {
    State state{swept.datasets[scene.datasets], scene.settings, {scene.visualization}, {}, scene.annotations, {}};
    all["scenes"].push_back({{"datasets", scene.datasets}, {"state", writeState(state)}});
  }
  State cameras;
  for (const SweptPicture& picture : swept.pictures) {
    cameras.cameras.push_back(picture.camera);
    all["pictures"].push_back({{"scene", picture.scene}, {"parameters", picture.parameters}});
  }
  all["cameras"] = writeState(cameras);
  return all;
}

SweptPictures sweptOnAll(const Steps& steps, const RenderOptions& options, const Place& at) {
  const json all = json::parse(textOfRoot(at.collective, at.root, [&] {
    return sweptByRoot(steps, options).dump(-1, ' ', false, json::error_handler_t::replace);
  }));
  SweptPictures swept;
  all.at("columns").get_to(swept.columns);
  if (!all.at("time").is_null()) swept.time = all.at("time").get<size_t>();
  for (const json& scene : all.at("scenes")) {
    State state =
        readState(scene.at("state").get<std::string>(), options.sweepFile, ".", &standardFilters()).state;
    const size_t index = scene.at("datasets");
    swept.datasets.resize(std::max(swept.datasets.size(), index + 1));
    swept.datasets[index] = std::move(state.datasets);
    swept.scenes.push_back({index, std::move(state.visualizations.at(0)), state.settings, state.annotations});
  }
  const State cameras = readState(all.at("cameras").get<std::string>(), options.sweepFile).state;
  for (const json& picture : all.at("pictures"))
    swept.pictures.push_back({picture.at("scene"), cameras.cameras.at(swept.pictures.size()),
                              picture.at("parameters").get<std::vector<std::string>>()});
  return swept;
}

/// Renders the pictures of one sweep, step by step.
class CinemaRun {
 public:
  CinemaRun(const Steps& steps, const RenderOptions& options, const Place& at)
      : steps_(steps),
        options_(options),
        at_(at),
        swept_(sweptOnAll(steps, options, at)),
        folder_(cinemaFolder(options.prefix)),
        shown_(swept_.datasets.size()) {
    textOfRoot(at.collective, at.root, [&] {
      CinemaTable::Row columns = swept_.columns;
      columns.push_back("FILE");
      if (options.depth) columns.push_back("FILE_depth");
      database_.emplace(folder_, columns);
      for (size_t p = 0; p < swept_.pictures.size(); p++)
        database_->expectFits(swept_.parametersOf(p, timeOf(0)));
      return std::string();
    });
  }

  void run() {
    const double begin = wallSeconds();
    for (size_t step = 0; step < steps_.count(); step++) {
      const std::vector<size_t> missing = missingOf(step);
      agree(at_.ranks, [&] {
        if (!missing.empty())  // all pictures of a step are in one folder
          std::filesystem::create_directories((folder_ / nameOf(missing[0], step)).parent_path());
      });
      for (size_t d = 0; d < swept_.datasets.size(); d++) renderGroup(d, step, missing);
      textOfRoot(at_.collective, at_.root, [&] {
        for (const size_t p : missing) database_->put(rowOf(p, step));
        database_->write();
        return std::string();
      });
      rendered_ += missing.size();
    }
    if (at_.root && !options_.quiet)
      std::cerr << rendered_ << " picture(s), " << folder_.string() << " has " << database_->rows() << ", in "
                << wallSeconds() - begin << " s\n";
  }

 private:
  /// One rank's part in the pictures under way.
  struct SceneOfGroup {
    size_t scene = 0, place = 0;   ///< `place`: among those of the group
    std::vector<size_t> pictures;  ///< that are missing
  };

  std::string timeOf(size_t step) const { return floatCell(steps_.time(step).value_or(double(step))); }
  std::string nameOf(size_t picture, size_t step) const {
    return cinemaFileName(swept_.parametersOf(picture, timeOf(step)), swept_.time);
  }
  CinemaTable::Row rowOf(size_t picture, size_t step) const {
    CinemaTable::Row row = swept_.parametersOf(picture, timeOf(step));
    const std::string name = nameOf(picture, step);
    row.push_back(name + "." + options_.format);
    if (options_.depth) row.push_back(name + "_depth.exr");
    return row;
  }

  /// Collective: the pictures that are to be rendered.
  std::vector<size_t> missingOf(size_t step) const {
    const std::string all = textOfRoot(at_.collective, at_.root, [&] {
      std::string flags;
      for (size_t p = 0; p < swept_.pictures.size(); p++) {
        const bool kept = options_.resume && database_->has(swept_.parametersOf(p, timeOf(step)));
        flags += kept ? '0' : '1';
      }
      return flags;
    });
    std::vector<size_t> missing;
    for (size_t p = 0; p < all.size(); p++)
      if (all[p] == '1') missing.push_back(p);
    return missing;
  }

  /// What shows the same datasets is loaded once. Also where nothing is missing: later steps widen what this one shows.
  void renderGroup(size_t datasets, size_t step, const std::vector<size_t>& missing) {
    State state = swept_.stateOf(datasets);
    steps_.giveFiles(state.datasets, step);
    const LoadedState loaded = loadData(state, steps_.directory, options_, at_.ranks, at_.ledger,
                                        std::move(shown_[datasets]), standardFilters(), at_.services);
    shown_[datasets] = loaded.shown;
    std::vector<SceneOfGroup> scenes;
    for (const size_t s : swept_.scenesOf(datasets)) {
      SceneOfGroup one{s, scenes.size(), {}};
      for (const size_t p : missing)
        if (swept_.pictures[p].scene == s) one.pictures.push_back(p);
      scenes.push_back(std::move(one));
    }
    Renderer::Options rendering{options_.packet, options_.raysInFlight, &at_.ledger, kTenant};
    rendering.runners = rendering.handOuts = at_.transport.threads();
    Renderer renderer(at_.transport, rendering);
    FrameId frames = 0;  // begun so far
    // So many scenes at a time that there is enough to do, and no more.
    for (size_t first = 0, last = 0; first < scenes.size(); first = last) {
      size_t pictures = 0;
      for (; last < scenes.size() &&
             (last == first || (pictures < 4 * size_t(options_.concurrent) && last < first + 16));
           last++)
        pictures += scenes[last].pictures.size();
      renderScenes(std::span(scenes).subspan(first, last - first), state, loaded, step, renderer, frames);
      frames += pictures;
    }
  }

  void renderScenes(std::span<const SceneOfGroup> scenes, State& state, const LoadedState& loaded,
                    size_t step, Renderer& renderer, FrameId before) {
    SceneBuilder builder(at_.backend, at_.transport.rank());
    const EnterMemory enter = [this](const char* purpose, int64_t bytes) {
      return at_.ledger.enter(kTenant, purpose, bytes);
    };
    std::vector<BuiltScene> built;
    std::vector<std::pair<const SceneOfGroup*, size_t>> order;  // of frames: scene and picture
    for (const SceneOfGroup& one : scenes) {
      if (one.pictures.empty()) continue;
      state.settings = swept_.scenes[one.scene].settings;
      const BuiltScene& scene = built.emplace_back(
          builder.build(sceneSource(state, loaded, one.place, at_.ranks), at_.ranks, enter));
      renderer.addScene(one.place, scene.compiled, scene.device);
      for (const size_t p : one.pictures) order.emplace_back(&one, p);
    }
    at_.collective.barrier(kRunKey);
    Frames frames;
    frames.before = before;
    frames.count = order.size();
    frames.concurrent = options_.concurrent;
    frames.request = [&](size_t frame) {
      const auto& [one, picture] = order[frame];
      FrameRequest request;
      request.scene = one->place;
      request.camera = fitted(swept_.pictures[picture].camera, loaded.shown[one->place].box);
      request.depth = options_.depth;
      return request;
    };
    frames.take = [&](size_t frame, const FrameRequest& request, Picture picture) {
      finish(order.at(frame).second, order.at(frame).first->place, request.camera, loaded, step,
             std::move(picture));
    };
    frames.show = [&](size_t done) {
      if (at_.showProgress)
        std::cerr << "\rstep " << step + 1 << " of " << steps_.count() << ": " << done << " of "
                  << frames.count << (done == frames.count ? "\n" : "") << std::flush;
    };
    renderFrames(frames, renderer, at_);
    for (const SceneOfGroup& one : scenes) renderer.removeScene(one.place);
  }

  /// Annotates and writes a picture, on the rank that has it.
  void finish(size_t index, size_t place, const Camera& camera, const LoadedState& loaded, size_t step,
              Picture picture) const {
    const SweptScene& scene = swept_.scenes[swept_.pictures[index].scene];
    const std::string name = (folder_ / nameOf(index, step)).string();
    if (options_.depth)
      replaceFile(name + "_depth.exr", encodeDepth(picture.width, picture.height, picture.depth));
    Image image{picture.width, picture.height, std::move(picture.rgba)};
    if (scene.annotations != Annotations())
      draw(overlayOf(scene.annotations, {scene.visualization, loaded.shown[place], camera, scene.settings,
                                         step, steps_.time(step)}),
           image);
    writeImage(name + "." + options_.format, image);
  }

  const Steps& steps_;
  const RenderOptions& options_;
  const Place& at_;
  const SweptPictures swept_;
  const std::filesystem::path folder_;
  std::vector<std::vector<ShownSoFar>> shown_;  ///< by datasets, then visualization, in all steps so far
  std::optional<CinemaDatabase> database_;      ///< on the root
  size_t rendered_ = 0;
};

}  // namespace

void runCinema(const Steps& steps, const RenderOptions& options, const Place& at) {
  CinemaRun(steps, options, at).run();
}

}  // namespace gxy
