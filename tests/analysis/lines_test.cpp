// SPDX-License-Identifier: Apache-2.0
// Stored points become path lines that depend neither on the ranks nor on how lines are cut over them.
#include "core/analysis/lines.h"

#include <gtest/gtest.h>

#include "core/comm/error.h"
#include "core/comm/random.h"
#include "core/data/geometry.h"
#include "tests/analysis/rank_flows.h"
#include "tests/support/seeds.h"
#include "tests/support/thread_ranks.h"

namespace gxy::test {
namespace {

LedgerEntry noLedger(int64_t) { return {}; }

/// Lines of random lengths, some points of which are equal to the ones before.
PathPoints randomLines(uint64_t seed) {
  Random random(seed);
  PathPoints points;
  points.values.resize(1);
  const int lines = int(random.below(9));
  for (int line = 0; line < lines; line++) {
    const int n = 1 + int(random.below(random.oneIn(3) ? 3 : 40)), least = -int(random.below(uint64_t(n)));
    for (int i = 0; i < n; i++) {
      const bool repeated = i > 0 && random.below(3) == 0;
      points.line.push_back(uint64_t(line) * 37 + (uint64_t(line % 2) << 39));
      points.number.push_back(least + i);
      points.position.push_back(repeated ? points.position.back()
                                         : glm::dvec3(random.below(3), random.below(3), line));
      const bool sameValue = repeated && random.below(4);
      points.values[0].push_back(sameValue ? points.values[0].back() : float(random.below(2)));
      points.time.push_back(i);
      points.length.push_back(2 * i);
      points.speed.push_back(float(i));
    }
  }
  return points;
}

/// Gives points to ranks, in runs of any length, each rank's in pieces and in any order.
std::vector<TracedLines> spread(const PathPoints& points, int ranks, uint64_t seed) {
  Random random(seed);
  std::vector<TracedLines> spread(static_cast<size_t>(ranks));
  const uint64_t stays = 1 + random.below(8);
  size_t rank = 0;
  for (TracedLines& lines : spread) lines.points.resize(3);
  std::vector<size_t> order(points.size());
  for (size_t i = 0; i < order.size(); i++) order[i] = i;
  std::vector<size_t> owner(points.size());
  for (size_t& o : owner) {
    if (random.oneIn(stays)) rank = random.below(uint64_t(ranks));
    o = rank;
  }
  for (size_t i = order.size(); i > 1; i--) std::swap(order[i - 1], order[random.below(i)]);
  for (const size_t i : order) {
    PathPoints& to = spread[owner[i]].points[random.below(3)];
    to.values.resize(1);
    to.line.push_back(points.line[i]);
    to.number.push_back(points.number[i]);
    to.position.push_back(points.position[i]);
    to.time.push_back(points.time[i]);
    to.length.push_back(points.length[i]);
    to.speed.push_back(points.speed[i]);
    to.values[0].push_back(points.values[0][i]);
  }
  return spread;
}

/// Segments between all points of each line, of which dropUnusable() then takes those whose points are equal. It
/// leaves one of a line whose points are all equal. Here that is a line of one point, and has no segment.
GeometryBlock plainLines(const PathPoints& points) {
  GeometryBlock block;
  block.points = points.position;
  block.values = points.values[0];
  uint64_t number = 0;
  for (size_t i = 1; i < points.size(); i++) {
    const auto on = [&](size_t k) { return k < points.size() && points.line[k] == points.line[i]; };
    if (!on(i - 1)) {
      number = 0;
      continue;
    }
    const auto a = uint32_t(i - 1), b = uint32_t(i);
    block.segments.push_back({a, b});
    block.neighbours.push_back({a > 0 && on(a - 1) ? a - 1 : a, on(b + 1) ? b + 1 : b});
    block.ids.push_back(points.line[i] << 24 | number++);
  }
  dropUnusable(block, GeometryKind::PathLines);
  std::vector<uint32_t> left;
  for (uint32_t i = 0; i < block.ids.size(); i++) {
    const auto [a, b] = block.segments[i];
    const auto same = [](const auto& x, const auto& y) { return std::memcmp(&x, &y, sizeof x) == 0; };
    if (!same(block.points[a], block.points[b]) || !same(block.values[a], block.values[b])) left.push_back(i);
  }
  return subset(block, GeometryKind::PathLines, left);
}

MadeLines madeOn(std::vector<TracedLines> spread, GeometryBlock& all,
                 const std::vector<NamedLineValue>& fields = {}) {
  std::vector<MadeLines> made(spread.size());
  const auto errors = ThreadRanks(int(spread.size())).run([&](Collectives& ranks) {
    const auto r = size_t(ranks.rank());
    made[r] = makeLines(std::move(spread[r]), {LineValue::Kind::Recorded, 0}, noLedger, ranks, fields);
  });
  for (const std::string& error : errors) EXPECT_EQ(error, "");
  std::vector<GeometryBlock> blocks;
  for (MadeLines& m : made) {
    validate(m.block, GeometryKind::PathLines);
    EXPECT_TRUE(std::is_sorted(m.block.ids.begin(), m.block.ids.end()));
    EXPECT_EQ(m.block.points.size(), m.block.points.capacity()) << "room that is not needed";
    GeometryBlock usable = m.block;
    EXPECT_EQ(dropUnusable(usable, GeometryKind::PathLines), 0);
    blocks.push_back(std::move(m.block));
  }
  all = merged(GeometryKind::PathLines, blocks);
  return std::move(made.front());
}

TEST(PathLines, AreThoseOfOneRankHoweverPointsAreSpread) {
  for (uint64_t seed = 1; seed <= uint64_t(seeds(400)); seed++) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    PathPoints points = randomLines(seed);
    points.sort();
    const GeometryBlock expected = merged(GeometryKind::PathLines, std::vector{plainLines(points)});
    for (const int ranks : {1, 2, 5}) {
      GeometryBlock all;
      const MadeLines made = madeOn(spread(points, ranks, seed), all);
      ASSERT_TRUE(bytesIn(all) == bytesIn(expected)) << ranks << " ranks";
      uint64_t lines = 0;
      for (size_t i = 0; i < all.ids.size(); i++) lines += i == 0 || all.ids[i] >> 24 != all.ids[i - 1] >> 24;
      ASSERT_EQ(made.lines, lines);
      ASSERT_EQ(made.points, lines + all.ids.size());
    }
  }
}

TEST(PathLines, HaveFieldsThatAreThoseOfOneRankHoweverPointsAreSpread) {
  for (uint64_t seed = 1; seed <= uint64_t(seeds(100)); seed++) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    PathPoints points = randomLines(seed);
    points.sort();
    const std::vector<NamedLineValue> fields{{"time", {LineValue::Kind::Time, 0}},
                                             {"length", {LineValue::Kind::Length, 0}}};
    GeometryBlock expected;
    const MadeLines one = madeOn(spread(points, 1, seed), expected, fields);
    for (size_t i = 0; i < expected.points.size(); i++)
      ASSERT_EQ(expected.fields.at(1).values.at(i), 2 * expected.fields.at(0).values.at(i));
    for (const int ranks : {2, 5}) {
      GeometryBlock all;
      const MadeLines made = madeOn(spread(points, ranks, seed), all, fields);
      ASSERT_TRUE(bytesIn(all) == bytesIn(expected)) << ranks << " ranks";
      ASSERT_EQ(made.points, one.points);
    }
  }
}

TEST(PathLines, KeepAPointAtTheSamePlaceWhereAFieldChanges) {
  PathPoints points;
  points.append(
      {{5, 5, 5}, {0, 1, 2}, {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}}, {0, 2, 4}, {0, 3, 3}, {7, 7, 7}, {}});
  for (const bool timed : {false, true}) {
    TracedLines traced;
    traced.points.push_back(points);
    SingleRank one;
    std::vector<NamedLineValue> fields{{"length", {LineValue::Kind::Length, 0}}};
    if (timed) fields.push_back({"time", {LineValue::Kind::Time, 0}});
    EXPECT_EQ(makeLines(std::move(traced), {}, noLedger, one, fields).points, timed ? 3u : 2u);
  }
}

TEST(PathLines, RefuseMoreFieldsThanAreKept) {
  SingleRank one;
  EXPECT_THROW(makeLines({}, {}, noLedger, one, std::vector<NamedLineValue>(4)), Error);
}

TEST(PathLines, HaveTheValueThatIsAskedFor) {
  PathPoints points;
  points.append({{5, 5}, {0, 1}, {{0, 0, 0}, {1, 0, 0}}, {0, 2}, {0, 3}, {10, 11}, {{20, 21}}});
  for (const auto& [kind, expected] :
       std::vector<std::pair<LineValue::Kind, std::vector<float>>>{{LineValue::Kind::Speed, {10, 11}},
                                                                   {LineValue::Kind::Time, {0, 2}},
                                                                   {LineValue::Kind::Length, {0, 3}},
                                                                   {LineValue::Kind::Recorded, {20, 21}}}) {
    TracedLines traced;
    traced.points.push_back(points);
    SingleRank one;
    EXPECT_EQ(makeLines(std::move(traced), {kind, 0}, noLedger, one).block.values, expected);
  }
}

TEST(PathLines, RefuseTwoLinesOfOneNumber) {
  for (const bool apart : {false, true}) {
    std::vector<TracedLines> ranks(2);
    PathPoints points;
    points.append({{5, 5}, {0, 1}, {{0, 0, 0}, {1, 0, 0}}, {0, 2}, {0, 3}, {10, 11}, {}});
    ranks[0].points = {points};
    ranks[apart].points.push_back(points);
    const auto errors = ThreadRanks(2).run(
        [&](Collectives& r) { makeLines(std::move(ranks[size_t(r.rank())]), {}, noLedger, r); });
    for (const std::string& error : errors)
      EXPECT_EQ(error, std::string("rank ") + (apart ? "1" : "0") +
                           ": line 5 has a point 0 twice; expected seeds with different numbers");
  }
}

TEST(PathLines, FailEverywhereWhereARankHasNoMemory) {
  PathPoints points = randomLines(5);
  points.sort();
  for (const int refused : {0, 1}) {  // for points that are sorted, and for the block
    auto ranks = spread(points, 3, 1);
    const auto errors = ThreadRanks(3).run([&](Collectives& r) {
      int calls = 0;
      makeLines(
          std::move(ranks[size_t(r.rank())]), {},
          [&](int64_t) {
            if (r.rank() == 1 && calls++ == refused) throw Error("no room");
            return LedgerEntry();
          },
          r);
    });
    for (const std::string& error : errors) EXPECT_EQ(error, "rank 1: no room");
  }
}

TEST(PathLines, CountTheEndsOfAllRanks) {
  std::vector<TracedLines> ranks(3);
  for (size_t r = 0; r < 3; r++)
    for (size_t k = 0; k <= r; k++) {
      LineEnd end;
      end.reason = k == 0 ? EndReason::Outside : EndReason::Slow;
      ranks[r].ends.push_back(end);
    }
  ThreadRanks(3).run([&](Collectives& r) {
    const MadeLines made = makeLines(std::move(ranks[size_t(r.rank())]), {}, noLedger, r);
    std::array<uint64_t, kEndReasons> expected{};
    expected[size_t(EndReason::Outside)] = 3;
    expected[size_t(EndReason::Slow)] = 3;
    EXPECT_EQ(made.ends, expected);
    EXPECT_EQ(made.lines, 0u);
    EXPECT_TRUE(made.block.points.empty());
  });
}

}  // namespace
}  // namespace gxy::test
