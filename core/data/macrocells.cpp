// SPDX-License-Identifier: Apache-2.0
#include "core/data/macrocells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <type_traits>

#include "core/comm/error.h"
#include "core/data/bricks.h"
#include "macrocell_rows_ispc.h"

namespace gxy {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr int64_t kSize = kMacrocellSize;

/// The rows of points of one row of macrocells as float, for one summary (component or magnitude) at a time, and what
/// summarizeRows() (macrocell_rows.ispc) finds in them.
class Rows {
 public:
  Rows(const VolumeBlock& block, ScalarType stored, int components)
      : block_(block),
        bricks_(block.extent.points),
        stored_(stored),
        components_(components),
        pitch_(block.extent.points[0] + 2),
        rows_(size_t(kRows * kRows * pitch_)),
        extremes_(size_t(kExtremes * pitch_)) {}

  /// Summarizes the rows [y0, y1] x [z0, z1] of the block, (kSize + 1)^2 at most.
  void summarize(int64_t y0, int64_t y1, int64_t z0, int64_t z1, int summary) {
    withType(stored_, [&](auto t) { read<decltype(t)>(y0, y1, z0, z1, summary); });
    const auto find = [&](bool finiteOnly) {
      ispc::summarizeRows(rows_.data() + 1, pitch_, int(kRows), int(y1 - y0 + 1), int(z1 - z0 + 1),
                          int(block_.extent.points[0]), finiteOnly, extremes_.data());
    };
    find(false);  // Half the work, which is done anew if differences are infinite.
    const auto differences = std::span(extremes_).subspan(size_t(kSteep * pitch_), size_t(5 * pitch_));
    if (std::find(differences.begin(), differences.end(), kInfinity) != differences.end()) find(true);
  }

  /// Returns the summary of the points from `first` to `last` in x.
  Macrocell over(int64_t first, int64_t last) const {
    const auto row = [&](int64_t kind) { return extremes_.data() + kind * pitch_; };
    Macrocell m{kInfinity, -kInfinity, 0, 0, false};
    for (int64_t x = first; x <= last; ++x) {
      m.min = std::min(m.min, row(kLo)[x]);
      m.max = std::max(m.max, row(kHi)[x]);
      m.steep = std::max(m.steep, row(kSteep)[x]);
      m.bend = std::max(m.bend, row(kBend)[x]);
      m.noData |= row(kBad)[x] != 0;
    }
    for (int64_t x = first; x < last; ++x) {
      m.steep = std::max(m.steep, row(kSteepNext)[x]);
      m.bend = std::max(m.bend, row(kBendNext)[x]);
    }
    for (int64_t x = first + 1; x < last; ++x) m.bend = std::max(m.bend, row(kBendBoth)[x]);
    return m;
  }

 private:
  static constexpr int64_t kRows = kSize + 1;
  enum : int64_t { kLo, kHi, kSteep, kBend, kSteepNext, kBendNext, kBendBoth, kBad, kExtremes };

  template <typename T>
  void read(int64_t y0, int64_t y1, int64_t z0, int64_t z1, int summary) {
    const auto* samples = reinterpret_cast<const T*>(block_.samples.data());
    for (int64_t z = z0; z <= z1; ++z)
      for (int64_t y = y0; y <= y1; ++y) {
        const T* row = samples + bricks_(0, y, z) * size_t(components_);
        float* to = &rows_[size_t(((z - z0) * kRows + (y - y0)) * pitch_ + 1)];
        if (components_ == 1)
          readScalars(row, to);
        else if (components_ ==
                 3)  // A number that is known when the loops are compiled makes them twice as fast.
          readVectors(row, 3, summary, to);
        else
          readVectors(row, components_, summary, to);
      }
  }
  template <typename T>
  void readScalars(const T* row, float* to) const {
    const auto points = int(block_.extent.points[0]), step = int(Bricks::kStepX);
    if constexpr (std::is_same_v<T, int8_t>) ispc::readRowInt8(row, step, points, to);
    if constexpr (std::is_same_v<T, uint8_t>) ispc::readRowUInt8(row, step, points, to);
    if constexpr (std::is_same_v<T, int16_t>) ispc::readRowInt16(row, step, points, to);
    if constexpr (std::is_same_v<T, uint16_t>) ispc::readRowUInt16(row, step, points, to);
    if constexpr (std::is_same_v<T, float>) ispc::readRowFloat(row, step, points, to);
  }
  /// Reads component `summary`, or the magnitude if that is the number of components.
  template <typename T>
  [[gnu::always_inline]] void readVectors(const T* row, int components, int summary, float* to) const {
    const int64_t points = block_.extent.points[0];
    for (int64_t x = 0; x < points; x += Bricks::kSide, row += Bricks::kStepX * components) {
      const int64_t n = std::min(Bricks::kSide, points - x);
      if (summary < components) {
        for (int64_t i = 0; i < n; ++i) to[x + i] = float(row[i * components + summary]);
        continue;
      }
      for (int64_t i = 0; i < n; ++i) {
        float squares = 0;
        for (int c = 0; c < components; ++c) {
          const float v = float(row[i * components + c]);
          squares += v * v;
        }
        to[x + i] = std::sqrt(squares);
      }
    }
  }

  const VolumeBlock& block_;
  const Bricks bricks_;
  const ScalarType stored_;
  const int components_;
  const int64_t pitch_;          ///< of rows: the float before and the one after a row may be read
  std::vector<float> rows_;      ///< kRows in each layer
  std::vector<float> extremes_;  ///< by kind
};

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

void checkSamples(const VolumeBlock& block, ScalarType stored, int components, size_t points) {
  if (bytesOf(stored) > 4 || stored == ScalarType::Int32 || stored == ScalarType::UInt32) {
    throw Error(std::string("macrocells: samples stored as ") + nameOf(stored) +
                ", expected 8 or 16 bits or float32");
  }
  if (components < 1 || block.samples.size() != points * size_t(components) * bytesOf(stored)) {
    throw Error("macrocells: a block of " + std::to_string(block.samples.size()) + " bytes, expected " +
                std::to_string(points) + " points of " + std::to_string(components) + " x " + nameOf(stored));
  }
  if (!block.summaries.empty()) throw Error("macrocells: a block that is complete already");
}

}  // namespace

MacrocellBox macrocellsOf(const Extent& extent) {
  MacrocellBox box;
  if (extent.count() == 0) return box;
  for (int a = 0; a < 3; ++a) {
    // Counted by cells: a block whose last point lies on a macrocell's first plane does not touch that macrocell.
    box.first[a] = extent.first[a] / kSize;
    const int64_t lastCell = extent.first[a] + std::max<int64_t>(extent.points[a] - 2, 0);
    box.count[a] = lastCell / kSize - box.first[a] + 1;
  }
  return box;
}

void summarizeBlock(VolumeBlock& block, ScalarType stored, int components, const Advance& advance) {
  const Extent& e = block.extent;
  checkSamples(block, stored, components, Bricks(e.points).count());
  block.summaries.assign(components > 1 ? size_t(components) + 1 : 1, {});
  const MacrocellBox box = macrocellsOf(e);
  block.firstMacrocell = box.first;
  block.macrocells = box.count;
  if (e.count() == 0) return;
  const Index3 &n = block.macrocells, &f = block.firstMacrocell;
  // The number of rows of macrocells between two reports of progress.
  const int64_t told = std::max<int64_t>(1, (int64_t(1) << 20) / (e.points[0] * kSize * kSize));
  for (std::vector<Macrocell>& cells : block.summaries) cells.reserve(size_t(n[0] * n[1] * n[2]));
  Rows rows(block, stored, components);
  for (int64_t k = 0; k < n[2]; ++k) {
    for (int64_t j = 0; j < n[1]; ++j) {
      if (const int64_t row = k * n[1] + j; j == 0 || row % told == 0)
        advance(double(row) / double(n[1] * n[2]));
      const PointSpan zs = pointsOf(e, 2, f[2] + k), ys = pointsOf(e, 1, f[1] + j);
      for (size_t s = 0; s < block.summaries.size(); ++s) {
        rows.summarize(ys.first, ys.last, zs.first, zs.last, int(s));
        for (int64_t i = 0; i < n[0]; ++i) {
          const PointSpan xs = pointsOf(e, 0, f[0] + i);
          block.summaries[s].push_back(rows.over(xs.first, xs.last));
        }
      }
    }
  }
}

void completeBlock(VolumeBlock& block, ScalarType stored, int components, const Advance& advance) {
  checkSamples(block, stored, components, size_t(block.extent.count()));
  putIntoBricks(block.samples, block.extent.points, size_t(components) * bytesOf(stored),
                [&] { advance(0); });
  summarizeBlock(block, stored, components, advance);
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
      if (!MacrocellBox{block.firstMacrocell, block.macrocells}.contains(r.macrocell)) continue;
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
