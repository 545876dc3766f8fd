// SPDX-License-Identifier: Apache-2.0
// The documentation says what the schema says, and its examples load.
#include <fstream>
#include <sstream>

#include "core/scene/state_file.h"
#include "core/scene/sweep.h"
#include "tests/scene/scene_test_support.h"

namespace gxy {
namespace {

const std::filesystem::path kDocs = GALAXY_DOCS_DIR;

std::string contentOf(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(Documentation, StateFileReferenceIsTheSchema) {
  const std::filesystem::path generated = std::filesystem::path(SCENE_TEST_OUTPUT_DIR) / "state-reference.md";
  std::ofstream(generated) << stateReference();
  EXPECT_NE(contentOf(kDocs / "state-file.md").find(stateReference()), std::string::npos)
      << "copy the tables of " << generated << " into docs/state-file.md";
}

TEST(Documentation, SweepReferenceIsTheSchema) {
  const std::filesystem::path generated = std::filesystem::path(SCENE_TEST_OUTPUT_DIR) / "sweep-reference.md";
  std::ofstream(generated) << sweepReference();
  EXPECT_NE(contentOf(kDocs / "cinema.md").find(sweepReference()), std::string::npos)
      << "copy the tables of " << generated << " into docs/cinema.md";
}

TEST(Documentation, ExamplesLoadWithoutWarnings) {
  int examples = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kDocs / "examples")) {
    if (entry.path().extension() != ".json") continue;
    const StateFile file = readStateFile(entry.path());
    EXPECT_TRUE(file.warnings.empty()) << file.warnings.front();
    EXPECT_FALSE(file.state.visualizations.empty());
    EXPECT_FALSE(file.state.cameras.empty());
    EXPECT_TRUE(readState(writeState(file.state), "saved").state == file.state) << entry.path();
    ++examples;
  }
  EXPECT_GE(examples, 13);
}

TEST(Documentation, ExamplesAreListedWithTheirData) {
  const std::string list = contentOf(kDocs / "examples" / "README.md");
  for (const auto& entry : std::filesystem::directory_iterator(kDocs / "examples")) {
    const std::string name = entry.path().filename();
    if (entry.path().extension() != ".json") continue;
    EXPECT_NE(list.find("[" + name + "](" + name + ")"), std::string::npos) << name;
    for (const DatasetSpec& data : readStateFile(entry.path()).state.datasets) {
      const std::string stem = std::filesystem::path(data.filename).stem();
      EXPECT_NE(list.find(stem), std::string::npos) << name << ": " << stem;
    }
  }
}

TEST(Documentation, JsonInTheReferenceLoadsWithoutWarnings) {
  const std::string text = contentOf(kDocs / "state-file.md");
  int blocks = 0;
  for (size_t at = text.find("```json\n"); at != std::string::npos; at = text.find("```json\n", at + 1)) {
    const size_t begin = at + 8, end = text.find("```", begin);
    ASSERT_NE(end, std::string::npos);
    const StateFile file = readState(text.substr(begin, end - begin), "block");
    EXPECT_TRUE(file.warnings.empty()) << file.warnings.front();
    ++blocks;
  }
  EXPECT_GE(blocks, 1);
}

}  // namespace
}  // namespace gxy
