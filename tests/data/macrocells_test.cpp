// SPDX-License-Identifier: Apache-2.0
#include "core/data/macrocells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/comm/error.h"
#include "tests/data/random_partitioning.h"

namespace gxy {
namespace {

/// A whole volume of random stored values, some of them no data where the type can say so.
template <typename T>
std::vector<T> randomField(std::mt19937& random, int64_t values) {
  std::vector<T> field(static_cast<size_t>(values));
  for (T& v : field) {
    v = T(random() % (sizeof(T) == 2 ? 65536 : 200));
    if constexpr (std::is_floating_point_v<T>) {
      if (random() % 500 == 0) v = random() % 2 ? NAN : -INFINITY;
    }
  }
  return field;
}

template <typename T>
VolumeBlock cut(const Grid& grid, const std::vector<T>& field, int components, const Extent& e) {
  VolumeBlock block;
  block.extent = e;
  for (int64_t z = e.first[2]; z < e.first[2] + e.points[2]; ++z) {
    for (int64_t y = e.first[1]; y < e.first[1] + e.points[1]; ++y) {
      const size_t first =
          size_t((z * grid.points[1] + y) * grid.points[0] + e.first[0]) * size_t(components);
      const auto row = std::as_bytes(std::span(&field[first], size_t(e.points[0]) * size_t(components)));
      block.samples.insert(block.samples.end(), row.begin(), row.end());
    }
  }
  return block;
}

Volume volumeOf(const Grid& grid, ScalarType type, int components) {
  Volume v;
  v.grid = grid;
  v.stored = type;
  v.components = components;
  return v;
}

/// The definition, point by point: what macrocell `at` of the whole volume holds.
template <typename T>
Macrocell definition(const Grid& grid, const std::vector<T>& field, int components, int summary, Index3 at) {
  Macrocell m{INFINITY, -INFINITY, 0, 0, false};
  Index3 last;
  for (int a = 0; a < 3; ++a) last[a] = std::min(at[a] * 8 + 8, grid.points[a] - 1);
  const auto value = [&](Index3 i) {
    const T* p = &field[size_t((i[2] * grid.points[1] + i[1]) * grid.points[0] + i[0]) * size_t(components)];
    float squares = 0;
    for (int c = 0; c < components; ++c) squares += float(p[c]) * float(p[c]);
    return summary == components ? std::sqrt(squares) : float(p[summary]);
  };
  const auto widen = [](float& most, float difference) {
    if (std::isfinite(difference)) most = std::max(most, std::abs(difference));
  };
  for (int64_t z = at[2] * 8; z <= last[2]; ++z) {
    for (int64_t y = at[1] * 8; y <= last[1]; ++y) {
      for (int64_t x = at[0] * 8; x <= last[0]; ++x) {
        const Index3 here{x, y, z};
        const float v = value(here);
        if (std::isfinite(v)) {
          m.min = std::min(m.min, v);
          m.max = std::max(m.max, v);
        } else {
          m.noData = true;
        }
        for (int a = 0; a < 3; ++a) {
          Index3 next = here, before = here;
          ++next[a], --before[a];
          if (next[a] > last[a]) continue;
          widen(m.steep, value(next) - v);
          if (before[a] >= at[a] * 8) widen(m.bend, (value(next) - v) - (v - value(before)));
          for (int b = 0; b < a; ++b) {
            Index3 aside = here, corner = next;
            ++aside[b], ++corner[b];
            if (aside[b] <= last[b]) widen(m.bend, (value(corner) - value(next)) - (value(aside) - v));
          }
        }
      }
    }
  }
  return m;
}

template <typename T>
void checkAnyCut(ScalarType type, int components, const Grid& grid, unsigned seed) {
  std::mt19937 random(seed);
  const std::vector<T> field =
      randomField<T>(random, grid.points[0] * grid.points[1] * grid.points[2] * components);
  for (int parts : {1, 2, 5, 13, 27}) {
    const Partitioning p = test::randomPartitioning(random, grid.box(), parts, 4);
    std::vector<Volume> ranks(4, volumeOf(grid, type, components));
    for (int i = 0; i < parts; ++i) {
      VolumeBlock block = cut(grid, field, components, extentOf(grid, p.box(i), 1 + int(seed % 2)));
      completeBlock(block, type, components);
      ranks[size_t(p.owner(i))].blocks.emplace(i, std::move(block));
    }
    std::vector<BorderSummary> records;
    for (const Volume& v : ranks) {
      const std::vector<BorderSummary> own = borderSummaries(v);
      records.insert(records.end(), own.begin(), own.end());
    }
    std::shuffle(records.begin(), records.end(), random);
    for (Volume& v : ranks) {
      mergeSummaries(v, records);
      for (const auto& [part, block] : v.blocks) {
        ASSERT_EQ(block.summaries.size(), components > 1 ? size_t(components) + 1 : 1);
        const Index3 &n = block.macrocells, &f = block.firstMacrocell;
        for (size_t s = 0; s < block.summaries.size(); ++s) {
          ASSERT_EQ(block.summaries[s].size(), size_t(n[0] * n[1] * n[2]));
          size_t at = 0;
          for (int64_t k = 0; k < n[2]; ++k)
            for (int64_t j = 0; j < n[1]; ++j)
              for (int64_t i = 0; i < n[0]; ++i)
                ASSERT_EQ(block.summaries[s][at++],
                          definition(grid, field, components, int(s), {f[0] + i, f[1] + j, f[2] + k}));
        }
      }
    }
  }
}

TEST(Macrocells, AnyCutGivesTheSummariesOfTheWholeVolume) {
  const Grid grid{{-1, 0, 5}, {0.1, 1, 0.3}, {38, 21, 19}};
  for (unsigned seed = 0; seed < 6; ++seed) checkAnyCut<float>(ScalarType::Float32, 1, grid, seed);
}

TEST(Macrocells, NarrowTypesAndVectorsToo) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {17, 18, 9}};
  checkAnyCut<uint8_t>(ScalarType::UInt8, 1, grid, 1);
  checkAnyCut<int16_t>(ScalarType::Int16, 1, grid, 2);
  checkAnyCut<int8_t>(ScalarType::Int8, 1, grid, 4);
  checkAnyCut<uint16_t>(ScalarType::UInt16, 1, grid, 5);
  checkAnyCut<float>(ScalarType::Float32, 3, grid, 2);
  checkAnyCut<int8_t>(ScalarType::Int8, 2, grid, 3);
}

TEST(Macrocells, SmallGridsToo) {
  checkAnyCut<float>(ScalarType::Float32, 1, Grid{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, 1);
  checkAnyCut<float>(ScalarType::Float32, 1, Grid{{0, 0, 0}, {1, 1, 1}, {2, 2, 40}}, 2);
  checkAnyCut<float>(ScalarType::Float32, 1, Grid{{0, 0, 0}, {1, 1, 1}, {9, 9, 9}}, 0);
}

TEST(Macrocells, WhatNoOtherBlockCanHoldIsNotSent) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {57, 57, 57}};
  std::mt19937 random(5);
  Volume v = volumeOf(grid, ScalarType::Float32, 1);
  v.blocks[0] = cut(grid, randomField<float>(random, 57 * 57 * 57), 1, {{0, 0, 0}, grid.points});
  completeBlock(v.blocks[0], v.stored, 1);
  EXPECT_EQ(v.blocks[0].macrocells, (Index3{7, 7, 7}));
  EXPECT_EQ(borderSummaries(v).size(), size_t(343 - 27));
}

// A slab thinner than the ghost layers: its neighbour holds the whole grid, and all that the slab lacks.
TEST(Macrocells, ThinSlabsAtTheEndOfTheGridLearnTheRest) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {30, 4, 4}};
  std::vector<float> field(30 * 16);
  for (size_t i = 0; i < field.size(); ++i) field[i] = float(i % 30);
  Volume v = volumeOf(grid, ScalarType::Float32, 1);
  const Box slab{{0, 0, 0}, {0.4, 3, 3}}, rest{{0.4, 0, 0}, {29, 3, 3}};
  v.blocks[0] = cut(grid, field, 1, extentOf(grid, slab, kGhostLayers));
  v.blocks[1] = cut(grid, field, 1, extentOf(grid, rest, kGhostLayers));
  for (auto& [partition, block] : v.blocks) completeBlock(block, v.stored, 1);
  mergeSummaries(v, borderSummaries(v));
  EXPECT_EQ(v.blocks[0].summaries[0][0], (Macrocell{0, 8, 1, 0, false}));
}

TEST(Macrocells, ForeignRecordsAndWrongSizesAreRefused) {
  Volume v = volumeOf(Grid{{0, 0, 0}, {1, 1, 1}, {17, 17, 17}}, ScalarType::Float32, 1);
  const auto merge = [&](Index3 at, int summary) {
    const BorderSummary record{at, summary, 0, 0, 1, 0, 0};
    mergeSummaries(v, std::span(&record, 1));
  };
  EXPECT_NO_THROW(merge({1, 1, 1}, 0));
  EXPECT_THROW(merge({2, 1, 1}, 0), Error);
  EXPECT_THROW(merge({1, -1, 1}, 0), Error);
  EXPECT_THROW(merge({1, 1, 1}, 1), Error);
  VolumeBlock block;
  block.extent = {{0, 0, 0}, {2, 2, 2}};
  block.samples.resize(31);
  EXPECT_THROW(completeBlock(block, ScalarType::Float32, 1), Error);
  EXPECT_THROW(completeBlock(block, ScalarType::Float64, 1), Error);
  block.samples.resize(32);
  EXPECT_NO_THROW(completeBlock(block, ScalarType::Float32, 1));
  EXPECT_THROW(completeBlock(block, ScalarType::Float32, 1), Error);  // its samples are in bricks by now
}

}  // namespace
}  // namespace gxy
