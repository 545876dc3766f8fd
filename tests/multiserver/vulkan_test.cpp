// SPDX-License-Identifier: Apache-2.0
// A server on the Vulkan backend: the pictures of one on Embree; and a device that is lost, or has too little memory, is an
// error of requests, not the server's end.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "backends/vulkan/vulkan_backend.h"
#include "core/image/image.h"
#include "tests/multiserver/test_server.h"
#include "tests/vulkan/difference.h"
#include "tests/vulkan/test_device.h"

namespace gxy::test {
namespace {

const std::string kBatch = R"(batch {"prefix": "out", "state": )" + stateOf("ball") + "}";

/// Ranks 0, 1, ... with a backend each, of these options; none: Embree.
std::unique_ptr<TestServer> serve(const std::vector<VulkanOptions>& ranks) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  if (!ranks.empty()) {
    setup.ranks = int(ranks.size());
    setup.backend = [ranks, next = std::make_shared<size_t>(0)](Ledger* ledger) {
      VulkanOptions options = ranks.at((*next)++);
      options.ledger = ledger;
      return makeVulkanBackend(options);
    };
  }
  return std::make_unique<TestServer>(std::move(setup));
}

std::unique_ptr<Client> viewer(const TestServer& server) {
  auto client = server.client();
  client->expect("load data");
  client->expect("load viewer");
  client->expect(importBall("ball"));
  return client;
}

/// The bytes of the picture that it has written.
std::string fileOf(const TestServer& server) {
  std::ifstream file(server.folder() / "out_00000.png", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Picture pictureOf(const TestServer& server) {
  Image image = readImage(server.folder() / "out_00000.png");
  return {image.width, image.height, std::move(image.rgba), {}};
}

TEST(VulkanServer, MakesThePicturesOfEmbree) {
  std::string file;
  Picture expected;
  {
    const auto server = serve({});
    viewer(*server)->expect(kBatch);
    file = fileOf(*server);
    expected = pictureOf(*server);
  }
  const VulkanOptions sound = vulkan_test::testDevice();
  const auto server = serve({sound, sound});
  viewer(*server)->expect(kBatch);
  EXPECT_GT(file.size(), 1000u);
  EXPECT_EQ(vulkan_test::difference(expected, pictureOf(*server)), "");
  EXPECT_TRUE(!vulkan_test::isSoftware() || file == fileOf(*server))
      << "the pictures are the same, and their files are not";
}

/// Requests that need rank 1's device fail in these words, and nothing else does.
void expectOthersGoOn(TestServer& server, Client& client, const std::string& batch,
                      const std::string& words) {
  for (int time = 0; time < 2; time++) {
    const Reply reply = client.request(batch);
    EXPECT_FALSE(reply.ok);
    EXPECT_NE(reply.error.find(words), std::string::npos) << reply.error;
    EXPECT_NE(reply.error.find("rank 1"), std::string::npos) << reply.error;
  }
  EXPECT_GE(client.expect("list").at("datasets").size(), 1u);
  EXPECT_EQ(server.client("another")->expect("echo hello").at("text"), "hello");
  EXPECT_FALSE(server.stopAsked());
}

TEST(VulkanServer, GoesOnWhenADeviceIsLost) {
  const VulkanOptions sound = vulkan_test::testDevice();
  VulkanOptions lost = sound;
  lost.lostAfter = 2;
  const auto server = serve({sound, lost});
  expectOthersGoOn(*server, *viewer(*server), kBatch, "the device was lost");
}

TEST(VulkanServer, GoesOnWhereADeviceHasTooLittleMemory) {
  const VulkanOptions sound = vulkan_test::testDevice();
  VulkanOptions small = sound;
  small.allocationBytes = size_t(4) << 20;
  const auto server = serve({sound, small});
  const auto client = viewer(*server);
  writeBall(server->folder().path().string(), "large", 128);  // 8 MiB, half of it on each rank
  client->expect(importBall("large", "large.vol"));
  const std::string batch = R"(batch {"prefix": "out", "state": )" + stateOf("large") + "}";
  expectOthersGoOn(*server, *client, batch, "gives no 5 MiB for volumes at once, expected up to 4 MiB");
  client->expect(kBatch);  // what fits is rendered there
  EXPECT_GT(fileOf(*server).size(), 1000u);
}

}  // namespace
}  // namespace gxy::test
