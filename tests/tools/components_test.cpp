// SPDX-License-Identifier: Apache-2.0
// gxyrender keeps those components of a volume that are shown, and its pictures do not depend on which others are there.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/data/bricks.h"
#include "tests/support/temporary_folder.h"

namespace gxy {
namespace {

constexpr int64_t kSide = 33, kPoints = kSide * kSide * kSide;
constexpr int64_t kMacrocells = 4 * 4 * 4;  // of 32^3 cells

class ComponentsShown : public ::testing::Test {
 protected:
  template <class T>
  void writeVolume(const char* type) const {
    std::ofstream raw(folder_ / "v.raw", std::ios::binary);
    for (int64_t i = 0; i < kPoints; i++)
      for (int c = 0; c < 4; c++) {
        const auto value = T(100 + 20 * std::sin(0.3 * double(i % kSide) + c) + 0.001 * double(i / kSide));
        raw.write(reinterpret_cast<const char*>(&value), sizeof value);
      }
    std::ofstream(folder_ / "v.json")
        << nlohmann::json{{"type", type},       {"origin", {0, 0, 0}},
                          {"delta", {1, 1, 1}}, {"counts", {kSide, kSide, kSide}},
                          {"rawdata", "v.raw"}, {"number of components", 4}};
  }

  // One picture for each of the components. Returns what rank 0 says of it.
  nlohmann::json render(const std::vector<nlohmann::json>& components) const {
    auto visualizations = nlohmann::json::array();
    for (const auto& component : components)
      visualizations.push_back({{"operators",
                                 {{{"type", "Volume"},
                                   {"dataset", "v"},
                                   {"component", component},
                                   {"volume rendering", true},
                                   {"isovalues", {112}},
                                   {"opacity", 0.5},
                                   {"colormap", {{80, 1, 0, 0}, {120, 0, 0, 1}}},
                                   {"opacitymap", {{90, 0}, {110, 0.2}}}}}}});
    std::ofstream(folder_ / "state.json") << nlohmann::json{
        {"Datasets", {{{"name", "v"}, {"type", "Volume"}, {"filename", "v.json"}}}},
        {"Visualizations", visualizations},
        {"Camera", {{"viewpoint", {60, 40, 80}}, {"viewcenter", {16, 16, 16}}, {"dimensions", {64, 48}}}}};
    const std::string command = "cd " + folder_.string() +
                                " && rm -f p_* && " GXYRENDER
                                " state.json -q -o p --backend embree --format raw --stats stats.json";
    if (std::system(command.c_str()) != 0) return {};
    return nlohmann::json::parse(std::ifstream(folder_ / "stats.json")).at("ranks").at(0);
  }
  std::string picture(int number) const {
    std::ifstream in(folder_ / ("p_0000" + std::to_string(number) + ".raw"), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  static int64_t bytesOf(int64_t components) {
    return int64_t(Bricks({kSide, kSide, kSide}).count()) * 4 * components +
           kMacrocells * (components > 1 ? components + 1 : 1) * int64_t(sizeof(Macrocell));
  }

  const test::TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

TEST_F(ComponentsShown, AreKeptAndTheOthersAreNot) {
  writeVolume<float>("float");
  const auto one = render({2});
  const std::string alone = picture(0);
  EXPECT_EQ(alone.size(), 64u * 48 * 16);
  EXPECT_EQ(one.at("memory").at("ledger").at("volume"), bytesOf(1));
  EXPECT_EQ(one.at("skipped").at("components"), 3);
  EXPECT_EQ(one.at("skipped").at("sample bytes"), kPoints * 3 * 4);

  const auto two = render({2, 0, 2});
  EXPECT_EQ(two.at("memory").at("ledger").at("volume"), bytesOf(2));
  EXPECT_EQ(two.at("skipped").at("components"), 2);
  EXPECT_EQ(picture(0), alone);
  EXPECT_NE(picture(1), alone);
  EXPECT_EQ(picture(2), alone);

  const auto all = render({2, "magnitude"});
  EXPECT_EQ(all.at("memory").at("ledger").at("volume"), bytesOf(4));
  EXPECT_EQ(all.at("skipped").at("components"), 0);
  EXPECT_EQ(picture(0), alone);
}

TEST_F(ComponentsShown, HaveTheSamePicturesInWideTypes) {
  writeVolume<double>("double");
  render({1});
  const std::string alone = picture(0);
  render({1, "magnitude"});
  EXPECT_EQ(picture(0), alone);
  EXPECT_FALSE(alone.empty());
}

TEST_F(ComponentsShown, MustBeThere) {
  writeVolume<float>("float");
  EXPECT_EQ(render({4}), nullptr);
}

}  // namespace
}  // namespace gxy
