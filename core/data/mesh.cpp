// SPDX-License-Identifier: Apache-2.0
#include "core/data/mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gxy {

namespace {

constexpr std::array<CellShape, kCellTypes> kShapes{{
    {4, 4, {{{3, {1, 2, 3}}, {3, {2, 0, 3}}, {3, {0, 1, 3}}, {3, {0, 2, 1}}}}},
    {5, 5, {{{4, {0, 3, 2, 1}}, {3, {0, 1, 4}}, {3, {1, 2, 4}}, {3, {2, 3, 4}}, {3, {3, 0, 4}}}}},
    {6, 5, {{{3, {0, 1, 2}}, {3, {3, 5, 4}}, {4, {0, 3, 4, 1}}, {4, {1, 4, 5, 2}}, {4, {2, 5, 3, 0}}}}},
    {8,
     6,
     {{{4, {0, 4, 7, 3}},
       {4, {1, 2, 6, 5}},
       {4, {0, 1, 5, 4}},
       {4, {3, 7, 6, 2}},
       {4, {0, 3, 2, 1}},
       {4, {4, 5, 6, 7}}}}},
}};

}  // namespace

const CellShape& shapeOf(CellType type) { return kShapes[size_t(type)]; }

const char* pluralOf(CellType type) {
  constexpr std::array<const char*, kCellTypes> kPlurals{"tetrahedra", "pyramids", "wedges", "hexahedra"};
  return kPlurals[size_t(type)];
}

template <class Numbers>
size_t CellsByType<Numbers>::size() const {
  size_t all = 0;
  for (const CellType type : kAllCellTypes) all += size(type);
  return all;
}

template <class Numbers>
uint32_t CellsByType<Numbers>::first(CellType type) const {
  size_t before = 0;
  for (const CellType t : kAllCellTypes)
    if (t < type) before += size(t);
  return uint32_t(before);
}

template <class Numbers>
CellType CellsByType<Numbers>::typeOf(uint32_t cell) const {
  size_t before = 0;
  for (const CellType type : kAllCellTypes)
    if (cell < (before += size(type))) return type;
  return CellType::Hexahedron;
}

template <class Numbers>
std::span<const uint32_t> CellsByType<Numbers>::pointsOf(uint32_t cell) const {
  const CellType type = typeOf(cell);
  const size_t n = shapeOf(type).points;
  return std::span(points[size_t(type)]).subspan((cell - first(type)) * n, n);
}

template struct CellsByType<std::vector<uint32_t>>;
template struct CellsByType<SharedVector<uint32_t>>;
template struct CellsByType<std::span<const uint32_t>>;

bool hasOnlyTetrahedra(const Mesh& mesh) {
  const auto& cells = mesh.report.cells;
  return std::all_of(cells.begin() + 1, cells.end(), [](uint64_t count) { return count == 0; });
}

double typicalLength(const Mesh& mesh) {
  if (mesh.box.empty()) return 1;
  const auto cells =
      std::max(uint64_t(1), std::accumulate(mesh.report.cells.begin(), mesh.report.cells.end(), uint64_t(0)));
  const glm::dvec3 size = mesh.box.hi - mesh.box.lo;
  const double longest = std::max({size.x, size.y, size.z});
  if (!(longest > 0)) return 1;
  // Relative to the longest side, so that scaling by a power of two is exact and nothing overflows.
  const glm::dvec3 sides = size / longest;
  const double volume = sides.x * sides.y * sides.z;
  return longest * std::cbrt((volume > 0 ? volume : 1) / double(cells));
}

int64_t bytesOfValues(const Mesh& mesh) {
  size_t bytes = 0;
  for (const auto& [partition, block] : mesh.blocks)
    bytes += (block.values.size() + block.cellValues.size()) * sizeof(float);
  return int64_t(bytes);
}

std::vector<float> shownValues(const std::vector<float>& values, int components,
                               std::optional<int> component) {
  if (components == 1) return values;
  const auto each = size_t(components);
  std::vector<float> shown(values.size() / each);
  for (size_t i = 0; i < shown.size(); i++) {
    const float* of = values.data() + i * each;
    float squares = 0;
    for (size_t c = 0; c < each; c++) squares += of[c] * of[c];
    shown[i] = component ? of[size_t(*component)] : std::sqrt(squares);
  }
  return shown;
}

int64_t bytesOf(const Mesh& mesh) {
  size_t bytes = 0;
  for (const auto& [partition, block] : mesh.blocks) {
    bytes += block.points.size() * sizeof(glm::dvec3) + block.shell.size() * sizeof(FaceId);
    for (const CellType type : kAllCellTypes)
      bytes += block.cells.points[size_t(type)].size() * sizeof(uint32_t) +
               block.neighbours[size_t(type)].size() * sizeof(FaceId);
  }
  return int64_t(bytes) + bytesOfValues(mesh);
}

}  // namespace gxy
