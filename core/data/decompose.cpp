// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <tuple>

#include "core/comm/error.h"
#include "core/data/partitioning.h"

namespace gxy {

std::array<int, 3> decompose(int parts, std::array<int64_t, 3> cells) {
  if (parts < 1)
    throw Error("decompose: " + std::to_string(parts) + " partitions asked for, expected 1 or more");
  const double nx = double(cells[0]), ny = double(cells[1]), nz = double(cells[2]);
  // (cut surface, -k, -j): the least one wins.
  std::tuple<double, int, int> best;
  std::array<int, 3> blocks{0, 0, 0};
  for (int k = 1; k <= parts; ++k) {
    if (parts % k != 0 || k > cells[2]) continue;
    for (int j = 1; j <= parts / k; ++j) {
      const int i = parts / k / j;
      if (i * j * k != parts || j > cells[1] || i > cells[0]) continue;
      const double surface = (i - 1) * ny * nz + (j - 1) * nx * nz + (k - 1) * nx * ny;
      const std::tuple candidate{surface, -k, -j};
      if (blocks[0] == 0 || candidate < best) {
        best = candidate;
        blocks = {i, j, k};
      }
    }
  }
  if (blocks[0] == 0) {
    throw Error("decompose: a grid of " + std::to_string(cells[0]) + " x " + std::to_string(cells[1]) +
                " x " + std::to_string(cells[2]) + " cells has no division into " + std::to_string(parts) +
                " blocks of one cell or more; ask for another number of partitions");
  }
  return blocks;
}

std::vector<double> evenFaces(double lo, double hi, int n, int64_t cells) {
  if (n < 1) throw Error("evenFaces: " + std::to_string(n) + " blocks asked for, expected 1 or more");
  if (!(lo < hi) || !std::isfinite(hi - lo)) {
    throw Error("evenFaces: [" + std::to_string(lo) + ", " + std::to_string(hi) +
                "] cannot be cut, expected finite ends in ascending order");
  }
  if (cells > 0 && n > cells) {
    throw Error("evenFaces: " + std::to_string(cells) + " cells cannot be cut into " + std::to_string(n) +
                " blocks, expected one cell or more in each");
  }
  std::vector<double> faces(size_t(n) + 1);
  for (int i = 0; i <= n; ++i) {
    // floor(i * cells / n) without overflow, and a fraction of the interval.
    const int64_t cell = cells / n * i + cells % n * i / n;
    const double fraction = cells > 0 ? double(cell) / double(cells) : double(i) / n;
    faces[i] = lo + (hi - lo) * fraction;
  }
  faces[n] = hi;
  return faces;
}

}  // namespace gxy
