// SPDX-License-Identifier: Apache-2.0
#include "core/rays/iso_mask.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/data/bricks.h"

namespace gxy {

namespace {

constexpr int64_t kSize = kMacrocellSize;
static_assert(kSize == 8);
constexpr int kLevels = 3;
constexpr uint8_t kBelow = 1, kAbove = 2;  // a corner's value is <= or >= the isovalue

/// Reads part of a row of points as float.
class Points {
 public:
  Points(const VolumeBlock& block, ScalarType stored, int components, int component)
      : block_(block),
        bricks_(block.extent.points),
        stored_(stored),
        components_(components),
        component_(component) {}

  /// Returns `n` points from (x, y, z) of the block on; valid until the next call.
  const float* operator()(int64_t x, int64_t y, int64_t z, size_t n) {
    row_.resize(n);
    withType(stored_, [&](auto t) {
      const auto* samples = reinterpret_cast<const decltype(t)*>(block_.samples.data());
      bricks_.alongX(x, y, z, int64_t(n), [&](size_t place, int64_t first, int64_t count) {
        convert(samples + place * size_t(components_), std::span(row_).subspan(size_t(first), size_t(count)));
      });
    });
    return row_.data();
  }

  /// Prefetches the cache lines of points that will be read soon.
  void prefetch(int64_t x, int64_t y, int64_t z, size_t n) const {
    const size_t each = size_t(components_) * bytesOf(stored_);
    bricks_.alongX(x, y, z, int64_t(n), [&](size_t place, int64_t, int64_t) {
      __builtin_prefetch(block_.samples.data() + place * each);
    });
  }

 private:
  template <typename T>
  void convert(const T* from, std::span<float> row) const {
    for (float& value : row) {
      if (component_ >= 0) {
        value = float(from[component_]);
      } else {
        float squares = 0;
        for (int c = 0; c < components_; c++) squares += float(from[c]) * float(from[c]);
        value = std::sqrt(squares);
      }
      from += components_;
    }
  }

  const VolumeBlock& block_;
  const Bricks bricks_;
  const ScalarType stored_;
  const int components_, component_;
  std::vector<float> row_;
};

/// Finds the bits of a run of macrocells along x. Points are classified once, then joined along x, y and z.
class CellBits {
 public:
  CellBits(const VolumeBlock& block, Points points, std::span<const float> isovalues)
      : block_(block), points_(std::move(points)), isovalues_(isovalues) {}

  /// Sets the bits of macrocells (x0 .. x1 - 1, y, z) of the block in `words`, where the run's bits begin.
  void add(int64_t x0, int64_t x1, int64_t y, int64_t z, int32_t* words) {
    const Extent& e = block_.extent;
    const Index3& f = block_.firstMacrocell;
    const Span xs = pointsOf(0, f[0] + x0, f[0] + x1), ys = pointsOf(1, f[1] + y, f[1] + y + 1),
               zs = pointsOf(2, f[2] + z, f[2] + z + 1);
    if (xs.last <= xs.first || ys.last <= ys.first || zs.last <= zs.first) return;
    const size_t cells = size_t(xs.last - xs.first);
    width_ = size_t(x1 - x0) * kSize;
    const size_t lead = size_t(xs.first + e.first[0] - (f[0] + x0) * kSize);
    plane_.assign(width_ * kSize, 0);
    before_.assign(width_ * kSize, 0);
    class_.resize(cells + 1);
    row_.assign(width_, 0);
    last_.assign(width_, 0);
    for (float isovalue : isovalues_) {
      for (int64_t k = zs.first; k <= zs.last; k++) {
        for (int64_t j = ys.first; j <= ys.last; j++) {
          if (k < zs.last) points_.prefetch(xs.first, j, k + 1, cells + 1);
          classify(points_(xs.first, j, k, cells + 1), isovalue, row_.data() + lead, cells);
          if (j > ys.first) join(last_.data(), row_.data(), plane_.data() + rowOf(1, j - 1) * width_, width_);
          std::swap(row_, last_);
        }
        if (k > zs.first)
          for (int64_t j = ys.first; j < ys.last; j++)
            pack(before_.data() + rowOf(1, j) * width_, plane_.data() + rowOf(1, j) * width_,
                 words + 2 * rowOf(2, k - 1) + rowOf(1, j) / 4, int(rowOf(1, j) % 4) * 8);
        std::swap(plane_, before_);
      }
    }
  }

 private:
  struct Span {
    int64_t first, last;
  };
  /// The points on an axis that belong to macrocells [m0, m1) and that the block has, relative to its first
  /// point.
  Span pointsOf(int axis, int64_t m0, int64_t m1) const {
    const Extent& e = block_.extent;
    return {std::max<int64_t>(m0 * kSize - e.first[axis], 0),
            std::min<int64_t>(m1 * kSize - e.first[axis], e.points[axis] - 1)};
  }
  /// The index of the block's cell `i`, on an axis, in its macrocell.
  size_t rowOf(int axis, int64_t i) const { return size_t((block_.extent.first[axis] + i) % kSize); }

  void classify(const float* __restrict__ value, float isovalue, uint8_t* __restrict__ cell, size_t cells) {
    uint8_t* __restrict__ c = class_.data();
    for (size_t i = 0; i <= cells; i++)
      c[i] = uint8_t((value[i] <= isovalue ? kBelow : 0) | (value[i] >= isovalue ? kAbove : 0));
    for (size_t i = 0; i < cells; i++) cell[i] = c[i] | c[i + 1];
  }
  static void join(const uint8_t* __restrict__ a, const uint8_t* __restrict__ b, uint8_t* __restrict__ out,
                   size_t n) {
    for (size_t i = 0; i < n; i++) out[i] = a[i] | b[i];
  }
  /// Joins two rows of faces, and adds the bits of 8 cells at a time to a word of each macrocell.
  void pack(const uint8_t* a, const uint8_t* b, int32_t* word, int shift) const {
    for (size_t x = 0; x < width_; x += kSize, word += kIsoWords) {
      uint64_t p, q;
      std::memcpy(&p, a + x, 8);
      std::memcpy(&q, b + x, 8);
      const uint64_t both = (p | q) & ((p | q) >> 1) & 0x0101010101010101u;  // one byte per cell
      // Gathers the lowest bit of each byte; that of the first byte becomes the lowest.
      const auto bits = uint32_t((both * 0x0102040810204080u) >> 56);
      *word |= std::bit_cast<int32_t>(bits << shift);
    }
  }

  const VolumeBlock& block_;
  Points points_;
  const std::span<const float> isovalues_;
  size_t width_ = 0;
  std::vector<uint8_t> class_, row_, last_, plane_, before_;
};

bool isIn(const Macrocell& m, std::span<const float> isovalues) {
  return std::any_of(isovalues.begin(), isovalues.end(), [&](float v) { return m.min <= v && v <= m.max; });
}

/// Marks the macrocells of aligned cubes of 2^level a side that hold no isovalue.
void markCubes(std::vector<int32_t>& plan, const VolumeBlock& block, int level) {
  const Index3 &n = block.macrocells, &f = block.firstMacrocell;
  const int64_t size = int64_t(1) << level;
  const auto firstOf = [&](int axis) { return f[axis] / size * size - f[axis]; };
  for (int64_t z = firstOf(2); z < n[2]; z += size)
    for (int64_t y = firstOf(1); y < n[1]; y += size)
      for (int64_t x = firstOf(0); x < n[0]; x += size) {
        const Index3 from{std::max<int64_t>(x, 0), std::max<int64_t>(y, 0), std::max<int64_t>(z, 0)};
        const Index3 to{std::min(x + size, n[0]), std::min(y + size, n[1]), std::min(z + size, n[2])};
        const auto rows = [&](auto&& visit) {
          bool all = true;
          for (int64_t k = from[2]; k < to[2] && all; k++)
            for (int64_t j = from[1]; j < to[1] && all; j++) {
              int32_t* row = plan.data() + (k * n[1] + j) * n[0];
              all = visit(row + from[0], row + to[0]);
            }
          return all;
        };
        const auto empty = [&](int32_t* a, int32_t* b) {
          return std::all_of(a, b, [&](int32_t w) { return w == 1 - level; });
        };
        if (rows(empty)) rows([&](int32_t* a, int32_t* b) { return std::fill(a, b, -level), true; });
      }
}

}  // namespace

std::vector<int32_t> isoMask(const VolumeBlock& block, ScalarType stored, int components, int component,
                             std::span<const Macrocell> summaries, std::span<const float> isovalues,
                             size_t mostWords, const Advance& advance) {
  if (block.samples.size() != Bricks(block.extent.points).count() * size_t(components) * bytesOf(stored))
    throw Error("isosurface plan: a block of " + std::to_string(block.samples.size()) + " bytes, expected " +
                std::to_string(block.extent.count()) + " points of " + std::to_string(components) + " x " +
                nameOf(stored));
  const Index3& n = block.macrocells;
  std::vector<int32_t> plan(summaries.size(), 0);
  size_t having = 0;
  for (size_t i = 0; i < plan.size(); i++) {
    plan[i] = isIn(summaries[i], isovalues);
    having += size_t(plan[i]);
  }
  // Blocks of bits begin at cache lines, and never at word 1 (ISO_END).
  const size_t first = (plan.size() + kIsoWords - 1) / kIsoWords * kIsoWords, full = first;
  const size_t most = mostWords > first + kIsoWords ? (mostWords - first) / kIsoWords - 1 : 0;
  plan.resize(first + (1 + std::min(having, most)) * kIsoWords, 0);
  std::fill_n(plan.begin() + ptrdiff_t(full), kIsoWords, -1);
  size_t next = full + kIsoWords;
  for (size_t i = 0; i < summaries.size(); i++) {
    if (plan[i] == 0) continue;
    const bool fits = next < plan.size();
    plan[i] = int32_t(fits ? next : full);
    if (fits) next += kIsoWords;
  }
  std::atomic<int64_t> rows = 0;  // of macrocells that are done
  parallelFor(int64_t(0), n[2], [&](int64_t slice) {
    CellBits bits(block, Points(block, stored, components, component), isovalues);
    for (int64_t row = 0; row < n[1]; row++) {
      const int32_t* words = plan.data() + (slice * n[1] + row) * n[0];
      for (int64_t x = 0, end; x < n[0]; x = end) {
        for (end = x; end < n[0] && words[end] > int32_t(full); end++) {
        }
        if (end > x) bits.add(x, end, row, slice, plan.data() + words[x]);
        end = std::max(end, x + 1);
      }
      advance(double(++rows) / double(n[1] * n[2]));
    }
  });
  for (int level = 1; level <= kLevels; level++) markCubes(plan, block, level);
  return plan;
}

bool hasIsoCell(std::span<const int32_t> plan, size_t index, const Index3& firstCell, const Extent& extent) {
  if (plan[index] <= 0) return false;
  Index3 from, to;
  for (size_t a = 0; a < 3; a++) {
    from[a] = std::max<int64_t>(extent.first[a] - firstCell[a], 0);
    to[a] = std::min(extent.first[a] + extent.points[a] - 1 - firstCell[a], kSize);
  }
  for (int64_t z = from[2]; z < to[2]; z++)
    for (int64_t y = from[1]; y < to[1]; y++)
      for (int64_t x = from[0]; x < to[0]; x++) {
        const int64_t bit = x + kSize * (y + kSize * z);
        if (uint32_t(plan[size_t(plan[index] + bit / 32)]) >> (bit % 32) & 1) return true;
      }
  return false;
}

uint64_t cellsWithoutIsovalue(std::span<const int32_t> plan, size_t macrocells) {
  uint64_t cells = 0;
  for (const int32_t word : plan.first(std::min(macrocells, plan.size())))
    if (word > 0)
      for (const int32_t bits : plan.subspan(size_t(word), kIsoWords))
        cells += uint64_t(std::popcount(~uint32_t(bits)));
  return cells;
}

bool anyIsosurface(std::span<const Macrocell> summaries, std::span<const float> isovalues) {
  return std::any_of(summaries.begin(), summaries.end(),
                     [&](const Macrocell& m) { return isIn(m, isovalues); });
}

}  // namespace gxy
