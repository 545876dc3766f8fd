// SPDX-License-Identifier: Apache-2.0
// What gxyrender shows of data without a state file: the object fills the picture, bright and dark, with smooth edges.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "core/io/write_geometry.h"
#include "tests/support/temporary_folder.h"

namespace gxy {
namespace {

constexpr int kSide = 128;

struct Pixels {
  std::vector<float> rgba;

  bool isObject(int x, int y) const {
    const float* p = at(x, y);
    const float* background = rgba.data();  // a corner: the object fills nine tenths at most
    float most = 0;
    for (int c = 0; c < 3; c++) most = std::max(most, std::abs(p[c] - background[c]));
    return most > 0.02f;
  }
  const float* at(int x, int y) const { return rgba.data() + 4 * (size_t(y) * kSide + size_t(x)); }
  double brightness(int x, int y) const {
    const float* p = at(x, y);
    return 0.2126 * double(p[0]) + 0.7152 * double(p[1]) + 0.0722 * double(p[2]);
  }

  /// The longer side of the object's box, of the picture's.
  double extent() const {
    int lo[2] = {kSide, kSide}, hi[2] = {-1, -1};
    for (int y = 0; y < kSide; y++)
      for (int x = 0; x < kSide; x++) {
        if (!isObject(x, y)) continue;
        lo[0] = std::min(lo[0], x), hi[0] = std::max(hi[0], x);
        lo[1] = std::min(lo[1], y), hi[1] = std::max(hi[1], y);
      }
    return std::max(hi[0] - lo[0], hi[1] - lo[1]) / double(kSide);
  }
  double covered() const {
    int n = 0;
    for (int y = 0; y < kSide; y++)
      for (int x = 0; x < kSide; x++) n += isObject(x, y);
    return n / double(kSide * kSide);
  }
  /// From the 2nd to the 98th hundredth of the object's brightness.
  double span() const {
    std::vector<double> values;
    for (int y = 0; y < kSide; y++)
      for (int x = 0; x < kSide; x++)
        if (isObject(x, y)) values.push_back(brightness(x, y));
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    return values[size_t(0.98 * double(values.size() - 1))] -
           values[size_t(0.02 * double(values.size() - 1))];
  }
  /// The part of the object's left edges where a pixel lies between background and what is right of it.
  double smoothEdges() const {
    int edges = 0, between = 0;
    for (int y = 0; y < kSide; y++)
      for (int x = 1; x + 1 < kSide; x++) {
        if (isObject(x - 1, y) || !isObject(x, y) || !isObject(x + 1, y)) continue;
        const double background = brightness(0, 0), inside = brightness(x + 1, y) - background;
        const double part = (brightness(x, y) - background) / inside;
        edges++;
        between += part > 0.05 && part < 0.9;
      }
    return edges ? double(between) / edges : 0;
  }
};

class FirstPicture : public ::testing::Test {
 protected:
  int call(const std::string& command) const {
    return std::system(("cd '" + folder_.path().string() + "' && " + command).c_str());
  }
  Pixels render(const std::string& files, const std::string& options = "") const {
    Pixels pixels;
    const std::string size = std::to_string(kSide) + "x" + std::to_string(kSide);
    if (call(GXYRENDER " " + files + " -q -o p --format raw --backend embree --size " + size + " " +
             options) != 0)
      return pixels;
    std::ifstream in(folder_.path() / "p_00000.raw", std::ios::binary);
    pixels.rgba.resize(size_t(4) * kSide * kSide);
    in.read(reinterpret_cast<char*>(pixels.rgba.data()), std::streamsize(pixels.rgba.size() * sizeof(float)));
    return pixels;
  }
  void expectGood(const Pixels& pixels, bool smooth = true) const {
    ASSERT_FALSE(pixels.rgba.empty());
    EXPECT_GE(pixels.extent(), 0.4);
    EXPECT_LE(pixels.extent(), 0.9);
    EXPECT_GE(pixels.span(), 0.5);
    if (smooth) {
      EXPECT_GT(pixels.smoothEdges(), 0.2);
    }
  }

  /// `value` of a point of [-1, 1]^3, in components.
  template <class T>
  void writeVolume(const std::string& name, const char* type, int components,
                   const std::function<std::vector<double>(glm::dvec3)>& value) const {
    constexpr int n = 40;
    std::ofstream raw(folder_.path() / (name + ".raw"), std::ios::binary);
    for (int i = 0; i < n * n * n; i++) {
      const glm::dvec3 p = glm::dvec3(i % n, i / n % n, i / n / n) * (2.0 / (n - 1)) - 1.0;
      for (const double v : value(p)) {
        const T t = T(v);
        raw.write(reinterpret_cast<const char*>(&t), sizeof t);
      }
    }
    std::ofstream(folder_.path() / (name + ".json"))
        << nlohmann::json{{"type", type},
                          {"origin", {-1, -1, -1}},
                          {"delta", {2.0 / (n - 1), 2.0 / (n - 1), 2.0 / (n - 1)}},
                          {"counts", {n, n, n}},
                          {"rawdata", name + ".raw"},
                          {"number of components", components}};
  }

  const test::TemporaryFolder folder_;
};

double bump(glm::dvec3 p, glm::dvec3 at, double width) {
  const glm::dvec3 d = p - at;
  return std::exp(-(d.x * d.x + d.y * d.y + d.z * d.z) / (width * width));
}

/// Nearly empty with a few peaks: mean about 0.6, at most about 115.
double clumps(glm::dvec3 p) {
  return 0.05 + 115 * bump(p, {0.2, 0.1, 0}, 0.12) + 20 * bump(p, {-0.4, -0.3, 0.2}, 0.2) +
         3 * bump(p, {0, 0, -0.2}, 0.5) + 0.5 * bump(p, {-0.1, 0.2, 0.1}, 0.9);
}

TEST_F(FirstPicture, NearlyEmptyVolumeWithALongTail) {
  writeVolume<float>("v", "float", 1, [](glm::dvec3 p) { return std::vector<double>{clumps(p)}; });
  expectGood(render("v.json"), false);
  expectGood(render("v.json", "--iso 0.7"));
}

TEST_F(FirstPicture, ABrightVesselInNoiseIsSeenWithoutTheNoise) {
  std::minstd_rand random(7);
  const auto uniform = [&random] { return double(random() % 10000) / 10000; };
  writeVolume<float>("v", "float", 1, [&](glm::dvec3 p) {
    const double noise = 20 + 40 * (uniform() + uniform() + uniform());
    const double away = std::hypot(p.y - 0.4 * std::sin(3 * p.x), p.z - 0.3 * std::cos(2 * p.x));
    return std::vector<double>{noise + 500 * std::exp(-away * away / 0.02)};
  });
  const Pixels pixels = render("v.json");
  expectGood(pixels, false);
  EXPECT_LT(pixels.covered(), 0.25) << "the noise is everywhere";
  EXPECT_GT(pixels.covered(), 0.05);
}

TEST_F(FirstPicture, VolumeOfBytes) {
  writeVolume<uint8_t>("v", "uchar", 1, [](glm::dvec3 p) {
    return std::vector<double>{255 * bump(p, {0, 0, 0}, 0.6)};
  });
  expectGood(render("v.json"), false);
  expectGood(render("v.json", "--slice"), false);
}

TEST_F(FirstPicture, AnImageIsSeenStraightOn) {
  std::ofstream(folder_.path() / "v.vtk")
      << "# vtk DataFile Version 3.0\nv\nASCII\nDATASET STRUCTURED_POINTS\n"
         "DIMENSIONS 4 1 3\nSPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 12\n"
         "SCALARS s float\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7 8 9 10 11\n";
  const Pixels pixels = render("v.vtk");
  expectGood(pixels);
  // The box, 1 thick, is fitted; the slice is in its middle.
  const double distance = 1.5 / (0.88 * std::tan(std::numbers::pi / 12)),
               side = 0.88 * distance / (distance + 0.5);
  EXPECT_NEAR(pixels.covered(), side * side * 2 / 3, 0.02);
}

TEST_F(FirstPicture, VectorFieldByItsMagnitude) {
  writeVolume<float>("v", "float", 3, [](glm::dvec3 p) {
    const double speed = 30 * bump(p, {0, 0, p.z}, 0.4);
    return std::vector<double>{-p.y * speed, p.x * speed, 0.2 * speed};
  });
  expectGood(render("v.json"), false);
}

TEST_F(FirstPicture, VolumeWithSpreadValues) {
  ASSERT_EQ(call(GXYDATA " radial -r 32 --array oneBall v.vti"), 0);
  expectGood(render("v.vti"), false);
}

TEST_F(FirstPicture, MeshWithAndWithoutValues) {
  ASSERT_EQ(call(GXYDATA " sphere-mesh -r 48 --displacement 0.2 g.vtp && " GXYDATA " convert g.vtp bare.stl"),
            0);
  expectGood(render("g.vtp"));
  expectGood(render("bare.stl"));
}

// A flat square that is green and, above the middle, red.
TEST_F(FirstPicture, MeshInColoursOfItsOwn) {
  std::ofstream file(folder_.path() / "g.off");
  file << "OFF\n6 2 0\n-1 -1 0\n1 -1 0\n1 0 0\n-1 0 0\n1 1 0\n-1 1 0\n4 0 1 2 3 0 255 0\n4 3 2 4 5 255 0 0\n";
  file.close();
  const Pixels pixels = render("g.off");
  ASSERT_FALSE(pixels.rgba.empty());
  EXPECT_NEAR(pixels.extent(), 0.88, 0.03);
  for (const int y : {kSide / 4, 3 * kSide / 4}) {
    const float* p = pixels.at(kSide / 2, y);
    const bool red = y > kSide / 2;
    EXPECT_GT(p[red ? 0 : 1], 0.5f);
    EXPECT_EQ(p[red ? 1 : 0], 0);
    EXPECT_EQ(p[2], 0);
  }
}

TEST_F(FirstPicture, LinesAreTubes) {
  ASSERT_EQ(call(GXYDATA " helix -r 3 g.vtp"), 0);
  expectGood(render("g.vtp"));
}

TEST_F(FirstPicture, PointsWithOutliers) {
  GeometryBlock block;
  for (int n = 0; n < 3000; n++) {
    const double z = 1 - 2 * (n + 0.5) / 3000,
                 r = std::sqrt(1 - z * z) * std::cbrt((n * 7919 % 3000 + 1) / 3000.0);
    block.points.push_back({r * std::cos(2.4 * n), r * std::sin(2.4 * n), z});
    block.values.push_back(float(z));
  }
  for (int n = 0; n < 10; n++) {
    block.points.push_back({1e4 * n, -3e4, 2e5});
    block.values.push_back(0);
  }
  for (size_t n = 0; n < block.points.size(); n++) block.ids.push_back(n);
  writeGeometry((folder_.path() / "g.vtp").string(), block, GeometryKind::Particles, "z");
  expectGood(render("g.vtp"));
}

TEST_F(FirstPicture, PointsInAClusterWithAFewBrightOnes) {
  std::minstd_rand random(11);
  const auto uniform = [&random] { return double(random() % 10000 + 1) / 10001; };
  GeometryBlock block;
  for (size_t n = 0; n < 1500; n++) {
    const double z = 2 * uniform() - 1, turn = 2 * std::numbers::pi * uniform();
    const double r = 1000 * std::pow(uniform(), 1.5);  // the density falls as r^-2.3
    const double across = std::sqrt(1 - z * z);
    block.points.push_back(glm::dvec3(across * std::cos(turn), across * std::sin(turn), z) * r);
    block.values.push_back(float(std::pow(uniform(), -1.5)));  // as luminosities
    block.ids.push_back(n);
  }
  writeGeometry((folder_.path() / "g.vtp").string(), block, GeometryKind::Particles, "lum");
  expectGood(render("g.vtp"));
}

TEST_F(FirstPicture, SceneFileGivesTheSamePicture) {
  ASSERT_EQ(call(GXYDATA " radial -r 16 --array eightBalls v.vti && " GXYDATA " helix -r 2 g.vtp && " GXYDATA
                         " scene v.vti g.vtp --iso auto > scene.json"),
            0);
  const Pixels files = render("v.vti g.vtp", "--iso auto"), scene = render("scene.json");
  ASSERT_FALSE(files.rgba.empty());
  EXPECT_EQ(files.rgba, scene.rgba);
  const auto state = nlohmann::json::parse(std::ifstream(folder_.path() / "scene.json"));
  EXPECT_EQ(state.at("Cameras").at(0).at("fit"), true);
  EXPECT_EQ(state.at("Visualizations").at(0).at("operators").at(1).at("radius"), "auto");
}

TEST_F(FirstPicture, RadiiMayComeFromAnotherArrayThanColours) {
  std::ofstream table(folder_.path() / "p.csv");
  table << "x,y,z,size,heat\n";
  for (int i = 0; i < 30; i++) table << i % 6 << ',' << i / 6 << ",0," << i / 30.0 << ",0.5\n";
  table.close();
  const auto scene = [&](const char* name, const std::string& arrays) {
    std::ofstream(folder_.path() / name)
        << R"({"Datasets": [{"name": "p", "type": "Particles", "filename": "p.csv", )" + arrays + R"(}],
  "Visualization": {"operators": [{"type": "Particles", "dataset": "p", "colormap": [[0.5, 0.9, 0.5, 0.1]],
  "radius0": 0.05, "radius1": 0.6, "value0": 0, "value1": 1}]}})";
  };
  scene("two.json", R"("array": "heat", "radius array": "size")");
  scene("one.json", R"("array": "size")");  // as its map has one colour
  scene("same.json", R"("array": "heat")");
  const Pixels two = render("two.json"), one = render("one.json"), same = render("same.json");
  ASSERT_FALSE(two.rgba.empty());
  EXPECT_EQ(two.rgba, one.rgba);
  EXPECT_NE(two.rgba, same.rgba);
  scene("none.json", R"("array": "heat", "radius array": "sise")");
  EXPECT_EQ(WEXITSTATUS(call(GXYRENDER " none.json -q -o n 2>error.txt")), 1);
  std::ifstream in(folder_.path() / "error.txt");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  EXPECT_NE(text.find("no array 'sise' of points with values for radii; the file has 'size', 'heat'"),
            std::string::npos)
      << text;
}

TEST_F(FirstPicture, AnOperatorMayShowAnotherArrayThanItsDataset) {
  std::ofstream table(folder_.path() / "p.csv");
  table << "x,y,z,size,heat,v:0,v:1,second\n";
  for (int i = 0; i < 30; i++)
    table << i % 6 << ',' << i / 6 << ",0," << i / 30.0 << ',' << i * 7 % 30 << ',' << i * 11 % 30 / 32.0
          << ',' << -i / 32.0 << ',' << -i / 32.0 << "\n";
  table.close();
  const auto scene = [&](const char* name, const std::string& dataset, const std::string& vis) {
    std::ofstream(folder_.path() / name)
        << R"({"Datasets": [{"name": "p", "type": "Particles", "filename": "p.csv", )" + dataset + R"(}],
  "Visualization": {"operators": [{"type": "Particles", "dataset": "p", "colormap": "Viridis", "data range": "data",
  "radius0": 0.05, "radius1": 0.6, "value0": -1, "value1": 1, )" +
               vis + R"(}]}})";
    return render(name);
  };
  const std::string fields = R"("array": "heat", "fields": ["size", "v"])";
  const Pixels size = scene("size.json", R"("array": "size")", R"("two sided": true)");
  ASSERT_FALSE(size.rgba.empty());
  EXPECT_EQ(scene("array.json", fields, R"("array": "size")").rgba, size.rgba);
  EXPECT_NE(scene("heat.json", fields, R"("array": "heat")").rgba, size.rgba);
  EXPECT_EQ(scene("heat.json", fields, R"("array": "heat")").rgba,
            scene("usual.json", R"("array": "heat")", R"("two sided": true)").rgba);
  EXPECT_EQ(scene("mag.json", fields, R"("array": "v")").rgba,
            scene("vector.json", R"("array": "v")", R"("two sided": true)").rgba);
  EXPECT_EQ(scene("part.json", fields, R"("array": "v", "component": 1)").rgba,
            scene("second.json", R"("array": "second")", R"("two sided": true)").rgba);
  std::ofstream(folder_.path() / "none.json") << R"({"Datasets": [{"name": "p", "type": "Particles",
    "filename": "p.csv", "array": "heat", "fields": "size"}],
    "Visualization": {"operators": [{"type": "Particles", "dataset": "p", "array": "sise"}]}})";
  EXPECT_EQ(WEXITSTATUS(call(GXYRENDER " none.json -q -o n 2>error.txt")), 1);
  std::ifstream in(folder_.path() / "error.txt");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  EXPECT_NE(
      text.find("there is no array \"sise\" of points; expected one of those there are: \"heat\", \"size\""),
      std::string::npos)
      << text;
}

TEST_F(FirstPicture, SeriesIsAPictureForEachFileInColoursOfTheFirst) {
  ASSERT_EQ(call(GXYDATA " radial -r 8 -t 3 --array x s.vti && " GXYRENDER
                         " 's_*.vti' -q -o p --backend embree --size 16x16"),
            0);
  for (const char* name : {"p_00000.png", "p_00001.png", "p_00002.png"})
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / name)) << name;
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "p_00003.png"));
}

TEST_F(FirstPicture, AnnotatedPicturesOfACollectionHaveTheirStepsAndTimes) {
  ASSERT_EQ(call(GXYDATA " radial -r 16 --array oneBall v.vti && " GXYDATA " scene v.vti >scene.json"), 0);
  std::ofstream(folder_.path() / "run.pvd")
      << "<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"0.5\" file=\"v.vti\"/>"
         "<DataSet timestep=\"2.25\" file=\"v.vti\"/></Collection></VTKFile>";
  const auto annotated = [&](const std::string& files, const std::string& prefix) {
    return call(GXYRENDER " " + files + " -q --annotate --format raw --backend embree --size 128x128 -o " +
                prefix);
  };
  ASSERT_EQ(annotated("run.pvd", "p"), 0);
  nlohmann::json state;
  std::ifstream(folder_.path() / "scene.json") >> state;
  for (const auto& [number, text] : {std::pair("0", "step 0, time 0.5"), {"1", "step 1, time 2.25"}}) {
    state["Annotations"]["text"] = text;
    std::ofstream(folder_.path() / "said.json") << state;
    ASSERT_EQ(annotated("said.json", "said"), 0);
    EXPECT_EQ(call(std::string("cmp said_00000.raw p_0000") + number + ".raw"), 0) << text;
  }
  EXPECT_NE(call("cmp -s p_00000.raw p_00001.raw"), 0);
}

// Programs that start at the same time would meet in Open MPI's directory, below the one of temporary files.
TEST_F(FirstPicture, NeedsNoDirectoryThatProgramsShare) {
  ASSERT_EQ(call(GXYDATA " helix -r 1 g.vtp"), 0);
  const Pixels pixels = render("g.vtp");
  ASSERT_FALSE(pixels.rgba.empty());
  setenv("TMPDIR", "/dev/null/none", 1);
  const Pixels without = render("g.vtp");
  unsetenv("TMPDIR");
  EXPECT_EQ(without.rgba, pixels.rgba);
}

TEST_F(FirstPicture, WhatCannotBeShownIsOneErrorAndStatus1) {
  std::ofstream(folder_.path() / "n.json") << R"({"a": 1})";
  std::ofstream(folder_.path() / "s.json") << R"({"Visualization": {"operators": []}})";
  for (const auto& [files, said] : {std::pair("nothing.vti", "no such file"),
                                    {"'x_*.vti'", "no file matches"},
                                    {".", "directory"},
                                    {"n.json", "neither a state file"},
                                    {"s.json s.json", "expected it alone"},
                                    {"s.json --slice", "for data files"},
                                    {"s.json --array density", "for data files"}}) {
    EXPECT_EQ(WEXITSTATUS(call(std::string(GXYRENDER " ") + files + " 2>error.txt")), 1) << files;
    std::ifstream in(folder_.path() / "error.txt");
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    EXPECT_NE(text.find(said), std::string::npos) << text;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
  }
  for (const char* wrong : {"--iso much", "--size 3", "--size 0x5", "--partitions 2,2", "--partitions none",
                            "--reference --stats x", "--format gif", "--nosuch"})
    EXPECT_EQ(WEXITSTATUS(call(std::string(GXYRENDER " v.vti ") + wrong + " 2>error.txt")), 2) << wrong;
}

}  // namespace
}  // namespace gxy
