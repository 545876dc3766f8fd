// SPDX-License-Identifier: Apache-2.0
// What names on a command line mean.
#include "gxy/scene/data_files.h"

#include "scene_test_support.h"

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

TEST(DataFiles, EveryStepOfASeriesHasTheOtherFiles) {
  const ScratchDirectory folder;
  for (const char* name : {"s_1.vti", "s_2.vti", "g.vtp", "u_1.vti", "u_2.vti", "u_3.vti"})
    folder.write(name, "");
  const std::string at = folder.path().string() + "/";
  const auto steps = stepsOf({at + "g.vtp", at + "s_*.vti"});
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[1], (std::vector<std::string>{at + "g.vtp", at + "s_2.vti"}));
  EXPECT_NE(errorOf([&] {
              stepsOf({at + "s_*.vti", at + "u_*.vti"});
            }).find("3 files match"),
            std::string::npos);
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
