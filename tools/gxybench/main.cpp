// SPDX-License-Identifier: Apache-2.0
// gxybench: run time against error.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "backends/registry/backends.h"
#include "core/comm/error.h"
#include "tools/gxybench/compare.h"
#include "tools/gxybench/options.h"
#include "tools/gxybench/page.h"
#include "tools/gxybench/truth.h"
#include "tools/gxybench/worker.h"

namespace {

using namespace gxy;
using namespace gxy::bench;

int list(bool quick) {
  for (const Scene& s : fixedScenes(quick)) std::printf("%-34s %s\n", s.name.c_str(), s.about.c_str());
  return 0;
}

int compare(const Options& o) {
  CurveAxes axes;
  axes.wall = o.wall;
  axes.error = o.error == "max" ? &Row::maxError : o.error == "p999" ? &Row::p999Error : &Row::rmsError;
  const std::vector<Change> all = changes(readTable(o.older), readTable(o.newer), axes);
  std::cout << report(all);
  const bool worse = std::any_of(all.begin(), all.end(), [](const Change& c) { return c.regressed(); });
  return o.fail && worse ? 1 : 0;
}

std::vector<Scene> chosenScenes(const Options& o) {
  std::vector<Scene> fixed = fixedScenes(o.quick), chosen;
  if (o.scenes.empty()) return fixed;
  for (const std::string& name : o.scenes) {
    const auto found =
        std::find_if(fixed.begin(), fixed.end(), [&](const Scene& s) { return s.name == name; });
    if (found != fixed.end()) {
      chosen.push_back(*found);
    } else if (std::filesystem::exists(name)) {
      const auto warn = [](const std::string& w) { std::cerr << "warning: " << w << '\n'; };
      for (Scene& s : scenesOf(name, warn)) chosen.push_back(std::move(s));
    } else {
      throw Error(name + ": expected a state file or one of the scenes that --list shows");
    }
  }
  for (size_t i = 0; i < chosen.size(); i++)
    for (size_t k = i + 1; k < chosen.size(); k++)
      if (chosen[i].name == chosen[k].name)
        throw Error("two scenes are called " + chosen[i].name + "; expected different names");
  return chosen;
}

/// Writes progress to standard error: on a terminal the present step is overwritten in place, and each
/// finished step gets a line.
class Speaker {
 public:
  explicit Speaker(bool quiet) : quiet_(quiet), terminal_(!quiet && ::isatty(STDERR_FILENO) == 1) {}
  void meanwhile(const std::string& what) const {
    if (terminal_) std::fprintf(stderr, "\r\033[K%s", what.c_str());
  }
  void done(const std::string& what) const {
    if (!quiet_) std::fprintf(stderr, "%s%s\n", terminal_ ? "\r\033[K" : "", what.c_str());
  }

 private:
  bool quiet_, terminal_;
};

std::string summary(const Row& r) {
  char text[200];
  std::snprintf(text, sizeof text, "  %-34s %-7s %9.1f ms, CPU %9.1f ms; error %.2e, RMS %.2e, %lld flips",
                r.curve().c_str(), r.setting.c_str(), 1e3 * r.wall, 1e3 * r.cpu, r.maxError, r.rmsError,
                static_cast<long long>(r.flips));
  std::string out = text;
  if (r.hits >= 0)
    out +=
        ", wrong hits " + std::to_string(r.missed + r.extra + r.wrongSheet) + " of " + std::to_string(r.hits);
  return out;
}

/// The folder for pictures on their way from the workers. It is removed with the object; what an interrupted
/// run has left in it is removed by the next run.
class Scratch {
 public:
  explicit Scratch(const std::string& parent) : path_(std::filesystem::absolute(parent) / ".working") {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Scratch() {
    std::error_code none;
    std::filesystem::remove_all(path_, none);
  }
  std::string prefix() const { return path_.string() + "/"; }

 private:
  std::filesystem::path path_;
};

void measureScene(const Options& o, Scene& scene, const Scratch& scratch, const Speaker& speaker,
                  const std::function<void(const Row&)>& add) {
  const std::vector<Setting> settings = settingsOf(scene, o.ladders);
  if (settings.empty()) return;
  makeData(scene, o.cache + "/data");
  speaker.done(scene.name);
  speaker.meanwhile("  reference");
  const Truth truth = truthOf(scene.state, scene.directory, o.cache, [&](double f) {
    speaker.meanwhile("  reference " + std::to_string(int(100 * f)) + " %");
  });
  for (const std::string& backend : o.backends)
    for (int ranks : o.ranks) {
      Job job;
      job.directory = scene.directory;
      job.backend = backend;
      if (hasDevices(backend)) job.device = o.device;
      job.repeats = o.repeats;
      job.seconds = o.quick ? 0 : 0.5;
      job.threads = o.threads;
      job.pictures = scratch.prefix();
      job.settings = settings;
      measure(job, ranks, ranks > 1 ? o.launcher : "", [&](size_t, Row row, const Picture& picture) {
        row.scene = scene.name;
        compareWith(truth, picture, scene.isosurfacesAlone(), row);
        speaker.done(summary(row));
        add(row);
      });
    }
}

int measureAll(const Options& o, const std::string& command) {
  std::vector<Scene> scenes = chosenScenes(o);
  if (!o.device.empty() && std::none_of(o.backends.begin(), o.backends.end(), hasDevices))
    throw Error("--device " + o.device + ": none of the backends has devices to choose from");
  if (o.size)
    for (Scene& s : scenes) s.state.cameras[0].dimensions = {(*o.size)[0], (*o.size)[1]};
  std::filesystem::create_directories(o.out);
  const Scratch scratch(o.out);
  const Speaker speaker(o.quiet);
  TableWriter table(o.out + "/results.csv");
  std::vector<Row> rows;
  std::vector<Heading> headings;
  for (Scene& scene : scenes) {
    measureScene(o, scene, scratch, speaker, [&](const Row& row) {
      rows.push_back(row);
      table.add(row);
    });
    headings.push_back({scene.name, scene.about});
    writeCharts(o.out, scene.name, rows);
    writePage(o.out, headings, rows, command);
  }
  speaker.done(o.out + "/index.html, " + o.out + "/results.csv");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  spdlog::set_default_logger(spdlog::stderr_color_mt("gxybench"));
  try {
    if (const auto code = parseOptions(argc, argv, options)) return *code;
    if (options.command == Options::Command::Work) return work(options.jobFile);
    if (options.command == Options::Command::List) return list(options.quick);
    if (options.command == Options::Command::Compare) return compare(options);
    std::string command = "gxybench";
    for (int i = 1; i < argc; i++) command += std::string(" ") + argv[i];
    return measureAll(options, command);
  } catch (const std::exception& e) {
    std::cerr << "gxybench: error: " << e.what() << '\n';
    return 1;
  }
}
