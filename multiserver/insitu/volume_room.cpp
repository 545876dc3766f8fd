// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/volume_room.h"

#include <string>
#include <utility>

#include "core/comm/error.h"
#include "core/data/mesh_kinds.h"
#include "multiserver/insitu/content_hash.h"

namespace gxy {

namespace {

std::string textOf(const Box& box) {
  const auto corner = [](const glm::dvec3& p) {
    return "(" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " + std::to_string(p.z) + ")";
  };
  return corner(box.lo) + " to " + corner(box.hi);
}

}  // namespace

VolumeRoom::VolumeRoom(const insitu::Mesh& mesh, const Partitioning& partitioning, TakeStepMemory take,
                       KeptVolume& kept)
    : sent_(mesh, std::move(take), 0), partitioning_(partitioning), kept_(kept) {}

// Of points and cells, but not of values.
std::array<uint64_t, 2> VolumeRoom::content() const {
  ContentHash hash;
  for (const SentArrays::Source& source : sent_.sources())
    for (size_t a = 0; a < source.arrays.size(); a++)
      if (sent_.arrays()[a].what != insitu::Array::What::Field)
        hash.add(std::span<const std::byte>(source.arrays[a]));
  return hash.value();
}

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
  return int64_t(
      points * (sizeof(glm::dvec3) + sizeof(uint64_t) + sizeof(VolumeLayout::Place) + sizeof(uint32_t)) +
      corners * sizeof(uint32_t));
}

MeshPiece VolumeRoom::make(const std::map<int, uint64_t>& firsts,
                           std::vector<VolumeLayout::Place>& places) const {
  constexpr uint32_t kNone = UINT32_MAX;
  MeshPiece piece;
  for (size_t r = 0; r < sent_.sources().size(); r++) {
    const SentArrays::Source& source = sent_.sources()[r];
    const insitu::Cells cells = cellsOf(sent_, source);
    std::vector<uint32_t> numberOf(source.points(), kNone);
    const auto pointOf = [&](uint32_t index) {
      if (numberOf[index] == kNone) {
        numberOf[index] = uint32_t(places.size());
        piece.points.push_back(sent_.position(source, index));
        piece.numbers.push_back(firsts.at(int(r)) + index);
        places.push_back({uint32_t(r), index});
      }
      return numberOf[index];
    };
    for (size_t c = 0; c < cells.count(); c++) {
      const CellType type = *meshCellOf(cells.types[c]);
      const std::span<const uint32_t> corners = cells.corners(c);
      for (size_t i = 0; i < corners.size(); i++)
        piece.cells.points[size_t(type)].push_back(pointOf(corners[placeInFile(cells.types[c], i)]));
    }
  }
  return piece;
}

// As files have them: a point's components together, as doubles.
std::vector<double> VolumeRoom::valuesOf(size_t field, const VolumeLayout& layout) const {
  const insitu::Field& f = sent_.mesh().fields[field];
  const size_t array = sent_.arrayOf(field);
  const auto components = size_t(f.components);
  std::vector<double> values;
  values.reserve(layout.places.size() * components);
  withType(f.type, [&](auto type) {
    using T = decltype(type);
    for (const VolumeLayout::Place& place : layout.places)
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

std::shared_ptr<Dataset> VolumeRoom::datasetOf(size_t field, Mesh mesh, const VolumeLayout& layout) const {
  auto d = std::make_shared<Dataset>();
  d->array = mesh.name = sent_.mesh().fields[field].name;
  d->bytes = bytesOf(mesh);
  d->memory = sent_.take(bytesOfValues(mesh));
  d->sharedMemory = layout.memory;
  d->mesh = std::make_shared<const Mesh>(std::move(mesh));
  return d;
}

// Makes the blocks, too. The places are known.
std::shared_ptr<Dataset> VolumeRoom::firstDataset(VolumeLayout& layout, Collectives& ranks) const {
  const insitu::Field& f = sent_.mesh().fields[0];
  std::vector<uint64_t> points;
  std::vector<LedgerEntry> onTheWay;
  const ToTake toTake = [&](int64_t bytes) { onTheWay.push_back(sent_.take(bytes)); };
  agree(ranks, [&] {
    checkCells(sent_);
    toTake(bytesToMake());
    for (const SentArrays::Source& source : sent_.sources()) points.push_back(source.points());
  });
  const std::map<int, uint64_t> firsts = firstNumbers(ranks, points);
  MeshPiece piece;
  std::vector<double> values;
  agree(ranks, [&] {
    piece = make(firsts, layout.places);
    piece.components = f.components;
    toTake(int64_t(layout.places.size() * size_t(f.components) * sizeof(double)));
    values = valuesOf(0, layout);
  });
  EncodedMesh encoded = encodedMesh(std::move(piece), f.type, std::move(values), ranks, toTake);
  agree(ranks, [&] { checkInside(encoded.box); });
  Mesh mesh = completeMesh(std::move(encoded), partitioning_, ranks, toTake, &layout.mesh);
  std::shared_ptr<Dataset> made;
  agree(ranks, [&] {
    onTheWay.clear();
    layout.memory = std::make_shared<const LedgerEntry>(sent_.take(bytesOf(layout.mesh)));
    layout.ownMemory =
        sent_.take(bytesOf(layout.mesh.routes) + int64_t(layout.places.size() * sizeof(VolumeLayout::Place)));
    made = datasetOf(0, std::move(mesh), layout);
  });
  return made;
}

// Only the values are made.
std::shared_ptr<Dataset> VolumeRoom::dataset(size_t field, const VolumeLayout& layout,
                                             Collectives& ranks) const {
  const insitu::Field& f = sent_.mesh().fields[field];
  std::vector<LedgerEntry> onTheWay;
  const ToTake toTake = [&](int64_t bytes) { onTheWay.push_back(sent_.take(bytes)); };
  std::vector<double> values;
  agree(ranks, [&] {
    toTake(int64_t(layout.places.size() * size_t(f.components) * sizeof(double)));
    values = valuesOf(field, layout);
  });
  EncodedValues encoded = encodedValues(f.type, f.components, std::move(values), ranks, toTake);
  Mesh mesh = completeMesh(std::move(encoded), layout.mesh, partitioning_, ranks, toTake);
  std::shared_ptr<Dataset> made;
  agree(ranks, [&] {
    onTheWay.clear();
    made = datasetOf(field, std::move(mesh), layout);
  });
  return made;
}

std::vector<std::shared_ptr<Dataset>> VolumeRoom::complete(Collectives& ranks) {
  const std::array<uint64_t, 2> sent = content();
  std::shared_ptr<const VolumeLayout> layout = kept_.layout();
  const bool isKept = layout && layout->content == sent;
  const bool areAllKept = sumOfCounts(ranks, isKept) == uint64_t(ranks.size());
  std::vector<std::shared_ptr<Dataset>> datasets;
  if (!areAllKept) {
    const auto made = std::make_shared<VolumeLayout>();
    made->content = sent;
    datasets.push_back(firstDataset(*made, ranks));
    layout = made;
  }
  for (size_t f = datasets.size(); f < sent_.mesh().fields.size(); f++)
    datasets.push_back(dataset(f, *layout, ranks));
  sent_.clear();
  if (areAllKept)
    kept_.countUse();
  else
    kept_.keep(std::move(layout));
  return datasets;
}

}  // namespace gxy
