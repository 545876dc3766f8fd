// SPDX-License-Identifier: Apache-2.0
// gpu_report: tests and times a Vulkan device, on a machine that has nothing but its driver.
#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <sstream>
#include <thread>

#include "gxy/comm/error.h"
#include "gxy/vulkan/vulkan_backend.h"
#include "report.h"

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
  std::string output = "gpu-report.md";
  VulkanOptions options;
  double minutes = 8, scale = 1;
  app.add_option("-o,--output", output, "The report")->capture_default_str();
  app.add_option("--device", options.device, "Number of a device, or a part of its name");
  app.add_option("--minutes", minutes, "What is not begun by then is left out")->capture_default_str();
  app.add_option("--scale", scale, "Of the benchmarks' data and pictures; 1 suits a large GPU, 0.1 software")
      ->check(CLI::Range(0.01, 2.0))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    std::ofstream file(output);
    if (!file) throw Error(output + ": cannot be written");
    gpu_report::Report report(file, std::cout, minutes);
    const std::unique_ptr<Backend> device = makeVulkanBackend(options);
    describe(report, *device);
    const int failures = gpu_report::agreement(*device, report);
    gpu_report::benchmarks(*device, scale, report);
    report.line("\n" + std::to_string(failures) + " scenes do not agree; " +
                std::to_string(int(60 * minutes - report.left())) + " s in all");
    return failures > 0;
  } catch (const std::exception& e) {
    std::cerr << "gpu_report: error: " << e.what() << '\n';
    return 1;
  }
}
