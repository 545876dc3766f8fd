// SPDX-License-Identifier: Apache-2.0
#include "core/data/collapsed.h"

#include <algorithm>

namespace gxy {

namespace {

using Hexahedron = std::array<uint32_t, 8>;

/// The points in the order that they have when the hexahedron lies on one of its faces, turned by quarters.
Hexahedron turned(std::span<const uint32_t, 8> points, size_t face, size_t quarters) {
  constexpr std::array<size_t, 3> kAcross{
      1, 3, 4};  // the other end of an edge: its bits that differ, by the direction
  const CellFace& below = shapeOf(CellType::Hexahedron).face[face];
  Hexahedron p{};
  for (size_t i = 0; i < 4; i++) {
    const size_t corner =
        below.corner[(quarters + 4 - i) % 4];  // faces run the other way around, seen from inside
    p[i] = points[corner];
    p[i + 4] = points[corner ^ kAcross[face / 2]];
  }
  return p;
}

std::optional<CollapsedCell> asItLies(const Hexahedron& p, size_t distinct) {
  const bool isPointAbove = p[4] == p[5] && p[5] == p[6] && p[6] == p[7];
  if (distinct == 6 && p[2] == p[3] && p[6] == p[7])
    return CollapsedCell{CellType::Wedge, {p[0], p[2], p[1], p[4], p[6], p[5]}};
  if (distinct == 5 && isPointAbove) return CollapsedCell{CellType::Pyramid, {p[0], p[1], p[2], p[3], p[4]}};
  if (distinct == 4 && isPointAbove && p[2] == p[3])
    return CollapsedCell{CellType::Tetrahedron, {p[0], p[1], p[2], p[4]}};
  return {};
}

}  // namespace

std::optional<CollapsedCell> collapsed(std::span<const uint32_t, 8> hexahedron) {
  Hexahedron ascending{};
  std::copy(hexahedron.begin(), hexahedron.end(), ascending.begin());
  std::sort(ascending.begin(), ascending.end());
  const auto distinct = size_t(std::unique(ascending.begin(), ascending.end()) - ascending.begin());
  if (distinct == 8) return {};
  for (size_t face = 0; face < 6; face++)
    for (size_t quarters = 0; quarters < 4; quarters++)
      if (const auto cell = asItLies(turned(hexahedron, face, quarters), distinct)) return cell;
  return {};
}

}  // namespace gxy
