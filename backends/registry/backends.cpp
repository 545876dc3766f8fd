// SPDX-License-Identifier: Apache-2.0
#include "backends/registry/backends.h"

#include <spdlog/spdlog.h>

#include "backends/embree/embree_backend.h"
#include "core/comm/error.h"
#ifdef GALAXY_VULKAN
#include "backends/vulkan/vulkan_backend.h"
#endif

namespace gxy {

const char* const kBackendHelp =
    "embree, vulkan, or auto: vulkan where there is a discrete GPU, and embree for what it fails with; "
    "vulkan alone where --device was given; else embree";
const char* const kDeviceHelp = "Device of the vulkan backend: its number, or a part of its name";

bool hasDevices(const std::string& backend) { return backend != "embree"; }

BackendRegistry allBackends(const BackendOptions& options) {
  BackendRegistry registry;
#ifdef GALAXY_VULKAN
  const auto fits = [options] {
    if (!options.device.empty()) return true;
    if (!showsGpu()) return false;  // no driver is loaded where there is nothing to find
    const std::vector<VulkanDeviceInfo> devices = vulkanDevices();
    if (hasDiscreteGpu(devices)) return true;
    if (const std::string lacking = lackingOf(devices); !lacking.empty() && options.rankOnMachine == 0)
      spdlog::warn("backend auto: {}; the embree backend is used", lacking);
    return false;
  };
  const auto make = [options](Ledger* ledger) {
    VulkanOptions vulkan;
    vulkan.device = options.device;
    vulkan.rankOnMachine = options.rankOnMachine;
    vulkan.ledger = ledger;
    std::unique_ptr<Backend> made = makeVulkanBackend(vulkan);
    if (deviceOf(*made).kind == VulkanDeviceInfo::Kind::Software && options.rankOnMachine == 0)
      spdlog::warn("backend vulkan: {} is software; the embree backend would be faster", made->device());
    return made;
  };
  registry.add("vulkan", make, fits);
#endif
  registry.add("embree", [options](Ledger*) {
    if (!options.device.empty())
      throw Error("device \"" + options.device +
                  "\" was asked for, but the embree backend has none to choose from");
    return makeEmbreeBackend();
  });
  registry.addForFields([](Ledger*) { return makeEmbreeBackend(); });
  return registry;
}

std::vector<std::string> listDevices() {
  std::vector<std::string> lines{"embree: " + makeEmbreeBackend()->device()};
#ifdef GALAXY_VULKAN
  const std::vector<VulkanDeviceInfo> devices = vulkanDevices();
  for (size_t i = 0; i < devices.size(); i++) {
    const VulkanDeviceInfo& d = devices[i];
    std::string line = "vulkan " + std::to_string(i) + ": " + d.name;
    if (!d.driver.empty()) line += ", " + d.driver;
    line += ", " + std::to_string(d.memory >> 20) + " MiB";
    if (d.kind == VulkanDeviceInfo::Kind::Software) line += ", software: taken only if asked for or if alone";
    for (size_t m = 0; m < d.missing.size(); m++)
      line += (m ? ", " : ", cannot be used: lacks ") + d.missing[m];
    lines.push_back(line);
  }
  if (devices.empty()) lines.emplace_back("vulkan: no devices");
#else
  lines.emplace_back("vulkan: not in this build (GALAXY_VULKAN)");
#endif
  return lines;
}

}  // namespace gxy
