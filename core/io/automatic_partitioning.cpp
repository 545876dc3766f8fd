// SPDX-License-Identifier: Apache-2.0
#include "core/io/automatic_partitioning.h"

#include <algorithm>
#include <cmath>

#include "core/comm/error.h"

namespace gxy {

namespace {

// With this limit a partition's samples stay below 2^31 bytes for up to 7 bytes per point. Above 2^31 bytes,
// kernels need 64-bit offsets and more time.
constexpr int64_t kMostPoints = int64_t(1) << 28;

// A partitioning needs a box with thickness on every axis.
Box thickened(Box box) {
  if (box.empty()) return {glm::dvec3(-1), glm::dvec3(1)};
  const glm::dvec3 size = box.hi - box.lo;
  const double longest = std::max({size.x, size.y, size.z});
  const double least = longest > 0 ? 1e-3 * longest : 1e-3 * std::max(1.0, std::abs(box.lo.x));
  for (int a = 0; a < 3; a++)
    if (size[a] < least) box.lo[a] -= 0.5 * least, box.hi[a] += 0.5 * least;
  return box;
}

// Decomposes into `parts` blocks, or, if the grid has no such division, into the largest smaller number that
// it has.
std::array<int, 3> decomposeAtMost(int parts, const Index3& cells) {
  for (;; parts--) {
    try {
      return decompose(parts, cells);
    } catch (const Error&) {
      if (parts <= 1) throw;
    }
  }
}

}  // namespace

std::shared_ptr<const Partitioning> automaticPartitioning(const Box& data, const Grid* grid,
                                                          std::array<int, 3> wanted, int ranks) {
  const Box domain = thickened(data);
  // Without a grid that fills the domain, a fine lattice stands for it.
  const bool onGrid = grid && grid->box() == domain;
  const glm::dvec3 size = domain.hi - domain.lo;
  const double longest = std::max({size.x, size.y, size.z});
  Index3 cells{};
  for (int a = 0; a < 3; a++)
    cells[a] =
        onGrid ? grid->cells()[a] : std::max<int64_t>(1, int64_t(std::ceil(1048576 * size[a] / longest)));
  if (wanted[0] == 0) {
    const Index3 points = grid ? grid->points : Index3{1, 1, 1};
    const int64_t parts = std::max<int64_t>(ranks, points[0] * points[1] * points[2] / kMostPoints + 1);
    wanted = decomposeAtMost(int(parts), cells);
  }
  if (wanted[1] == 0) wanted = decompose(wanted[0], cells);
  std::array<std::vector<double>, 3> faces;
  for (int a = 0; a < 3; a++)
    faces[a] = evenFaces(domain.lo[a], domain.hi[a], wanted[a], onGrid ? cells[a] : 0);
  return std::make_shared<Partitioning>(Partitioning::lattice(faces, ranks));
}

}  // namespace gxy
