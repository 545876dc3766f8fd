// SPDX-License-Identifier: Apache-2.0
#include "core/data/ghosts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/random.h"
#include "core/data/bricks.h"
#include "core/data/complete_volume.h"
#include "tests/data/random_partitioning.h"
#include "tests/support/seeds.h"
#include "tests/support/thread_ranks.h"

namespace gxy {
namespace {

/// Collective operations of a rank, whose messages to the other ranks are counted, and which can be cancelled.
class Watched final : public Collectives {
 public:
  explicit Watched(Collectives& ranks) : sent(size_t(ranks.size())), ranks_(ranks) {}
  int rank() const override { return ranks_.rank(); }
  int size() const override { return ranks_.size(); }
  std::vector<Bytes> allGather(Bytes mine) override { return ranks_.allGather(std::move(mine)); }
  std::vector<Bytes> allToAll(std::vector<Bytes> perRank) override {
    ++exchanges;
    for (size_t r = 0; r < perRank.size(); ++r) sent[r] += perRank[r].size();
    return ranks_.allToAll(std::move(perRank));
  }
  void check() const override {
    if (cancelled) throw Error("cancelled");
  }

  std::vector<size_t> sent;  ///< bytes, by rank
  int exchanges = 0;
  bool cancelled = false;

 private:
  Collectives& ranks_;
};

/// A field of a test: what its samples are at each point of the grid.
struct Field {
  ScalarType type = ScalarType::Float32;
  int components = 1;
  uint64_t seed = 0;

  size_t bytesPerPoint() const { return bytesOf(type) * size_t(components); }

  /// Writes the samples of a point. Their bits are random, so floating-point samples are NaNs and infinities, too.
  void write(const Index3& point, std::byte* to) const {
    Random random(seed + uint64_t(point[0] + 1000 * (point[1] + 1000 * point[2])) * 0x9e3779b9u);
    for (size_t i = 0; i < bytesPerPoint(); ++i) to[i] = std::byte(random.next() >> 56);
  }
};

template <class Use>
void forPoints(const Extent& extent, Use use) {
  for (int64_t z = 0; z < extent.points[2]; ++z)
    for (int64_t y = 0; y < extent.points[1]; ++y)
      for (int64_t x = 0; x < extent.points[0]; ++x)
        use(Index3{extent.first[0] + x, extent.first[1] + y, extent.first[2] + z});
}

/// The place of a point in a block, in bricks or x fastest, counted in points.
enum class Order { Bricks, Rows };
size_t placeIn(const Extent& extent, const Index3& point, Order order = Order::Bricks) {
  const int64_t x = point[0] - extent.first[0], y = point[1] - extent.first[1],
                z = point[2] - extent.first[2];
  if (order == Order::Bricks) return Bricks(extent.points)(x, y, z);
  return size_t((z * extent.points[1] + y) * extent.points[0] + x);
}

/// The blocks of a rank, in which each byte has the value `poison`.
Volume emptyVolume(const Grid& grid, const Partitioning& cut, int ghosts, int rank, ScalarType type,
                   int components, std::byte poison) {
  Volume volume;
  volume.name = "density";
  volume.grid = grid;
  volume.stored = type;
  volume.components = components;
  for (const int partition : cut.owned(rank)) {
    const Extent extent = extentOf(grid, cut.box(partition), ghosts);
    if (extent.count() == 0) continue;
    VolumeBlock& block = volume.blocks[partition];
    block.extent = extent;
    block.samples.assign(Bricks(extent.points).count() * bytesOf(type) * size_t(components), poison);
  }
  return volume;
}

/// The blocks of a rank. Points that their partition owns have the field's samples; the others have other bits.
Volume ownedSamples(const Grid& grid, const Partitioning& cut, int ghosts, int rank, const Field& field) {
  Volume volume = emptyVolume(grid, cut, ghosts, rank, field.type, field.components, std::byte(0xa5));
  for (auto& entry : volume.blocks)
    forPoints(ownedPoints(grid, cut, entry.first), [&, &block = entry.second](const Index3& point) {
      field.write(point, block.samples.data() + placeIn(block.extent, point) * field.bytesPerPoint());
    });
  return volume;
}

/// The number of points in a volume's blocks whose samples are not those of the field, bit for bit.
int64_t wrongPoints(const Volume& volume, const Field& field) {
  const size_t size = field.bytesPerPoint();
  std::vector<std::byte> expected(size);
  int64_t wrong = 0;
  for (const auto& entry : volume.blocks)
    forPoints(entry.second.extent, [&, &block = entry.second](const Index3& point) {
      field.write(point, expected.data());
      const std::byte* found = block.samples.data() + placeIn(block.extent, point) * size;
      wrong += std::memcmp(expected.data(), found, size) != 0;
    });
  return wrong;
}

std::string describe(const Grid& grid, const Partitioning& cut, int ghosts, int ranks) {
  std::string text = std::to_string(cut.partitions()) + " partitions on " + std::to_string(ranks) +
                     " ranks, " + std::to_string(ghosts) + " layers, points";
  for (const int64_t n : grid.points) text += " " + std::to_string(n);
  return text;
}

/// Exchanges the ghosts of some fields on threads, and expects that each block has the samples of all its points.
void expectGhosts(const Grid& grid, const Partitioning& cut, int ghosts, int size,
                  const std::vector<Field>& fields) {
  test::ThreadRanks threads(size);
  const std::string what = describe(grid, cut, ghosts, size);
  const auto errors = threads.run([&](Collectives& threadRank) {
    Watched ranks(threadRank);
    const GhostPlan plan(grid, cut, ghosts, ranks.rank(), size);
    std::vector<Volume> volumes;
    for (const Field& field : fields) volumes.push_back(ownedSamples(grid, cut, ghosts, ranks.rank(), field));
    std::vector<Volume*> pointers;
    for (Volume& volume : volumes) pointers.push_back(&volume);
    exchangeGhosts(pointers, plan, ranks);
    for (size_t f = 0; f < fields.size(); ++f)
      EXPECT_EQ(wrongPoints(volumes[f], fields[f]), 0) << what << ", field " << f;
    EXPECT_EQ(ranks.exchanges, 1) << "all fields go together";
    EXPECT_EQ(ranks.sent[size_t(ranks.rank())], 0u) << "a rank sends nothing to itself";
  });
  EXPECT_EQ(errors, std::vector<std::string>(size_t(size))) << what;
}

Grid randomGrid(Random& random) {
  Grid grid;
  grid.rim = random.oneIn(3);
  for (int a = 0; a < 3; ++a) {
    grid.origin[a] = double(random.below(2000)) / 7 - 100;
    grid.spacing[a] = double(1 + random.below(1000)) / 300;
    grid.points[size_t(a)] = 3 + int64_t(random.below(16));
  }
  return grid;
}

/// Returns the domain of the grid, or one that is up to 3 cells larger on some sides.
Box randomDomain(Random& random, const Grid& grid) {
  Box domain = grid.box();
  for (int a = 0; a < 3; ++a) {
    if (random.oneIn(3)) domain.lo[a] -= grid.spacing[a] * double(random.below(30)) / 10;
    if (random.oneIn(3)) domain.hi[a] += grid.spacing[a] * double(random.below(30)) / 10;
  }
  return domain;
}

/// Cuts a domain by random faces, half of which lie on points of the grid. Owners are random, too.
Partitioning randomLattice(Random& random, const Grid& grid, const Box& domain, int ranks) {
  std::array<std::vector<double>, 3> faces;
  size_t parts = 1;
  for (int a = 0; a < 3; ++a) {
    std::set<double> all{domain.lo[a], domain.hi[a]};
    for (uint64_t n = random.below(6); n > 0; --n) {
      const auto points = uint64_t(grid.points[size_t(a)]);
      const double plane =
          random.oneIn(2) ? double(random.below(points)) : double(random.below(1000 * points)) / 1000;
      const double face = grid.origin[a] + grid.spacing[a] * plane;
      if (face > domain.lo[a] && face < domain.hi[a]) all.insert(face);
    }
    faces[size_t(a)].assign(all.begin(), all.end());
    parts *= all.size() - 1;
  }
  std::vector<int32_t> cells, owners;
  for (size_t p = 0; p < parts; ++p) {
    cells.push_back(int32_t(p));
    owners.push_back(int32_t(random.below(uint64_t(ranks))));
  }
  return Partitioning(faces, cells, owners);
}

std::vector<Field> randomFields(Random& random) {
  std::vector<Field> fields;
  for (uint64_t n = 1 + random.below(3); n > 0; --n)
    fields.push_back({ScalarType(random.below(10)), int(1 + random.below(3)), random.next()});
  return fields;
}

/// Cuts a box again and again, as a k-d tree does. Owners are random.
Partitioning kdCut(uint64_t seed, const Box& domain, int parts, int ranks) {
  std::mt19937 random{unsigned(seed)};
  return test::randomPartitioning(random, domain, parts, ranks);
}

TEST(Ghosts, EachBlockGetsThePointsOfAnyLattice) {
  for (int seed = 0; seed < test::seeds(120); ++seed) {
    Random random{uint64_t(seed)};
    const int ranks = 1 + seed % 5, ghosts = int(random.below(6));
    const Grid grid = randomGrid(random);
    const Partitioning cut = randomLattice(random, grid, randomDomain(random, grid), ranks);
    expectGhosts(grid, cut, ghosts, ranks, randomFields(random));
    ASSERT_FALSE(HasFailure()) << "seed " << seed;
  }
}

TEST(Ghosts, EachBlockGetsThePointsOfAnyBoxes) {
  for (int seed = 0; seed < test::seeds(80); ++seed) {
    Random random{uint64_t(seed)};
    const int ranks = 1 + seed % 5, ghosts = int(random.below(6)), parts = 1 + int(random.below(24));
    const Grid grid = randomGrid(random);
    const Partitioning cut = kdCut(random.next(), randomDomain(random, grid), parts, ranks);
    expectGhosts(grid, cut, ghosts, ranks, randomFields(random));
    ASSERT_FALSE(HasFailure()) << "seed " << seed;
  }
}

TEST(Ghosts, ComeFromBeyondTheNextPartitionIfThatIsThin) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {17, 4, 3}};
  const auto slabs = [](int parts, int ranks) {
    return Partitioning::lattice(
        {evenFaces(0, 16, parts, 0), std::vector<double>{0, 3}, std::vector<double>{0, 2}}, ranks);
  };
  // Slabs are a cell thick, or a third of a cell, so that most own no point.
  for (const int parts : {16, 48})
    expectGhosts(grid, slabs(parts, 5), kGhostLayers, 5,
                 {{ScalarType::Float64, 1, 1}, {ScalarType::UInt8, 3, 2}});
  const GhostPlan plan(grid, slabs(16, 16), kGhostLayers, 0, 16);
  EXPECT_EQ(plan.receivedFrom(5).size(), 1u) << "the last point of the block is the first of partition 5";
  EXPECT_EQ(plan.receivedFrom(6).size(), 0u);
}

TEST(Ghosts, BothRanksListTheSamePieces) {
  Random random(7);
  for (int i = 0; i < 10; ++i) {
    const Grid grid = randomGrid(random);
    const int ranks = 6;
    const Partitioning cut = kdCut(random.next(), randomDomain(random, grid), 30, ranks);
    std::vector<GhostPlan> plans;
    for (int r = 0; r < ranks; ++r) plans.emplace_back(grid, cut, kGhostLayers, r, ranks);
    for (int from = 0; from < ranks; ++from)
      for (int to = 0; to < ranks; ++to)
        EXPECT_TRUE(std::ranges::equal(plans[size_t(from)].sentTo(to), plans[size_t(to)].receivedFrom(from)));
  }
}

TEST(Ghosts, NothingIsSentToRanksThatShareNone) {
  // Four slabs of 10 points each, one on each rank.
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {40, 3, 5}};
  const std::vector<double> x{0, 10, 20, 30, 39}, y{0, 2}, z{0, 4};
  const Partitioning slabs = Partitioning::lattice({x, y, z}, 4);
  const Field field{ScalarType::Int16, 2, 3};
  test::ThreadRanks four(4);
  const auto errors = four.run([&](Collectives& threadRank) {
    Watched ranks(threadRank);
    Volume volume = ownedSamples(grid, slabs, kGhostLayers, ranks.rank(), field);
    Volume* const pointer = &volume;
    exchangeGhosts(std::span(&pointer, 1), GhostPlan(grid, slabs, kGhostLayers, ranks.rank(), 4), ranks);
    for (int r = 0; r < 4; ++r) {
      // The lower neighbour also needs the points of the face between the two.
      const size_t layers = r == ranks.rank() + 1   ? kGhostLayers
                            : r == ranks.rank() - 1 ? kGhostLayers + 1
                                                    : 0;
      EXPECT_EQ(ranks.sent[size_t(r)], layers * 3 * 5 * 4) << ranks.rank() << " to " << r;
    }
  });
  EXPECT_EQ(errors, std::vector<std::string>(4));
}

template <class T>
ScalarType scalarTypeOf() {
  return std::is_same_v<T, double> ? ScalarType::Float64 : ScalarType::Float32;
}

/// A wave around a large offset, with one NaN.
double waveAt(const Index3& p) {
  if (p == Index3{3, 4, 5}) return NAN;
  return 1e5 + std::sin(double(p[0] + 21 * (p[1] + 18 * p[2])) * 0.37);
}

/// The blocks of a rank, x fastest, with the wave at all points.
template <class T>
Volume wholeWave(const Grid& grid, const Partitioning& cut, int rank) {
  Volume volume = emptyVolume(grid, cut, kGhostLayers, rank, scalarTypeOf<T>(), 1, std::byte(0));
  for (auto& entry : volume.blocks) {
    entry.second.samples.resize(size_t(entry.second.extent.count()) * sizeof(T));
    forPoints(entry.second.extent, [&, &block = entry.second](const Index3& point) {
      const T value = T(waveAt(point));
      std::memcpy(block.samples.data() + placeIn(block.extent, point, Order::Rows) * sizeof(T), &value,
                  sizeof(T));
    });
  }
  return volume;
}

/// The same in bricks, with the wave at points that are owned. The others have a value that would change every range.
template <class T>
Volume ownedWave(const Grid& grid, const Partitioning& cut, int rank) {
  Volume volume = emptyVolume(grid, cut, kGhostLayers, rank, scalarTypeOf<T>(), 1, std::byte(0));
  for (auto& entry : volume.blocks) {
    const auto write = [&block = entry.second](const Index3& point, T value) {
      std::memcpy(block.samples.data() + placeIn(block.extent, point) * sizeof(T), &value, sizeof(T));
    };
    forPoints(entry.second.extent, [&](const Index3& point) { write(point, T(-1e30)); });
    forPoints(ownedPoints(grid, cut, entry.first),
              [&](const Index3& point) { write(point, T(waveAt(point))); });
  }
  return volume;
}

/// Statistics of the wave at the points that a rank owns.
template <class T>
FieldStatistics ownedStatistics(const Grid& grid, const Partitioning& cut, int rank) {
  FieldStatistics statistics;
  for (const int partition : cut.owned(rank))
    forPoints(ownedPoints(grid, cut, partition), [&](const Index3& point) {
      const T value = T(waveAt(point));
      statistics.merge(statisticsOf(std::as_bytes(std::span(&value, 1)), scalarTypeOf<T>(), 1));
    });
  return statistics;
}

template <class T>
void expectThatOfWholeBlocks(const Grid& grid, const Partitioning& cut) {
  test::ThreadRanks three(3);
  const auto errors = three.run([&](Collectives& ranks) {
    Volume whole = wholeWave<T>(grid, cut, ranks.rank());
    Volume mine = ownedWave<T>(grid, cut, ranks.rank());
    Volume* const pointer = &mine;
    exchangeGhosts(std::span(&pointer, 1), GhostPlan(grid, cut, kGhostLayers, ranks.rank(), 3), ranks);
    EXPECT_EQ(needsStatistics(mine, cut), (std::is_same_v<T, double>));
    completeVolume(whole, cut, ranks);
    completeBricks(
        mine, cut, ranks,
        std::is_same_v<T, double> ? ownedStatistics<T>(grid, cut, ranks.rank()) : FieldStatistics{}, 1);
    const FieldStatistics all = ownedStatistics<T>(grid, decomposed(grid, 1, 1), 0);
    for (const Volume& volume : {std::cref(whole), std::cref(mine)}) {
      EXPECT_EQ(volume.ranges, all.ranges);
      EXPECT_EQ(volume.noDataSamples, 1);
    }
    EXPECT_EQ(mine.stored, whole.stored);
    EXPECT_EQ(mine.shift, whole.shift);
    EXPECT_EQ(mine.scale, whole.scale);
    EXPECT_EQ(mine.blocks.size(), whole.blocks.size());
    for (const auto& [partition, block] : whole.blocks) {
      EXPECT_EQ(mine.blocks.at(partition).samples, block.samples);
      EXPECT_EQ(mine.blocks.at(partition).summaries, block.summaries);
    }
  });
  EXPECT_EQ(errors, std::vector<std::string>(3));
}

TEST(Ghosts, ACompletedVolumeIsThatOfWholeBlocks) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {21, 18, 15}};
  for (uint64_t seed = 0; seed < 6; ++seed) {
    const Partitioning cut = kdCut(seed, grid.box(), 9, 3);
    expectThatOfWholeBlocks<double>(grid, cut);
    expectThatOfWholeBlocks<float>(grid, cut);
  }
}

std::string errorOf(const Grid& grid, const Partitioning& cut, int ghosts, int ranks) {
  try {
    GhostPlan(grid, cut, ghosts, 0, ranks);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(Ghosts, AGridThatIsNotCoveredIsAnError) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {9, 8, 7}};
  const auto cut = [](glm::dvec3 lo, glm::dvec3 hi) { return kdCut(1, {lo, hi}, 5, 1); };
  EXPECT_EQ(errorOf(grid, cut({0, 0, 0}, {8, 7, 6}), 4, 1), "");
  EXPECT_EQ(errorOf(grid, cut({0.5, 0.5, 0.5}, {7.5, 6.5, 5.5}), 4, 1), "")
      << "all cells that are touched have owners";
  EXPECT_EQ(errorOf(grid, cut({0, 0, 1}, {8, 7, 6}), 4, 1),
            "ghosts: no partition owns point (0, 0, 0) of the grid, expected partitions that cover it");
  EXPECT_EQ(errorOf(grid, cut({0, 0, 0}, {8, 5.5, 6}), 4, 1),
            "ghosts: no partition owns point (8, 7, 6) of the grid, expected partitions that cover it");
  EXPECT_NE(errorOf(grid, cut({20, 0, 0}, {30, 7, 6}), 4, 1), "");
}

TEST(Ghosts, WrongNumbersAreErrors) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {9, 8, 7}};
  EXPECT_EQ(errorOf(grid, decomposed(grid, 4, 4), 4, 3),
            "ghosts: partition 3 is owned by rank 3, expected fewer than 3");
  EXPECT_EQ(errorOf(grid, decomposed(grid, 4, 4), -1, 4), "ghosts: -1 layers, expected 0 or more");
}

/// Exchanges the ghosts of a volume on two ranks and returns their errors. `change` may change what a rank gives.
template <class Change>
std::vector<std::string> errorsOf(Change change) {
  const Grid grid{{0, 0, 0}, {1, 1, 1}, {9, 8, 7}};
  const Partitioning cut = decomposed(grid, 4, 2);
  test::ThreadRanks two(2);
  return two.run([&](Collectives& threadRank) {
    Watched ranks(threadRank);
    Volume volume = ownedSamples(grid, cut, kGhostLayers, ranks.rank(), {});
    std::vector<Volume*> volumes{&volume};
    int planRank = ranks.rank();
    change(ranks, volumes, planRank);
    exchangeGhosts(volumes, GhostPlan(grid, cut, kGhostLayers, planRank, 2), ranks);
  });
}

TEST(Ghosts, AnErrorOnOneRankIsThrownOnAll) {
  const auto expectOnBoth = [](const std::vector<std::string>& errors, const std::string& part) {
    EXPECT_EQ(errors[0].find("rank 1: "), 0u) << errors[0];
    EXPECT_NE(errors[0].find(part), std::string::npos) << errors[0];
    EXPECT_EQ(errors[0], errors[1]);
  };
  const auto onRank1 = [](auto change) {
    return errorsOf([change](Watched& ranks, std::vector<Volume*>& volumes, int& planRank) {
      if (ranks.rank() == 1) change(ranks, volumes, planRank);
    });
  };
  using Volumes = std::vector<Volume*>;
  EXPECT_EQ(onRank1([](Watched&, Volumes&, int&) {}), std::vector<std::string>(2));
  expectOnBoth(onRank1([](Watched& ranks, Volumes&, int&) { ranks.cancelled = true; }), "cancelled");
  expectOnBoth(onRank1([](Watched&, Volumes&, int& planRank) { planRank = 0; }),
               "the plan is for rank 0 of 2, expected rank 1 of 2");
  expectOnBoth(onRank1([](Watched&, Volumes& volumes, int&) { volumes[0]->blocks.erase(3); }),
               "volume 'density', partition 3: there is no block with the extent of the plan");
  expectOnBoth(onRank1([](Watched&, Volumes& volumes, int&) { ++volumes[0]->blocks.at(2).extent.points[0]; }),
               "volume 'density', partition 2: there is no block with the extent of the plan");
  expectOnBoth(onRank1([](Watched&, Volumes& volumes, int&) { volumes[0]->blocks.at(2).samples.pop_back(); }),
               "bytes of samples, expected ");
}

TEST(Ghosts, RanksThatGiveDifferentVolumesGetAnError) {
  const auto errors = errorsOf([](Watched& ranks, std::vector<Volume*>& volumes, int&) {
    if (ranks.rank() == 1) volumes.clear();
  });
  EXPECT_EQ(errors[0].find("rank 0: ghosts: rank 1 has sent 0 bytes of samples, expected "), 0u) << errors[0];
  EXPECT_EQ(errors[0], errors[1]);
}

}  // namespace
}  // namespace gxy
