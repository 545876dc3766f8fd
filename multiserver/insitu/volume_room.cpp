// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/volume_room.h"

#include <string>
#include <utility>

#include "core/comm/error.h"
#include "core/data/mesh_kinds.h"

namespace gxy {

namespace {

std::string textOf(const Box& box) {
  const auto corner = [](const glm::dvec3& p) {
    return "(" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " + std::to_string(p.z) + ")";
  };
  return corner(box.lo) + " to " + corner(box.hi);
}

}  // namespace

VolumeRoom::VolumeRoom(const insitu::Mesh& mesh, const Partitioning& partitioning, TakeStepMemory take)
    : sent_(mesh, std::move(take), 0), partitioning_(partitioning) {}

// Throws Error if there are more points than a mesh may have.
int64_t VolumeRoom::bytesToMake() const {
  uint64_t points = 0, corners = 0;
  for (const SentArrays::Source& source : sent_.sources()) {
    points += source.points();
    corners += cellsOf(sent_, source).connectivity.size();
  }
  if (points >= kMostMeshPoints)
    throw Error("cells \"" + sent_.mesh().name + "\": one rank would hold a mesh of " +
                std::to_string(points) + " points, expected fewer than 2^30; use more ranks");
  return int64_t(points * (sizeof(glm::dvec3) + sizeof(uint64_t) + sizeof(Made::Place) + sizeof(uint32_t)) +
                 corners * sizeof(uint32_t));
}

VolumeRoom::Made VolumeRoom::make(const std::map<int, uint64_t>& firsts) const {
  constexpr uint32_t kNone = UINT32_MAX;
  Made made;
  for (size_t r = 0; r < sent_.sources().size(); r++) {
    const SentArrays::Source& source = sent_.sources()[r];
    const insitu::Cells cells = cellsOf(sent_, source);
    std::vector<uint32_t> numberOf(source.points(), kNone);
    const auto pointOf = [&](uint32_t index) {
      if (numberOf[index] == kNone) {
        numberOf[index] = uint32_t(made.places.size());
        made.piece.points.push_back(sent_.position(source, index));
        made.piece.numbers.push_back(firsts.at(int(r)) + index);
        made.places.push_back({uint32_t(r), index});
      }
      return numberOf[index];
    };
    for (size_t c = 0; c < cells.count(); c++) {
      const CellType type = *meshCellOf(cells.types[c]);
      const std::span<const uint32_t> corners = cells.corners(c);
      for (size_t i = 0; i < corners.size(); i++)
        made.piece.cells.points[size_t(type)].push_back(pointOf(corners[placeInFile(cells.types[c], i)]));
    }
  }
  return made;
}

// As files have them: a point's components together, as doubles.
std::vector<double> VolumeRoom::valuesOf(const insitu::Field& field, size_t array, const Made& made) const {
  const auto components = size_t(field.components);
  std::vector<double> values;
  values.reserve(made.places.size() * components);
  withType(field.type, [&](auto type) {
    using T = decltype(type);
    for (const Made::Place& place : made.places)
      for (size_t c = 0; c < components; c++)
        values.push_back(
            double(valueAt<T>(sent_.sources()[place.rank].data(array), place.index * components + c)));
  });
  return values;
}

// Rays do not go on outside of the domain.
void VolumeRoom::checkInside(const Box& box) const {
  const Box& domain = partitioning_.domain();
  for (int a = 0; a < 3; a++)
    if (!box.empty() && (box.lo[a] < domain.lo[a] || box.hi[a] > domain.hi[a]))
      throw Error(
          "cells \"" + sent_.mesh().name + "\": they fill " + textOf(box) +
          ", expected them inside the stream's domain, which is " + textOf(domain) +
          " (that of the first step's points, a tenth larger, unless there is a grid or another partition)");
}

std::shared_ptr<Dataset> VolumeRoom::datasetOf(size_t field, MeshPiece piece, const Made& made,
                                               Collectives& ranks) const {
  const insitu::Field& f = sent_.mesh().fields[field];
  std::vector<LedgerEntry> onTheWay;
  const auto toTake = [&](int64_t bytes) { onTheWay.push_back(sent_.take(bytes)); };
  std::vector<double> values;
  agree(ranks, [&] {
    toTake(int64_t(made.places.size() * size_t(f.components) * sizeof(double)) + bytesOf(piece));
    values = valuesOf(f, sent_.arrayOf(field), made);
    piece.components = f.components;
  });
  EncodedMesh encoded = encodedMesh(std::move(piece), f.type, std::move(values), ranks, toTake);
  agree(ranks, [&] { checkInside(encoded.box); });
  auto mesh = std::make_shared<Mesh>(completeMesh(std::move(encoded), partitioning_, ranks, toTake));
  mesh->name = f.name;
  auto d = std::make_shared<Dataset>();
  agree(ranks, [&] {
    d->array = f.name;
    d->bytes = bytesOf(*mesh);
    onTheWay.clear();
    d->memory = sent_.take(d->bytes);
    d->mesh = std::move(mesh);
  });
  return d;
}

std::vector<std::shared_ptr<Dataset>> VolumeRoom::complete(Collectives& ranks) {
  std::vector<uint64_t> points;
  LedgerEntry memory;
  agree(ranks, [&] {
    checkCells(sent_);
    memory = sent_.take(bytesToMake());
    for (const SentArrays::Source& source : sent_.sources()) points.push_back(source.points());
  });
  const std::map<int, uint64_t> firsts = firstNumbers(ranks, points);
  Made made;
  agree(ranks, [&] { made = make(firsts); });
  std::vector<std::shared_ptr<Dataset>> datasets;
  for (size_t f = 0; f < sent_.mesh().fields.size(); f++) {
    MeshPiece piece;
    agree(ranks, [&] { piece = made.piece; });
    datasets.push_back(datasetOf(f, std::move(piece), made, ranks));
  }
  sent_.clear();
  return datasets;
}

}  // namespace gxy
