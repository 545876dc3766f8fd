// SPDX-License-Identifier: Apache-2.0
// What the ranks of a server have of datasets of tenant "user".
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "core/data/dataset.h"
#include "core/data/geometry_bytes.h"
#include "multiserver/server/datasets.h"
#include "tests/multiserver/test_server.h"

namespace gxy::test {

/// A dataset on one rank.
inline std::shared_ptr<const Dataset> datasetOn(TestServer& server, int rank, const std::string& name) {
  const Key key = server.serverRank().datasets->get("user", name).key;
  return server.serverRank(rank).objects.pin(key).get<Dataset>();
}

/// What all ranks of a server own of a dataset, by ascending number.
inline GeometryBlock gathered(TestServer& server, const std::string& name) {
  std::vector<GeometryBlock> parts;
  GeometryKind kind = GeometryKind::Triangles;
  for (int r = 0; r < server.serverRank().ranks(); r++) {
    const auto d = datasetOn(server, r, name);
    kind = d->geometry->kind;
    if (!d->geometry->block.ids.empty()) parts.push_back(d->geometry->block);
    EXPECT_TRUE(std::is_sorted(d->geometry->block.ids.begin(), d->geometry->block.ids.end()));
    EXPECT_EQ(d->bytes, gxy::bytesOf(d->geometry->block));
    EXPECT_EQ(d->memory.bytes(), d->bytes);
  }
  return merged(kind, parts);
}

/// Compares the parts of a rank of two volumes, but for their names.
inline void expectSame(const Volume& found, const Volume& expected) {
  EXPECT_EQ(found.grid, expected.grid);
  EXPECT_EQ(found.stored, expected.stored);
  EXPECT_EQ(found.components, expected.components);
  EXPECT_EQ(found.shift, expected.shift);
  EXPECT_EQ(found.scale, expected.scale);
  EXPECT_EQ(found.noDataSamples, expected.noDataSamples);
  ASSERT_EQ(found.ranges.size(), expected.ranges.size());
  for (size_t i = 0; i < found.ranges.size(); i++) {
    EXPECT_EQ(found.ranges[i].min, expected.ranges[i].min);
    EXPECT_EQ(found.ranges[i].max, expected.ranges[i].max);
  }
  ASSERT_EQ(found.blocks.size(), expected.blocks.size());
  for (const auto& [partition, block] : found.blocks) {
    const VolumeBlock& other = expected.blocks.at(partition);
    EXPECT_EQ(block.extent, other.extent);
    EXPECT_TRUE(block.samples == other.samples) << "partition " << partition;
    EXPECT_TRUE(block.summaries == other.summaries) << "partition " << partition;
  }
}

}  // namespace gxy::test
