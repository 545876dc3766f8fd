// SPDX-License-Identifier: Apache-2.0
// gxyviewer: a window on what a multiserver renders.
#include <algorithm>
#include <iostream>

#include "file_watch.h"
#include "gxy/comm/error.h"
#include "gxy/protocol/json.h"
#include "gxy/scene/state_file.h"
#include "options.h"
#include "png.h"
#include "viewer_window.h"

using namespace gxy;

namespace {

void warn(const std::string& text) {
  std::cerr << "gxyviewer: warning: " << protocol::printable(text) << '\n';
}

/// What the state file says, with a visualization and a camera at least.
State stateOf(const ViewOptions& options) {
  StateFile file = readStateFile(options.stateFile);
  for (const std::string& warning : file.warnings) warn(warning);
  if (file.state.visualizations.empty())
    throw Error(options.stateFile + ": it has no `Visualization`, expected one, with operators");
  if (file.state.cameras.empty()) file.state.cameras.resize(1);
  if (options.size) file.state.cameras[0].dimensions = *options.size;
  return std::move(file.state);
}

int run(const ViewOptions& options) {
  FileWatch file(options.stateFile);
  const Selection selection(stateOf(options));
  const State state = selection.shown();
  if (options.snapshot.empty()) checkDisplay();
  const auto rays = uint32_t(state.settings.raysPerPixel);
  RemoteWindow remote(options.client, state,
                      options.passes             ? options.passes
                      : options.snapshot.empty() ? std::max(rays, 16u)
                                                 : rays,
                      warn);
  if (options.snapshot.empty()) {
    runViewer(remote, selection, options.output, [&]() -> std::optional<State> {
      if (!file.changed(FileWatch::Clock::now())) return std::nullopt;
      return stateOf(options);
    });
    return 0;
  }
  remote.waitUntilLoaded();
  remote.renderWhole();
  writePng(options.snapshot, remote.picture());
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
