// SPDX-License-Identifier: Apache-2.0
#include "gxy/data/macrocells.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "gxy/comm/error.h"

namespace gxy {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int64_t kSize = kMacrocellSize;

/// Running minimum, maximum and no-data flag of a row of points, over the rows met so far.
struct RowSummary {
  std::vector<float> lo, hi;
  std::vector<uint32_t> bad;

  explicit RowSummary(size_t points) : lo(points), hi(points), bad(points) {}
  void reset() {
    std::fill(lo.begin(), lo.end(), kInfinity);
    std::fill(hi.begin(), hi.end(), -kInfinity);
    std::fill(bad.begin(), bad.end(), 0u);
  }
  /// Written so that compilers vectorise it: no branch, one pass, arrays that do not alias.
  void add(const float* __restrict__ row) {
    float* __restrict__ l = lo.data();
    float* __restrict__ h = hi.data();
    uint32_t* __restrict__ b = bad.data();
    const size_t n = lo.size();
    for (size_t x = 0; x < n; ++x) {
      const float v = row[x];
      const bool finite = v - v == 0;
      const float below = finite ? v : kInfinity, above = finite ? v : -kInfinity;
      l[x] = below < l[x] ? below : l[x];
      h[x] = above > h[x] ? above : h[x];
      b[x] |= finite ? 0u : 1u;
    }
  }
  Macrocell over(int64_t first, int64_t last) const {
    Macrocell m{kInfinity, -kInfinity, false};
    for (int64_t x = first; x <= last; ++x) {
      m.min = std::min(m.min, lo[x]);
      m.max = std::max(m.max, hi[x]);
      m.noData |= bad[x] != 0;
    }
    return m;
  }
};

/// Rows of a block as float, one summary (component or magnitude) at a time.
class Rows {
 public:
  Rows(const VolumeBlock& block, ScalarType stored, int components)
      : block_(block), stored_(stored), components_(components), row_(size_t(block.extent.points[0])) {}

  const float* operator()(int64_t y, int64_t z, int summary) {
    const Extent& e = block_.extent;
    const size_t first = size_t((z * e.points[1] + y) * e.points[0]) * size_t(components_);
    const std::byte* at = block_.samples.data() + first * bytesOf(stored_);
    if (stored_ == ScalarType::Float32 && components_ == 1) return reinterpret_cast<const float*>(at);
    withType(stored_, [&](auto t) {
      using T = decltype(t);
      if (summary < components_) {
        component(reinterpret_cast<const T*>(at) + summary);
      } else {
        magnitude(reinterpret_cast<const T*>(at));
      }
    });
    return row_.data();
  }

 private:
  template <typename T>
  void component(const T* from) {
    for (size_t x = 0; x < row_.size(); ++x) row_[x] = float(from[x * size_t(components_)]);
  }
  template <typename T>
  void magnitude(const T* from) {
    for (size_t x = 0; x < row_.size(); ++x) {
      float squares = 0;
      for (int c = 0; c < components_; ++c) {
        const float v = float(*from++);
        squares += v * v;
      }
      row_[x] = std::sqrt(squares);
    }
  }

  const VolumeBlock& block_;
  const ScalarType stored_;
  const int components_;
  std::vector<float> row_;
};

/// The points of macrocell `m` on an axis that lie in the extent, relative to its first point.
struct PointSpan {
  int64_t first, last;
};
PointSpan pointsOf(const Extent& e, int axis, int64_t m) {
  return {std::max<int64_t>(m * kSize - e.first[axis], 0),
          std::min<int64_t>((m + 1) * kSize - e.first[axis], e.points[axis] - 1)};
}

size_t indexOf(const VolumeBlock& block, const Index3& macrocell) {
  const Index3 &n = block.macrocells, &f = block.firstMacrocell;
  return size_t(((macrocell[2] - f[2]) * n[1] + macrocell[1] - f[1]) * n[0] + macrocell[0] - f[0]);
}

/// Whether a macrocell lies so deep inside a block that no other block holds any of its cells. The block's
/// extent ends at most kGhostLayers and a cell outside its partition, and that of a neighbour reaches as far
/// into it. Ends of the grid are no exception: the partition may end up to that far before them.
bool isPrivate(const VolumeBlock& block, const Index3& macrocell) {
  constexpr int64_t kReach = 2 * (kGhostLayers + 1);
  for (int a = 0; a < 3; ++a) {
    const int64_t first = block.extent.first[a], last = first + block.extent.points[a] - 1;
    if (macrocell[a] * kSize < first + kReach) return false;
    if ((macrocell[a] + 1) * kSize > last - kReach) return false;
  }
  return true;
}

}  // namespace

void summarise(VolumeBlock& block, ScalarType stored, int components) {
  const Extent& e = block.extent;
  if (bytesOf(stored) > 4 || stored == ScalarType::Int32 || stored == ScalarType::UInt32) {
    throw Error(std::string("macrocells: samples stored as ") + nameOf(stored) +
                ", expected 8 or 16 bits or float32");
  }
  if (components < 1 || block.samples.size() != size_t(e.count()) * size_t(components) * bytesOf(stored)) {
    throw Error("macrocells: a block of " + std::to_string(block.samples.size()) + " bytes, expected " +
                std::to_string(e.count()) + " points of " + std::to_string(components) + " x " +
                nameOf(stored));
  }
  block.summaries.assign(components > 1 ? size_t(components) + 1 : 1, {});
  block.firstMacrocell = block.macrocells = {0, 0, 0};
  if (e.count() == 0) return;
  for (int a = 0; a < 3; ++a) {
    // By cells: a last point that lies on a macrocell's first plane does not touch that macrocell.
    block.firstMacrocell[a] = e.first[a] / kSize;
    const int64_t lastCell = e.first[a] + std::max<int64_t>(e.points[a] - 2, 0);
    block.macrocells[a] = lastCell / kSize - block.firstMacrocell[a] + 1;
  }
  const Index3 &n = block.macrocells, &f = block.firstMacrocell;
  Rows rows(block, stored, components);
  RowSummary row(size_t(e.points[0]));
  for (size_t s = 0; s < block.summaries.size(); ++s) {
    std::vector<Macrocell>& cells = block.summaries[s];
    cells.reserve(size_t(n[0] * n[1] * n[2]));
    for (int64_t k = 0; k < n[2]; ++k) {
      for (int64_t j = 0; j < n[1]; ++j) {
        const PointSpan zs = pointsOf(e, 2, f[2] + k), ys = pointsOf(e, 1, f[1] + j);
        row.reset();
        for (int64_t z = zs.first; z <= zs.last; ++z) {
          for (int64_t y = ys.first; y <= ys.last; ++y) row.add(rows(y, z, int(s)));
        }
        for (int64_t i = 0; i < n[0]; ++i) {
          const PointSpan xs = pointsOf(e, 0, f[0] + i);
          cells.push_back(row.over(xs.first, xs.last));
        }
      }
    }
  }
}

std::vector<BorderSummary> borderSummaries(const Volume& volume) {
  std::vector<BorderSummary> records;
  for (const auto& [partition, block] : volume.blocks) {
    const Index3 &n = block.macrocells, &f = block.firstMacrocell;
    for (int64_t k = 0; k < n[2]; ++k) {
      for (int64_t j = 0; j < n[1]; ++j) {
        for (int64_t i = 0; i < n[0]; ++i) {
          const Index3 at{f[0] + i, f[1] + j, f[2] + k};
          if (isPrivate(block, at)) continue;
          for (size_t s = 0; s < block.summaries.size(); ++s) {
            const Macrocell& m = block.summaries[s][indexOf(block, at)];
            records.push_back({at, int32_t(s), m.noData, m.min, m.max});
          }
        }
      }
    }
  }
  return records;
}

void mergeSummaries(Volume& volume, std::span<const BorderSummary> records) {
  const int32_t summaries = volume.components > 1 ? volume.components + 1 : 1;
  const Index3 cells = volume.grid.cells();
  for (const BorderSummary& r : records) {
    bool valid = r.summary >= 0 && r.summary < summaries;
    for (int a = 0; a < 3; ++a) valid = valid && r.macrocell[a] >= 0 && r.macrocell[a] * kSize < cells[a];
    if (!valid) {
      throw Error("macrocells: a record for macrocell " + std::to_string(r.macrocell[0]) + ", " +
                  std::to_string(r.macrocell[1]) + ", " + std::to_string(r.macrocell[2]) + ", summary " +
                  std::to_string(r.summary) + " came, expected one inside the grid of " + volume.name);
    }
    for (auto& [partition, block] : volume.blocks) {
      bool inside = true;
      for (int a = 0; a < 3; ++a) {
        const int64_t at = r.macrocell[a] - block.firstMacrocell[a];
        inside = inside && at >= 0 && at < block.macrocells[a];
      }
      if (!inside) continue;
      Macrocell& m = block.summaries[size_t(r.summary)][indexOf(block, r.macrocell)];
      m.min = std::min(m.min, r.min);
      m.max = std::max(m.max, r.max);
      m.noData |= r.noData != 0;
    }
  }
}

}  // namespace gxy
