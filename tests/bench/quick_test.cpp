// SPDX-License-Identifier: Apache-2.0
// gxybench as a user runs it: exit status, files, and errors against the reference. Timings are not looked
// at.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <set>

#include "tests/bench/rows.h"

namespace gxy::bench::test {
namespace {

int gxybench(const std::string& arguments, const std::string& output = "/dev/null") {
  const std::string command = std::string(GXYBENCH) + " " + arguments + " >" + output + " 2>&1";
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string textOf(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

class Gxybench : public ::testing::Test {
 protected:
  /// Standard places, so that all tests share nothing.
  std::string places() const { return " -q --out " + folder_ / "out" + " --cache " + folder_ / "cache"; }
  std::string out(const std::string& name) const { return folder_ / ("out/" + name); }
  size_t references() const {
    size_t n = 0;
    for ([[maybe_unused]] const auto& entry :
         std::filesystem::directory_iterator(folder_ / "cache/references"))
      n++;
    return n;
  }
  /// A state file that shows a volume of steps of 0.2 as `operatorKeys` say.
  std::string stepped(const std::string& operatorKeys) const {
    constexpr int kSide = 11;
    std::ofstream raw(folder_ / "v.raw", std::ios::binary);
    for (int i = 0; i < kSide * kSide * kSide; i++) {
      const auto value = float(0.2 * (i / kSide / kSide % 4));
      raw.write(reinterpret_cast<const char*>(&value), sizeof value);
    }
    std::ofstream(folder_ / "v.json")
        << R"({"type": "float", "origin": [-1, -1, -1], "delta": [0.2, 0.2, 0.2],
        "counts": [11, 11, 11], "rawdata": "v.raw"})";
    std::ofstream(folder_ / "stepped.json") << R"({
        "Datasets": [{"name": "v", "type": "Volume", "filename": "v.json"}],
        "Visualizations": [{"operators": [{"type": "Volume", "dataset": "v", )"
                                            << operatorKeys << R"(}]}],
        "Camera": {"viewpoint": [2.1, 1.4, 3.3], "viewcenter": [0, 0, 0], "dimensions": [32, 32]}})";
    return folder_ / "stepped.json";
  }
  TemporaryFolder folder_;
};

#if defined(GALAXY_VULKAN)
TEST_F(Gxybench, QuickMeasuresEveryBackend) {
  ASSERT_EQ(
      gxybench("--quick mixed-48 --backend embree vulkan --methods adaptive --tolerances 1/64" + places(),
               folder_ / "log"),
      0)
      << textOf(folder_ / "log");
  std::puts(textOf(folder_ / "log").c_str());  // what the validation layers said
  const std::vector<Row> rows = readTable(out("results.csv"));
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].backend, "embree");
  EXPECT_EQ(rows[1].backend, "vulkan");
  EXPECT_EQ(rows[1].samples, rows[0].samples);
  EXPECT_EQ(rows[1].cells, rows[0].cells);
  EXPECT_EQ(rows[1].rays, rows[0].rays);
  EXPECT_EQ(rows[1].maxError, rows[0].maxError);
  EXPECT_EQ(rows[1].rmsError, rows[0].rmsError);
}
#endif

TEST_F(Gxybench, QuickMeasuresEverySceneWithinItsTolerance) {
  ASSERT_EQ(gxybench("--quick" + places(), folder_ / "log"), 0) << textOf(folder_ / "log");
  std::map<std::string, std::set<std::string>> methods;
  for (const Row& r : readTable(out("results.csv"))) {
    const std::string name = r.scene + " " + r.method + " " + r.setting;
    methods[r.scene].insert(r.method);
    EXPECT_GT(r.wall, 0) << name;
    EXPECT_GT(r.cpu, 0) << name;
    EXPECT_GT(r.rays, 0) << name;
    EXPECT_GT(r.bytesHeld, 0) << name;
    EXPECT_GT(r.peakMemory, r.bytesHeld) << name;
    EXPECT_LE(r.rmsError, r.p999Error) << name;
    EXPECT_LE(r.p999Error, r.maxError) << name;
    EXPECT_LE(r.flips * 1000, r.width * r.height) << name;
    if (r.method == "adaptive") {
      EXPECT_LE(r.maxError, r.tolerance) << name;
    } else {
      EXPECT_GT(r.samples, 0) << name;
    }
    if (r.method == "uncorrected") {  // the grids are not those that the maps speak of
      EXPECT_GT(r.maxError, 0.1) << name;
    }
    if (r.hits >= 0) {
      EXPECT_GT(r.hits, 500) << name;
      EXPECT_GT(r.cells, 0) << name;
      EXPECT_EQ(r.missed + r.extra + r.wrongSheet, 0) << name;
      EXPECT_LE(r.dtRms, 1e-4) << name;
    }
  }
  EXPECT_EQ(methods.size(), 11u);
  const std::string page = textOf(out("index.html"));
  for (const auto& [scene, used] : methods) {
    EXPECT_EQ(used.size() == 3, used.count("fixed") == 1) << scene;
    for (const char* kind : {"-max.svg", "-rms.svg"}) {
      EXPECT_NE(page.find(scene + kind), std::string::npos);
      EXPECT_EQ(textOf(out(scene + kind)).rfind("<svg", 0), 0u) << scene;
    }
  }
}

TEST_F(Gxybench, RanksShareTheWorkAndChangeNoError) {
  const std::string scene =
      "--quick marschner-lobb-25-smooth --steps 1 --tolerances 1/64 --ranks 1,2 --launcher '";
  ASSERT_EQ(gxybench(scene + GALAXY_RUN + "'" + places(), folder_ / "log"), 0) << textOf(folder_ / "log");
  const std::vector<Row> rows = readTable(out("results.csv"));
  ASSERT_EQ(rows.size(), 6u);
  for (size_t i = 0; i < 3; i++) {
    EXPECT_EQ(rows[i].ranks, 1);
    EXPECT_EQ(rows[i + 3].ranks, 2);
    EXPECT_EQ(rows[i].method, rows[i + 3].method);
    EXPECT_EQ(rows[i].rmsError, rows[i + 3].rmsError);
    EXPECT_EQ(rows[i].samples, rows[i + 3].samples);
    EXPECT_EQ(rows[i].bytesSent, 0);
    EXPECT_GT(rows[i + 3].bytesSent, 0);
  }
}

TEST_F(Gxybench, AReferenceIsFoundByContent) {
  const std::string scene = "--quick marschner-lobb-25-isosurface";
  ASSERT_EQ(gxybench(scene + places()), 0);
  EXPECT_EQ(references(), 1u);
  const std::vector<Row> first = readTable(out("results.csv"));
  ASSERT_EQ(gxybench(scene + places()), 0);
  EXPECT_EQ(references(), 1u);
  EXPECT_EQ(readTable(out("results.csv"))[0].rmsError, first[0].rmsError);
  EXPECT_EQ(readTable(out("results.csv"))[0].dtRms, first[0].dtRms);
  ASSERT_EQ(gxybench(scene + " --size 60x50" + places()), 0);
  EXPECT_EQ(references(), 2u);
}

TEST_F(Gxybench, AReferenceOfOtherDataIsNotTaken) {
  const std::string scene = stepped(R"("isovalues": [0.3])") + " --methods adaptive --tolerances 1/64";
  ASSERT_EQ(gxybench(scene + places()), 0);
  EXPECT_EQ(references(), 1u);
  const Row first = readTable(out("results.csv"))[0];
  const float other = 0.9f;  // of the first layer, in place of 0
  {
    std::fstream raw(folder_ / "v.raw", std::ios::binary | std::ios::in | std::ios::out);
    for (int i = 0; i < 11 * 11; i++) raw.write(reinterpret_cast<const char*>(&other), sizeof other);
  }
  ASSERT_EQ(gxybench(scene + places()), 0);
  EXPECT_EQ(references(), 2u);
  const Row second = readTable(out("results.csv"))[0];
  EXPECT_NE(second.hits, first.hits);
  EXPECT_EQ(second.missed + second.extra + second.wrongSheet, 0);
}

// 0.4 is no float: it meets samples that stand for it, a plateau of them too.
TEST_F(Gxybench, ReferencesCompareIsovaluesAsSamplesAreStored) {
  const std::string scene = stepped(R"("isovalues": [0.4])");
  ASSERT_EQ(gxybench(scene + places(), folder_ / "log"), 0) << textOf(folder_ / "log");
  const std::vector<Row> rows = readTable(out("results.csv"));
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_GT(rows[0].hits, 100);
  EXPECT_EQ(rows[0].missed + rows[0].extra + rows[0].wrongSheet, 0);
}

// They speak of no thickness that could be left uncorrected.
TEST_F(Gxybench, ExtinctionMapsHaveNoUncorrectedSetting) {
  const auto methodsOf = [&](const std::string& map, const std::string& methods) {
    const std::string scene = stepped("\"volume rendering\": true, " + map);
    EXPECT_EQ(gxybench(scene + " --steps 1 --methods " + methods + places(), folder_ / "log"), 0)
        << textOf(folder_ / "log");
    std::vector<std::string> used;
    for (const Row& r : readTable(out("results.csv"))) used.push_back(r.method);
    return used;
  };
  using Methods = std::vector<std::string>;
  EXPECT_EQ(methodsOf(R"("opacitymap": [[0, 0.1]])", "fixed uncorrected"), (Methods{"fixed", "uncorrected"}));
  EXPECT_EQ(methodsOf(R"("extinctionmap": [[0, 0.1]])", "fixed uncorrected"), Methods{"fixed"});
  const std::string nothing = stepped(R"("volume rendering": true, "extinctionmap": [[0, 0.1]])");
  EXPECT_EQ(gxybench(nothing + " --methods uncorrected" + places()), 0);
}

TEST_F(Gxybench, CompareReportsAndFailsOnlyWhenAsked) {
  const std::string older = folder_ / "old.csv", newer = folder_ / "new.csv";
  TableWriter(older).add(row("fixed", "1", 1, 1e-3, 1e-3));
  TableWriter(newer).add(row("fixed", "1", 2, 1e-3, 1e-3));
  EXPECT_EQ(gxybench("compare " + older + " " + newer, folder_ / "log"), 0);
  EXPECT_NE(textOf(folder_ / "log").find("time x 2.000"), std::string::npos);
  EXPECT_NE(textOf(folder_ / "log").find("SLOWER"), std::string::npos);
  EXPECT_EQ(gxybench("compare --fail " + older + " " + newer), 1);
  EXPECT_EQ(gxybench("compare --fail " + newer + " " + older), 0);
}

TEST_F(Gxybench, StatusTellsWrongUsageFromFailure) {
  EXPECT_EQ(gxybench("--help"), 0);
  EXPECT_EQ(gxybench("--list"), 0);
  EXPECT_EQ(gxybench("--no-such-option"), 2);
  EXPECT_EQ(gxybench("--tolerances 1/0"), 2);
  EXPECT_EQ(gxybench("--tolerances 7"), 2);
  EXPECT_EQ(gxybench("--steps a"), 2);
  EXPECT_EQ(gxybench("--size 10"), 2);
  EXPECT_EQ(gxybench("--ranks 0"), 2);
  EXPECT_EQ(gxybench("--methods none"), 2);
  EXPECT_EQ(gxybench("compare only-one"), 2);
  EXPECT_EQ(gxybench("compare no-such.csv file.csv"), 1);
  EXPECT_EQ(gxybench("no-such-scene" + places()), 1);
  EXPECT_EQ(gxybench("--quick marschner-lobb-25-isosurface --backend none" + places()), 1);
}

}  // namespace
}  // namespace gxy::bench::test
