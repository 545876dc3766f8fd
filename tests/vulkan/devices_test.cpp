// SPDX-License-Identifier: Apache-2.0
// Which device is taken, and what is said where there is none to take.
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "backends/registry/backends.h"
#include "backends/vulkan/vulkan_device.h"
#include "core/comm/error.h"
#include "tests/vulkan/test_device.h"

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
  const std::vector<VulkanDeviceInfo> all = vulkanDevices();
  for (size_t i = 0; i < all.size(); i++) {
    if (!all[i].missing.empty()) continue;
    VulkanOptions options;
    options.device = std::to_string(i);
    EXPECT_NE(makeVulkanBackend(options)->device().find(all[i].name), std::string::npos);
    options.device = all[i].name.substr(1);
    std::transform(options.device.begin(), options.device.end(), options.device.begin(), ::toupper);
    EXPECT_NE(makeVulkanBackend(options)->device().find(all[i].name), std::string::npos);
  }
  EXPECT_TRUE(testedInfo().missing.empty());
}

using Kind = VulkanDeviceInfo::Kind;

VulkanDeviceInfo info(const std::string& name, Kind kind, std::vector<std::string> missing = {}) {
  return {name, "a driver", kind, 0, std::move(missing)};
}

/// The devices that the first ranks of a machine get.
std::vector<size_t> picks(const std::vector<VulkanDeviceInfo>& infos, const std::string& device) {
  std::vector<size_t> all;
  VulkanOptions options;
  options.device = device;
  for (; options.rankOnMachine < 4; options.rankOnMachine++) all.push_back(vulkan::pick(infos, options));
  return all;
}

TEST(PickedDevices, AreTheBestKindRoundRobin) {
  const std::vector<VulkanDeviceInfo> infos{
      info("llvmpipe", Kind::Software), info("A", Kind::Discrete), info("i", Kind::Integrated),
      info("B", Kind::Discrete, {"shaderInt64"}), info("C", Kind::Discrete)};
  EXPECT_EQ(picks(infos, ""), (std::vector<size_t>{1, 4, 1, 4}));
}

TEST(PickedDevices, AreSoftwareOnlyIfAloneOrAskedFor) {
  const VulkanDeviceInfo software = info("llvmpipe", Kind::Software), gpu = info("i", Kind::Integrated);
  EXPECT_EQ(picks({software, gpu}, "")[0], 1u);
  EXPECT_EQ(picks({software}, "")[0], 0u);
  EXPECT_EQ(picks({software, info("old", Kind::Discrete, {"Vulkan 1.2"})}, "")[0], 0u);
  EXPECT_EQ(picks({software, gpu}, "LLVM")[0], 0u);
  EXPECT_EQ(picks({software, gpu}, "0")[0], 0u);
}

TEST(PickedDevices, AreTakenByAutoWhereOneIsADiscreteGpuThatLacksNothing) {
  const VulkanDeviceInfo software = info("llvmpipe", Kind::Software),
                         integrated = info("i", Kind::Integrated),
                         old = info("old", Kind::Discrete, {"Vulkan 1.2"}), gpu = info("A", Kind::Discrete);
  EXPECT_FALSE(hasDiscreteGpu({}));
  EXPECT_FALSE(hasDiscreteGpu({software, integrated, old}));
  EXPECT_TRUE(hasDiscreteGpu({software, old, gpu}));
  EXPECT_EQ(lackingOf({software, integrated, gpu}), "");
  EXPECT_EQ(lackingOf({software, old, gpu}), "\"old\" lacks Vulkan 1.2");
}

TEST(PickedDevices, OfANameAreAllThatHaveItAndLackNothing) {
  const std::vector<VulkanDeviceInfo> infos{
      info("GeForce RTX 4090", Kind::Discrete, {"shaderFloat64"}), info("GeForce RTX 4090", Kind::Discrete),
      info("llvmpipe", Kind::Software), info("GeForce RTX 4090", Kind::Discrete)};
  EXPECT_EQ(picks(infos, "geforce"), (std::vector<size_t>{1, 3, 1, 3}));
  EXPECT_EQ(picks(infos, "RTX 4090"), (std::vector<size_t>{1, 3, 1, 3}));
  EXPECT_EQ(picks(infos, "2"), (std::vector<size_t>{2, 2, 2, 2}));
  EXPECT_NE(
      errorOf([&] { picks(infos, "4090"); }).find("there is no Vulkan device \"4090\"; expected one of: 0"),
      std::string::npos)
      << "digits are a number, also where they stand in a name";
}

TEST(PickedDevices, ThatLackSomethingAreAnErrorThatSaysWhat) {
  const std::vector<VulkanDeviceInfo> infos{info("old", Kind::Discrete, {"Vulkan 1.2"}),
                                            info("older", Kind::Discrete, {"shaderInt64", "shaderFloat64"})};
  const std::string both =
      " that can be used; \"old\" lacks Vulkan 1.2; "
      "\"older\" lacks shaderInt64, shaderFloat64";
  EXPECT_EQ(errorOf([&] { picks(infos, ""); }), "there is no Vulkan device" + both);
  EXPECT_EQ(errorOf([&] { picks(infos, "old"); }), "there is no Vulkan device \"old\"" + both);
  EXPECT_EQ(errorOf([&] { picks(infos, "0"); }),
            "there is no Vulkan device \"0\" that can be used; \"old\" lacks Vulkan 1.2");
}

TEST(VulkanDevices, UnknownOnesAreAnErrorThatListsThoseThereAre) {
  for (const char* device : {"no such thing", "97"}) {
    VulkanOptions options;
    options.device = device;
    const std::string error = errorOf([&] { makeVulkanBackend(options); });
    EXPECT_NE(error.find(device), std::string::npos) << error;
    EXPECT_NE(error.find(testedInfo().name), std::string::npos) << error;
  }
}

TEST(VulkanDevices, TooLittleMemoryIsAnErrorThatSaysHowMuchThereIs) {
  const vulkan::Device device(testDevice());
  const std::string error =
      errorOf([&] { vulkan::Buffer(device, size_t(1) << 44, vulkan::Place::Device, "volumes"); });
  EXPECT_NE(error.find("16777216 MiB left for volumes"), std::string::npos) << error;
  EXPECT_NE(error.find(std::to_string(device.info().memory >> 20) + " MiB"), std::string::npos) << error;
  EXPECT_EQ(device.bytes(), 0u);
}

TEST(VulkanDevices, MoreThanIsGivenAtOnceIsAnErrorThatSaysHowMuchIs) {
  VulkanOptions options = testDevice();
  options.allocationBytes = size_t(3) << 20;
  const vulkan::Device device(options);
  const vulkan::Buffer fits(device, size_t(3) << 20, vulkan::Place::Device, "volumes");
  const std::string error =
      errorOf([&] { vulkan::Buffer(device, size_t(4) << 20, vulkan::Place::Device, "volumes"); });
  EXPECT_NE(error.find("gives no 4 MiB for volumes at once, expected up to 3 MiB (maxMemoryAllocationSize)"),
            std::string::npos)
      << error;
}

TEST(VulkanDevices, BuffersAreCountedWhileTheyLive) {
  const vulkan::Device device(testDevice());
  {
    const vulkan::Buffer buffer(device, 1000, vulkan::Place::Device, "a test");
    EXPECT_EQ(device.bytes(), 1000u);
  }
  EXPECT_EQ(device.bytes(), 0u);
}

/// Fills a buffer twice, in one submission or two.
void fill(const VulkanOptions& options, bool barrier, bool together = true) {
  const vulkan::Device device(options);
  const vulkan::Buffer buffer(device, 1000, vulkan::Place::Device, "a test");
  vulkan::Commands commands(device), more(device);
  const VkCommandBuffer c = commands.begin();
  vkCmdFillBuffer(c, buffer.get(), 0, VK_WHOLE_SIZE, 1);
  if (!together) commands.submit();
  vulkan::Commands& then = together ? commands : more;
  const VkCommandBuffer d = together ? c : more.begin();
  if (barrier) then.barrier();
  vkCmdFillBuffer(d, buffer.get(), 0, VK_WHOLE_SIZE, 2);
  then.submit();
  then.wait();
}

// Or silence would say nothing.
TEST(ValidationLayers, HearAMissingBarrier) {
  std::vector<std::string> heard;
  VulkanOptions options = testDevice();
  options.heard = [&](const char* message) { heard.emplace_back(message); };
  for (bool together : {true, false}) {
    heard.clear();
    fill(options, true, together);
    EXPECT_EQ(heard, std::vector<std::string>());
    fill(options, false, together);
    ASSERT_EQ(heard.size(), 1u);
    EXPECT_NE(heard[0].find("SYNC-HAZARD-WRITE-AFTER-WRITE"), std::string::npos) << heard[0];
  }
}

// Run by a test that expects to hear of it: layers that the environment asks for, not the program.
TEST(ValidationLayers, DISABLED_HearAMissingBarrierOfPrograms) {
  VulkanOptions options;
  options.device = testDevice().device;
  unsetenv("VK_LAYER_ENABLES");  // testDevice()'s
  fill(options, false, false);
}

TEST(VulkanDevices, AutoTakesVulkanForADiscreteGpuOrADeviceThatIsAskedFor) {
  EXPECT_EQ(allBackends({}).make("auto")->name(), hasDiscreteGpu(vulkanDevices()) ? "vulkan" : "embree");
  EXPECT_EQ(allBackends({testDevice().device, 0}).make("auto")->name(), "vulkan");
  EXPECT_EQ(allBackends({"", 5}).make("vulkan")->name(), "vulkan");
}

/// The name of a software device; empty where there is none, as there may be on a machine with a GPU.
std::string softwareName() {
  if (isSoftware()) return testedInfo().name;
  for (const VulkanDeviceInfo& device : vulkanDevices())
    if (device.kind == Kind::Software && device.missing.empty()) return device.name;
  return "";
}

TEST(VulkanDevices, SoftwareIsTakenWithAWarningOnEachMachine) {
  const std::string name = softwareName();
  if (name.empty()) GTEST_SKIP() << "there is no software device";
  std::ostringstream said;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_st>(said)));
  allBackends({name, 1}).make("vulkan");
  EXPECT_EQ(said.str(), "");
  allBackends({name, 0}).make("vulkan");
  spdlog::set_default_logger(before);
  EXPECT_NE(said.str().find("is software"), std::string::npos) << said.str();
  EXPECT_NE(said.str().find(name), std::string::npos) << said.str();
}

TEST(VulkanDevices, EmbreeHasNoneToChooseFrom) {
  EXPECT_NE(errorOf([] {
              allBackends({testDevice().device, 0}).make("embree");
            }).find("has none to choose from"),
            std::string::npos);
}

TEST(VulkanDevices, AreListedWithTheBackendThatUsesThem) {
  std::string text;
  for (const std::string& line : listDevices()) text += line + "\n";
  EXPECT_EQ(text.find("embree: CPU"), 0u) << text;
  EXPECT_NE(text.find(testedInfo().name), std::string::npos) << text;
  const std::string software = softwareName();
  EXPECT_EQ(text.find("software") != std::string::npos, !software.empty()) << text;
  EXPECT_NE(text.find(software), std::string::npos) << text;
}

}  // namespace
}  // namespace gxy::vulkan_test
