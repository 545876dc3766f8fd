// SPDX-License-Identifier: Apache-2.0
#include "core/io/hidden_samples.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "core/io/volume_formats.h"

namespace gxy {
namespace {

constexpr std::byte kHiddenPoint{2}, kHiddenCell{32 | 8}, kHidden{1};  // A refined cell (8) counts as hidden.

/// Reads the ghost bytes of several boxes.
std::vector<std::vector<std::byte>> bytesOf(const SampleSource& source, const std::vector<Extent>& boxes,
                                            const TakeSamples& take) {
  std::vector<std::vector<std::byte>> all;
  for (const Extent& box : boxes) all.emplace_back(size_t(box.count()));
  source.read(boxes, [&](const SamplesRead& some) {
    copyBox(some.points, some.samples, some.layout, all[some.wanted], boxes[some.wanted], 1);
    take({0, {}, {}, {}});  // so that `take` can end this reading by an exception
  });
  return all;
}

/// Returns the cells that touch a box of points (`cellsOfPoints`), or the points that touch a box of cells.
/// `n` is the number of all such cells or points.
Extent touching(const Extent& box, const Index3& n, bool cellsOfPoints) {
  Extent all;
  for (size_t a = 0; a < 3; ++a) {
    const int64_t first = std::max<int64_t>(box.first[a] - (cellsOfPoints ? 1 : 0), 0);
    const int64_t end = std::min(box.first[a] + box.points[a] + (cellsOfPoints ? 0 : 1), n[a]);
    // An axis with one point has one cell.
    all.first[a] = std::min(first, n[a] - 1);
    all.points[a] = std::max<int64_t>(end - all.first[a], 1);
  }
  return all;
}

/// For each point (or cell) of a box and each cell (or point) that touches it, calls visit(flag of the
/// former, ghost byte of the latter).
template <class Visit>
void forTouching(const Extent& box, const Index3& n, bool cellsOfPoints, std::vector<std::byte>& flags,
                 const std::vector<std::byte>& values, Visit visit) {
  const Extent all = touching(box, n, cellsOfPoints);
  size_t at = 0;
  for (int64_t z = 0; z < box.points[2]; ++z)
    for (int64_t y = 0; y < box.points[1]; ++y)
      for (int64_t x = 0; x < box.points[0]; ++x, ++at) {
        const Extent one{{box.first[0] + x, box.first[1] + y, box.first[2] + z}, {1, 1, 1}};
        const Extent around = touching(one, n, cellsOfPoints);
        forBoxes(around, 0, around.count(), [&](const Extent& b, int64_t) {
          for (int64_t i = 0; i < b.count(); ++i) {
            const int64_t px = b.first[0] + i % b.points[0], py = b.first[1] + i / b.points[0] % b.points[1],
                          pz = b.first[2] + i / (b.points[0] * b.points[1]);
            visit(flags[at],
                  values[size_t(((pz - all.first[2]) * all.points[1] + py - all.first[1]) * all.points[0] +
                                px - all.first[0])]);
          }
        });
      }
}

}  // namespace

ScalarType HiddenSamples::typeFor(ScalarType type) {
  if (type == ScalarType::Float64) return type;
  return gxy::bytesOf(type) > 2 && type != ScalarType::Float32 ? ScalarType::Float64 : ScalarType::Float32;
}

std::vector<HiddenSamples::Flags> HiddenSamples::hiddenOf(std::span<const Extent> wanted,
                                                          const TakeSamples& take) const {
  std::vector<Flags> hidden;
  const std::vector<Extent> boxes(wanted.begin(), wanted.end());
  const bool cells = ghosts_.samplesOfCells;
  for (const Extent& box : boxes) hidden.emplace_back(size_t(box.count()));
  if (const auto& own = cells ? ghosts_.ofCells : ghosts_.ofPoints) {
    hidden = bytesOf(*own, boxes, take);
    for (Flags& flags : hidden)
      for (std::byte& f : flags)
        f = (f & (cells ? kHiddenCell : kHiddenPoint)) != std::byte(0) ? kHidden : std::byte(0);
  }
  const auto& other = cells ? ghosts_.ofPoints : ghosts_.ofCells;
  if (!other) return hidden;
  const Index3& n = cells ? ghosts_.points : ghosts_.cells;
  std::vector<Extent> around;
  for (const Extent& box : boxes) around.push_back(touching(box, n, !cells));
  const auto values = bytesOf(*other, around, take);
  for (size_t w = 0; w < boxes.size(); ++w) {
    Flags any(hidden[w].size());  // for cells: a corner is hidden; for points: a cell is not hidden
    forTouching(boxes[w], n, !cells, any, values[w], [&](std::byte& flag, std::byte value) {
      const bool is = cells ? (value & kHiddenPoint) != std::byte(0) : (value & kHiddenCell) == std::byte(0);
      if (is) flag = kHidden;
    });
    for (size_t i = 0; i < any.size(); ++i)
      if ((any[i] == kHidden) == cells) hidden[w][i] = kHidden;
  }
  return hidden;
}

void HiddenSamples::read(std::span<const Extent> wanted, const TakeSamples& take) const {
  const std::vector<Flags> hidden = hiddenOf(wanted, take);
  const size_t bytesIn = gxy::bytesOf(type_) * size_t(components_);
  const size_t bytesOut = gxy::bytesOf(typeFor(type_)) * size_t(components_);
  std::vector<std::byte> in, out;
  Flags flags;
  source_->read(wanted, [&](const SamplesRead& some) {
    const auto points = size_t(some.points.count());
    in.resize(points * bytesIn);
    out.resize(points * bytesOut);
    flags.resize(points);
    copyBox(some.points, some.samples, some.layout, in, some.points, bytesIn);
    copyBox(some.points, hidden[some.wanted], wanted[some.wanted], flags, some.points, 1);
    const auto convert = [&](auto from, auto to) {
      for (size_t i = 0; i < points * size_t(components_); ++i) {
        std::memcpy(&from, &in[i * sizeof from], sizeof from);
        to = static_cast<decltype(to)>(from);
        if (flags[i / size_t(components_)] == kHidden) to = std::numeric_limits<decltype(to)>::quiet_NaN();
        std::memcpy(&out[i * sizeof to], &to, sizeof to);
      }
    };
    const bool wide = typeFor(type_) == ScalarType::Float64;
    withType(type_, [&](auto from) { wide ? convert(from, double{}) : convert(from, float{}); });
    take({some.wanted, some.points, some.points, out});
  });
}

}  // namespace gxy
