// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyrender/options.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <sstream>

#include "backends/registry/backends.h"
#include "tools/look_options.h"
#include "tools/number_option.h"
#include "tools/version_option.h"

namespace gxy {

namespace {

// "800x600" or "4,3,2" to numbers.
template <size_t N>
bool parseNumbers(const std::string& text, char separator, std::array<int, N>& out, size_t least) {
  std::stringstream in(text);
  std::string part;
  size_t n = 0;
  while (std::getline(in, part, separator)) {
    size_t used = 0;
    try {
      if (n == N) return false;
      out[n] = std::stoi(part, &used);
    } catch (const std::exception&) {
      return false;
    }
    if (used != part.size() || out[n] < 1) return false;
    n++;
  }
  return n == N || n == least;
}

}  // namespace

void RenderOptions::apply(State& state) const {
  if (tolerance) state.settings.tolerance = *tolerance;
  if (step) state.settings.step = *step;
  if (annotate) state.annotations.legend = state.annotations.axes = state.annotations.outline = true;
  if (size) {
    for (Camera& c : state.cameras) c.dimensions = {(*size)[0], (*size)[1]};
    for (Visualization& v : state.visualizations) v.view.size = {(*size)[0], (*size)[1]};
  }
}

std::optional<int> parseOptions(int argc, char** argv, bool speaks, RenderOptions& o) {
  CLI::App app(
      "Renders every visualization of a state file with every camera, or data files as they are, on all "
      "ranks it is "
      "started on.\n"
      "  gxyrender scene.json -o picture\n"
      "  galaxy run -n 4 gxyrender scene.json -o picture --size 1920x1080\n"
      "  gxyrender density.vti                      volume rendering, of values as their content suggests\n"
      "  gxyrender density.vti halos.vtp --iso 0.3  a surface in it, and points\n"
      "  gxyrender 'step_*.vti'                     a picture for each file (also step_%04d.vti)\n"
      "  gxyrender scene.json --cinema sweep.json   a Cinema database: image.cdb, with a page to browse it\n"
      "Pictures are PREFIX_00000.png, ...: all visualizations of the first camera, then of the next. Views "
      "are rendered with their own camera alone.");
  std::string size, partitions;
  app.add_option("FILE", o.files,
                 "State file (docs/state-file.md), or data files, together in one picture; gxydata scene "
                 "writes the state "
                 "file that shows data files so")
      ->required();
  std::vector<std::string> isovalues;
  addLookOptions(app, isovalues, o.look, o.array);
  std::vector<std::string> datasets;
  app.add_option("--dataset", datasets,
                 "NAME=FILE: the file of a dataset of the state file, in place of what it says")
      ->type_size(1)
      ->allow_extra_args(false);
  app.add_option("-o,--output", o.prefix, "Prefix of the pictures' names; with --cinema the database's name")
      ->capture_default_str();
  CLI::Option* cinema =
      app.add_option("--cinema", o.sweepFile,
                     "Make a Cinema database, PREFIX.cdb, of the pictures of this sweep (docs/cinema.md)");
  app.add_flag("--resume", o.resume, "Of a Cinema database: keep what it has, and render what it lacks")
      ->needs(cinema);
  app.add_option("--size", size, "Picture size WxH, instead of the cameras'");
  app.add_option("--backend", o.backend, kBackendHelp)->capture_default_str();
  app.add_option("--device", o.device, kDeviceHelp);
  app.add_flag_callback(
      "--list-devices",
      [&] {
        if (speaks)
          for (const std::string& line : listDevices()) std::cout << line << '\n';
        throw CLI::Success();
      },
      "List the devices of all backends, and end");
  app.add_flag("--reference", o.reference,
               "Render with the reference renderer: double precision, slow, on one rank");
  app.add_option("--tolerance", o.tolerance,
                 "Error that every channel of every pixel stays below (default 1/512)")
      ->check(numberFrom(1e-6, 1));
  app.add_option("--step", o.step, "Fixed step of the volume integrator in cells, for comparison")
      ->check(numberFrom(1e-3, 4));
  app.add_option("--partitions", partitions,
                 "Number of partitions N, or I,J,K of them per axis (default: one a rank, more for volumes "
                 "of over 2^28 points)");
  app.add_option("--concurrent", o.concurrent, "Pictures in flight at once")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  app.add_option("--format", o.format,
                 "png (8 bit), exr (float) or raw (float RGBA, premultiplied, rows bottom to top)")
      ->check(CLI::IsMember({"png", "exr", "raw"}))
      ->capture_default_str();
  app.add_flag("--depth", o.depth,
               "Also write the hit distance, PREFIX_00000.depth: float64, world units, 1e30 for a miss");
  app.add_flag(
      "--annotate", o.annotate,
      "Draw colour legends, the axes' directions, the data's box and, of several steps, their number "
      "and time over the pictures");
  app.add_option("--stats", o.statsFile, "Write counters per rank and stage to this JSON file");
  app.add_option("--threads", o.threads, "Threads per rank (default: the cores shared by the ranks)")
      ->check(CLI::Range(0, 4096));
  app.add_option("--packet", o.packet, "Rays that are traced together, at most")
      ->check(CLI::Range(16, 1 << 20))
      ->capture_default_str();
  app.add_option("--rays-in-flight", o.raysInFlight, "Rays a rank may have under way; bounds memory")
      ->check(CLI::Range(int64_t(1), int64_t(1) << 40))
      ->capture_default_str();
  app.add_flag("-q,--quiet", o.quiet, "No progress and no summary");
  auto usage = [&](const std::string& why) {
    if (speaks) std::cerr << "gxyrender: " << why << "\nRun with --help for more information.\n";
    return 2;
  };
  addVersion(app, "gxyrender");
  try {
    app.parse(argc, argv);
    readIsovalues(isovalues, o.look);
  } catch (const CLI::ParseError& e) {
    if (speaks) app.exit(e);
    return e.get_exit_code() == 0 ? 0 : 2;
  }
  if (o.reference)
    for (const char* other :
         {"--backend", "--device", "--partitions", "--stats", "--concurrent", "--packet", "--rays-in-flight"})
      if (app.count(other) > 0)
        return usage(std::string(other) + " does not go with --reference, which renders by itself");
  if (!o.sweepFile.empty() && (o.reference || !o.statsFile.empty() || o.format == "raw"))
    return usage(std::string(o.reference         ? "--reference"
                             : o.format == "raw" ? "--format raw"
                                                 : "--stats") +
                 " does not go with --cinema");
  o.looks = !isovalues.empty() || o.look.slice || !o.array.empty();
  for (const std::string& text : datasets) {
    const size_t equals = text.find('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == text.size())
      return usage("--dataset " + text + ": expected NAME=FILE");
    o.datasets[text.substr(0, equals)] = text.substr(equals + 1);
  }
  if (!size.empty()) {
    o.size.emplace();
    if (!parseNumbers(size, 'x', *o.size, 2))
      return usage("--size " + size + ": expected WxH, such as 800x600");
  }
  if (!partitions.empty() && !parseNumbers(partitions, ',', o.partitions, 1))
    return usage("--partitions " + partitions + ": expected N or I,J,K, such as 8 or 2,2,2");
  return std::nullopt;
}

}  // namespace gxy
