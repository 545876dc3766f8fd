// SPDX-License-Identifier: Apache-2.0
// A volume of more than 2^31 samples, looked at where its indices no longer fit into 32 bits. The file is sparse: zeros
// but for a ramp in the far corner, which a trilinear field repeats exactly, so that every pixel is known.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "core/image/image.h"

namespace gxy {
namespace {

constexpr int64_t kPoints = 1300, kFirst = kPoints - 24;  // of the ramp, on each axis
constexpr double kMiddle = 3 * 1288;                      // value = x + y + z - kMiddle
constexpr int kPixels = 32;
constexpr double kWindow = 12, kCentre = 1288, kEye = 1400, kSlice = 1290.25, kIsovalue = -2, kClip = 1280;
constexpr double kExtinction = 0.0015;  // times value + 40

static_assert(kPoints * kPoints * kPoints > int64_t(1) << 31);
static_assert((kFirst * kPoints + kFirst) * kPoints + kFirst > int64_t(1) << 31);

double placeOf(int pixel) { return kCentre + (pixel + 0.5 - kPixels / 2) * kWindow / kPixels; }
double valueAt(double x, double y, double z) { return x + y + z - kMiddle; }

class LargeVolume : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(LARGE_VOLUME_FOLDER);
    std::filesystem::current_path(LARGE_VOLUME_FOLDER);
    const int file = ::open("ramp.raw", O_CREAT | O_TRUNC | O_WRONLY, 0644);
    ASSERT_GE(file, 0);
    ASSERT_EQ(::ftruncate(file, kPoints * kPoints * kPoints), 0);
    std::vector<int8_t> row(kPoints - kFirst);
    for (int64_t k = kFirst; k < kPoints; ++k)
      for (int64_t j = kFirst; j < kPoints; ++j) {
        for (size_t i = 0; i < row.size(); ++i)
          row[i] = int8_t(valueAt(double(kFirst) + double(i), double(j), double(k)));
        const int64_t at = (k * kPoints + j) * kPoints + kFirst;
        ASSERT_EQ(::pwrite(file, row.data(), row.size(), at), ssize_t(row.size()));
      }
    ASSERT_EQ(::close(file), 0);
    const std::string n = std::to_string(kPoints);
    std::ofstream("ramp.json") << R"({"type": "int8", "origin": [0, 0, 0], "delta": [1, 1, 1], "counts": [)"
                               << n << ", " << n << ", " << n << R"(], "rawdata": "ramp.raw"})";
    const std::string look =
        R"("type": "Volume", "dataset": "ramp", "colormap": [[-40, 0, 0, 0], [40, 1, 1, 1]])";
    const std::string lit =
        R"("Lighting": {"Sources": [[0, 0, -1, 0]], "Ka": 1, "Kd": 0}, "operators": [{)" + look;
    std::ofstream("state.json")
        << R"({"Datasets": {"name": "ramp", "type": "Volume", "filename": "ramp.json"},
 "Renderer": {"background": [0, 0, 0, 0]},
 "Visualizations": [
  {"annotation": "-slice", )"
        << lit << R"(, "slices": [[0, 0, 1, )" << kSlice << R"(]]}]},
  {"annotation": "-isosurface", )"
        << lit << R"(, "isovalues": [)" << kIsovalue << R"(]}]},
  {"annotation": "-volume", "operators": [{"type": "Volume", "dataset": "ramp", "volume rendering": true,
   "colormap": [[-40, 1, 1, 1], [40, 1, 1, 1]], "clip planes": [[0, 0, 1, )"
        << kClip << R"(]], "extinctionmap": [[-40, 0], [40, )" << 80 * kExtinction << R"(]]}]}],
 "Camera": {"viewpoint": [)"
        << kCentre << ", " << kCentre << ", " << kEye
        << R"(], "viewdirection": [0, 0, -1], "viewup": [0, 1, 0],
  "aov": 0, "height": )"
        << kWindow << R"(, "dimensions": [)" << kPixels << ", " << kPixels << "]}}";
  }
  void TearDown() override {
    std::filesystem::current_path("/");
    std::filesystem::remove_all(LARGE_VOLUME_FOLDER);
  }

  static int render(const std::string& name, int ranks, const std::string& options) {
    const std::string command = MPI_COMMAND " -n " + std::to_string(ranks) +
                                " " GXYRENDER " state.json -q -o " + name + " --format raw --depth " +
                                options;
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  static void check(const std::string& name) {
    const Image slice = picture(name, 0, "slice"), isosurface = picture(name, 1, "isosurface"),
                volume = picture(name, 2, "volume");
    std::vector<double> depth(kPixels * kPixels);
    std::ifstream(name + "_00001-isosurface.depth", std::ios::binary)
        .read(reinterpret_cast<char*>(depth.data()), std::streamsize(depth.size() * sizeof(double)));
    int hits = 0;
    for (int j = 0; j < kPixels; ++j)
      for (int i = 0; i < kPixels; ++i) {
        const double x = placeOf(i), y = placeOf(j);
        const size_t pixel = size_t(j * kPixels + i);
        ASSERT_NEAR(slice.rgba[4 * pixel], (valueAt(x, y, kSlice) + 40) / 80, 1e-4)
            << name << ' ' << i << ' ' << j;
        ASSERT_EQ(slice.rgba[4 * pixel + 3], 1.f);

        const double top = double(kPoints - 1);
        const double mean = valueAt(x, y, 0.5 * (kClip + top)) + 40;
        ASSERT_NEAR(volume.rgba[4 * pixel + 3], 1 - std::exp(-kExtinction * mean * (top - kClip)), 1.0 / 512)
            << name << ' ' << i << ' ' << j;

        const double z = kIsovalue + kMiddle - x - y;  // below the ramp's lower end other surfaces are met
        if (z < double(kFirst) + 1 || z > top - 0.01) continue;
        ++hits;
        ASSERT_NEAR(depth[pixel], kEye - z, 2e-3) << name << ' ' << i << ' ' << j;
        ASSERT_NEAR(isosurface.rgba[4 * pixel], (kIsovalue + 40) / 80, 1e-4) << name << ' ' << i << ' ' << j;
      }
    EXPECT_GT(hits, kPixels * kPixels / 2);
  }

 private:
  static Image picture(const std::string& name, int number, const std::string& what) {
    return readImage(name + "_0000" + std::to_string(number) + "-" + what + ".raw", kPixels, kPixels);
  }
};

TEST_F(LargeVolume, OfMoreThan2To31SamplesIsReadRightAtItsFarEnd) {
  ASSERT_EQ(render("one", 1, "--backend embree --partitions 1"), 0);
  check("one");
  ASSERT_EQ(render("automatic", 1, "--backend embree"), 0);
  check("automatic");
  ASSERT_EQ(render("partitions", 1, "--backend embree --partitions 1,3,2"), 0);
  check("partitions");
  ASSERT_EQ(render("ranks", 2, "--backend embree"), 0);
  check("ranks");
}

#ifdef TEST_DEVICE
// Of which a partition has up to 2^31; more is an error.
TEST_F(LargeVolume, OfMoreThan2To31SamplesIsReadRightOnVulkanToo) {
  const std::string options = "--backend vulkan --device " TEST_DEVICE;
  ASSERT_EQ(render("ranks", 2, options), 0);
  check("ranks");
  ASSERT_EQ(render("partitions", 1, options + " --partitions 1,1,2"), 0);
  check("partitions");
  EXPECT_EQ(render("one", 1, options + " --partitions 1 >one.log 2>&1"), 1);
  std::ifstream log("one.log");
  const std::string said{std::istreambuf_iterator<char>(log), {}};
  EXPECT_NE(said.find("expected up to 2^31 points"), std::string::npos) << said;
}
#endif

}  // namespace
}  // namespace gxy
