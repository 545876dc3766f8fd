// SPDX-License-Identifier: Apache-2.0
// What gxyrender --stats says of memory: the ledger to the byte where arithmetic gives it, and beside it the process.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/data/volume.h"
#include "tests/support/temporary_folder.h"

namespace gxy {
namespace {

constexpr int64_t kPoints = 256, kWidth = 320, kHeight = 200;

class RenderMemory : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(folder_ / "zero.raw").close();
    std::filesystem::resize_file(folder_ / "zero.raw", uint64_t(kPoints * kPoints * kPoints) * 4);
    std::ofstream(folder_ / "zero.json")
        << R"({"type": "float", "origin": [0, 0, 0], "delta": [1, 1, 1], "counts": [256, 256, 256],
               "rawdata": "zero.raw"})";
    std::ofstream(folder_ / "state.json") << R"({
      "Datasets": {"name": "zero", "type": "Volume", "filename": "zero.json"},
      "Visualization": {"operators": [{"type": "Volume", "dataset": "zero", "volume rendering": true,
        "colormap": [[0, 1, 1, 1]], "extinctionmap": [[0, 0.001]]}]},
      "Camera": {"viewpoint": [128, 128, 700], "viewcenter": [128, 128, 128], "dimensions": [320, 200]}})";
  }

  nlohmann::json memoryOf(const std::string& options) const {
    const std::string command = "cd " + folder_.string() + " && " GXYRENDER +
                                " state.json -q -o p --format raw --stats stats.json " + options;
    if (std::system(command.c_str()) != 0) return {};
    return nlohmann::json::parse(std::ifstream(folder_ / "stats.json")).at("ranks").at(0).at("memory");
  }

  const test::TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

TEST_F(RenderMemory, IsInTheLedgerByPurpose) {
  const nlohmann::json memory = memoryOf("--depth");
  const int64_t macrocells = 32 * 32 * 32;  // of 255^3 cells
  EXPECT_EQ(memory.at("ledger").at("volume"),
            kPoints * kPoints * kPoints * 4 + macrocells * int64_t(sizeof(Macrocell)));
  EXPECT_EQ(memory.at("ledger peaks").at("framebuffer"), kWidth * kHeight * (32 + 8));
  EXPECT_EQ(memory.at("ledger peaks").at("picture"), kWidth * kHeight * (16 + 8));
  EXPECT_GE(memory.at("ledger").at("scene"), macrocells);  // a byte of the step plan each
  EXPECT_GT(memory.at("ledger peaks").at("rays"), 0);
}

// All samples are touched, so the process grows by them; what else it grows by is less than half as much again.
TEST_F(RenderMemory, OfTheProcessGrowsByWhatTheLedgerSays) {
  const nlohmann::json memory = memoryOf("");
  const int64_t total = memory.at("ledger total"), before = memory.at("process before data");
  EXPECT_GE(memory.at("process").get<int64_t>() - before, total * 9 / 10);
  EXPECT_LE(memory.at("process peak").get<int64_t>() - before, total * 3 / 2);
}

}  // namespace
}  // namespace gxy
