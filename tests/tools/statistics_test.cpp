// SPDX-License-Identifier: Apache-2.0
// What --stats says was skipped is what the counters of that name hold.
#include "tools/gxyrender/statistics.h"

#include <gtest/gtest.h>

namespace gxy {
namespace {

TEST(Statistics, EachSkippedEntryHoldsItsCounter) {
  Renderer::Counters c;
  LeftBefore before;
  before.data.arrays = 1;
  before.data.components = 2;
  before.data.pieces = 3;
  before.data.bytes = 4;
  before.isoCells = 5;
  c.partitionsSkipped = 6;
  c.tilesSkipped = 7;
  c.messagesSkipped = 8;
  c.trace.macrocellsSkipped = 9;
  c.trace.segmentsSkipped = 10;
  c.trace.isoMacrocellsSkipped = 11;
  c.trace.secondariesSkipped = 12;
  c.trace.raysEndedEarly = 13;
  c.pixelsSkipped = 14;
  c.trace.kernelRuns.fill(1);
  c.trace.runs(Kernel::Isosurfaces) = 0;
  const nlohmann::json all = statisticsOf(c, {}, {}, before, Ledger(), 0);
  EXPECT_EQ(all.at("skipped"), (nlohmann::json{{"arrays", 1},
                                               {"components", 2},
                                               {"pieces", 3},
                                               {"sample bytes", 4},
                                               {"isosurface cells", 5},
                                               {"partitions", 6},
                                               {"tiles", 7},
                                               {"pixels", 14},
                                               {"messages", 8},
                                               {"macrocells", 9},
                                               {"segments", 10},
                                               {"isosurface macrocells", 11},
                                               {"secondaries", 12},
                                               {"rays ended early", 13},
                                               {"kernels", {"isosurfaces"}}}));
}

TEST(Statistics, TellTheTrafficOfEachKind) {
  const nlohmann::json all = trafficOf({{Channel::Rays, {1, 2, 3, 4}}, {Channel::Credits, {5, 6, 7, 8}}}, 9);
  const auto kind = [](int first) {
    return nlohmann::json{{"messages sent", first},
                          {"bytes sent", first + 1},
                          {"messages received", first + 2},
                          {"bytes received", first + 3}};
  };
  EXPECT_EQ(all, (nlohmann::json{{"kinds", {{"rays", kind(1)}, {"credits", kind(5)}}}, {"partners", 9}}));
}

}  // namespace
}  // namespace gxy
