// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "core/scene/state_file.h"
#include "tests/scene/random_state.h"
#include "tests/scene/scene_test_support.h"
#include "tests/support/seeds.h"

namespace gxy {
namespace {

TEST(RoundTrip, RandomStatesLoadEqualToWhatWasSaved) {
  for (uint64_t seed = 0; seed < uint64_t(test::sweep(500)); ++seed) {
    const State state = RandomState(seed).state();
    const std::string text = writeState(state);
    const State back = readState(text, "saved").state;
    ASSERT_TRUE(back == state) << "seed " << seed << "\n" << text;
    ASSERT_EQ(writeState(back), text) << "seed " << seed;
  }
}

TEST(RoundTrip, EveryOperatorTypeKeepsItsDefaults) {
  for (const char* type : {"Volume", "Particles", "PathLines", "Triangles"}) {
    const std::string text =
        std::string(R"({"Visualization": {"operators": [{"type": ")") + type + R"(", "dataset": "d"}]}})";
    const State state = readState(text, "s").state;
    EXPECT_TRUE(readState(writeState(state), "saved").state == state) << type;
  }
}

TEST(RoundTrip, SavedFilesLoadWithoutWarnings) {
  State state;
  state.datasets.push_back({"v", DatasetType::Volume, "v.vol", "", {0.8, 0.8, 0.8, 1}});
  Vis vis;
  vis.dataset = "v";
  vis.volumeRendering = true;
  state.visualizations.emplace_back();
  state.visualizations.back().operators.push_back(vis);
  vis.volumeRendering = false;
  vis.isovalues = {0.5};
  state.visualizations.back().operators.push_back(vis);
  state.cameras.emplace_back();
  const StateFile back = readState(writeState(state), "saved");
  EXPECT_TRUE(back.warnings.empty()) << back.warnings.front();
  EXPECT_TRUE(back.state == state);
}

TEST(RoundTrip, NumbersThatAreNotFiniteCannotBeSaved) {
  State state;
  state.settings.step = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(errorOf([&] { writeState(state); }).find("not finite"), std::string::npos);
}

}  // namespace
}  // namespace gxy
