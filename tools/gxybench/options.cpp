// SPDX-License-Identifier: Apache-2.0
#include "tools/gxybench/options.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdlib>
#include <filesystem>

#include "backends/registry/backends.h"
#include "tools/version_option.h"

namespace gxy::bench {
namespace {

constexpr const char* kExamples = R"(Examples:
  gxybench --list                                   the scenes
  gxybench --out before                             all scenes; before/index.html, before/results.csv
  gxybench turbulence-256-spiky scene.json --ranks 1,2 --tolerances 1/64,1/512
  gxybench compare before/results.csv after/results.csv
Exit status: 0 done, 1 failed (compare --fail: something is slower or worse), 2 wrong usage.)";

/// The number in "1/512" or "0.5"; nothing for other texts.
std::optional<double> numberIn(const std::string& text) {
  const auto plain = [](std::string_view part) -> std::optional<double> {
    double x = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), x);
    if (error != std::errc() || end != part.data() + part.size()) return std::nullopt;
    return x;
  };
  const size_t slash = text.find('/');
  if (slash == std::string::npos) return plain(text);
  const auto above = plain(std::string_view(text).substr(0, slash)),
             below = plain(std::string_view(text).substr(slash + 1));
  if (!above || !below || *below == 0) return std::nullopt;
  return *above / *below;
}

void addLadder(CLI::App& app, const char* name, std::vector<double>& values, double least, double most,
               const std::string& about) {
  app.add_option_function<std::vector<std::string>>(
         name,
         [=, &values](const std::vector<std::string>& words) {
           values.clear();
           for (const std::string& word : words) {
             const auto x = numberIn(word);
             if (!x || !(*x >= least) || *x > most)
               throw CLI::ValidationError(name, "expected numbers from " + fractionText(least) + " to " +
                                                    fractionText(most) + " such as 1/2,1/4, found '" + word +
                                                    "'");
             values.push_back(*x);
           }
         },
         about)
      ->delimiter(',');
}

/// The folder where references and data stay between runs.
std::string userCache() {
  const char* xdg = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  if (xdg && *xdg) return std::string(xdg) + "/galaxy/gxybench";
  return home && *home ? std::string(home) + "/.cache/galaxy/gxybench" : "gxybench-cache";
}

/// The script tools/galaxy of the source tree that this program was built in, otherwise the one on the PATH.
std::string galaxyRun() {
  std::error_code none;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", none);
  const auto script = program.parent_path() / "../../../tools/galaxy";
  return (std::filesystem::exists(script, none) ? script.lexically_normal().string() : "galaxy") + " run -n";
}

void addMeasuring(CLI::App& app, Options& o, std::string& size) {
  app.add_option("SCENES", o.scenes, "Names of fixed scenes, or state files (default: all fixed scenes)");
  app.add_flag_function(
      "--list", [&](int64_t) { o.command = Options::Command::List; }, "List the fixed scenes");
  app.add_flag("--quick", o.quick,
               "Small scenes and short ladders: under a minute, for a test of the plumbing");
  app.add_option("--backend", o.backends, "Backends to measure, each " + std::string(kBackendHelp))
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--device", o.device, kDeviceHelp);
  app.add_option("--ranks", o.ranks, "Numbers of ranks to measure on, such as 1,2,4")
      ->delimiter(',')
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
  app.add_option(
      "--size", size,
      "Picture size WxH, instead of the scenes' own (fixed scenes: 512x512, the mixed one 256x256)");
  app.add_option("--methods", o.ladders.methods, "Methods to measure: adaptive, fixed, uncorrected")
      ->delimiter(',')
      ->check(CLI::IsMember({"adaptive", "fixed", "uncorrected"}));
  addLadder(app, "--tolerances", o.ladders.tolerances, 1e-6, 1,
            "Ladder of `adaptive` (default 1/32 to 1/8192)");
  addLadder(app, "--steps", o.ladders.steps, 1e-3, 4, "Ladder of `fixed`, in cells (default 4 to 1/8)");
  app.add_option("--repeats", o.repeats, "Frames timed per setting, at least (default 3; --quick 1)")
      ->check(CLI::Range(1, 1000));
  app.add_option("--threads", o.threads, "Threads per rank (default: the cores shared by the ranks)")
      ->check(CLI::Range(1, 4096));
  app.add_option("--out", o.out, "Folder for results.csv, the charts and index.html")->capture_default_str();
  app.add_option("--cache", o.cache, "Folder that keeps data and references between runs")
      ->capture_default_str();
  app.add_option("--launcher", o.launcher, "What starts ranks, given their number and the program")
      ->capture_default_str();
  app.add_flag("-q,--quiet", o.quiet, "No progress");
}

void addOthers(CLI::App& app, Options& o) {
  CLI::App* compare = app.add_subcommand("compare", "Which curves moved from one run to another");
  compare->add_option("OLD", o.older, "results.csv of the earlier run")->required();
  compare->add_option("NEW", o.newer, "results.csv of the later run")->required();
  compare->add_flag("--wall", o.wall, "Compare wall time, not processor time");
  compare->add_option("--error", o.error, "Which error is to be equal: rms, max or p999")
      ->check(CLI::IsMember({"rms", "max", "p999"}))
      ->capture_default_str();
  compare->add_flag("--fail", o.fail, "Exit with 1 if a curve is slower beyond noise, less exact or missing");
  compare->callback([&] { o.command = Options::Command::Compare; });
  CLI::App* work = app.add_subcommand("work", "")->group("");  // for the workers that gxybench starts
  work->add_option("JOB", o.jobFile)->required();
  work->callback([&] { o.command = Options::Command::Work; });
}

}  // namespace

std::optional<int> parseOptions(int argc, char** argv, Options& o) {
  CLI::App app(
      "Measures rendering: time, work and error against a double-precision reference, for every method and "
      "setting on\n"
      "a ladder. Writes a table, a chart per scene and a page that shows them.",
      "gxybench");
  app.footer(kExamples);
  app.require_subcommand(0, 1);
  o.cache = userCache();
  o.launcher = galaxyRun();
  std::string size;
  addMeasuring(app, o, size);
  addOthers(app, o);
  addVersion(app, "gxybench");
  try {
    app.parse(argc, argv);
    if (!size.empty()) {
      int width = 0, height = 0, used = 0;
      if (std::sscanf(size.c_str(), "%6dx%6d%n", &width, &height, &used) != 2 ||
          size_t(used) != size.size() || width < 1 || height < 1 || width > 65536 || height > 65536)
        throw CLI::ValidationError("--size", "expected WxH, such as 512x512, found '" + size + "'");
      o.size = {width, height};
    }
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  if (o.repeats == 0) o.repeats = o.quick ? 1 : 3;
  if (o.ladders.tolerances.empty())
    o.ladders.tolerances = o.quick
                               ? std::vector<double>{1.0 / 32, 1.0 / 512, 1.0 / 2048}
                               : std::vector<double>{1.0 / 32,   1.0 / 64,   1.0 / 128,  1.0 / 256, 1.0 / 512,
                                                     1.0 / 1024, 1.0 / 2048, 1.0 / 4096, 1.0 / 8192};
  if (o.ladders.steps.empty())
    o.ladders.steps = o.quick ? std::vector<double>{1, 0.25} : std::vector<double>{4, 2, 1, 0.5, 0.25, 0.125};
  return std::nullopt;
}

}  // namespace gxy::bench
