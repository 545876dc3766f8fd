// SPDX-License-Identifier: Apache-2.0
// What `auto` loads where there is no GPU: not Mesa's software device with its compiler. In a program of its own, as what one
// test has loaded stays for the next.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "backends/registry/backends.h"
#include "backends/vulkan/vulkan_backend.h"

namespace gxy {
namespace {

bool isMapped(const std::string& library) {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);)
    if (line.find(library) != std::string::npos) return true;
  return false;
}

TEST(Auto, LoadsNoDriverWhereNoGpuIsShown) {
  allBackends({}).make("auto");
  const bool loaded = isMapped("libLLVM");
  const std::vector<VulkanDeviceInfo> devices = vulkanDevices();
  const auto software = std::find_if(devices.begin(), devices.end(), [](const VulkanDeviceInfo& d) {
    return d.kind == VulkanDeviceInfo::Kind::Software;
  });
  if (showsGpu() && software == devices.end()) GTEST_SKIP() << "there is no software device to be loaded";
  EXPECT_EQ(loaded, showsGpu());
  ASSERT_NE(software, devices.end());
  const auto backend = allBackends({software->name, 0}).make("auto");
  EXPECT_TRUE(isMapped("libLLVM")) << "it would not have been seen";
}

TEST(ShowsGpu, WhereADriverHasMadeItsNode) {
  namespace fs = std::filesystem;
  const fs::path dev = fs::path(testing::TempDir()) / "galaxy_dev";
  fs::remove_all(dev);
  EXPECT_FALSE(showsGpu(dev.string()));
  fs::create_directories(dev / "dri" / "by-path");
  for (const char* other : {"nvidiactl", "nvidia-uvm", "dri/card0"}) std::ofstream(dev / other).put(' ');
  EXPECT_FALSE(showsGpu(dev.string()));
  for (const char* node : {"dri/renderD128", "nvidia0", "dxg"}) {
    std::ofstream(dev / node).put(' ');
    EXPECT_TRUE(showsGpu(dev.string())) << node;
    fs::remove(dev / node);
  }
}

}  // namespace
}  // namespace gxy
