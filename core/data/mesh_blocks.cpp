// SPDX-License-Identifier: Apache-2.0
#include "core/data/mesh_blocks.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/data/collapsed.h"
#include "core/data/connect.h"
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
  if (piece.components < 1 || piece.values.size() != piece.points.size() * size_t(piece.components) ||
      piece.numbers.size() != piece.points.size())
    throw Error("a mesh of " + std::to_string(piece.points.size()) + " points has " +
                std::to_string(piece.values.size()) + " values of " + std::to_string(piece.components) +
                " components and " + std::to_string(piece.numbers.size()) +
                " numbers, expected those of each point");
}

template <size_t N>
using CellPoints = std::array<uint32_t, N>;

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
    if (dropped_) dropUnusedPoints();
    for (const uint8_t isHere : sources_.isHere) counts_.points += isHere;
    for (const PointSources::Source& source : sources_.sources) counts_.mergedPoints += source.merged;
    MeshBlock block;
    block.values = valuesOfBlock(sources_, piece_.values, piece_.components, partition_, counts_);
    piece_.values = {};
    advance(0.5);
    Connectivity found = connect(cells_, points_.size());
    for (const uint32_t point : found.crowdedAt) counts_.crowdedFaces += sources_.isHere[point];
    countFoldedFaces(found);
    if (sources) *sources = std::move(sources_);
    block.points = std::move(points_);
    block.cells.points = shared(std::move(cells_.points));
    block.neighbours = shared(std::move(found.neighbours));
    block.shell = std::move(found.shell);
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
        continue;
      }
      std::copy_n(hexahedra.begin() + std::ptrdiff_t(at), 8, hexahedra.begin() + std::ptrdiff_t(kept));
      kept += 8;
    }
    hexahedra.resize(kept);
  }

  /// A face as a plane: that of a triangle, or the one through the middle of a quad along both of its diagonals.
  struct Plane {
    glm::dvec3 point, normal;
    int sideOf(const glm::dvec3& p) const {
      const double distance = glm::dot(normal, p - point);
      return int(distance > 0) - int(distance < 0);
    }
  };

  Plane planeOf(const CellFace& face, std::span<const uint32_t> cell) const {
    std::array<glm::dvec3, 4> p{};
    for (size_t k = 0; k < face.corners; k++) p[k] = points_[cell[face.corner[k]]];
    if (face.corners == 3) return {p[0], glm::cross(p[1] - p[0], p[2] - p[0])};
    return {(p[0] + p[1] + p[2] + p[3]) * 0.25, glm::cross(p[2] - p[0], p[3] - p[1])};
  }

  /// The middle of a cell's points that do not belong to a face. It is on the same side of the face as the middle of the cell.
  glm::dvec3 middleBeside(FaceId id) const {
    const auto cell = cells_.pointsOf(cellOf(id));
    const CellFace& face = shapeOf(cells_.typeOf(cellOf(id))).face[size_t(faceOf(id))];
    glm::dvec3 sum(0);
    for (size_t i = 0; i < cell.size(); i++)
      if (std::find(face.corner.begin(), face.corner.begin() + face.corners, i) ==
          face.corner.begin() + face.corners)
        sum += points_[cell[i]];
    return sum / double(cell.size() - face.corners);
  }

  void countFoldedFaces(const Connectivity& found) {
    for (const CellType type : kAllCellTypes) {
      const CellShape& shape = shapeOf(type);
      const uint32_t first = cells_.first(type);
      const std::vector<FaceId>& neighbours = found.neighbours[size_t(type)];
      const std::span<const uint32_t> cells = cells_.points[size_t(type)];
      for (size_t i = 0; i < neighbours.size(); i++) {
        const size_t cell = i / shape.faces, f = i % shape.faces;
        const FaceId id = faceId(first + uint32_t(cell), int(f)), other = neighbours[i];
        if (other == kNoFace || other < id) continue;
        const auto points = cells.subspan(cell * shape.points, shape.points);
        uint32_t lowest = points[shape.face[f].corner[0]];
        for (size_t k = 1; k < shape.face[f].corners; k++)
          lowest = std::min(lowest, points[shape.face[f].corner[k]]);
        if (!sources_.isHere[lowest]) continue;
        const Plane plane = planeOf(shape.face[f], points);
        counts_.foldedFaces += plane.sideOf(middleBeside(id)) * plane.sideOf(middleBeside(other)) >= 0;
      }
    }
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
    size_t kept = 0;
    for (size_t at = 0, n = read.size(); at < n; at += N) {
      tell(advance, at / N, n / N);
      CellPoints<N> cell;
      for (size_t i = 0; i < N; i++) cell[i] = numberOf_[read[at + i]];
      const CellPoints<N> sorted = ascending(cell);
      if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) {
        counts_.degenerateCells += sources_.isHere[sorted[0]];
        dropped_ = true;
        continue;
      }
      if (type == CellType::Tetrahedron) cell = sorted;
      std::copy(cell.begin(), cell.end(), read.begin() + std::ptrdiff_t(kept));
      kept += N;
      end[sorted[0] + 1]++;
    }
    for (size_t p = 1; p < end.size(); p++) end[p] += end[p - 1];
    std::vector<CellPoints<N>> cells(kept / N);
    for (size_t at = 0; at < kept; at += N) {
      CellPoints<N> cell;
      std::copy_n(read.begin() + std::ptrdiff_t(at), N, cell.begin());
      cells[end[*std::min_element(cell.begin(), cell.end())]++] = cell;
    }
    read = {};
    sortAmongSameLowest(cells, end, advance);
    made.reserve(kept);
    CellPoints<N> last{};
    for (const CellPoints<N>& cell : cells) {
      const CellPoints<N> sorted = ascending(cell);
      if (!made.empty() && sorted == last) {
        counts_.repeatedCells += sources_.isHere[sorted[0]];
        continue;
      }
      counts_.cells[size_t(type)] += sources_.isHere[sorted[0]];
      made.insert(made.end(), cell.begin(), cell.end());
      last = sorted;
    }
  }

  /// end[p]: the end of the cells whose lowest point is p.
  template <size_t N>
  static void sortAmongSameLowest(std::vector<CellPoints<N>>& cells, const std::vector<size_t>& end,
                                  const Advance& advance) {
    const auto sortCellsOf = [&](size_t p) {
      const auto from = cells.begin() + std::ptrdiff_t(p == 0 ? 0 : end[p - 1]);
      const auto to = cells.begin() + std::ptrdiff_t(end[p]);
      std::sort(from, to, [](const CellPoints<N>& a, const CellPoints<N>& b) {
        if constexpr (N == 4) return a < b;
        const CellPoints<N> x = ascending(a), y = ascending(b);
        return x != y ? x < y : a < b;
      });
    };
    if (!cells.empty()) parallelFor(size_t(0), end.size() - 1, sortCellsOf, advance);
  }

  void dropUnusedPoints() {
    constexpr uint32_t kNone = UINT32_MAX;
    std::vector<uint32_t> numbers(points_.size(), kNone);
    for (const auto& cells : cells_.points)
      for (const uint32_t point : cells) numbers[point] = 0;
    uint32_t kept = 0;
    for (size_t p = 0; p < numbers.size(); p++) {
      if (numbers[p] == kNone) continue;
      points_[kept] = points_[p];
      sources_.isHere[kept] = sources_.isHere[p];
      numbers[p] = kept++;
    }
    points_.resize(kept);
    sources_.isHere.resize(kept);
    std::erase_if(sources_.sources,
                  [&](const PointSources::Source& source) { return numbers[source.to] == kNone; });
    for (PointSources::Source& source : sources_.sources) source.to = numbers[source.to];
    for (auto& cells : cells_.points)
      for (uint32_t& point : cells) point = numbers[point];
  }

  MeshPiece piece_;
  const Partitioning& partitioning_;
  const int partition_;
  MeshBlockCounts& counts_;
  std::vector<glm::dvec3> points_;  // of the block, as are the next two
  MeshCells cells_;
  PointSources sources_;
  std::vector<uint32_t> numberOf_;  // by point of the piece: its number in the block
  bool dropped_ = false;            // a cell, which may have been the only one with its points
};

}  // namespace

int64_t bytesOf(const MeshPiece& piece) {
  size_t bytes = piece.points.size() * sizeof(glm::dvec3) + piece.values.size() * sizeof(float) +
                 piece.numbers.size() * sizeof(uint64_t);
  for (const auto& cells : piece.cells.points) bytes += cells.size() * sizeof(uint32_t);
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
