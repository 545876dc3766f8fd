// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/cells_room.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <utility>

#include "core/comm/error.h"
#include "core/io/import_geometry.h"

namespace gxy {

CellsRoom::CellsRoom(const insitu::Mesh& mesh, TakeStepMemory take)
    : sent_(mesh, std::move(take), 0),
      kind_(mesh.shape == insitu::Mesh::Shape::Lines ? GeometryKind::PathLines : GeometryKind::Triangles) {}

// By rank of the simulation.
std::vector<uint64_t> CellsRoom::checkedPrimitives() const {
  checkCells(sent_);
  std::vector<uint64_t> primitives;
  for (const SentArrays::Source& source : sent_.sources())
    primitives.push_back(insitu::primitivesOf(cellsOf(sent_, source)));
  return primitives;
}

// Of all datasets. Throws Error if their points cannot be numbered with 32 bits.
int64_t CellsRoom::bytesToMake(uint64_t primitives) const {
  const insitu::Mesh& mesh = sent_.mesh();
  uint64_t points = 0, bytes = 0;
  for (const SentArrays::Source& source : sent_.sources()) points += source.points();
  const bool isLines = kind_ == GeometryKind::PathLines;
  const uint64_t each =
      sizeof(uint64_t) + (isLines ? 2 * sizeof(std::array<uint32_t, 2>) : sizeof(std::array<uint32_t, 3>));
  for (const insitu::Publishes& dataset : datasetsOf(std::span(&mesh, 1))) {
    const bool ofCells = dataset.field && mesh.fields[*dataset.field].ofCells;
    const uint64_t most = points + (ofCells ? primitives * (isLines ? 4 : 3) : 0);
    if (most > insitu::kMostParticles)
      throw Error("cells \"" + mesh.name +
                  "\": one rank would hold more than 2^32 - 2 points; use more ranks");
    bytes += most * (sizeof(glm::dvec3) + 2 * sizeof(glm::vec3)) + primitives * each;
  }
  return int64_t(bytes);
}

CellsRoom::Made CellsRoom::make(const std::map<int, uint64_t>& firstIds) const {
  const bool hasCellFields = std::any_of(sent_.mesh().fields.begin(), sent_.mesh().fields.end(),
                                         [](const insitu::Field& f) { return f.ofCells; });
  Made made;
  GeometryBlock& block = made.block;
  std::vector<uint32_t> corners;
  int64_t cell = 0;
  for (size_t r = 0; r < sent_.sources().size(); r++) {
    const SentArrays::Source& source = sent_.sources()[r];
    const insitu::Cells cells = cellsOf(sent_, source);
    const auto shift = uint32_t(block.points.size());
    for (size_t i = 0; i < source.points(); i++) block.points.push_back(sent_.position(source, i));
    for (size_t c = 0; c < cells.count(); c++, cell++) {
      corners.clear();
      for (const uint32_t point : cells.corners(c)) corners.push_back(point + shift);
      if (kind_ == GeometryKind::PathLines)
        appendLine(corners, block);
      else if (corners.size() > 2)
        appendTriangles(DrawnCellType(cells.types[c]), corners, block);
      if (hasCellFields)
        made.cells.resize(kind_ == GeometryKind::PathLines ? block.segments.size() : block.triangles.size(),
                          cell);
    }
    const size_t before = block.ids.size(), primitives = kind_ == GeometryKind::PathLines
                                                             ? block.segments.size()
                                                             : block.triangles.size();
    block.ids.resize(primitives);
    if (primitives > before)
      std::iota(block.ids.begin() + ptrdiff_t(before), block.ids.end(), firstIds.at(int(r)));
  }
  return made;
}

// Appends unit normals, if the mesh has them. False if one has no direction.
bool CellsRoom::addNormals(GeometryBlock& block) const {
  const insitu::Mesh& mesh = sent_.mesh();
  const auto field = std::find_if(mesh.fields.begin(), mesh.fields.end(),
                                  [&](const insitu::Field& f) { return isNormals(mesh, f); });
  if (field == mesh.fields.end()) return true;
  const size_t array = sent_.arrayOf(size_t(field - mesh.fields.begin()));
  bool haveDirections = true;
  withType(field->type, [&](auto type) {
    using T = decltype(type);
    for (const SentArrays::Source& source : sent_.sources())
      for (size_t i = 0; i < source.points(); i++) {
        glm::dvec3 n;
        for (int c = 0; c < 3; c++) n[c] = double(valueAt<T>(source.data(array), 3 * i + size_t(c)));
        const double length = glm::length(n);
        haveDirections = haveDirections && length > 0 && std::isfinite(length);
        block.normals.push_back(glm::vec3(n / length));
      }
  });
  return haveDirections;
}

void CellsRoom::giveLook(Made& made, size_t field) const {
  const insitu::Field& f = sent_.mesh().fields[field];
  const LookOf look(f);
  const size_t array = sent_.arrayOf(field);
  GeometryBlock looks;  // of all points, or all cells
  for (const SentArrays::Source& source : sent_.sources())
    for (size_t i = 0; !source.counts.empty() && i < source.counts[array]; i++)
      look.append(source.data(array), i, f.ofCells ? looks : made.block);
  if (!f.ofCells) return;
  splitByCell(made.block, kind_, made.cells, [&](GeometryBlock& split, int64_t cell) {
    if (look.colored())
      split.colors.push_back(looks.colors[size_t(cell)]);
    else
      split.values.push_back(looks.values[size_t(cell)]);
  });
}

OwnedGeometry CellsRoom::geometryOf(Made made, const insitu::Publishes& dataset, Collectives& ranks) const {
  LoadedGeometry loaded;
  OwnedGeometry& geometry = loaded.geometry;
  geometry.kind = kind_;
  int64_t dropped = 0;
  uint64_t colors = 0;
  agree(ranks, [&] {
    if (dataset.field) giveLook(made, *dataset.field);
    colors = made.block.colors.size();
    dropped = dropUnusable(made.block, kind_);
    geometry.block = std::move(made.block);
  });
  geometry.colored = sumOfCounts(ranks, colors) > 0;
  geometry.primitives = sumOfCounts(ranks, geometry.block.ids.size());
  geometry.droppedPrimitives = sumOfCounts(ranks, uint64_t(dropped));
  measureGeometry(loaded, ranks);
  return std::move(loaded.geometry);
}

std::vector<std::shared_ptr<Dataset>> CellsRoom::complete(Collectives& ranks) {
  const insitu::Mesh& mesh = sent_.mesh();
  const std::vector<insitu::Publishes> all = datasetsOf(std::span(&mesh, 1));
  std::vector<uint64_t> primitives;
  LedgerEntry memory;
  agree(ranks, [&] {
    primitives = checkedPrimitives();
    memory = sent_.take(bytesToMake(std::accumulate(primitives.begin(), primitives.end(), uint64_t(0))));
  });
  const std::map<int, uint64_t> firstIds = firstNumbers(ranks, primitives);
  Made made;
  bool haveDirections = true;
  agree(ranks, [&] {
    made = make(firstIds);
    haveDirections = addNormals(made.block);
  });
  if (sumOfCounts(ranks, !haveDirections) > 0) made.block.normals.clear();  // as of files

  std::vector<OwnedGeometry> geometries;
  for (size_t i = 0; i < all.size(); i++) {
    Made own;
    agree(ranks, [&] { own = i + 1 < all.size() ? made : std::move(made); });
    geometries.push_back(geometryOf(std::move(own), all[i], ranks));
  }
  std::vector<std::shared_ptr<Dataset>> datasets;
  agree(ranks, [&] {
    memory.resize(0);
    for (size_t i = 0; i < all.size(); i++)
      datasets.push_back(datasetOf(mesh, all[i].field ? &mesh.fields[*all[i].field] : nullptr,
                                   std::move(geometries[i]), memory));
    sent_.clear();
  });
  return datasets;
}

}  // namespace gxy
