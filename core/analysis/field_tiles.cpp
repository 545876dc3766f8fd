// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/field_tiles.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/analysis/brick_rows.h"
#include "core/comm/parallel_for.h"
#include "core/data/bricks.h"
#include "point_rows_ispc.h"

namespace gxy {
namespace {

constexpr int kRow = 512;    ///< points of a tile along x, at most
constexpr int kStrip = 16;   ///< along y
constexpr int kPlanes = 64;  ///< along z
constexpr int kMargin =
    16;  ///< of a row: the halo on both sides, and what makes rows start at full cache lines
constexpr double kNone = std::numeric_limits<double>::quiet_NaN(),
                 kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

DataPoints::DataPoints(const Grid& grid) {
  for (size_t a = 0; a < 3; ++a) first[a] = grid.rim ? 1 : 0, last[a] = grid.points[a] - (grid.rim ? 2 : 1);
}

int64_t DataPoints::nearest(int axis, int64_t i) const {
  return std::clamp(i, first[size_t(axis)], last[size_t(axis)]);
}

PlainArithmetic::PlainArithmetic() : before_(_mm_getcsr()) { _mm_setcsr(0x1f80); }
PlainArithmetic::~PlainArithmetic() { _mm_setcsr(before_); }

struct FieldTiles::Tile {
  int partition;
  Extent points;
};

/// The registers and windows of one tile at a time.
class FieldTiles::Workspace {
 public:
  explicit Workspace(FieldTiles& tiles) : tiles_(tiles), pass_(tiles.pass_) {
    size_t next = 0;
    for (int r = 0; r < pass_.registers; ++r) next += kStride;
    for (const auto& halo : pass_.windows) {
      windows_.push_back(next);
      next += size_t(rowsOf(halo)) * size_t(planesOf(halo)) * kStride;
    }
    squares_ = next;
    memory_.resize(next + kStride);
    bytes_.resize(kStride);
    floats_.resize(3 * kStride);
    vectors_.resize(3 * kStride);
    results.statistics.ranges.resize(rangesOf(tiles.target_.components));
  }

  static int64_t bytesFor(const FieldPass& pass) {
    int64_t rows = pass.registers + 6;
    for (const auto& halo : pass.windows) rows += rowsOf(halo) * planesOf(halo);
    return rows * int64_t(kStride * sizeof(double));
  }
  static size_t rangesOf(int components) { return size_t(components) + (components > 1); }

  void run(const Tile& tile, const std::function<void()>& check) {
    tile_ = &tile;
    int most = 0;
    for (const auto& halo : pass_.windows) most = std::max(most, halo[2]);
    const int64_t z0 = tile.points.first[2], z1 = z0 + tile.points.points[2];
    for (int64_t z = z0 - 2 * most; z < z1; ++z) {
      for (const FieldStage& stage : pass_.stages) {
        const int64_t plane = z + stage.halo[2];
        if (plane < z0 - stage.halo[2]) continue;
        const int64_t y0 = tile.points.first[1] - stage.halo[1];
        for (int64_t y = y0; y < y0 + tile.points.points[1] + 2 * stage.halo[1]; ++y) row(stage, y, plane);
      }
      check();
    }
  }

  FieldResults results;
  std::array<double, 2> squareExtremes{kInfinity,
                                       -kInfinity};  ///< of the sum of squares of a point's components

 private:
  static constexpr size_t kStride = kRow + kMargin;
  static int64_t rowsOf(const std::array<int, 3>& halo) { return kStrip + 2 * halo[1]; }
  static int64_t planesOf(const std::array<int, 3>& halo) { return 2 * halo[2] + 1; }

  double* registerAt(int r) { return memory_.data() + size_t(r) * kStride; }

  /// The value of a window at (x, y, z); the row goes on along x.
  double* windowAt(int w, int64_t x, int64_t y, int64_t z) {
    const auto& halo = pass_.windows[size_t(w)];
    const Index3& first = tile_->points.first;
    const int64_t plane = (z - first[2] + halo[2]) % planesOf(halo), rowOf = y - first[1] + halo[1];
    return memory_.data() + windows_[size_t(w)] + size_t(plane * rowsOf(halo) + rowOf) * kStride +
           size_t(x - first[0] + halo[0]);
  }

  double* at(const PointPlace& place, int64_t x, int64_t y, int64_t z) {
    return place.kind == PointPlace::Kind::Window ? windowAt(place.index, x, y, z) : registerAt(place.index);
  }

  /// Computes a row of a stage. Windows have no data outside the points that have data of their own.
  void row(const FieldStage& stage, int64_t y, int64_t z) {
    const int64_t x = tile_->points.first[0] - stage.halo[0];
    const auto points = int(tile_->points.points[0] + 2 * stage.halo[0]);
    const DataPoints& data = tiles_.data_;
    if (!data.contain(1, y) || !data.contain(2, z)) {
      for (const int32_t w : stage.windows) std::fill_n(windowAt(w, x, y, z), points, kNone);
      return;
    }
    for (size_t i = 0; i < stage.steps.size(); ++i) {
      if (isVector(stage.steps, i)) {
        load(&stage.steps[i], 3, x, y, z, points);
        i += 2;
      } else {
        run(stage.steps[i], x, y, z, points);
      }
    }
    if (!stage.results.empty()) return store(stage, y, z);
    const auto before = int(std::clamp<int64_t>(data.first[0] - x, 0, points));
    const auto behind = int(std::clamp<int64_t>(x + points - 1 - data.last[0], 0, points));
    for (const PointStep& step : stage.steps) {
      if (step.to.kind != PointPlace::Kind::Window || step.op == PointOp::Load) continue;
      double* const made = windowAt(step.to.index, x, y, z);
      ispc::pointFinite(made, points);
      std::fill_n(made, before, kNone);
      std::fill_n(made + points - behind, behind, kNone);
    }
  }

  /// Whether three steps load the components of a field of vectors.
  bool isVector(std::span<const PointStep> steps, size_t i) const {
    if (i + 3 > steps.size() || steps[i].op != PointOp::Load) return false;
    const Volume& field = *tiles_.fields_[size_t(steps[i].source)];
    if (field.stored != ScalarType::Float32 || field.components != 3) return false;
    for (size_t c = 0; c < 3; ++c)
      if (steps[i + c].op != PointOp::Load || steps[i + c].source != steps[i].source ||
          steps[i + c].component != int(c))
        return false;
    return true;
  }

  void run(const PointStep& step, int64_t x, int64_t y, int64_t z, int points) {
    double* const to = at(step.to, x, y, z);
    const PointPlace& of = step.operands[0];
    const Grid& grid = tiles_.target_.grid;
    switch (step.op) {
      case PointOp::Load:
        return load(&step, 1, x, y, z, points);
      case PointOp::Fill:
        std::fill_n(to, points, of.number);
        return;
      case PointOp::Coordinate:
        return coordinates(step.axis, x, y, z, points, to);
      case PointOp::Difference: {
        const auto p = [&](int64_t d) { return neighbour(of, step.axis, d, x, y, z); };
        return ispc::pointDifference(p(-2), p(-1), p(0), p(1), p(2), 0.5 / grid.spacing[step.axis], to,
                                     points);
      }
      case PointOp::SecondDifference: {
        const auto p = [&](int64_t d) { return neighbour(of, step.axis, d, x, y, z); };
        const double once = 1 / grid.spacing[step.axis];
        return ispc::pointSecondDifference(p(-3), p(-2), p(-1), p(0), p(1), p(2), p(3), once * once, to,
                                           points);
      }
      default:
        break;
    }
    std::array<const double*, 9> operands{};
    unsigned numbers = 0;
    const int count = operandsOf(step.op);
    for (int i = 0; i < count; ++i) {
      const PointPlace& place = step.operands[size_t(i)];
      const bool isNumber = place.kind == PointPlace::Kind::Number;
      if (isNumber) numbers |= 1u << i;
      operands[size_t(i)] = isNumber ? &place.number : at(place, x, y, z);
    }
    computePoints(step.op, std::span(operands.data(), size_t(count)), numbers, to, points);
  }

  double* neighbour(const PointPlace& window, int axis, int64_t d, int64_t x, int64_t y, int64_t z) {
    return windowAt(window.index, axis == 0 ? x + d : x, axis == 1 ? y + d : y, axis == 2 ? z + d : z);
  }

  void coordinates(int axis, int64_t x, int64_t y, int64_t z, int points, double* to) const {
    const Grid& grid = tiles_.target_.grid;
    if (axis != 0) {
      std::fill_n(to, points, grid.origin[axis] + grid.spacing[axis] * double(axis == 1 ? y : z));
      return;
    }
    for (int i = 0; i < points; ++i) to[i] = grid.origin.x + grid.spacing.x * double(x + i);
  }

  /// Loads one component of a field, or all three of vectors, by one or three steps.
  void load(const PointStep* steps, size_t count, int64_t x, int64_t y, int64_t z, int points) {
    const Volume& field = *tiles_.fields_[size_t(steps[0].source)];
    const VolumeBlock& block = field.blocks.at(tile_->partition);
    const int64_t first = std::max(x, tiles_.data_.first[0]),
                  end = std::min(x + points, tiles_.data_.last[0] + 1);
    const auto n = int(end - first);
    std::array<double*, 3> rows{};
    for (size_t i = 0; i < count; ++i) {
      double* const to = at(steps[i].to, x, y, z);
      std::fill_n(to, first - x, kNone);
      std::fill_n(to + (end - x), x + points - end, kNone);
      rows[i] = to + (first - x);
    }
    const Bricks bricks(block.extent.points);
    const Index3 from{first - block.extent.first[0], y - block.extent.first[1], z - block.extent.first[2]};
    const std::byte* const samples = block.samples.data();
    if (field.stored == ScalarType::Float32 && (count == 3 || field.components == 1)) {
      readSamples(bricks, samples, sizeof(float) * size_t(field.components), from, n,
                  reinterpret_cast<std::byte*>(vectors_.data()));
      if (count == 3)
        ispc::pointValuesOfVectors(vectors_.data(), field.shift, field.scale, rows[0], rows[1], rows[2], n);
      else
        ispc::pointValuesOfFloats(vectors_.data(), field.shift, field.scale, rows[0], n);
      return;
    }
    withType(field.stored, [&](auto t) {
      readPieces<decltype(t)>(bricks, samples, field.components, steps[0].component, from, n, rows[0]);
    });
    if (field.stored != ScalarType::Float64) ispc::pointValues(rows[0], field.shift, field.scale, n);
  }

  void store(const FieldStage& stage, int64_t y, int64_t z) {
    Volume& target = tiles_.target_;
    VolumeBlock& block = target.blocks.at(tile_->partition);
    const int64_t x = tile_->points.first[0];
    const auto points = int(tile_->points.points[0]);
    const Bricks bricks(block.extent.points);
    const Index3 from{x - block.extent.first[0], y - block.extent.first[1], z - block.extent.first[2]};
    // Of points that are computed here and are another partition's, nothing is told.
    const Extent& owned = tiles_.owned_.at(tile_->partition);
    const int64_t first = std::max(x, owned.first[0]),
                  end = std::min(x + points, owned.first[0] + owned.points[0]);
    const auto inside = [&](size_t a, int64_t i) {
      return i >= owned.first[a] && i < owned.first[a] + owned.points[a];
    };
    const int told = inside(1, y) && inside(2, z) ? int(std::max<int64_t>(0, end - first)) : 0;
    double* const squares = memory_.data() + squares_;
    auto& ranges = results.statistics.ranges;
    for (size_t c = 0; c < stage.results.size(); ++c) {
      double* const values = at(stage.results[c], x, y, z);
      if (target.stored == ScalarType::Float64) {
        ispc::pointFinite(values, points);
        writePieces(bricks, block.samples.data(), target.components, int(c), from, points, values);
      } else if (target.stored == ScalarType::Float32) {
        float* const floats = floats_.data() + (target.components == 3 ? c * kStride : 0);
        ispc::pointFloats(values, floats, points);
        if (target.components != 3)
          writePieces(bricks, block.samples.data(), target.components, int(c), from, points, floats);
        if (told > 0) {
          double extremes[2] = {ranges[c].min, ranges[c].max};
          ispc::pointSquares(floats + (first - x), c == 0, squares, extremes, told);
          ranges[c] = {extremes[0], extremes[1]};
        }
      } else {
        for (int i = 0; i < points; ++i) bytes_[size_t(i)] = values[i] == 1;
        writePieces(bricks, block.samples.data(), 1, 0, from, points, bytes_.data());
        for (int i = 0; i < told; ++i) results.noData += std::isnan(values[first - x + i]);
      }
    }
    if (target.stored == ScalarType::Float32 && target.components == 3) {
      ispc::pointVectors(floats_.data(), floats_.data() + kStride, floats_.data() + 2 * kStride,
                         vectors_.data(), points);
      writeSamples(bricks, block.samples.data(), 3 * sizeof(float), from, points,
                   reinterpret_cast<const std::byte*>(vectors_.data()));
    }
    if (target.stored != ScalarType::Float32 || told == 0) return;
    results.noData += ispc::pointExtremes(squares, squareExtremes.data(), told);
  }

  FieldTiles& tiles_;
  const FieldPass& pass_;
  const Tile* tile_ = nullptr;
  std::vector<size_t> windows_;  ///< where each begins
  size_t squares_ = 0;
  std::vector<double> memory_;
  std::vector<float> floats_, vectors_;  ///< rows of components, and of whole points
  std::vector<uint8_t> bytes_;
};

FieldTiles::FieldTiles(const FieldPass& pass, std::span<const Volume* const> fields, Volume& target,
                       const std::map<int, Extent>& computed, const std::map<int, Extent>& owned,
                       const std::function<void(int64_t)>& memory)
    : pass_(pass),
      fields_(fields),
      target_(target),
      computed_(computed),
      owned_(owned),
      memory_(memory),
      data_(target.grid) {}

FieldTiles::~FieldTiles() {
  if (workspaceBytes_ > 0) memory_(-workspaceBytes_);
}

std::unique_ptr<FieldTiles::Workspace> FieldTiles::take() {
  const std::lock_guard lock(mutex_);
  if (!free_.empty()) {
    auto workspace = std::move(free_.back());
    free_.pop_back();
    return workspace;
  }
  const int64_t bytes = Workspace::bytesFor(pass_);
  memory_(bytes);
  workspaceBytes_ += bytes;
  return std::make_unique<Workspace>(*this);
}

void FieldTiles::give(std::unique_ptr<Workspace> workspace) {
  const std::lock_guard lock(mutex_);
  free_.push_back(std::move(workspace));
}

FieldResults FieldTiles::run(const Advance& advance) {
  std::vector<Tile> tiles;
  int64_t planes = 0;
  for (const auto& [partition, part] : computed_)
    for (int64_t z = 0; z < part.points[2]; z += kPlanes)
      for (int64_t y = 0; y < part.points[1]; y += kStrip)
        for (int64_t x = 0; x < part.points[0]; x += kRow) {
          const Index3 at{x, y, z}, most{kRow, kStrip, kPlanes};
          Tile tile{partition, {}};
          for (size_t a = 0; a < 3; ++a) {
            tile.points.first[a] = part.first[a] + at[a];
            tile.points.points[a] = std::min(most[a], part.points[a] - at[a]);
          }
          planes += tile.points.points[2];
          tiles.push_back(tile);
        }
  std::atomic<int64_t> done = 0;
  parallelFor(size_t(0), tiles.size(), [&](size_t i) {
    const PlainArithmetic plain;
    auto workspace = take();
    const int64_t all = tiles[i].points.points[2];
    int64_t mine = 0;
    workspace->run(tiles[i], [&] {
      const int64_t now = mine < all ? (++mine, ++done) : done.load();
      advance(double(now) / double(planes));
    });
    give(std::move(workspace));
  });
  results_.statistics.ranges.resize(Workspace::rangesOf(target_.components));
  for (const auto& workspace : free_) {
    results_.statistics.merge(workspace->results.statistics);
    results_.noData += workspace->results.noData;
    const auto& [lo, hi] = workspace->squareExtremes;
    if (target_.components > 1 && lo <= hi)
      results_.statistics.ranges.back().extend(Range{std::sqrt(lo), std::sqrt(hi)});
  }
  results_.statistics.noDataSamples = results_.noData;
  return results_;
}

}  // namespace gxy
