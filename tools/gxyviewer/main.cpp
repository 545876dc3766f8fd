// SPDX-License-Identifier: Apache-2.0
// gxyviewer: shows pictures that a multiserver renders in a window.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <set>

#include "core/annotate/annotations.h"
#include "core/comm/error.h"
#include "core/scene/data_files.h"
#include "core/scene/state_file.h"
#include "multiserver/protocol/json.h"
#include "multiserver/protocol/statement.h"
#include "tools/gxyviewer/file_watch.h"
#include "tools/gxyviewer/options.h"
#include "tools/gxyviewer/png.h"
#include "tools/gxyviewer/series.h"
#include "tools/gxyviewer/viewer_window.h"

using namespace gxy;

namespace {

void warn(const std::string& text) {
  std::cerr << "gxyviewer: warning: " << protocol::printable(text) << '\n';
}

/// Returns the name that the server needs: the absolute path of a file on this machine, or the name itself.
std::string asServerHasIt(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code failed;
  const bool pattern = name.find_first_of("*?%") != std::string::npos;
  return fs::exists(name, failed) || pattern ? fs::absolute(name).string() : name;
}

State withWarnings(StateFile file) {
  for (const std::string& warning : file.warnings) warn(warning);
  return std::move(file.state);
}

/// The state to show and the time steps of its data.
struct Whole {
  State state;
  Series series;
};

/// Returns the names of the datasets on the server.
std::set<std::string> datasetsOf(Client& client) {
  std::set<std::string> names;
  const nlohmann::json list = client.expect("data.list");
  for (const auto& dataset : list.at("datasets")) names.insert(dataset.at("name").get<std::string>());
  return names;
}

/// Asks the server for a first look at data, with their time steps if `inTime`.
Whole firstLookOf(const ViewOptions& options, bool inTime) {
  std::string statement = "viewer.scene";
  for (const std::string& name : options.files) statement += " " + protocol::asWord(asServerHasIt(name));
  nlohmann::json how{{"slice", options.look.slice}, {"array", options.array}};
  if (options.look.autoIsovalue) how["isovalues"] = "auto";
  if (!options.look.isovalues.empty()) how["isovalues"] = options.look.isovalues;
  Client client(options.client);
  client.expect("load data");
  client.expect("load viewer");
  const nlohmann::json look = client.expect(statement + " " + protocol::dump(how));
  Whole whole{withWarnings(readState(protocol::dump(look.at("state")), "scene")), {}};
  if (inTime && look.contains("steps"))
    whole.series = makeSeries(whole.state, stepsFrom(look.at("steps")), datasetsOf(client));
  return whole;
}

/// Whether the first file is a state file. Otherwise all files are data.
bool isStateFile(const ViewOptions& options) {
  const std::string& first = options.files[0];
  return options.files.size() == 1 && first.ends_with(".json") && gxy::isStateFile(first);
}

/// Returns the state to show, with at least one visualization and one camera.
Whole wholeOf(const ViewOptions& options) {
  const std::string& first = options.files[0];
  Whole whole = isStateFile(options) ? Whole{withWarnings(readStateFile(first)), {}}
                                     : firstLookOf(options, options.snapshot.empty());
  State& state = whole.state;
  if (state.visualizations.empty())
    throw Error(first + ": it has no `Visualization`, expected one, with operators");
  if (state.cameras.empty()) state.cameras = {defaultCamera()};
  if (options.size) {
    state.cameras[0].dimensions = *options.size;
    if (state.visualizations[0].view.camera) state.visualizations[0].view.size = *options.size;
  }
  return whole;
}

/// Returns the state with all cameras after fitted(). Waits for the data if a camera has `fit`.
State withFittedCameras(State state, RemoteWindow& remote) {
  std::vector<Camera*> cameras;
  for (Camera& camera : state.cameras) cameras.push_back(&camera);
  for (Visualization& v : state.visualizations)
    if (v.view.camera) cameras.push_back(&*v.view.camera);
  std::erase_if(cameras, [](const Camera* camera) { return !camera->fit; });
  if (!cameras.empty()) remote.waitUntilLoaded();
  for (Camera* camera : cameras) *camera = remote.fittedCamera(*camera);
  return state;
}

int run(const ViewOptions& options) {
  std::optional<FileWatch> stateFile;  // The server watches data.
  if (isStateFile(options)) stateFile.emplace(options.files[0]);
  const Whole whole = wholeOf(options);
  const State state = Selection(whole.state).shown();
  if (options.snapshot.empty()) checkDisplay();
  const auto rays = uint32_t(state.settings.raysPerPixel);
  RemoteWindow remote(options.client, state,
                      options.passes             ? options.passes
                      : options.snapshot.empty() ? std::max(rays, 16u)
                                                 : rays,
                      warn);
  if (options.snapshot.empty()) {
    const std::shared_ptr<void> atTheEnd(nullptr, [&](void*) {
      if (whole.series.count() > 1) remote.drop(whole.state.datasets);  // Nobody else uses them.
    });
    const State seen = withFittedCameras(whole.state, remote);
    remote.setCamera(Selection(seen).camera());
    const auto newer = [&]() -> std::optional<State> {
      if (!stateFile || !stateFile->changed(FileWatch::Clock::now())) return std::nullopt;
      return withFittedCameras(wholeOf(options).state, remote);
    };
    runViewer(remote, Selection(seen), whole.series, options.output, options.annotated, newer);
    return 0;
  }
  remote.waitUntilLoaded();
  remote.renderWhole();
  const Camera seenFrom = state.cameras[0].fit ? remote.fittedCamera(state.cameras[0]) : state.cameras[0];
  writePng(options.snapshot, remote.picture(),
           overlayOf(state.annotations, {state.visualizations[0], remote.shown(), seenFrom, state.settings}));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  ViewOptions options;
  if (const auto code = parseOptions(argc, argv, options)) return *code;
  try {
    return run(options);
  } catch (const std::exception& e) {
    std::cerr << "gxyviewer: error: " << protocol::printable(e.what()) << '\n';
    return 1;
  }
}
