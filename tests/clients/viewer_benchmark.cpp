// SPDX-License-Identifier: Apache-2.0
// viewer_benchmark: gxyviewer's window without the window. Turns the camera about what a state file shows, as a mouse would,
// then lets it rest, and prints one JSON object of what was seen of it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <glm/trigonometric.hpp>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/comm/error.h"
#include "core/scene/state_file.h"
#include "tools/gxyviewer/png.h"
#include "tools/gxyviewer/remote_window.h"

using namespace gxy;
using Clock = RemoteWindow::Clock;

namespace {

struct Options {
  Client::Options client;
  std::string stateFile, picture;
  int width = 1920, height = 1080;
  double seconds = 5;
  int changes = 5;
  uint32_t passes = 1;
};

double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// The camera after a turn about the y axis through what it looks at.
Camera turned(const Camera& camera, double degrees) {
  const double a = glm::radians(degrees), c = std::cos(a), s = std::sin(a);
  const glm::dvec3 center = camera.viewpoint + camera.viewdirection, v = camera.viewdirection;
  Camera out = camera;
  out.viewdirection = {c * v.x + s * v.z, v.y, c * v.z - s * v.x};
  out.viewpoint = center - out.viewdirection;
  return out;
}

void tick(RemoteWindow& window) {
  window.update(Clock::now());
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  if (!window.failure().empty()) throw Error(window.failure());
}

/// Until the picture is whole and at rest.
void rest(RemoteWindow& window) {
  const auto begin = Clock::now();
  do {
    tick(window);
    if (secondsSince(begin) > 600)
      throw Error("the picture is not complete after ten minutes: " + window.status());
  } while (!window.statistics().ended || window.statistics().passes == 0);
}

nlohmann::json measure(const Options& options) {
  State state = readStateFile(options.stateFile).state;
  state.visualizations.resize(1);
  state.cameras.resize(1);
  state.cameras[0].dimensions = {options.width, options.height};
  RemoteWindow window(options.client, state, options.passes);
  window.waitUntilLoaded();
  rest(window);

  // Moving: 30 degrees a second. The first second is for finding its pace.
  Camera camera = state.cameras[0];
  std::vector<double> first, bytes, intervals;
  const auto begin = Clock::now();
  auto lastShown = begin;
  uint64_t frames = window.statistics().frames;
  while (secondsSince(begin) < options.seconds + 1) {
    camera = turned(state.cameras[0], 30 * secondsSince(begin));
    window.setCamera(camera);
    tick(window);
    const RemoteWindow::Statistics now = window.statistics();
    if (now.frames == frames) continue;
    frames = now.frames;
    if (secondsSince(begin) > 1) {
      first.push_back(now.firstPixels);
      bytes.push_back(double(now.passBytes));
      intervals.push_back(secondsSince(lastShown));
    }
    lastShown = Clock::now();
  }
  const Detail detail = window.statistics().detail;
  rest(window);

  // Single changes of a camera that rests.
  std::vector<double> toFirst, toComplete;
  for (int i = 1; i <= options.changes; i++) {
    frames = window.statistics().frames;
    const auto changed = Clock::now();
    window.setCamera(turned(camera, 7 * i));
    while (window.statistics().frames == frames) tick(window);
    toFirst.push_back(secondsSince(changed));
    rest(window);
    toComplete.push_back(secondsSince(changed));
  }
  if (!options.picture.empty()) {
    window.setCamera(state.cameras[0]);
    while (window.statistics().ended) tick(window);
    rest(window);
    writePng(options.picture, window.picture());
  }
  return {{"frames", first.size()},
          {"frames per second", double(first.size()) / options.seconds},
          {"longest interval", intervals.empty() ? 0 : *std::max_element(intervals.begin(), intervals.end())},
          {"latency", median(first)},
          {"bytes per frame", median(bytes)},
          {"most bytes of a frame", bytes.empty() ? 0 : *std::max_element(bytes.begin(), bytes.end())},
          {"scale", detail.scale},
          {"quality", detail.quality},
          {"first pixels", median(toFirst)},
          {"complete", median(toComplete)}};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("What a user of gxyviewer sees of a server: frames a second, and how long pictures take.",
               "viewer_benchmark");
  Options o;
  o.client.name = "viewer_benchmark";
  app.add_option("state", o.stateFile, "STATE.json")->required();
  app.add_option("-P,--port", o.client.port, "the server's port")->capture_default_str();
  app.add_option("--token-file", o.client.tokenFile, "the server's token");
  app.add_option("--width", o.width, "of the window")->capture_default_str();
  app.add_option("--height", o.height, "of the window")->capture_default_str();
  app.add_option("--seconds", o.seconds, "for which the camera moves, after one more")->capture_default_str();
  app.add_option("--changes", o.changes, "single changes of the camera")->capture_default_str();
  app.add_option("--passes", o.passes, "of a picture at rest")->capture_default_str();
  app.add_option("--picture", o.picture,
                 "F.png: the picture of the state file's camera, at rest, at the end");
  CLI11_PARSE(app, argc, argv);
  try {
    std::cout << measure(o).dump() << std::endl;
    return 0;
  } catch (const std::exception& e) {
    std::cerr << "viewer_benchmark: error: " << e.what() << '\n';
    return 1;
  }
}
