// SPDX-License-Identifier: Apache-2.0
// What names on a command line mean.
#include "core/scene/data_files.h"

#include "core/scene/collection_file.h"
#include "tests/scene/scene_test_support.h"

namespace gxy {
namespace {

TEST(DataFiles, StateFilesAreToldFromDataByTheirKeys) {
  const ScratchDirectory folder;
  EXPECT_TRUE(isStateFile(folder.write("a.json", R"({"Visualization": {"operators": []}})")));
  EXPECT_TRUE(isStateFile(folder.write("b.JSON", R"({"Camera": {}})")));
  EXPECT_TRUE(isStateFile(folder.write("c.json", "{ broken")));  // its reader says where
  EXPECT_FALSE(
      isStateFile(folder.write("d.json", R"({"type": "float", "counts": [2, 2, 2], "rawdata": "r"})")));
  EXPECT_FALSE(isStateFile(folder.write("e.vol", "float\n")));
  EXPECT_NE(
      errorOf([&] { isStateFile(folder.write("f.json", R"({"name": 1})")); }).find("neither a state file"),
      std::string::npos);
}

TEST(DataFiles, PatternsMeanFilesInTheOrderOfTheirNumbers) {
  const ScratchDirectory folder;
  for (const char* name : {"s_10.vti", "s_2.vti", "s_1.vti", "s_x.vti", "t_0003.vti"}) folder.write(name, "");
  const std::string at = folder.path().string() + "/";
  using Names = std::vector<std::string>;
  EXPECT_EQ(filesOf(at + "s_%d.vti"), (Names{at + "s_1.vti", at + "s_2.vti", at + "s_10.vti"}));
  EXPECT_EQ(filesOf(at + "s_*.vti"),
            (Names{at + "s_1.vti", at + "s_2.vti", at + "s_10.vti", at + "s_x.vti"}));
  EXPECT_EQ(filesOf(at + "t_%04d.vti"), (Names{at + "t_0003.vti"}));
  EXPECT_EQ(filesOf(at + "?_2.vti"), (Names{at + "s_2.vti"}));
  EXPECT_EQ(filesOf(at + "s_x.vti"), (Names{at + "s_x.vti"}));
}

TEST(DataFiles, PatternsTakeATimeThatGrowsWithTheirLength) {
  const ScratchDirectory folder;
  folder.write("aaaaaaa", "");
  folder.write("a12b", "");
  const std::string at = folder.path().string() + "/";
  const auto matches = [&](const std::string& pattern) {
    try {
      return !filesOf(at + pattern).empty();
    } catch (const Error&) {
      return false;
    }
  };
  EXPECT_FALSE(matches(std::string(200, '*') + "x"));
  EXPECT_TRUE(matches(std::string(200, '*') + "a"));
  EXPECT_FALSE(matches("a%d2%db"));
  EXPECT_TRUE(matches("a%d2b"));
  EXPECT_TRUE(matches("a*%db*"));
  EXPECT_FALSE(matches("a%d"));
  EXPECT_FALSE(matches("%db"));
  EXPECT_FALSE(matches("a?b"));
  EXPECT_NE(errorOf([&] {
              filesOf(at + std::string(256, '*'));
            }).find("a pattern of file names has 256 letters, expected at most 255"),
            std::string::npos);
}

TEST(DataFiles, EveryStepOfASeriesHasTheOtherFiles) {
  const ScratchDirectory folder;
  for (const char* name : {"s_1.vti", "s_2.vti", "g.vtp", "u_1.vti", "u_2.vti", "u_3.vti"})
    folder.write(name, "");
  const std::string at = folder.path().string() + "/";
  const auto steps = stepsOf({at + "g.vtp", at + "s_*.vti"});
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[1].files, (std::vector<std::string>{at + "g.vtp", at + "s_2.vti"}));
  EXPECT_FALSE(steps[1].time) << "a pattern says no times";
  EXPECT_NE(errorOf([&] {
              stepsOf({at + "s_*.vti", at + "u_*.vti"});
            }).find("it has 3 steps"),
            std::string::npos);
}

std::string collectionOf(const std::string& dataSets) {
  return "<?xml version=\"1.0\"?>\n<!-- <DataSet file=\"not this one\"/> -->\n<VTKFile type=\"Collection\" "
         "version=\"0.1\">\n<Collection>\n" +
         dataSets + "</Collection></VTKFile>\n";
}

TEST(DataFiles, ACollectionSaysItsSteps) {
  const ScratchDirectory folder;
  for (const char* name : {"a.vti", "b & c.vti", "p0.vtp", "p1.vtp", "q0.vtp", "q1.vtp", "g.ply", "z.vti"})
    folder.write(name, "");
  const std::string at = folder.path().string() + "/";
  const std::string two =
      folder.write("two.pvd", collectionOf("<DataSet timestep=\"2.5\" part='0' file='b &amp; c.vti'/>\n"
                                           "<DataSet timestep=\"1e-1\" file=\"a.vti\"/>\n"));
  EXPECT_EQ(readCollection(two)[0].time, 0.1);
  EXPECT_EQ(readCollection(two)[1].time, 2.5);
  const std::string pair =
      folder.write("pair.pvd", collectionOf("<DataSet timestep=\"0\" part=\"0\" file=\"p0.vtp\"/>\n"
                                            "<DataSet timestep=\"0\" part=\"1\" file=\"p1.vtp\"/>\n"));
  for (const auto& files : {std::vector{two, pair}, {pair, two}, {at + "a.vti", pair}})
    EXPECT_NE(errorOf([&] { stepsOfFiles(files); }).find("expected equally many"), std::string::npos);
  using Steps = std::vector<std::vector<std::string>>;
  const auto filesOfSteps = [](const std::vector<std::string>& names) {
    Steps files;
    for (const TimeStep& step : stepsOf(names)) files.push_back(step.files);
    return files;
  };
  EXPECT_EQ(stepsOf({at + "?.vti", two})[1].time, 2.5) << "of the name that says it";
  EXPECT_EQ(filesOfSteps({two, at + "g.ply"}),
            (Steps{{at + "a.vti", at + "g.ply"}, {at + "b & c.vti", at + "g.ply"}}));
  const std::string parts =
      folder.write("parts.PVD", collectionOf("<DataSet timestep=\"0\" part=\"0\" file=\"p0.vtp\"/>"
                                             "<DataSet timestep=\"1\" part=\"0\" file=\"q0.vtp\"/>"
                                             "<DataSet timestep=\"0\" part=\"1\" file=\"p1.vtp\"/>"
                                             "<DataSet timestep=\"1\" part=\"1\" file=\"" +
                                             at + "q1.vtp\"/>"));
  EXPECT_EQ(filesOfSteps({parts}), (Steps{{at + "p0.vtp", at + "p1.vtp"}, {at + "q0.vtp", at + "q1.vtp"}}));
}

TEST(DataFiles, WhatIsWrongWithACollectionIsSaid) {
  const ScratchDirectory folder;
  folder.write("a.vti", "");
  const auto errorOfText = [&](const std::string& text) {
    const std::string path = folder.write("c.pvd", text);
    return errorOf([&] { stepsOf({path}); });
  };
  const auto says = [&](const std::string& text, const std::string& words) {
    EXPECT_NE(errorOfText(text).find(words), std::string::npos) << errorOfText(text);
  };
  says("", "expected a collection");
  says("<VTKFile type=\"ImageData\"><DataSet file=\"a.vti\"/>", "expected a collection");
  says(collectionOf(""), "it names no file");
  says(collectionOf("<DataSet timestep=\"0\"/>"), "a DataSet has no `file`");
  says(collectionOf("<DataSet timestep=\"soon\" file=\"a.vti\"/>"),
       "`timestep`: expected a number, found \"soon\"");
  says(collectionOf("<DataSet file=\"b.vti\"/>"), "b.vti: there is no such file");
  says(collectionOf("<DataSet file=\"a.vti\"/><DataSet timestep=\"1\" file=\"a.vti\"/><DataSet "
                    "timestep=\"1\" file=\"a.vti\"/>"),
       "2 files at time 1, but 1 at 0");
  says("<VTKFile type=\"Collection\"><DataSet file=\"a.vti\"", "ends inside a tag");
}

TEST(DataFiles, WhatIsNotThereIsOneClearError) {
  const ScratchDirectory folder;
  const std::string at = folder.path().string();
  EXPECT_NE(errorOf([&] { filesOf(at + "/s_*.vti"); }).find("no file matches"), std::string::npos);
  EXPECT_NE(errorOf([&] { filesOf(at + "/s.vti"); }).find("no such file"), std::string::npos);
  EXPECT_NE(errorOf([&] { filesOf(at); }).find("this is a directory"), std::string::npos);
}

}  // namespace
}  // namespace gxy
