// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/volume_room.h"

#include <algorithm>
#include <limits>
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

bool hasFieldsOfCells(const insitu::Mesh& mesh) {
  return std::any_of(mesh.fields.begin(), mesh.fields.end(),
                     [&](const insitu::Field& f) { return f.ofCells && !isGhosts(mesh, f); });
}

size_t countOf(const std::array<std::vector<VolumeLayout::Place>, kCellTypes>& cells) {
  size_t count = 0;
  for (const auto& ofType : cells) count += ofType.size();
  return count;
}

int64_t bytesOfValues(const insitu::Field& field, const VolumeLayout& layout) {
  const size_t count = field.ofCells ? countOf(layout.cells) : layout.points.size();
  return int64_t(count * size_t(field.components) * sizeof(double));
}

std::optional<size_t> ghostsOf(const SentArrays& sent, bool ofCells) {
  const std::vector<insitu::Field>& fields = sent.mesh().fields;
  for (size_t f = 0; f < fields.size(); f++)
    if (fields[f].ofCells == ofCells && isGhosts(sent.mesh(), fields[f])) return sent.arrayOf(f);
  return std::nullopt;
}

}  // namespace

VolumeRoom::VolumeRoom(const insitu::Mesh& mesh, const Partitioning& partitioning, TakeStepMemory take,
                       KeptVolume& kept)
    : sent_(mesh, std::move(take), 0),
      hasCellFields_(hasFieldsOfCells(mesh)),
      ghostCells_(ghostsOf(sent_, true)),
      ghostPoints_(ghostsOf(sent_, false)),
      partitioning_(partitioning),
      kept_(kept) {}

// Of points, cells and what marks ghosts of these, but not of values.
std::array<uint64_t, 2> VolumeRoom::content() const {
  ContentHash hash;
  for (const SentArrays::Source& source : sent_.sources())
    for (size_t a = 0; a < source.arrays.size(); a++)
      if (sent_.arrays()[a].what != insitu::Array::What::Field || a == ghostCells_)
        hash.add(std::span<const std::byte>(source.arrays[a]));
  return hash.value();
}

// Throws Error if there are more points than a mesh may have.
int64_t VolumeRoom::bytesToMake() const {
  uint64_t points = 0, corners = 0, placed = 0;
  for (const SentArrays::Source& source : sent_.sources()) {
    const insitu::Cells cells = cellsOf(sent_, source);
    points += source.points();
    corners += cells.connectivity.size();
    placed += hasCellFields_ ? cells.count() : 0;
  }
  if (points >= kMostMeshPoints)
    throw Error("cells \"" + sent_.mesh().name + "\": one rank would hold a mesh of " +
                std::to_string(points) + " points, expected fewer than 2^30; use more ranks");
  return int64_t(
      points * (sizeof(glm::dvec3) + sizeof(uint64_t) + sizeof(VolumeLayout::Place) + sizeof(uint32_t)) +
      corners * sizeof(uint32_t) + placed * (sizeof(VolumeLayout::Place) + 1));
}

MeshPiece VolumeRoom::make(const std::map<int, uint64_t>& firsts, VolumeLayout& layout) const {
  constexpr uint32_t kNone = UINT32_MAX;
  MeshPiece piece;
  piece.ofCells = hasCellFields_;
  for (size_t r = 0; r < sent_.sources().size(); r++) {
    const SentArrays::Source& source = sent_.sources()[r];
    const insitu::Cells cells = cellsOf(sent_, source);
    std::vector<uint32_t> numberOf(source.points(), kNone);
    const auto pointOf = [&](uint32_t index) {
      if (numberOf[index] == kNone) {
        numberOf[index] = uint32_t(layout.points.size());
        piece.points.push_back(sent_.position(source, index));
        piece.numbers.push_back(firsts.at(int(r)) + index);
        layout.points.push_back({uint32_t(r), index});
      }
      return numberOf[index];
    };
    for (size_t c = 0; c < cells.count(); c++) {
      const auto ghost = ghostCells_ ? valueAt<uint8_t>(source.data(*ghostCells_), c) : uint8_t(0);
      layout.ghostCells += isGhostCell(ghost);
      if (isGhostCell(ghost) && !(hasCellFields_ && isDuplicateOnly(ghost))) continue;
      const CellType type = *meshCellOf(cells.types[c]);
      const std::span<const uint32_t> corners = cells.corners(c);
      for (size_t i = 0; i < corners.size(); i++)
        piece.cells.points[size_t(type)].push_back(pointOf(corners[placeInFile(cells.types[c], i)]));
      if (!hasCellFields_) continue;
      piece.duplicates[size_t(type)].push_back(isGhostCell(ghost));
      layout.cells[size_t(type)].push_back({uint32_t(r), uint32_t(c)});
    }
  }
  return piece;
}

bool VolumeRoom::isHidden(const VolumeLayout::Place& point) const {
  if (!ghostPoints_) return false;
  return (valueAt<uint8_t>(sent_.sources()[point.rank].data(*ghostPoints_), point.index) & kHiddenPoint) != 0;
}

bool VolumeRoom::hasHiddenPoint(const VolumeLayout::Place& cell) const {
  if (!ghostPoints_) return false;
  const std::span<const uint32_t> corners = cellsOf(sent_, sent_.sources()[cell.rank]).corners(cell.index);
  return std::any_of(corners.begin(), corners.end(), [&](uint32_t point) {
    return isHidden({cell.rank, point});
  });
}

// As files have them: the components of a point or cell together, as doubles; those that are hidden, or have a hidden point, have no data.
std::vector<double> VolumeRoom::valuesOf(size_t field, const VolumeLayout& layout) const {
  const insitu::Field& f = sent_.mesh().fields[field];
  const size_t array = sent_.arrayOf(field);
  const auto components = size_t(f.components);
  std::vector<double> values;
  values.reserve((f.ofCells ? countOf(layout.cells) : layout.points.size()) * components);
  const auto append = [&](const std::vector<VolumeLayout::Place>& places) {
    withType(f.type, [&](auto type) {
      using T = decltype(type);
      for (const VolumeLayout::Place& place : places) {
        const bool isData = !(f.ofCells ? hasHiddenPoint(place) : isHidden(place));
        const std::byte* const own = sent_.sources()[place.rank].data(array);
        for (size_t c = 0; c < components; c++)
          values.push_back(isData ? double(valueAt<T>(own, place.index * components + c))
                                  : std::numeric_limits<double>::quiet_NaN());
      }
    });
  };
  if (f.ofCells)
    for (const auto& ofType : layout.cells) append(ofType);
  else
    append(layout.points);
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
  mesh.report.ghostCells = layout.ghostCells;
  d->bytes = bytesOf(mesh);
  d->memory = sent_.take(bytesOfValues(mesh));
  d->sharedMemory = layout.memory;
  d->mesh = std::make_shared<const Mesh>(std::move(mesh));
  return d;
}

// Makes the blocks, too. The places are known.
std::shared_ptr<Dataset> VolumeRoom::firstDataset(size_t field, VolumeLayout& layout,
                                                  Collectives& ranks) const {
  const insitu::Field& f = sent_.mesh().fields[field];
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
    piece = make(firsts, layout);
    piece.components = f.components;
    toTake(bytesOfValues(f, layout));
    values = valuesOf(field, layout);
  });
  layout.ghostCells = sumOfCounts(ranks, layout.ghostCells);
  EncodedMesh encoded = encodedMesh(std::move(piece), f.type, std::move(values), ranks, toTake);
  agree(ranks, [&] { checkInside(encoded.box); });
  Mesh mesh = completeMesh(std::move(encoded), partitioning_, ranks, toTake, &layout.mesh);
  std::shared_ptr<Dataset> made;
  agree(ranks, [&] {
    onTheWay.clear();
    layout.memory = std::make_shared<const LedgerEntry>(sent_.take(bytesOf(layout.mesh)));
    layout.ownMemory =
        sent_.take(bytesOf(layout.mesh.routes) +
                   int64_t((layout.points.size() + countOf(layout.cells)) * sizeof(VolumeLayout::Place) +
                           layout.mesh.pointsOfDuplicates.size() + layout.mesh.duplicates.size()));
    made = datasetOf(field, std::move(mesh), layout);
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
    toTake(bytesOfValues(f, layout));
    values = valuesOf(field, layout);
  });
  EncodedValues encoded =
      encodedValues(f.type, f.components, f.ofCells, values,
                    f.ofCells ? layout.mesh.duplicates : layout.mesh.pointsOfDuplicates, ranks, toTake);
  values = {};
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
  const insitu::Mesh& mesh = sent_.mesh();
  const std::vector<insitu::Publishes> all = datasetsOf(std::span(&mesh, 1));
  std::vector<std::shared_ptr<Dataset>> datasets(all.size());
  if (!areAllKept) {
    const auto made = std::make_shared<VolumeLayout>();
    made->content = sent;
    // With a field of cells come duplicates, too, that fields of points have no use for.
    const auto first = std::find_if(all.begin(), all.end(), [&](const insitu::Publishes& one) {
      return mesh.fields[*one.field].ofCells == hasCellFields_;
    });
    datasets[size_t(first - all.begin())] = firstDataset(*first->field, *made, ranks);
    layout = made;
  }
  for (size_t i = 0; i < all.size(); i++)
    if (!datasets[i]) datasets[i] = dataset(*all[i].field, *layout, ranks);
  sent_.clear();
  if (areAllKept)
    kept_.countUse();
  else
    kept_.keep(std::move(layout));
  return datasets;
}

}  // namespace gxy
