// SPDX-License-Identifier: Apache-2.0
// gxyrender against gxyrender --reference: within the tolerance, with ambient occlusion and shadows too.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/temporary_folder.h"

namespace gxy {
namespace {

constexpr int kWidth = 40, kHeight = 30;
constexpr double kTolerance = 1.0 / 512;  // the default

std::vector<float> readPicture(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::vector<float> rgba(4 * kWidth * kHeight);
  in.read(reinterpret_cast<char*>(rgba.data()), std::streamsize(rgba.size() * sizeof(float)));
  return in ? rgba : std::vector<float>();
}

/// A floor below a roof that hides half of it, both translucent, so that most rays have several hits.
nlohmann::json sheetsUnderLamp() {
  return {{"Datasets", {{{"name", "sheets"}, {"type", "Triangles"}, {"filename", "sheets.obj"}}}},
          {"Renderer", {{"rays per pixel", 2}}},
          {"Visualization",
           {{"Lighting",
             {{"Sources", {{0.3, 2, 1, 2}}},
              {"shadows", true},
              {"ao count", 6},
              {"ao radius", 3},
              {"Ka", 0.7},
              {"Kd", 0.3}}},
            {"operators", {{{"type", "Triangles"}, {"dataset", "sheets"}, {"opacity", 0.75}}}}}},
          {"Camera", {{"viewpoint", {1.5, 4, 6}}, {"viewcenter", {0, 0, 0}}, {"aov", 25}}}};
}

TEST(ReferenceRun, ShadesWithTheRenderersOcclusionRays) {
  const test::TemporaryFolder temporary;
  const std::filesystem::path folder = temporary.path();
  std::ofstream(folder / "sheets.obj") << "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\n"
                                          "v -1 0.5 -1\nv 0.1 0.7 -1\nv 0.1 0.7 1\nv -1 0.5 1\n"
                                          "f 1 2 3\nf 1 3 4\nf 5 6 7\nf 5 7 8\n";
  std::ofstream(folder / "state.json") << sheetsUnderLamp();
  const std::string common =
      " state.json -q --format raw --size " + std::to_string(kWidth) + "x" + std::to_string(kHeight);
  const std::string command = "cd " + folder.string() + " && " GXYRENDER + common + " -o a && " GXYRENDER +
                              common + " -o b --reference";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const std::vector<float> a = readPicture(folder / "a_00000.raw"), b = readPicture(folder / "b_00000.raw");
  ASSERT_FALSE(a.empty());
  ASSERT_FALSE(b.empty());
  int wrong = 0, occluded = 0;
  for (size_t i = 0; i < a.size(); i += 4) {
    bool differs = false;
    for (size_t c = i; c < i + 4; c++) differs = differs || !(std::abs(a[c] - b[c]) <= kTolerance);
    wrong += differs;
    occluded += b[i + 3] > 0.9 && b[i] < 0.5;
  }
  EXPECT_LE(wrong, kWidth * kHeight / 1000) << "flips: pixels whose rays graze an edge";
  EXPECT_GT(occluded, 100);
}

}  // namespace
}  // namespace gxy
