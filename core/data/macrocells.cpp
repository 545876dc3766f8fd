// SPDX-License-Identifier: Apache-2.0
#include "core/data/macrocells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/comm/error.h"
#include "core/data/bricks.h"

namespace gxy {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int64_t kSize = kMacrocellSize;

/// Extremes over the rows of points of one row of macrocells, by x: of a point itself (lo_, hi_, steep_, bend_),
/// of it and the next point in x (steepNext_, bendNext_), and of it and both its neighbours in x (bendBoth_).
class RowSummary {
 public:
  explicit RowSummary(size_t points)
      : lo_(points),
        hi_(points),
        steep_(points),
        bend_(points),
        steepNext_(points),
        bendNext_(points),
        bendBoth_(points),
        bad_(points) {}

  void reset() {
    std::fill(lo_.begin(), lo_.end(), kInfinity);
    std::fill(hi_.begin(), hi_.end(), -kInfinity);
    for (auto* v : {&steep_, &bend_, &steepNext_, &bendNext_, &bendBoth_})
      std::fill(v->begin(), v->end(), 0.f);
    std::fill(bad_.begin(), bad_.end(), 0u);
  }

  // Each loop is written so that compilers vectorise it: no branch, one pass, arrays that do not alias. A
  // difference of a NaN or an infinity is NaN or infinite, and so fails the comparisons in widen(). With
  // Take::Any infinite differences are taken: half the work, which is done anew if there are any.
  enum class Take { Any, Finite };
  bool hasInfiniteDifferences() const {
    for (const auto* v : {&steep_, &bend_, &steepNext_, &bendNext_, &bendBoth_})
      if (std::find(v->begin(), v->end(), kInfinity) != v->end()) return true;
    return false;
  }

  /// Adds a row and its differences along x.
  template <Take kTake>
  void add(const float* __restrict__ row) {
    float* __restrict__ l = lo_.data(), * __restrict__ h = hi_.data();
    float* __restrict__ steep = steepNext_.data(), * __restrict__ bend = bendBoth_.data();
    uint32_t* __restrict__ b = bad_.data();
    const size_t n = lo_.size();
    for (size_t x = 0; x < n; ++x) {
      const float v = row[x];
      const bool finite = v - v == 0;
      const float below = finite ? v : kInfinity, above = finite ? v : -kInfinity;
      l[x] = below < l[x] ? below : l[x];
      h[x] = above > h[x] ? above : h[x];
      b[x] |= finite ? 0u : 1u;
    }
    for (size_t x = 0; x + 1 < n; ++x) widen<kTake>(steep[x], row[x + 1] - row[x]);
    for (size_t x = 1; x + 1 < n; ++x) widen<kTake>(bend[x], (row[x + 1] - row[x]) - (row[x] - row[x - 1]));
  }
  /// Adds the differences of rows that are neighbours along y or z.
  template <Take kTake>
  void addPair(const float* __restrict__ a, const float* __restrict__ b) {
    float* __restrict__ steep = steep_.data(), * __restrict__ twist = bendNext_.data();
    const size_t n = lo_.size();
    for (size_t x = 0; x < n; ++x) widen<kTake>(steep[x], b[x] - a[x]);
    for (size_t x = 0; x + 1 < n; ++x) widen<kTake>(twist[x], (b[x + 1] - b[x]) - (a[x + 1] - a[x]));
  }
  /// Adds the second differences (b - a) - (d - c) of three rows in a line, a, b = c and d, or of four
  /// rows around a face.
  template <Take kTake>
  void addSecond(const float* __restrict__ a, const float* b, const float* __restrict__ c, const float* d) {
    float* __restrict__ bend = bend_.data();
    const size_t n = lo_.size();
    for (size_t x = 0; x < n; ++x) widen<kTake>(bend[x], (b[x] - a[x]) - (d[x] - c[x]));
  }

  Macrocell over(int64_t first, int64_t last) const {
    Macrocell m{kInfinity, -kInfinity, 0, 0, false};
    for (int64_t x = first; x <= last; ++x) {
      m.min = std::min(m.min, lo_[x]);
      m.max = std::max(m.max, hi_[x]);
      m.steep = std::max(m.steep, steep_[x]);
      m.bend = std::max(m.bend, bend_[x]);
      m.noData |= bad_[x] != 0;
      if (x < last) m.steep = std::max(m.steep, steepNext_[x]), m.bend = std::max(m.bend, bendNext_[x]);
      if (x > first && x < last) m.bend = std::max(m.bend, bendBoth_[x]);
    }
    return m;
  }

 private:
  template <Take kTake>
  static void widen(float& most, float difference) {
    const float d = std::abs(difference);
    if constexpr (kTake == Take::Any)
      most = d > most ? d : most;
    else
      most = d > most && d < kInfinity ? d : most;
  }

  std::vector<float> lo_, hi_, steep_, bend_, steepNext_, bendNext_, bendBoth_;
  std::vector<uint32_t> bad_;
};

/// The rows of points of one row of macrocells as float, for one summary (component or magnitude) at a time.
class Rows {
 public:
  Rows(const VolumeBlock& block, ScalarType stored, int components)
      : block_(block), stored_(stored), components_(components) {
    if (stored != ScalarType::Float32 || components != 1)
      copies_.resize(kRows * kRows, std::vector<float>(size_t(block.extent.points[0])));
  }

  /// Reads the rows [y0, y1] x [z0, z1] of the block, (kSize + 1)^2 at most.
  void read(int64_t y0, int64_t y1, int64_t z0, int64_t z1, int summary) {
    const Extent& e = block_.extent;
    for (int64_t z = z0; z <= z1; ++z)
      for (int64_t y = y0; y <= y1; ++y) {
        const size_t first = size_t((z * e.points[1] + y) * e.points[0]) * size_t(components_);
        const std::byte* at = block_.samples.data() + first * bytesOf(stored_);
        const size_t slot = size_t((z - z0) * kRows + (y - y0));
        if (copies_.empty()) {
          rows_[slot] = reinterpret_cast<const float*>(at);
          continue;
        }
        withType(stored_, [&](auto t) {
          using T = decltype(t);
          if (summary < components_) {
            component(reinterpret_cast<const T*>(at) + summary, copies_[slot]);
          } else {
            magnitude(reinterpret_cast<const T*>(at), copies_[slot]);
          }
        });
        rows_[slot] = copies_[slot].data();
      }
  }
  /// The row (y, z), counted from the first that was read.
  const float* operator()(int64_t y, int64_t z) const { return rows_[size_t(z * kRows + y)]; }

 private:
  static constexpr size_t kRows = kSize + 1;

  template <typename T>
  void component(const T* from, std::vector<float>& row) const {
    for (size_t x = 0; x < row.size(); ++x) row[x] = float(from[x * size_t(components_)]);
  }
  template <typename T>
  void magnitude(const T* from, std::vector<float>& row) const {
    for (float& r : row) {
      float squares = 0;
      for (int c = 0; c < components_; ++c) {
        const float v = float(*from++);
        squares += v * v;
      }
      r = std::sqrt(squares);
    }
  }

  const VolumeBlock& block_;
  const ScalarType stored_;
  const int components_;
  std::array<const float*, kRows * kRows> rows_{};
  std::vector<std::vector<float>> copies_;
};

/// Adds all rows of one row of macrocells, `ny` x `nz` of them.
template <RowSummary::Take kTake>
void addAll(const Rows& rows, int64_t ny, int64_t nz, RowSummary& to) {
  to.reset();
  for (int64_t z = 0; z < nz; ++z) {
    for (int64_t y = 0; y < ny; ++y) {
      to.add<kTake>(rows(y, z));
      if (y > 0) to.addPair<kTake>(rows(y - 1, z), rows(y, z));
      if (z > 0) to.addPair<kTake>(rows(y, z - 1), rows(y, z));
      if (y > 1) to.addSecond<kTake>(rows(y - 2, z), rows(y - 1, z), rows(y - 1, z), rows(y, z));
      if (z > 1) to.addSecond<kTake>(rows(y, z - 2), rows(y, z - 1), rows(y, z - 1), rows(y, z));
      if (y > 0 && z > 0) to.addSecond<kTake>(rows(y - 1, z - 1), rows(y, z - 1), rows(y - 1, z), rows(y, z));
    }
  }
}

/// The points of macrocell `m` on one axis that lie in the extent, relative to the extent's first point.
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

/// Whether a macrocell lies so deep inside a block that no other block contains any of its cells. The block's
/// extent ends at most kGhostLayers and one cell outside its partition, and a neighbour's extent reaches as far
/// into the partition. This holds at the ends of the grid too: a partition may end up to that far before them.
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

void completeBlock(VolumeBlock& block, ScalarType stored, int components, const Advance& advance) {
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
  if (!block.summaries.empty()) throw Error("macrocells: a block that is complete already");
  block.summaries.assign(components > 1 ? size_t(components) + 1 : 1, {});
  block.firstMacrocell = block.macrocells = {0, 0, 0};
  if (e.count() == 0) return;
  for (int a = 0; a < 3; ++a) {
    // Counted by cells: a block whose last point lies on a macrocell's first plane does not touch that macrocell.
    block.firstMacrocell[a] = e.first[a] / kSize;
    const int64_t lastCell = e.first[a] + std::max<int64_t>(e.points[a] - 2, 0);
    block.macrocells[a] = lastCell / kSize - block.firstMacrocell[a] + 1;
  }
  const Index3 &n = block.macrocells, &f = block.firstMacrocell;
  // The number of rows of macrocells between two reports of progress.
  const int64_t told = std::max<int64_t>(1, (int64_t(1) << 20) / (e.points[0] * kSize * kSize));
  Rows rows(block, stored, components);
  RowSummary row(size_t(e.points[0]));
  for (size_t s = 0; s < block.summaries.size(); ++s) {
    std::vector<Macrocell>& cells = block.summaries[s];
    cells.reserve(size_t(n[0] * n[1] * n[2]));
    const Advance summing = partOf(advance, s, block.summaries.size());
    for (int64_t k = 0; k < n[2]; ++k) {
      for (int64_t j = 0; j < n[1]; ++j) {
        if (const int64_t row = k * n[1] + j; j == 0 || row % told == 0)
          summing(double(row) / double(n[1] * n[2]));
        const PointSpan zs = pointsOf(e, 2, f[2] + k), ys = pointsOf(e, 1, f[1] + j);
        rows.read(ys.first, ys.last, zs.first, zs.last, int(s));
        const int64_t ny = ys.last - ys.first + 1, nz = zs.last - zs.first + 1;
        addAll<RowSummary::Take::Any>(rows, ny, nz, row);
        if (row.hasInfiniteDifferences()) addAll<RowSummary::Take::Finite>(rows, ny, nz, row);
        for (int64_t i = 0; i < n[0]; ++i) {
          const PointSpan xs = pointsOf(e, 0, f[0] + i);
          cells.push_back(row.over(xs.first, xs.last));
        }
      }
    }
  }
  putIntoBricks(block.samples, e.points, size_t(components) * bytesOf(stored), [&] { advance(1); });
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
            records.push_back({at, int32_t(s), m.noData, m.min, m.max, m.steep, m.bend});
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
      m.steep = std::max(m.steep, r.steep);
      m.bend = std::max(m.bend, r.bend);
      m.noData |= r.noData != 0;
    }
  }
}

}  // namespace gxy
