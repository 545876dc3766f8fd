// SPDX-License-Identifier: Apache-2.0
// Which device is taken, and what is said where there is none to take.
#include <gtest/gtest.h>

#include "gxy/backends/backends.h"
#include "gxy/comm/error.h"
#include "gxy/vulkan/vulkan_device.h"
#include "vulkan/software_device.h"

namespace gxy::vulkan_test {
namespace {

template <class Call>
std::string errorOf(const Call& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST(VulkanDevices, AreFoundByNumberAndByPartOfTheirName) {
  const VulkanOptions byNumber = softwareDevice();
  const VulkanDeviceInfo info = vulkanDevices().at(std::stoul(byNumber.device));
  EXPECT_TRUE(info.missing.empty());
  EXPECT_NE(makeVulkanBackend(byNumber)->device().find(info.name), std::string::npos);
  VulkanOptions byName;
  byName.device = "LLVMpipe";
  EXPECT_NE(makeVulkanBackend(byName)->device().find("llvmpipe"), std::string::npos);
}

TEST(VulkanDevices, UnknownOnesAreAnErrorThatListsThoseThereAre) {
  for (const char* device : {"no such thing", "97"}) {
    VulkanOptions options;
    options.device = device;
    const std::string error = errorOf([&] { makeVulkanBackend(options); });
    EXPECT_NE(error.find(device), std::string::npos) << error;
    EXPECT_NE(error.find("llvmpipe"), std::string::npos) << error;
  }
}

TEST(VulkanDevices, TooLittleMemoryIsAnErrorThatSaysHowMuchThereIs) {
  const vulkan::Device device(softwareDevice());
  const std::string error =
      errorOf([&] { vulkan::Buffer(device, size_t(1) << 44, vulkan::Place::Device, "volumes"); });
  EXPECT_NE(error.find("16777216 MiB left for volumes"), std::string::npos) << error;
  EXPECT_NE(error.find(std::to_string(device.info().memory >> 20) + " MiB"), std::string::npos) << error;
  EXPECT_EQ(device.bytes(), 0u);
}

TEST(VulkanDevices, BuffersAreCountedWhileTheyLive) {
  const vulkan::Device device(softwareDevice());
  {
    const vulkan::Buffer buffer(device, 1000, vulkan::Place::Device, "a test");
    EXPECT_EQ(device.bytes(), 1000u);
  }
  EXPECT_EQ(device.bytes(), 0u);
}

TEST(VulkanDevices, AutoTakesVulkanForADiscreteGpuOrADeviceThatIsAskedFor) {
  bool discrete = false;
  for (const VulkanDeviceInfo& d : vulkanDevices())
    discrete = discrete || (d.kind == VulkanDeviceInfo::Kind::Discrete && d.missing.empty());
  EXPECT_EQ(allBackends({}).make("auto")->name(), discrete ? "vulkan" : "embree");
  EXPECT_EQ(allBackends({"llvmpipe", 0}).make("auto")->name(), "vulkan");
  EXPECT_EQ(allBackends({"", 5}).make("vulkan")->name(), "vulkan");
}

TEST(VulkanDevices, EmbreeHasNoneToChooseFrom) {
  EXPECT_NE(errorOf([] {
              allBackends({"llvmpipe", 0}).make("embree");
            }).find("has none to choose from"),
            std::string::npos);
}

TEST(VulkanDevices, AreListedWithTheBackendThatUsesThem) {
  std::string text;
  for (const std::string& line : listDevices()) text += line + "\n";
  EXPECT_EQ(text.find("embree: CPU"), 0u) << text;
  EXPECT_NE(text.find("llvmpipe"), std::string::npos) << text;
  EXPECT_NE(text.find("software"), std::string::npos) << text;
}

}  // namespace
}  // namespace gxy::vulkan_test
