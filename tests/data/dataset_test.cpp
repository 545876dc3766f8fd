// SPDX-License-Identifier: Apache-2.0
#include "core/data/dataset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/comm/error.h"

namespace gxy {
namespace {

TEST(Origins, OfSeveralInputsAreTheirUnionInOrder) {
  const std::vector<Origin> pressure{{3, 7}, {9, 1}}, density{{2, 4}, {3, 7}};
  const std::vector<InputOrigins> inputs{{"pressure", pressure}, {"density", density}};
  EXPECT_EQ(originsOf(inputs), (std::vector<Origin>{{2, 4}, {3, 7}, {9, 1}}));
  EXPECT_TRUE(originsOf({}).empty());
}

TEST(Origins, OfTwoStepsOfOneSourceAreRefusedByNames) {
  const std::vector<Origin> pressure{{3, 7}}, density{{3, 8}};
  const std::vector<InputOrigins> inputs{{"pressure", pressure}, {"density", density}};
  try {
    originsOf(inputs);
    FAIL() << "an error was expected";
  } catch (const Error& e) {
    EXPECT_EQ(
        std::string(e.what()),
        "\"pressure\" is of step 7 and \"density\" of step 8 of the same source, expected data of one step");
  }
}

TEST(Origins, OfOneInputWithTwoStepsAreRefusedToo) {
  const std::vector<Origin> mixed{{3, 7}, {3, 8}};
  const std::vector<InputOrigins> inputs{{"mixed", mixed}};
  EXPECT_THROW(originsOf(inputs), Error);
}

TEST(Dataset, HasTheBoxAndRangeOfItsVolumeOrGeometry) {
  Volume volume;
  volume.grid = {{0, 0, 0}, {1, 1, 1}, {3, 3, 3}};
  volume.components = 2;
  volume.ranges = {{0, 3}, {0, 4}, {0, 5}};
  Dataset dataset;
  dataset.volume = std::make_shared<const Volume>(volume);
  EXPECT_EQ(dataset.box(), (Box{{0, 0, 0}, {2, 2, 2}}));
  EXPECT_EQ(dataset.range(), (Range{0, 5})) << "of the magnitude";
  EXPECT_EQ(dataset.components(), 2);
  EXPECT_TRUE(std::isnan(dataset.time));

  OwnedGeometry geometry;
  geometry.box = {{1, 1, 1}, {2, 2, 2}};
  geometry.range = {-1, 1};
  Dataset other;
  other.geometry = std::make_shared<const OwnedGeometry>(geometry);
  EXPECT_EQ(other.box(), geometry.box);
  EXPECT_EQ(other.range(), geometry.range);
  EXPECT_EQ(other.components(), 1);
}

}  // namespace
}  // namespace gxy
