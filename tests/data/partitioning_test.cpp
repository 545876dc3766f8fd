// SPDX-License-Identifier: Apache-2.0
#include "core/data/partitioning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/comm/error.h"
#include "tests/data/random_partitioning.h"

namespace gxy {
namespace {

using Faces = std::array<std::vector<double>, 3>;

Box boxOf(glm::dvec3 lo, glm::dvec3 hi) {
  Box b;
  b.lo = lo;
  b.hi = hi;
  return b;
}

/// How many partitions hold p by the half-open rule, and the last of them.
std::pair<int, int> holders(const Partitioning& parts, glm::dvec3 p) {
  int count = 0, last = -1;
  for (int i = 0; i < parts.partitions(); ++i) {
    bool inside = true;
    for (int a = 0; a < 3; ++a) {
      const double hi = parts.box(i).hi[a];
      inside =
          inside && p[a] >= parts.box(i).lo[a] && (p[a] < hi || (p[a] == hi && hi == parts.domain().hi[a]));
    }
    if (inside) {
      ++count;
      last = i;
    }
  }
  return {count, last};
}

TEST(Partitioning, EveryPointHasExactlyOnePartition) {
  std::mt19937 random(7);
  const Box domain = boxOf({-3, 1e6, 0}, {5, 1e6 + 1, 0.01});
  for (int parts = 1; parts <= 27; ++parts) {
    const Partitioning p = test::randomPartitioning(random, domain, parts, 4);
    ASSERT_EQ(p.partitions(), parts);
    for (int i = 0; i < 300; ++i) {
      glm::dvec3 point;
      for (int a = 0; a < 3; ++a) {
        const auto faces = p.faces(a);
        // One in two coordinates lies exactly on a face.
        point[a] = random() % 2 ? faces[random() % faces.size()]
                                : std::uniform_real_distribution<>(domain.lo[a], domain.hi[a])(random);
      }
      const auto [count, holder] = holders(p, point);
      ASSERT_EQ(count, 1);
      ASSERT_EQ(p.locate(point), holder);
    }
  }
}

TEST(Partitioning, PointsOutsideTheDomainHaveNone) {
  const Partitioning p = Partitioning::single(boxOf({0, 0, 0}, {1, 2, 3}));
  EXPECT_EQ(p.locate({0, 0, 0}), 0);
  EXPECT_EQ(p.locate({1, 2, 3}), 0);
  EXPECT_EQ(p.locate({std::nextafter(1.0, 2.0), 1, 1}), -1);
  EXPECT_EQ(p.locate({0.5, -1e-300, 1}), -1);
  EXPECT_EQ(p.locate({NAN, 1, 1}), -1);
  EXPECT_EQ(p.nearest({9, -9, 1}), 0);
}

TEST(Partitioning, LatticeSharesPartitionsEvenlyAmongRanks) {
  const Partitioning many = Partitioning::lattice({{{0, 1, 2, 3}, {0, 1, 2, 3}, {0, 1, 2, 3}}}, 4);
  size_t owned = 0;
  for (int r = 0; r < 4; ++r) {
    const size_t n = many.owned(r).size();
    EXPECT_TRUE(n == 6 || n == 7);
    owned += n;
  }
  EXPECT_EQ(owned, 27u);
  const Partitioning few = Partitioning::lattice({{{0, 1, 2}, {0, 1}, {0, 1}}}, 5);
  EXPECT_EQ(few.owned(0), std::vector<int>{0});
  EXPECT_TRUE(few.owned(1).empty());
  EXPECT_EQ(few.owned(2), std::vector<int>{1});
  EXPECT_TRUE(few.owned(17).empty());
}

TEST(Partitioning, InvalidTablesAreRefused) {
  const Faces faces{{{0, 1, 2}, {0, 1, 2}, {0, 1}}};
  EXPECT_NO_THROW(Partitioning(faces, {0, 0, 1, 1}, {0, 0}));
  EXPECT_THROW(Partitioning(faces, {0, 1, 1, 0}, {0, 0}), Error);  // no boxes
  EXPECT_THROW(Partitioning(faces, {0, 0, 0, 1}, {0, 0}), Error);  // an L
  EXPECT_THROW(Partitioning(faces, {0, 0, 0, 0}, {0, 0}), Error);  // partition 1 is empty
  EXPECT_THROW(Partitioning(faces, {0, 0, 2, 2}, {0, 0}), Error);  // no such partition
  EXPECT_THROW(Partitioning(faces, {0, 0, -1, -1}, {0}), Error);
  EXPECT_THROW(Partitioning(faces, {0, 0, 1}, {0, 0}), Error);      // table too short
  EXPECT_THROW(Partitioning(faces, {0, 0, 1, 1}, {0, -1}), Error);  // no such rank
  EXPECT_THROW(Partitioning::lattice({{{0, 1}, {0}, {0, 1}}}, 1), Error);
  EXPECT_THROW(Partitioning::lattice({{{0, 1}, {0, 0}, {0, 1}}}, 1), Error);
  EXPECT_THROW(Partitioning::lattice({{{0, 1}, {0, INFINITY}, {0, 1}}}, 1), Error);
  EXPECT_THROW(Partitioning::lattice({{{0, 1}, {0, 1}, {0, 1}}}, 0), Error);
}

TEST(Partitioning, BoxesWithNearlyEqualFacesFillTheirDomain) {
  const std::vector<Box> boxes{boxOf({0, 0, 0}, {0.3, 1, 1}), boxOf({0.3 + 1e-12, 0, 0}, {1, 0.5, 1}),
                               boxOf({0.3 - 1e-13, 0.5 + 1e-14, 0}, {1, 1, 1})};
  const Partitioning p = Partitioning::fromBoxes(boxes, {2, 0, 1});
  EXPECT_EQ(p.cells(), (std::array<int, 3>{2, 2, 1}));
  EXPECT_EQ(p.box(0).hi.x, p.box(1).lo.x);
  EXPECT_EQ(p.box(1).hi.y, p.box(2).lo.y);
  EXPECT_EQ(p.owner(0), 2);
  EXPECT_EQ(p.domain(), boxOf({0, 0, 0}, {1, 1, 1}));
}

TEST(Partitioning, OverlapsAndHolesAreRefused) {
  const Box left = boxOf({0, 0, 0}, {1, 1, 1}), right = boxOf({1, 0, 0}, {2, 1, 1});
  const auto pair = [&](const Box& other) {
    return Partitioning::fromBoxes(std::array{left, other}, {0, 0});
  };
  EXPECT_NO_THROW(pair(right));
  EXPECT_THROW(pair(boxOf({0.9, 0, 0}, {2, 1, 1})), Error);
  EXPECT_THROW(pair(boxOf({1.1, 0, 0}, {2, 1, 1})), Error);
  EXPECT_THROW(pair(boxOf({1, 0, 0}, {2, 0.5, 1})), Error);
  EXPECT_THROW(pair(boxOf({1, 0, 0}, {1, 1, 1})), Error);
  EXPECT_THROW(pair(Box{}), Error);
  EXPECT_THROW(Partitioning::fromBoxes(std::array{left, right}, {0}), Error);
  EXPECT_THROW(Partitioning::fromBoxes({}, {}), Error);
}

TEST(Partitioning, TouchedCellsMeetTheClosedIntervalAndReachOutwards) {
  const Partitioning p = Partitioning::lattice({{{0, 1, 2, 3}, {0, 1}, {0, 1}}}, 1);
  using Cells = std::array<int, 2>;
  EXPECT_EQ(p.cellsTouched(0, 1.5, 1.5), (Cells{1, 1}));
  EXPECT_EQ(p.cellsTouched(0, 1, 1), (Cells{0, 1}));
  EXPECT_EQ(p.cellsTouched(0, 0.5, 2), (Cells{0, 2}));
  EXPECT_EQ(p.cellsTouched(0, -9, -8), (Cells{0, 0}));
  EXPECT_EQ(p.cellsTouched(0, 8, 9), (Cells{2, 2}));
  EXPECT_EQ(p.cellsTouched(1, 8, 9), (Cells{0, 0}));
}

TEST(Decompose, BlocksFollowTheAspectOfTheGrid) {
  using Blocks = std::array<int, 3>;
  EXPECT_EQ(decompose(1, {5, 5, 5}), (Blocks{1, 1, 1}));
  EXPECT_EQ(decompose(8, {64, 64, 64}), (Blocks{2, 2, 2}));
  EXPECT_EQ(decompose(27, {64, 64, 64}), (Blocks{3, 3, 3}));
  EXPECT_EQ(decompose(2, {64, 64, 64}), (Blocks{1, 1, 2}));
  EXPECT_EQ(decompose(12, {64, 64, 64}), (Blocks{2, 2, 3}));
  EXPECT_EQ(decompose(4, {400, 10, 10}), (Blocks{4, 1, 1}));
  EXPECT_EQ(decompose(8, {100, 200, 10}), (Blocks{2, 4, 1}));
  EXPECT_EQ(decompose(7, {7, 1, 1}), (Blocks{7, 1, 1}));
}

TEST(Decompose, ImpossibleNumbersAreRefused) {
  EXPECT_THROW(decompose(0, {4, 4, 4}), Error);
  EXPECT_THROW(decompose(7, {4, 4, 4}), Error);
  EXPECT_THROW(decompose(65, {4, 4, 4}), Error);
  EXPECT_EQ(decompose(64, {4, 4, 4}), (std::array<int, 3>{4, 4, 4}));
}

TEST(EvenFaces, LieOnGridPointsAndDifferByOneCellAtMost) {
  for (int64_t cells : {1, 2, 7, 63, 100}) {
    for (int n = 1; n <= std::min<int64_t>(cells, 27); ++n) {
      const std::vector<double> f = evenFaces(-2, -2 + 0.5 * double(cells), n, cells);
      ASSERT_EQ(f.size(), size_t(n) + 1);
      EXPECT_EQ(f.front(), -2);
      EXPECT_EQ(f.back(), -2 + 0.5 * double(cells));
      for (int i = 0; i < n; ++i) {
        const double size = (f[i + 1] - f[i]) / 0.5;
        EXPECT_NEAR(size, std::round(size), 1e-12);
        EXPECT_GE(size, double(cells / n) - 1e-9);
        EXPECT_LE(size, double((cells + n - 1) / n) + 1e-9);
      }
    }
  }
  EXPECT_EQ(evenFaces(0, 1, 4, 0), (std::vector<double>{0, 0.25, 0.5, 0.75, 1}));
  EXPECT_THROW(evenFaces(0, 1, 4, 3), Error);
  EXPECT_THROW(evenFaces(0, 1, 0, 3), Error);
  EXPECT_THROW(evenFaces(1, 1, 1, 0), Error);
}

}  // namespace
}  // namespace gxy
