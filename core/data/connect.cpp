// SPDX-License-Identifier: Apache-2.0
#include "core/data/connect.h"

#include <algorithm>
#include <string>

#include "core/comm/error.h"

namespace gxy {

namespace {

constexpr uint32_t kNoPoint = UINT32_MAX;

// A face as a key that does not depend on where its points begin and on the way around. With its lowest point, it says which face
// it is: the point opposite the lowest one, or kNoPoint, and the two that are beside it.
struct FaceKey {
  uint32_t lowest = kNoPoint;  // kNoPoint: the face has no area
  uint32_t opposite = kNoPoint;
  uint32_t beside = 0;
  uint32_t otherAndWay = 0;  // the higher one of both, and a bit: whether the lower one follows the lowest
};

struct FaceEntry {
  uint64_t oppositeAndBeside;
  uint32_t otherAndWay;
  FaceId id;

  bool operator<(const FaceEntry& o) const {
    return oppositeAndBeside != o.oppositeAndBeside ? oppositeAndBeside < o.oppositeAndBeside
                                                    : otherAndWay < o.otherAndWay;
  }
  bool isOneWith(const FaceEntry& o) const {
    return oppositeAndBeside == o.oppositeAndBeside && otherAndWay >> 1 == o.otherAndWay >> 1;
  }
};

FaceKey keyOf(const CellFace& face, const uint32_t* cell) {
  std::array<uint32_t, 4> p{};
  int n = 0;
  for (int i = 0; i < face.corners; i++) {
    const uint32_t point = cell[face.corner[size_t(i)]];
    if (n == 0 || p[size_t(n - 1)] != point) p[size_t(n++)] = point;
  }
  while (n > 1 && p[size_t(n - 1)] == p[0]) n--;
  if (n < 3 || (n == 4 && (p[0] == p[2] || p[1] == p[3]))) return {};
  const int at = int(std::min_element(p.begin(), p.begin() + n) - p.begin());
  const uint32_t next = p[size_t((at + 1) % n)], before = p[size_t((at + n - 1) % n)];
  return {p[size_t(at)], n == 4 ? p[size_t((at + 2) % 4)] : kNoPoint, std::min(next, before),
          std::max(next, before) << 1 | uint32_t(next < before)};
}

template <class Visit>
void eachFace(const MeshCells& cells, Visit&& visit) {
  uint32_t cell = 0;
  for (const CellType type : kAllCellTypes) {
    const CellShape& shape = shapeOf(type);
    const std::vector<uint32_t>& points = cells.points[size_t(type)];
    for (size_t at = 0; at < points.size(); at += shape.points, cell++)
      for (int f = 0; f < shape.faces; f++)
        visit(faceId(cell, f), keyOf(shape.face[size_t(f)], points.data() + at));
  }
}

void check(const MeshCells& cells, uint64_t points) {
  if (points >= kMostMeshPoints)
    throw Error("a mesh of " + std::to_string(points) + " points, expected fewer than 2^30");
  if (cells.size() >= kMostMeshCells)
    throw Error("a mesh of " + std::to_string(cells.size()) + " cells, expected fewer than 2^29");
  for (const auto& ofType : cells.points)
    for (const uint32_t point : ofType)
      if (point >= points)
        throw Error("a cell has point " + std::to_string(point) + " of a mesh of " + std::to_string(points) +
                    " points (counted from 0)");
}

uint64_t cellsWithAPointTwice(const MeshCells& cells) {
  uint64_t count = 0;
  for (const CellType type : kAllCellTypes) {
    const size_t n = shapeOf(type).points;
    const std::vector<uint32_t>& points = cells.points[size_t(type)];
    for (size_t at = 0; at < points.size(); at += n) {
      bool twice = false;
      for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < i; k++) twice = twice || points[at + i] == points[at + k];
      count += twice;
    }
  }
  return count;
}

}  // namespace

Connectivity connect(const MeshCells& cells, uint64_t points) {
  check(cells, points);
  Connectivity found;
  found.repeated = cellsWithAPointTwice(cells);
  std::array<uint32_t, kCellTypes> first{};
  for (const CellType type : kAllCellTypes) {
    first[size_t(type)] = cells.first(type);
    found.neighbours[size_t(type)].assign(cells.size(type) * shapeOf(type).faces, kNoFace);
  }
  const auto neighbour = [&](FaceId id) -> FaceId& {
    const uint32_t cell = cellOf(id);
    size_t type = kCellTypes - 1;
    while (cell < first[type]) type--;
    return found
        .neighbours[type][size_t(cell - first[type]) * shapeOf(CellType(type)).faces + size_t(faceOf(id))];
  };

  // Faces of the same lowest point stand together, from its place on.
  std::vector<uint32_t> place(points + 1, 0);
  eachFace(cells, [&](FaceId, const FaceKey& key) {
    if (key.lowest != kNoPoint) place[key.lowest + 1]++;
  });
  for (size_t p = 0; p < points; p++) place[p + 1] += place[p];
  std::vector<FaceEntry> entries(place[points]);
  eachFace(cells, [&](FaceId id, const FaceKey& key) {
    if (key.lowest != kNoPoint)
      entries[place[key.lowest]++] = {uint64_t(key.opposite) << 32 | key.beside, key.otherAndWay, id};
  });

  // Each place is now where the next point's entries begin.
  size_t from = 0;
  for (size_t p = 0; p < points; p++) {
    const size_t to = place[p];
    std::sort(entries.begin() + int64_t(from), entries.begin() + int64_t(to));
    while (from < to) {
      const FaceEntry& one = entries[from];
      size_t end = from + 1;
      while (end < to && entries[end].isOneWith(one)) end++;
      if (end - from == 2) {
        const FaceEntry& other = entries[from + 1];
        neighbour(one.id) = other.id;
        neighbour(other.id) = one.id;
        found.sameSide += one.otherAndWay == other.otherAndWay;
      } else {
        if (end - from > 2) {
          found.crowded++;
          found.crowdedAt.push_back(uint32_t(p));
        }
        for (; from < end; from++) found.shell.push_back(entries[from].id);
      }
      from = end;
    }
  }
  std::sort(found.shell.begin(), found.shell.end());
  for (const CellType type : kAllCellTypes) {
    const int faces = shapeOf(type).faces;
    const std::vector<FaceId>& neighbours = found.neighbours[size_t(type)];
    for (auto cell = neighbours.begin(); cell != neighbours.end(); cell += faces)
      found.twins += *cell != kNoFace && std::all_of(cell, cell + faces, [&](FaceId other) {
        return other != kNoFace && cellOf(other) == cellOf(*cell);
      });
  }
  return found;
}

}  // namespace gxy
