// SPDX-License-Identifier: Apache-2.0
// gpu_report: tests and times a Vulkan device, on a machine that has nothing but its driver.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iostream>
#include <sstream>
#include <thread>

#include "backends/vulkan/vulkan_backend.h"
#include "core/comm/error.h"
#include "tools/gpu-report/report.h"
#include "tools/version_option.h"

using namespace gxy;

namespace {

void describe(gpu_report::Report& report, const Backend& backend) {
  report.line("# Report on " + backend.device() + "\n");
  for (const VulkanDeviceInfo& d : vulkanDevices()) {
    std::string line =
        "- device: " + d.name + ", " + d.driver + ", " + std::to_string(d.memory >> 20) + " MiB";
    for (const std::string& m : d.missing) line += ", lacks " + m;
    report.line(line);
  }
  report.line("- host: " + std::to_string(std::thread::hardware_concurrency()) + " hardware threads");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Tests a Vulkan device against the Embree backend, times it, and writes one report.");
  std::string output = "gpu-report.md", pictures;
  VulkanOptions options;
  double minutes = 7.5, scale = 1;
  int scenes = 1000;
  app.add_option("-o,--output", output, "The report")->capture_default_str();
  app.add_option(
         "--pictures", pictures,
         "A folder to leave the compared pictures in, as raw float RGBA, premultiplied, 192 x 160, rows "
         "bottom to top")
      ->check(CLI::ExistingDirectory);
  app.add_option("--device", options.device, "Number of a device, or a part of its name");
  app.add_option("--minutes", minutes,
                 "It ends after so many, half a minute at least; half of them are for the comparison")
      ->capture_default_str();
  app.add_option("--scenes", scenes, "Compare only the first so many (default: all)")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--scale", scale,
                 "Of the benchmarks' data and pictures; 0.01 to 2; 1 suits a large GPU, 0.1 software")
      ->capture_default_str();
  addVersion(app, "gpu_report");
  try {
    app.parse(argc, argv);
    if (!(minutes >= 0 && minutes <= 1440)) throw CLI::ValidationError("--minutes", "expected 0 to 1440");
    if (!(scale >= 0.01 && scale <= 2)) throw CLI::ValidationError("--scale", "expected 0.01 to 2");
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  try {
    std::ofstream file(output);
    if (!file) throw Error(output + ": cannot be written");
    gpu_report::Report report(file, std::cout, minutes);
    std::unique_ptr<Backend> device;  // until after the last line
    gpu_report::Tally compared, timed;
    try {
      device = makeVulkanBackend(options);
      describe(report, *device);
      compared = gpu_report::agreement(*device, scenes, pictures, report);
      const double each = 60 * minutes / 48;  // frames of the four: about ten seconds each
      timed = gpu_report::benchmarks(*device, options, scale, each, report);
      report.line("\n" + std::to_string(compared.tried) + " of " + std::to_string(compared.all) +
                  " scenes compared, " + std::to_string(compared.failed) + " do not agree; " +
                  std::to_string(timed.tried) + " of " + std::to_string(timed.all) + " benchmarks run, " +
                  std::to_string(timed.failed) + " failed; " +
                  std::to_string(int(60 * minutes - report.left())) + " s in all");
    } catch (const std::exception& e) {
      report.line(std::string("\nIt ended here: ") + e.what());
      report.finish();
      throw;
    }
    report.finish();
    const bool done = compared.tried == std::min(compared.all, scenes) && timed.tried == timed.all;
    return !done || compared.tried == 0 || compared.failed > 0 || timed.failed > 0;
  } catch (const std::exception& e) {
    std::cerr << "gpu_report: error: " << e.what() << '\n';
    return 1;
  }
}
