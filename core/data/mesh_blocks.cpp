// SPDX-License-Identifier: Apache-2.0
#include "core/data/mesh_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/data/collapsed.h"
#include "core/data/connect.h"
#include "core/data/mesh_defects.h"
#include "core/data/mesh_values.h"
#include "core/data/morton.h"
#include "core/data/point_averages.h"

namespace gxy {

namespace {

bool isFinitePoint(const glm::dvec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

void checkSizes(const MeshPiece& piece) {
  if (piece.points.size() >= kMostMeshPoints)
    throw Error("a mesh of " + std::to_string(piece.points.size()) +
                " points, expected fewer than 2^30 on one rank and in one partition; use more of them");
  if (piece.cells.size() >= kMostMeshCells)
    throw Error("a mesh of " + std::to_string(piece.cells.size()) +
                " cells, expected fewer than 2^29 on one rank and in one partition; use more of them");
  const auto components = size_t(piece.components);
  for (const CellType type : kAllCellTypes) {
    const size_t count = piece.ofCells ? piece.cells.size(type) : 0;
    if (piece.cellValues[size_t(type)].size() != count * components ||
        piece.duplicates[size_t(type)].size() != count)
      throw Error("a mesh of " + std::to_string(count) + " " + pluralOf(type) + " has " +
                  std::to_string(piece.cellValues[size_t(type)].size()) + " values of " +
                  std::to_string(piece.components) + " components and " +
                  std::to_string(piece.duplicates[size_t(type)].size()) +
                  " marks of duplicates, expected those of each cell");
  }
  const size_t ofPoints = piece.ofCells ? 0 : piece.points.size() * components;
  if (piece.components < 1 || piece.values.size() != ofPoints || piece.numbers.size() != piece.points.size())
    throw Error("a mesh of " + std::to_string(piece.points.size()) + " points has " +
                std::to_string(piece.values.size()) + " values of " + std::to_string(piece.components) +
                " components and " + std::to_string(piece.numbers.size()) + " numbers, expected " +
                (piece.ofCells ? "the numbers" : "those") + " of each point");
}

bool lacksData(const float* values, int components) {
  return std::any_of(values, values + components, [](float v) { return !std::isfinite(v); });
}

/// Whether values come before others: NaN is behind all numbers.
bool isLower(const float* a, const float* b, int components) {
  for (int c = 0; c < components; c++)
    if (a[c] != b[c] && !(std::isnan(a[c]) && std::isnan(b[c]))) return std::isnan(b[c]) || a[c] < b[c];
  return false;
}

template <size_t N>
using CellPoints = std::array<uint32_t, N>;

/// A cell and which one of the piece it is, among those of its type.
template <size_t N>
struct ReadCell {
  CellPoints<N> points;
  uint32_t from;
};

template <size_t N>
CellPoints<N> ascending(CellPoints<N> cell) {
  for (size_t i = 1; i < N; i++)
    for (size_t k = i; k > 0 && cell[k] < cell[k - 1]; k--) std::swap(cell[k], cell[k - 1]);
  return cell;
}

class BlockMaker {
 public:
  BlockMaker(MeshPiece piece, const Partitioning& partitioning, int partition, MeshBlockCounts& counts)
      : piece_(std::move(piece)), partitioning_(partitioning), partition_(partition), counts_(counts) {}

  MeshBlock make(const Advance& advance, PointSources* sources) {
    placePoints(partOf(advance, 0, 4));
    collapseHexahedra();
    const Advance ordering = partOf(advance, 1, 4);
    orderCells<4>(CellType::Tetrahedron, partOf(ordering, 0, kCellTypes));
    orderCells<5>(CellType::Pyramid, partOf(ordering, 1, kCellTypes));
    orderCells<6>(CellType::Wedge, partOf(ordering, 2, kCellTypes));
    orderCells<8>(CellType::Hexahedron, partOf(ordering, 3, kCellTypes));
    if (piece_.ofCells) averageCells(partOf(advance, 2, 4));
    if (dropped_) dropUnusedPoints();
    for (const uint8_t isHere : sources_.isHere) counts_.points += isHere;
    for (const PointSources::Source& source : sources_.sources) counts_.mergedPoints += source.merged;
    MeshBlock block;
    if (piece_.ofCells)
      giveCellValues(block);
    else
      block.values = valuesOfBlock(sources_, piece_.values, piece_.components, partition_, counts_);
    piece_.values = {};
    advance(piece_.ofCells ? 0.75 : 0.5);
    Connectivity found = connect(cells_, points_.size());
    for (const uint32_t point : found.crowdedAt) counts_.crowdedFaces += sources_.isHere[point];
    block.points = std::move(points_);
    block.cells.points = shared(std::move(cells_.points));
    block.neighbours = shared(std::move(found.neighbours));
    block.shell = std::move(found.shell);
    const MeshDefects defects = defectsOf(block, sources_.isHere);
    counts_.foldedFaces += defects.foldedFaces;
    counts_.hangingPoints += defects.hangingPoints;
    counts_.splitFaces += defects.splitFaces;
    if (sources) *sources = std::move(sources_);
    advance(1);
    return block;
  }

 private:
  /// Hexahedra with repeated points become the cells that they are. These have points of the piece, of which several may be at one place.
  void collapseHexahedra() {
    std::vector<uint32_t>& hexahedra = piece_.cells.points[size_t(CellType::Hexahedron)];
    size_t kept = 0;
    for (size_t at = 0; at < hexahedra.size(); at += 8) {
      std::array<uint32_t, 8> places;
      for (size_t i = 0; i < 8; i++) places[i] = numberOf_[hexahedra[at + i]];
      if (const auto cell = collapsed(places)) {
        std::vector<uint32_t>& to = piece_.cells.points[size_t(cell->type)];
        for (size_t i = 0; i < shapeOf(cell->type).points; i++) {
          const auto one = std::find(places.begin(), places.end(), cell->points[i]);
          to.push_back(hexahedra[at + size_t(one - places.begin())]);
        }
        if (piece_.ofCells) becomes(at / 8, cell->type);
        continue;
      }
      std::copy_n(hexahedra.begin() + std::ptrdiff_t(at), 8, hexahedra.begin() + std::ptrdiff_t(kept));
      if (piece_.ofCells) movesTo(at / 8, kept / 8);
      kept += 8;
    }
    hexahedra.resize(kept);
    if (!piece_.ofCells) return;
    piece_.cellValues[kHexes].resize(kept / 8 * size_t(piece_.components));
    piece_.duplicates[kHexes].resize(kept / 8);
  }

  /// The value of a hexahedron becomes that of the last cell of a type.
  void becomes(size_t hexahedron, CellType type) {
    const float* values = piece_.cellValues[kHexes].data() + hexahedron * size_t(piece_.components);
    std::vector<float>& to = piece_.cellValues[size_t(type)];
    to.insert(to.end(), values, values + piece_.components);
    piece_.duplicates[size_t(type)].push_back(piece_.duplicates[kHexes][hexahedron]);
  }

  void movesTo(size_t hexahedron, size_t place) {
    const auto components = size_t(piece_.components);
    float* const values = piece_.cellValues[kHexes].data();
    std::copy_n(values + hexahedron * components, components, values + place * components);
    piece_.duplicates[kHexes][place] = piece_.duplicates[kHexes][hexahedron];
  }

  struct Place {
    uint64_t along;
    uint32_t point;
    bool operator<(const Place& o) const { return along < o.along; }
  };

  /// Makes one point of all at one place, in the order of the block; numberOf_ says which one each point of the piece becomes.
  void placePoints(const Advance& advance) {
    const std::vector<Place> places = orderedPlaces(advance);
    numberOf_.resize(piece_.points.size());
    points_.reserve(places.size());
    std::vector<uint8_t>& isHere = sources_.isHere;
    isHere.reserve(places.size());
    sources_.sources.reserve(places.size());
    sources_.pointsOfPiece = piece_.points.size();
    uint64_t lastNumber = 0;  // several ranks may have read a point
    for (const auto& [along, point] : places) {
      const glm::dvec3& p = piece_.points[point];
      const bool isNew = points_.empty() || points_.back() != p;
      if (isNew) {
        points_.push_back(p);
        isHere.push_back(partitioning_.partitions() == 1 || partitioning_.nearest(p) == partition_);
      }
      numberOf_[point] = uint32_t(points_.size() - 1);
      const bool merged = !isNew && isHere.back() && piece_.numbers[point] != lastNumber;
      sources_.sources.push_back({point, numberOf_[point], merged});
      lastNumber = piece_.numbers[point];
    }
    piece_.points = {};
    piece_.numbers = {};
  }

  /// The points that cells have, along the curve, those at one place by their numbers in the files.
  std::vector<Place> orderedPlaces(const Advance& advance) {
    std::vector<uint8_t> used(piece_.points.size(), 0);
    for (const auto& cells : piece_.cells.points)
      for (const uint32_t point : cells) used[point] = 1;
    std::vector<Place> places;
    places.reserve(piece_.points.size());
    for (uint32_t i = 0; i < piece_.points.size(); i++)
      if (used[i]) places.push_back({0, i});
    const MortonCurve curve(partitioning_.domain());
    parallelFor(
        size_t(0), places.size(),
        [&](size_t i) {
          glm::dvec3& p = piece_.points[places[i].point];
          p += glm::dvec3(0);  // -0 becomes 0, so that equal places are the same bits
          places[i].along = curve(p);
        },
        advance);
    parallelSort(places.begin(), places.end());
    for (auto from = places.begin(); from != places.end();) {
      const auto to =
          std::find_if(from + 1, places.end(), [&](const Place& p) { return p.along != from->along; });
      if (to - from > 1) std::sort(from, to, [&](const Place& a, const Place& b) { return isBefore(a, b); });
      from = to;
    }
    return places;
  }

  bool isBefore(const Place& a, const Place& b) const {
    const glm::dvec3 &p = piece_.points[a.point], &q = piece_.points[b.point];
    for (int k = 0; k < 3; k++)
      if (p[k] != q[k]) return p[k] < q[k];
    return piece_.numbers[a.point] < piece_.numbers[b.point];
  }

  /// Sorts the cells of a type by their points. Only the few with the same lowest point are compared.
  template <size_t N>
  void orderCells(CellType type, const Advance& advance) {
    std::vector<uint32_t>& read = piece_.cells.points[size_t(type)];
    std::vector<uint32_t>& made = cells_.points[size_t(type)];
    if (read.empty()) return;
    std::vector<size_t> end(points_.size() + 1, 0);
    std::vector<uint32_t> from;
    from.reserve(read.size() / N);
    for (size_t at = 0, n = read.size(); at < n; at += N) {
      tell(advance, at / N, n / N);
      CellPoints<N> cell;
      for (size_t i = 0; i < N; i++) cell[i] = numberOf_[read[at + i]];
      const CellPoints<N> sorted = ascending(cell);
      if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) {
        counts_.degenerateCells += sources_.isHere[sorted[0]] && !isDuplicate(type, at / N);
        dropped_ = true;
        continue;
      }
      counts_.invertedCells +=
          sources_.isHere[sorted[0]] && !isDuplicate(type, at / N) && isInverted(points_, type, cell);
      if (type == CellType::Tetrahedron) cell = sorted;
      std::copy(cell.begin(), cell.end(), read.begin() + std::ptrdiff_t(from.size() * N));
      from.push_back(uint32_t(at / N));
      end[sorted[0] + 1]++;
    }
    for (size_t p = 1; p < end.size(); p++) end[p] += end[p - 1];
    std::vector<ReadCell<N>> cells(from.size());
    for (size_t i = 0; i < from.size(); i++) {
      ReadCell<N> cell{{}, from[i]};
      std::copy_n(read.begin() + std::ptrdiff_t(i * N), N, cell.points.begin());
      cells[end[*std::min_element(cell.points.begin(), cell.points.end())]++] = cell;
    }
    read = {};
    sortAmongSameLowest(cells, end, advance);
    made.reserve(cells.size() * N);
    for (auto cell = cells.begin(); cell != cells.end();) {
      const CellPoints<N> sorted = ascending(cell->points);
      const auto next = std::find_if(
          cell + 1, cells.end(), [&](const ReadCell<N>& other) { return ascending(other.points) != sorted; });
      made.insert(made.end(), cell->points.begin(), cell->points.end());
      const bool isHere = sources_.isHere[sorted[0]];
      auto several = uint64_t(next - cell);
      if (piece_.ofCells) several = takeValues(type, std::span<const ReadCell<N>>(cell, next), isHere);
      if (isHere && several > 0) {
        counts_.cells[size_t(type)]++;
        counts_.repeatedCells += several - 1;
      }
      cell = next;
    }
  }

  bool isDuplicate(CellType type, size_t cell) const {
    return piece_.ofCells && piece_.duplicates[size_t(type)][cell];
  }

  /// Appends the value of the one of these cells that is kept. Returns how many of them are no duplicates of other pieces' cells.
  template <size_t N>
  uint64_t takeValues(CellType type, std::span<const ReadCell<N>> same, bool isHere) {
    const int components = piece_.components;
    const float* const all = piece_.cellValues[size_t(type)].data();
    const auto valuesOf = [&](const ReadCell<N>& cell) {
      return all + size_t(cell.from) * size_t(components);
    };
    const ReadCell<N>* kept = nullptr;
    uint64_t several = 0;
    for (const ReadCell<N>& cell : same) {
      const bool duplicate = isDuplicate(type, cell.from);
      const bool first = !kept || (!duplicate && several == 0);
      if (first || (duplicate == (several == 0) && isLower(valuesOf(cell), valuesOf(*kept), components)))
        kept = &cell;
      several += !duplicate;
    }
    if (isHere && several > 1)
      counts_.differingCells += std::any_of(same.begin(), same.end(), [&](const ReadCell<N>& cell) {
        return !isDuplicate(type, cell.from) && (isLower(valuesOf(cell), valuesOf(*kept), components) ||
                                                 isLower(valuesOf(*kept), valuesOf(cell), components));
      });
    cellValues_.insert(cellValues_.end(), valuesOf(*kept), valuesOf(*kept) + components);
    onlyDuplicate_.push_back(several == 0);
    return several;
  }

  /// end[p]: the end of the cells whose lowest point is p.
  template <size_t N>
  static void sortAmongSameLowest(std::vector<ReadCell<N>>& cells, const std::vector<size_t>& end,
                                  const Advance& advance) {
    const auto sortCellsOf = [&](size_t p) {
      const auto from = cells.begin() + std::ptrdiff_t(p == 0 ? 0 : end[p - 1]);
      const auto to = cells.begin() + std::ptrdiff_t(end[p]);
      std::sort(from, to, [](const ReadCell<N>& a, const ReadCell<N>& b) {
        if constexpr (N == 4) return a.points < b.points;
        const CellPoints<N> x = ascending(a.points), y = ascending(b.points);
        return x != y ? x < y : a.points < b.points;
      });
    };
    if (!cells.empty()) parallelFor(size_t(0), end.size() - 1, sortCellsOf, advance);
  }

  /// Gives values to points. Then cells that are there as duplicates only have served, and leave.
  void averageCells(const Advance& advance) {
    values_ = averagesAtPoints(points_, cells_, cellValues_, piece_.components, advance);
    if (std::none_of(onlyDuplicate_.begin(), onlyDuplicate_.end(), [](uint8_t only) { return only; })) return;
    dropped_ = true;
    const auto components = size_t(piece_.components);
    size_t cell = 0, kept = 0;
    for (const CellType type : kAllCellTypes) {
      std::vector<uint32_t>& cells = cells_.points[size_t(type)];
      const size_t n = shapeOf(type).points, count = cells.size() / n;
      size_t keptOfType = 0;
      for (size_t i = 0; i < count; i++, cell++) {
        if (onlyDuplicate_[cell]) continue;
        std::copy_n(cells.begin() + std::ptrdiff_t(i * n), n,
                    cells.begin() + std::ptrdiff_t(keptOfType++ * n));
        std::copy_n(cellValues_.begin() + std::ptrdiff_t(cell * components), components,
                    cellValues_.begin() + std::ptrdiff_t(kept++ * components));
      }
      cells.resize(keptOfType * n);
    }
    cellValues_.resize(kept * components);
  }

  void giveCellValues(MeshBlock& block) {
    uint32_t cell = 0;
    for (const CellType type : kAllCellTypes) {
      const std::vector<uint32_t>& cells = cells_.points[size_t(type)];
      const auto n = std::ptrdiff_t(shapeOf(type).points);
      for (auto at = cells.begin(); at != cells.end(); at += n, cell++) {
        float* const values = cellValues_.data() + cell * size_t(piece_.components);
        if (!lacksData(values, piece_.components)) continue;
        counts_.noDataCells += sources_.isHere[*std::min_element(at, at + n)];
        std::fill_n(values, piece_.components, std::numeric_limits<float>::quiet_NaN());
      }
    }
    std::vector<uint32_t> here;
    for (uint32_t p = 0; p < points_.size() && partitioning_.partitions() > 1; p++)
      if (sources_.isHere[p]) here.push_back(p);
    if (!here.empty()) counts_.differing[partition_] = std::move(here);
    block.values = std::move(values_);
    block.cellValues = std::move(cellValues_);
  }

  void dropUnusedPoints() {
    constexpr uint32_t kNone = UINT32_MAX;
    std::vector<uint32_t> numbers(points_.size(), kNone);
    for (const auto& cells : cells_.points)
      for (const uint32_t point : cells) numbers[point] = 0;
    uint32_t kept = 0;
    const auto components = size_t(piece_.components);
    for (size_t p = 0; p < numbers.size(); p++) {
      if (numbers[p] == kNone) continue;
      points_[kept] = points_[p];
      if (piece_.ofCells)
        std::copy_n(values_.begin() + std::ptrdiff_t(p * components), components,
                    values_.begin() + std::ptrdiff_t(kept * components));
      sources_.isHere[kept] = sources_.isHere[p];
      numbers[p] = kept++;
    }
    points_.resize(kept);
    if (piece_.ofCells) values_.resize(kept * components);
    sources_.isHere.resize(kept);
    std::erase_if(sources_.sources,
                  [&](const PointSources::Source& source) { return numbers[source.to] == kNone; });
    for (PointSources::Source& source : sources_.sources) source.to = numbers[source.to];
    for (auto& cells : cells_.points)
      for (uint32_t& point : cells) point = numbers[point];
  }

  static constexpr auto kHexes = size_t(CellType::Hexahedron);
  MeshPiece piece_;
  const Partitioning& partitioning_;
  const int partition_;
  MeshBlockCounts& counts_;
  std::vector<glm::dvec3> points_;  // of the block, as are the next two
  MeshCells cells_;
  PointSources sources_;
  std::vector<uint32_t> numberOf_;  // by point of the piece: its number in the block
  // If the data are those of cells: by point and by cell of the block, and whether all cells with a cell's points are duplicates.
  std::vector<float> values_, cellValues_;
  std::vector<uint8_t> onlyDuplicate_;
  bool dropped_ = false;  // a cell, which may have been the only one with its points
};

}  // namespace

int64_t bytesOf(const MeshPiece& piece) {
  size_t bytes = piece.points.size() * sizeof(glm::dvec3) + piece.values.size() * sizeof(float) +
                 piece.numbers.size() * sizeof(uint64_t);
  for (const CellType type : kAllCellTypes)
    bytes += piece.cells.points[size_t(type)].size() * sizeof(uint32_t) +
             piece.cellValues[size_t(type)].size() * sizeof(float) + piece.duplicates[size_t(type)].size();
  return int64_t(bytes);
}

void validate(const MeshPiece& piece) {
  checkSizes(piece);
  if (!std::all_of(piece.points.begin(), piece.points.end(), isFinitePoint))
    throw Error("a mesh has a point whose coordinates are not finite");
  for (const CellType type : kAllCellTypes) {
    const std::vector<uint32_t>& cells = piece.cells.points[size_t(type)];
    if (cells.size() % shapeOf(type).points != 0)
      throw Error("a mesh has cells of " + std::to_string(shapeOf(type).points) + " points each with " +
                  std::to_string(cells.size()) + " points in all");
    for (const uint32_t point : cells)
      if (point >= piece.points.size())
        throw Error("a cell has point " + std::to_string(point) + " of a mesh of " +
                    std::to_string(piece.points.size()) + " points (counted from 0)");
  }
}

MeshBlock meshBlock(MeshPiece piece, const Partitioning& partitioning, int partition, MeshBlockCounts& counts,
                    const Advance& advance, PointSources* sources) {
  validate(piece);
  return BlockMaker(std::move(piece), partitioning, partition, counts).make(advance, sources);
}

}  // namespace gxy
