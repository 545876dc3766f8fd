// SPDX-License-Identifier: Apache-2.0
// gxyrender --cinema: pictures are those of gxyrender, and the database is valid whenever somebody looks.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "core/image/image.h"
#include "core/scene/check_cinema.h"
#include "core/scene/cinema_table.h"
#include "core/scene/state_file.h"
#include "core/scene/swept_pictures.h"
#include "tests/support/temporary_folder.h"

namespace gxy {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string contentOf(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

class CinemaRunTest : public ::testing::Test {
 protected:
  CinemaRunTest() {
    for (int step = 0; step < 3; step++) writeVolume("v" + std::to_string(step), 1 + 0.5 * step);
    write("run.pvd", R"(<VTKFile type="Collection"><Collection>
      <DataSet timestep="0.5" file="v0.vti"/><DataSet timestep="1.5" file="v1.vti"/><DataSet timestep="4" file="v2.vti"/>
    </Collection></VTKFile>)");
    write("state.json", kState.dump());
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(fs::path(folder_) / name) << text;
  }

  /// Distances from the middle, times `scale`, and a second array of ramps.
  void writeVolume(const std::string& name, double scale) const {
    constexpr int n = 8;
    std::ofstream out(fs::path(folder_) / (name + ".vti"));
    out << R"(<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian"><ImageData WholeExtent="0 7 0 7 0 7" Origin="-1 -1 -1"
      Spacing="0.2857142857142857 0.2857142857142857 0.2857142857142857"><Piece Extent="0 7 0 7 0 7"><PointData>)";
    for (const bool ramp : {false, true}) {
      out << R"(<DataArray type="Float32" format="ascii" Name=")" << (ramp ? "ramp" : "ball") << "\">";
      for (int i = 0; i < n * n * n; i++) {
        const double x = i % n * 2.0 / 7 - 1, y = i / n % n * 2.0 / 7 - 1, z = i / n / n * 2.0 / 7 - 1;
        out << float(scale * (ramp ? x : std::sqrt(x * x + y * y + z * z))) << ' ';
      }
      out << "</DataArray>";
    }
    out << "</PointData></Piece></ImageData></VTKFile>";
  }

  int run(const std::string& arguments, const std::string& before = "") const {
    const int status =
        std::system(("cd '" + folder_ + "' && " + before + " " GXYRENDER " -q " +
                     (arguments.find("--reference") == std::string::npos ? "--backend embree " : "") +
                     arguments + " 2>said")
                        .c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string said() const { return contentOf(folder_ + "/said"); }
  CinemaTable tableOf(const std::string& database) const {
    return CinemaTable::read(contentOf(folder_ + "/" + database + "/data.csv"), database);
  }
  void expectValid(const std::string& database) const {
    const CinemaCheck check = checkCinema(fs::path(folder_) / database);
    EXPECT_TRUE(check.problems.empty()) << check.problems.front();
  }
  /// All files of a database, by their relative names.
  std::map<std::string, std::string> filesOf(const std::string& database) const {
    std::map<std::string, std::string> files;
    const fs::path root = fs::path(folder_) / database;
    for (const auto& entry : fs::recursive_directory_iterator(root))
      if (entry.is_regular_file()) files[fs::relative(entry.path(), root)] = contentOf(entry.path());
    return files;
  }
  void writeSweep(const json& axes) const { write("sweep.json", json{{"axes", axes}}.dump()); }

  const json kState{
      {"Datasets", {{{"name", "v"}, {"type", "Volume"}, {"filename", "v0.vti"}, {"array", "ball"}}}},
      {"Visualization",
       {{"operators",
         {{{"type", "Volume"},
           {"dataset", "v"},
           {"isovalues", {0.5}},
           {"colormap", "Viridis"},
           {"data range", {0, 1.8}}}}}}},
      {"Camera", {{"viewpoint", {1, 2, 4}}, {"viewcenter", {0, 0, 0}}, {"dimensions", {40, 32}}}}};
  const test::TemporaryFolder temporary_;
  const std::string folder_ = temporary_.path().string();
};

TEST_F(CinemaRunTest, EachPictureIsThatOfTheStateWithTheValuesOfItsRow) {
  const json axes{{{"axis", "phi"}, {"values", {0, 50}}},
                  {{"axis", "isovalue"}, {"values", {0.5, 0.8}}},
                  {{"axis", "theta"}, {"from", -30}, {"to", 90}, {"count", 2}},
                  {{"axis", "key"}, {"path", "/Datasets/0/array"}, {"values", {"ball", "ramp"}}}};
  writeSweep(axes);
  ASSERT_EQ(run("state.json --cinema sweep.json -o a --depth"), 0) << said();
  expectValid("a.cdb");
  const CinemaTable table = tableOf("a.cdb");
  ASSERT_EQ(table.rows().size(), 16u);
  EXPECT_EQ(table.columns(), (CinemaTable::Row{"phi", "isovalue", "theta", "array", "FILE", "FILE_depth"}));
  EXPECT_EQ(std::system(GXYDATA " check-cinema --help >/dev/null"), 0);
  EXPECT_EQ(std::system(("cd '" + folder_ + "' && " GXYDATA " check-cinema a.cdb >said").c_str()), 0);
  EXPECT_EQ(said(), "a.cdb: 16 rows, 4 parameters, 2 columns of files: valid\n");

  // A document for each pair of an array and an isovalue, with all cameras.
  const SweptPictures swept =
      sweptPictures(readSweepFile(folder_ + "/sweep.json"), readState(kState.dump(), "state").state,
                    [](const std::string& text) { return readState(text, "state"); });
  std::map<std::pair<std::string, std::string>, std::vector<size_t>> documents;
  for (size_t p = 0; p < 16; p++) documents[{table.rows()[p][1], table.rows()[p][3]}].push_back(p);
  ASSERT_EQ(documents.size(), 4u);
  std::map<std::string, int> different;
  for (const auto& [values, pictures] : documents) {
    json document = kState;
    document["Visualization"]["operators"][0]["isovalues"] = {std::stod(values.first)};
    document["Datasets"][0]["array"] = values.second;
    State cameras;
    for (const size_t p : pictures) cameras.cameras.push_back(swept.pictures[p].camera);
    document["Cameras"] = json::parse(writeState(cameras)).at("Cameras");
    document.erase("Camera");
    write("one.json", document.dump());
    ASSERT_EQ(run("one.json --depth -o one"), 0) << said();
    for (size_t i = 0; i < pictures.size(); i++) {
      const CinemaTable::Row& row = table.rows()[pictures[i]];
      const std::string one = folder_ + "/one_0000" + std::to_string(i);
      const std::string picture = contentOf(folder_ + "/a.cdb/" + row[4]);
      EXPECT_EQ(picture, contentOf(one + ".png")) << row[4];
      different[picture]++;
      const Image depth = readImage(folder_ + "/a.cdb/" + row[5]);
      const std::string expected = contentOf(one + ".depth");
      ASSERT_EQ(expected.size(), size_t(40) * 32 * sizeof(double));
      const auto* depths = reinterpret_cast<const double*>(expected.data());
      int wrong = 0;
      for (size_t pixel = 0; pixel < size_t(40) * 32; pixel++)
        wrong += depth.rgba[4 * pixel] != float(depths[pixel]);
      EXPECT_EQ(wrong, 0) << row[5];
    }
  }
  EXPECT_EQ(different.size(), 16u) << "all differ";
  EXPECT_EQ(swept.pictures[4].camera.viewpoint, swept.pictures[0].camera.viewpoint);
}

TEST_F(CinemaRunTest, NoAnglesAreTheStateItself) {
  writeSweep({{{"axis", "phi"}, {"values", {0}}}, {{"axis", "theta"}, {"values", {0}}}});
  ASSERT_EQ(run("state.json --cinema sweep.json -o a.cdb"), 0) << said();
  ASSERT_EQ(run("state.json -o one"), 0) << said();
  EXPECT_EQ(contentOf(folder_ + "/a.cdb/pictures/0.0_0.0.png"), contentOf(folder_ + "/one_00000.png"));
  EXPECT_EQ(contentOf(folder_ + "/a.cdb/data.csv"), "phi,theta,FILE\r\n0.0,0.0,pictures/0.0_0.0.png\r\n");
}

TEST_F(CinemaRunTest, RanksMakeTheSameDatabase) {
  writeSweep({{{"axis", "isovalue"}, {"values", {0.5, 0.9}}},
              {{"axis", "time"}},
              {{"axis", "phi"}, {"values", {0, 120}}}});
  const std::string what = "run.pvd --iso 0.5 --array ball --size 40x32 --cinema sweep.json";
  ASSERT_EQ(run(what + " -o one"), 0) << said();
  ASSERT_EQ(run(what + " -o two --threads 1 --partitions 3 --depth", MPIEXEC " -n 2"), 0) << said();
  expectValid("two.cdb");
  const auto one = filesOf("one.cdb"), two = filesOf("two.cdb");
  EXPECT_EQ(one.size(), 12u + 2);
  EXPECT_EQ(two.size(), 24u + 2);
  for (const auto& [name, content] : one)
    if (name.ends_with(".png")) {
      EXPECT_EQ(two.at(name), content) << name;
    }
  EXPECT_EQ(tableOf("one.cdb").rows()[3],
            (CinemaTable::Row{"0.9", "0.5", "120.0", "time=0.5/0.9_120.0.png"}));
}

TEST_F(CinemaRunTest, StepsAreThoseOfASeries) {
  writeSweep({{{"axis", "time"}}, {{"axis", "phi"}, {"values", {0}}}});
  const std::string what = "run.pvd --array ball --annotate --size 64x64";
  ASSERT_EQ(run(what + " --cinema sweep.json -o a"), 0) << said();
  ASSERT_EQ(run(what + " -o series"), 0) << said();
  const CinemaTable table = tableOf("a.cdb");
  ASSERT_EQ(table.rows().size(), 3u);
  for (size_t step = 0; step < 3;
       step++)  // with their numbers and times, and ranges that earlier steps have widened
    EXPECT_EQ(contentOf(folder_ + "/a.cdb/" + table.rows()[step][2]),
              contentOf(folder_ + "/series_0000" + std::to_string(step) + ".png"))
        << step;
}

TEST_F(CinemaRunTest, ADatabaseIsValidWheneverItIsReadAndGoesOnWhereItEnded) {
  writeSweep({{{"axis", "time"}}, {{"axis", "theta"}, {"values", {0, 20}}}});
  const std::string what = "run.pvd --array ball --size 40x32 --cinema sweep.json";
  ASSERT_EQ(run(what + " -o whole"), 0) << said();
  const std::map<std::string, std::string> whole = filesOf("whole.cdb");
  const auto expectWhole = [&](const std::string& database) {
    expectValid(database);
    const std::map<std::string, std::string> files = filesOf(database);
    EXPECT_EQ(files.size(), whole.size());
    for (const auto& [name, content] : whole)
      if (name != "index.html") {
        EXPECT_EQ(files.at(name), content) << name;
      }
  };

  // Killed when it is first seen, or later; then once more until it ends.
  const fs::path csv = fs::path(folder_) / "killed.cdb/data.csv";
  for (const bool kills : {true, false}) {
    const pid_t child = fork();
    if (child == 0) {
      setpgid(0, 0);
      std::_Exit(run(what + " -o killed --resume"));
    }
    int status = 0;
    while (waitpid(child, &status, WNOHANG) == 0) {
      if (!fs::exists(csv)) continue;
      const CinemaCheck check = checkCinema(csv.parent_path());
      ASSERT_TRUE(check.problems.empty()) << check.problems.front();
      EXPECT_EQ(check.rows % 2, 0u) << "whole steps";
      if (kills) kill(-child, SIGKILL);
    }
  }
  for (const auto& entry : fs::recursive_directory_iterator(csv.parent_path()))
    if (entry.path().extension() == ".partial") fs::remove(entry.path());
  expectWhole("killed.cdb");

  // Ended by the third step's data, which are good the next time.
  const std::string good = contentOf(folder_ + "/v2.vti");
  write("v2.vti", "");
  ASSERT_EQ(run(what + " -o ended"), 1);
  expectValid("ended.cdb");
  EXPECT_EQ(tableOf("ended.cdb").rows().size(), 4u);
  write("v2.vti", good);
  ASSERT_EQ(run(what + " -o ended --resume"), 0) << said();
  expectWhole("ended.cdb");
}

TEST_F(CinemaRunTest, MoreValuesAreAddedAndTheSameOnesReplaced) {
  writeSweep({{{"axis", "phi"}, {"values", {0, 10}}}});
  ASSERT_EQ(run("state.json --cinema sweep.json -o a"), 0) << said();
  writeSweep({{{"axis", "phi"}, {"values", {10, 20}}}});
  ASSERT_EQ(run("state.json --cinema sweep.json -o a --size 20x20"), 0) << said();
  expectValid("a.cdb");
  EXPECT_EQ(tableOf("a.cdb").rows().size(), 3u);
  EXPECT_EQ(readImage(folder_ + "/a.cdb/pictures/10.0.png").width, 20);
  EXPECT_EQ(readImage(folder_ + "/a.cdb/pictures/0.0.png").width, 40);
  fs::remove(fs::path(folder_) / "a.cdb/pictures/20.0.png");
  ASSERT_EQ(run("state.json --cinema sweep.json -o a --resume --size 30x30"), 0) << said();
  EXPECT_EQ(readImage(folder_ + "/a.cdb/pictures/20.0.png").width, 30);
  EXPECT_EQ(readImage(folder_ + "/a.cdb/pictures/10.0.png").width, 20) << "it was there";
  const std::string page = contentOf(folder_ + "/a.cdb/index.html");
  EXPECT_NE(page.find(R"("rows":[["0.0","pictures/0.0.png"])"), std::string::npos);
}

TEST_F(CinemaRunTest, WrongUseIsOneClearError) {
  const auto fails = [&](const std::string& arguments, int code, const std::string& why) {
    EXPECT_EQ(run(arguments), code) << arguments;
    EXPECT_NE(said().find(why), std::string::npos) << said();
  };
  writeSweep({{{"axis", "phi"}, {"values", {0, 10}}}});
  fails("state.json --resume", 2, "--cinema");
  fails("state.json --cinema sweep.json --reference", 2, "--reference does not go with --cinema");
  fails("state.json --cinema sweep.json --format raw", 2, "--format raw does not go with --cinema");
  fails("state.json --cinema sweep.json --stats s.json", 2, "--stats does not go with --cinema");
  fails("state.json --cinema none.json", 1, "none.json");
  fails("run.pvd --cinema sweep.json", 1,
        "sweep.json: it has no axis \"time\", expected one for 3 time steps");
  fails("state.json --cinema sweep.json -o none/a", 1, "none/a.cdb: no folder can be made there");
  EXPECT_EQ(std::count_if(fs::directory_iterator(folder_), fs::directory_iterator(),
                          [](const auto& entry) { return entry.path().extension() == ".cdb"; }),
            0)
      << "nothing was begun";
  ASSERT_EQ(run("state.json --cinema sweep.json -o a"), 0) << said();
  write("bad.json", "{\"axes\": [\n  {\"axis\": \"slice\", \"values\": [1]}]}");
  fails("state.json --cinema bad.json -o b", 1,
        "gxyrender: error: bad.json:2:3: `index`: operator 0 has 0 of them, expected a smaller number, from "
        "0 on\n");
  writeSweep({{{"axis", "theta"}, {"values", {0}}}});
  fails("state.json --cinema sweep.json -o a", 1,
        "a.cdb/data.csv: its columns are phi, FILE, expected theta, FILE");
  writeSweep({{{"axis", "key"},
               {"path", "/Renderer/tolerance"},
               {"name", "phi"},
               {"values", {0.5}},
               {"labels", {"low"}}}});
  fails("state.json --cinema sweep.json -o a", 1,
        "a.cdb/data.csv: column \"phi\": \"low\" is a text, expected a number with a point as in the first "
        "row");
  EXPECT_FALSE(fs::exists(fs::path(folder_) / "a.cdb/pictures/low.png")) << "nothing was rendered";
  expectValid("a.cdb");
  EXPECT_EQ(std::system(("cd '" + folder_ +
                         "' && echo 'x,FILE' >a.cdb/data.csv && " GXYDATA
                         " check-cinema a.cdb >said 2>&1 && exit 1 || exit 0")
                            .c_str()),
            0);
  EXPECT_EQ(said(),
            "a.cdb/data.csv: there are no rows, expected one at least\n"
            "gxydata: check-cinema: of 1 database(s) 1 not valid\n");
}

}  // namespace
}  // namespace gxy
