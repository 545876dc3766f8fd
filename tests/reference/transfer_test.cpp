// SPDX-License-Identifier: Apache-2.0
#include "core/reference/transfer.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gxy::reference {
namespace {

TEST(Transfer, OpacityIsThatOfASlabOneReferenceLengthThick) {
  Vis vis;
  vis.opacitymap.points = {{0, 0}, {1, 0.8}};
  const Transfer transfer(vis, 0.25);
  EXPECT_NEAR(1 - std::exp(-transfer.extinction(0.5) * 0.25), 0.4, 1e-15);
  EXPECT_NEAR(1 - std::exp(-transfer.extinction(7) * 0.25), 0.8, 1e-15);
  EXPECT_EQ(transfer.extinction(-1), 0);
}

TEST(Transfer, ExtinctionMapIsPerWorldUnitWhateverTheReferenceLength) {
  Vis vis;
  vis.opacitymap = {true, {{0, 2}, {1, 6}}};
  EXPECT_DOUBLE_EQ(Transfer(vis, 0.25).extinction(0.5), 4);
}

TEST(Transfer, FullOpacityIsInfiniteExtinction) {
  Vis vis;
  vis.opacitymap.points = {{0, 0}, {1, 1}};
  EXPECT_TRUE(std::isinf(Transfer(vis, 1).extinction(1)));
}

TEST(Transfer, LaterOfTwoEqualPointsHoldsFromThatValueOn) {
  Vis vis;
  vis.colormap.points = {{0, glm::dvec3(0)}, {0.5, glm::dvec3(0)}, {0.5, glm::dvec3(1)}, {1, glm::dvec3(1)}};
  const Transfer transfer(vis, 1);
  EXPECT_EQ(transfer.colour(std::nextafter(0.5, 0)).x, 0);
  EXPECT_EQ(transfer.colour(0.5).x, 1);
}

TEST(Transfer, DataRangeMovesTheEndsOfEachMap) {
  Vis vis;
  vis.colormap.points = {{0, glm::dvec3(0)}, {1, glm::dvec3(1)}};
  vis.opacitymap = {true, {{10, 0}, {30, 1}}};
  vis.dataRange = {-5, 5};
  const Transfer transfer(vis, 1);
  EXPECT_DOUBLE_EQ(transfer.colour(0).x, 0.5);
  EXPECT_DOUBLE_EQ(transfer.extinction(0), 0.5);
  EXPECT_EQ(transfer.breaks(), (std::vector<double>{-5, 5}));
}

TEST(Transfer, TransparencyOfARangeSeesAPeakInsideIt) {
  Vis vis;
  vis.opacitymap.points = {{0, 0}, {0.5, 0}, {0.5001, 0.3}, {0.5002, 0}, {1, 0}};
  const Transfer transfer(vis, 1);
  EXPECT_FALSE(transfer.transparent(0.2, 0.8));
  EXPECT_TRUE(transfer.transparent(0.6, 0.8));
}

}  // namespace
}  // namespace gxy::reference
