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

/// The values of all cells of a piece, types one after the other.
std::vector<float> together(std::array<std::vector<float>, kCellTypes> values) {
  std::vector<float> all;
  for (std::vector<float>& some : values) {
    if (all.empty())
      all = std::move(some);
    else
      all.insert(all.end(), some.begin(), some.end());
    some = {};
  }
  return all;
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

  MeshBlock make(const Advance& advance, BlockSources* sources) {
    placePoints(partOf(advance, 0, 4));
    if (piece_.ofCells) numberCells();
    collapseHexahedra();
    const Advance ordering = partOf(advance, 1, 4);
    orderCells<4>(CellType::Tetrahedron, partOf(ordering, 0, kCellTypes));
    orderCells<5>(CellType::Pyramid, partOf(ordering, 1, kCellTypes));
    orderCells<6>(CellType::Wedge, partOf(ordering, 2, kCellTypes));
    orderCells<8>(CellType::Hexahedron, partOf(ordering, 3, kCellTypes));
    if (piece_.ofCells) dropDuplicates();
    if (dropped_) dropUnusedPoints();
    PointSources& ofPoints = sources_.points;
    for (const uint8_t isHere : ofPoints.isHere) counts_.points += isHere;
    for (const PointSources::Source& source : ofPoints.sources) counts_.mergedPoints += source.merged;
    MeshBlock block;
    if (!piece_.ofCells)
      block.values = valuesOfBlock(ofPoints, piece_.values, piece_.components, partition_, counts_);
    piece_.values = {};
    advance(0.5);
    Connectivity found = connect(cells_, points_.size());
    for (const uint32_t point : found.crowdedAt) counts_.crowdedFaces += ofPoints.isHere[point];
    block.points = std::move(points_);
    block.cells.points = shared(std::move(cells_.points));
    block.neighbours = shared(std::move(found.neighbours));
    block.shell = std::move(found.shell);
    const MeshDefects defects = defectsOf(block, ofPoints.isHere);
    counts_.foldedFaces += defects.foldedFaces;
    counts_.hangingPoints += defects.hangingPoints;
    counts_.splitFaces += defects.splitFaces;
    if (piece_.ofCells)
      giveCellValues(block, sources_, together(std::move(piece_.cellValues)), piece_.components,
                     partitioning_, partition_, counts_, partOf(advance, 3, 4));
    if (sources) *sources = std::move(sources_);
    advance(1);
    return block;
  }

 private:
  void numberCells() {
    sources_.cells.emplace();
    uint64_t& cells = sources_.cells->cellsOfPiece;
    for (size_t type = 0; type < kCellTypes; type++)
      for (size_t i = 0; i < piece_.duplicates[type].size(); i++) from_[type].push_back(uint32_t(cells++));
  }

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
    from_[kHexes].resize(kept / 8);
    piece_.duplicates[kHexes].resize(kept / 8);
  }

  /// A hexahedron becomes the last cell of a type.
  void becomes(size_t hexahedron, CellType type) {
    from_[size_t(type)].push_back(from_[kHexes][hexahedron]);
    piece_.duplicates[size_t(type)].push_back(piece_.duplicates[kHexes][hexahedron]);
  }

  void movesTo(size_t hexahedron, size_t place) {
    from_[kHexes][place] = from_[kHexes][hexahedron];
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
    const std::vector<uint8_t> isSource = pointsOfCells(false);
    numberOf_.resize(piece_.points.size());
    points_.reserve(places.size());
    std::vector<uint8_t>& isHere = sources_.points.isHere;
    std::vector<PointSources::Source>& sources = sources_.points.sources;
    isHere.reserve(places.size());
    sources.reserve(places.size());
    sources_.points.pointsOfPiece = piece_.points.size();
    uint64_t lastNumber = 0;  // several ranks may have read a point
    for (const auto& [along, point] : places) {
      const glm::dvec3& p = piece_.points[point];
      const bool isNew = points_.empty() || points_.back() != p;
      if (isNew) {
        points_.push_back(p);
        isHere.push_back(partitioning_.partitions() == 1 || partitioning_.nearest(p) == partition_);
      }
      numberOf_[point] = uint32_t(points_.size() - 1);
      if (!isSource[point]) continue;
      const bool isFirst = sources.empty() || sources.back().to != numberOf_[point];
      const bool merged = !isFirst && isHere.back() && piece_.numbers[point] != lastNumber;
      sources.push_back({point, numberOf_[point], merged});
      lastNumber = piece_.numbers[point];
    }
    piece_.points = {};
    piece_.numbers = {};
  }

  /// By point of the piece: whether a cell has it, of those that are no duplicates, or of all.
  std::vector<uint8_t> pointsOfCells(bool duplicatesToo) const {
    std::vector<uint8_t> used(piece_.points.size(), 0);
    for (const CellType type : kAllCellTypes) {
      const std::vector<uint32_t>& corners = piece_.cells.points[size_t(type)];
      const size_t n = shapeOf(type).points;
      for (size_t i = 0; i < corners.size(); i++)
        if (duplicatesToo || !isDuplicate(type, i / n)) used[corners[i]] = 1;
    }
    return used;
  }

  /// The points that cells have, along the curve, those at one place by their numbers in the files.
  std::vector<Place> orderedPlaces(const Advance& advance) {
    const std::vector<uint8_t> used = pointsOfCells(true);
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
        counts_.degenerateCells += sources_.points.isHere[sorted[0]] && !isDuplicate(type, at / N);
        dropped_ = true;
        continue;
      }
      counts_.invertedCells +=
          sources_.points.isHere[sorted[0]] && !isDuplicate(type, at / N) && isInverted(points_, type, cell);
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
    sortAmongSameLowest(type, cells, end, advance);
    made.reserve(cells.size() * N);
    for (auto cell = cells.begin(); cell != cells.end();) {
      const CellPoints<N> sorted = ascending(cell->points);
      const auto next = std::find_if(
          cell + 1, cells.end(), [&](const ReadCell<N>& other) { return ascending(other.points) != sorted; });
      made.insert(made.end(), cell->points.begin(), cell->points.end());
      const bool isHere = sources_.points.isHere[sorted[0]];
      auto several = uint64_t(next - cell);
      if (piece_.ofCells) several = addSources(type, std::span<const ReadCell<N>>(cell, next));
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

  /// Returns how many of these cells with the same points are no duplicates of other pieces' cells.
  template <size_t N>
  uint64_t addSources(CellType type, std::span<const ReadCell<N>> same) {
    uint64_t several = 0;
    for (const ReadCell<N>& cell : same) {
      const bool duplicate = isDuplicate(type, cell.from);
      sources_.cells->sources.push_back(
          {from_[size_t(type)][cell.from], uint32_t(onlyDuplicate_.size()), duplicate});
      several += !duplicate;
    }
    onlyDuplicate_.push_back(several == 0);
    return several;
  }

  /// end[p]: the end of the cells whose lowest point is p. Duplicates come after the cells that they are duplicates of.
  template <size_t N>
  void sortAmongSameLowest(CellType type, std::vector<ReadCell<N>>& cells, const std::vector<size_t>& end,
                           const Advance& advance) {
    const auto sortCellsOf = [&](size_t p) {
      const auto from = cells.begin() + std::ptrdiff_t(p == 0 ? 0 : end[p - 1]);
      const auto to = cells.begin() + std::ptrdiff_t(end[p]);
      std::sort(from, to, [this, type](const ReadCell<N>& a, const ReadCell<N>& b) {
        if constexpr (N == 4) return a.points < b.points;
        const CellPoints<N> x = ascending(a.points), y = ascending(b.points);
        if (x != y) return x < y;
        const bool p = isDuplicate(type, a.from), q = isDuplicate(type, b.from);
        return p != q ? q : a.points < b.points;
      });
    };
    if (!cells.empty()) parallelFor(size_t(0), end.size() - 1, sortCellsOf, advance);
  }

  /// Cells that are there as duplicates only serve averages, and leave the block.
  void dropDuplicates() {
    if (std::none_of(onlyDuplicate_.begin(), onlyDuplicate_.end(), [](uint8_t only) { return only; })) return;
    dropped_ = true;
    sources_.cells->served = {points_, cells_, {}};
    size_t cell = 0;
    for (const CellType type : kAllCellTypes) {
      std::vector<uint32_t>& cells = cells_.points[size_t(type)];
      const size_t n = shapeOf(type).points, count = cells.size() / n;
      size_t keptOfType = 0;
      for (size_t i = 0; i < count; i++, cell++) {
        if (onlyDuplicate_[cell]) continue;
        std::copy_n(cells.begin() + std::ptrdiff_t(i * n), n,
                    cells.begin() + std::ptrdiff_t(keptOfType++ * n));
      }
      cells.resize(keptOfType * n);
    }
  }

  void dropUnusedPoints() {
    constexpr uint32_t kNone = UINT32_MAX;
    std::vector<uint32_t> numbers(points_.size(), kNone);
    for (const auto& cells : cells_.points)
      for (const uint32_t point : cells) numbers[point] = 0;
    uint32_t kept = 0;
    PointSources& sources = sources_.points;
    CellSources::Served* served =
        sources_.cells && sources_.cells->served ? &*sources_.cells->served : nullptr;
    for (size_t p = 0; p < numbers.size(); p++) {
      if (numbers[p] == kNone) continue;
      points_[kept] = points_[p];
      if (served) served->keptPoints.push_back(uint32_t(p));
      sources.isHere[kept] = sources.isHere[p];
      numbers[p] = kept++;
    }
    points_.resize(kept);
    sources.isHere.resize(kept);
    std::erase_if(sources.sources,
                  [&](const PointSources::Source& source) { return numbers[source.to] == kNone; });
    for (PointSources::Source& source : sources.sources) source.to = numbers[source.to];
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
  BlockSources sources_;
  std::vector<uint32_t> numberOf_;  // by point of the piece: its number in the block
  // If the data are those of cells: by type which cells of the piece as it came they are, and whether all cells with a cell's points are
  // duplicates.
  std::array<std::vector<uint32_t>, kCellTypes> from_;
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
                    const Advance& advance, BlockSources* sources) {
  validate(piece);
  return BlockMaker(std::move(piece), partitioning, partition, counts).make(advance, sources);
}

}  // namespace gxy
