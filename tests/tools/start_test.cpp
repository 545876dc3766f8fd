// SPDX-License-Identifier: Apache-2.0
// What programs load: OpenImageIO, VTK and what they bring only when they are needed, and Open MPI's parts that move data
// between processes only where there are several.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/support/temporary_folder.h"

namespace gxy {
namespace {

class Start : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(folder_ / "zero.raw") << std::string(8 * 8 * 8 * 4, '\0');
    std::ofstream(folder_ / "zero.json")
        << R"({"type": "float", "origin": [0, 0, 0], "delta": [1, 1, 1], "counts": [8, 8, 8], "rawdata": "zero.raw"})";
    std::ofstream(folder_ / "scene.json") << sceneOf("zero.json");
  }

  static std::string sceneOf(const std::string& file) {
    return R"({"Datasets": {"name": "zero", "type": "Volume", "filename": ")" + file + R"("},
      "Visualization": {"operators": [{"type": "Volume", "dataset": "zero", "isovalues": [0.5]}]},
      "Camera": {"viewpoint": [4, 4, 30], "viewcenter": [4, 4, 4], "dimensions": [16, 16]}})";
  }

  /// Runs a command in the folder; its exit status. What it says is in the file `said`.
  int run(const std::string& command) const {
    const int status = std::system(("cd " + folder_.string() + " && " + command + " >said 2>&1").c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  std::string said() const {
    std::stringstream text;
    text << std::ifstream(folder_ / "said").rdbuf();
    return text.str();
  }

  /// File names of the shared libraries that the program initialised, those opened later among them.
  std::set<std::string> librariesOf(const std::string& command) const {
    EXPECT_EQ(run("LD_DEBUG=libs LD_DEBUG_OUTPUT=loaded exec " + command), 0) << said();
    std::set<std::string> names;
    for (const auto& file : std::filesystem::directory_iterator(folder_)) {
      if (file.path().stem() != "loaded") continue;  // loaded.PID
      std::ifstream in(file.path());
      for (std::string line; std::getline(in, line);)
        if (const auto at = line.find("calling init: "); at != line.npos)
          names.insert(std::filesystem::path(line.substr(at + 14)).filename().string());
      std::filesystem::remove(file.path());
    }
    return names;
  }

  static std::string beginning(const std::set<std::string>& names, const std::vector<std::string>& prefixes) {
    std::string found;
    for (const std::string& name : names)
      for (const std::string& prefix : prefixes)
        if (name.starts_with(prefix)) found += name + " ";
    return found;
  }

  const test::TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

const std::vector<std::string> kLarge{"libOpenImageIO", "libOpenEXR",  "libvtk",
                                      "libX11",         "libOpenCL",   "libvulkan_",
                                      "libLLVM",        "mca_btl_tcp", "mca_btl_vader"};

TEST_F(Start, APngOfARawVolumeTakesAtMost60LibrariesAnd60Megabytes) {
  const std::set<std::string> loaded = librariesOf(GXYRENDER " scene.json -q --stats stats.json");
  EXPECT_LE(loaded.size(), 60u) << ::testing::PrintToString(loaded);
  EXPECT_GE(loaded.size(), 10u);  // they are counted at all
  EXPECT_EQ(beginning(loaded, kLarge), "");
  const auto stats = nlohmann::json::parse(std::ifstream(folder_ / "stats.json"));
  EXPECT_LT(stats.at("ranks").at(0).at("memory").at("process before data").get<int64_t>(), 60'000'000);
}

TEST_F(Start, HelpLoadsNothingThatItDoesNotNeed) {
  for (const char* program : {GXYRENDER, GXYSERVER, GXYDATA, GXYDIFF, MSDATA}) {
    const std::set<std::string> loaded = librariesOf(std::string(program) + " --help");
    EXPECT_LE(loaded.size(), 32u) << program << ::testing::PrintToString(loaded);
    EXPECT_EQ(beginning(loaded, kLarge) + beginning(loaded, {"mca_"}), "") << program;
  }
}

TEST_F(Start, VtkIsLoadedForItsFilesAndOpenImageIoForOtherFormats) {
  ASSERT_EQ(run(GXYDATA " radial -r 8 ball.vti"), 0) << said();
  std::ofstream(folder_ / "ball-scene.json") << sceneOf("ball.vti");
  const std::set<std::string> vti = librariesOf(GXYRENDER " ball-scene.json -q");
  EXPECT_TRUE(vti.contains("libgalaxy_vtk.so"));
  EXPECT_NE(beginning(vti, {"libvtkIOXML"}), "");
  EXPECT_EQ(beginning(vti, {"libOpenImageIO"}), "");
  const std::set<std::string> exr = librariesOf(GXYRENDER " scene.json -q --format exr");
  EXPECT_TRUE(exr.contains("libgalaxy_image.so"));
  EXPECT_NE(beginning(exr, {"libOpenImageIO"}), "");
  EXPECT_EQ(beginning(exr, {"libvtk"}), "");
}

TEST_F(Start, AMissingPluginIsNamedWithItsPlaceAndPurpose) {
  ASSERT_EQ(run(GXYRENDER " scene.json -q"), 0) << said();
  std::filesystem::copy(GXYDIFF, folder_ / "gxydiff");  // beside it there is no ../lib/galaxy
  EXPECT_NE(run("./gxydiff image_00000.png image_00000.png"), 0);
  EXPECT_NE(
      said().find(
          "image_00000.png: reading it needs Galaxy's library libgalaxy_image.so, expected in lib/galaxy"),
      std::string::npos)
      << said();
}

}  // namespace
}  // namespace gxy
