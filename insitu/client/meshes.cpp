// SPDX-License-Identifier: Apache-2.0
#include "insitu/client/meshes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/comm/error.h"
#include "insitu/client/snapshot.h"

namespace gxy::insitu {

namespace {

std::string sizeText(const Index3& i) {
  return std::to_string(i[0]) + " x " + std::to_string(i[1]) + " x " + std::to_string(i[2]);
}

// `what` names the array in errors.
void checkArray(const std::string& what, const gxy_array& a, const Extent& owned) {
  const auto fail = [&](const std::string& why) { throw Error(what + ": " + why); };
  if (a.memory != 0) fail("memory " + std::to_string(a.memory) + ", expected 0, the memory of the host");
  if (a.type < 0 || a.type > GXY_FLOAT64)
    fail("type " + std::to_string(a.type) + ", expected one of gxy_type, 0 to 9");
  if (a.components < 1 || a.components > kMostComponents)
    fail(std::to_string(a.components) + " components, expected 1 to " + std::to_string(kMostComponents));
  if (owned.count() == 0) return;
  if (!a.data) fail("there are no data, expected a pointer to the first owned value");
  for (size_t axis = 0; axis < 3; axis++)
    if (a.stride[axis] == 0 && owned.points[axis] > 1)
      fail("stride[" + std::to_string(axis) + "] is 0, expected the bytes from one point to the next");
}

// The grid of the centres of cells, with a rim. `cells` counts cells; its origin is that of the first point.
Grid centresOf(const Grid& cells) {
  Grid grid = cells;
  grid.rim = true;
  for (int a = 0; a < 3; a++) {
    grid.points[size_t(a)] += 2;
    grid.origin[a] -= grid.spacing[a] / 2;
  }
  return grid;
}

// The points of the stream's grid that a rank owns with some cells: their centres, and the rim beside the outermost ones.
Extent withRim(const Extent& cells, const Index3& all) {
  Extent owned;
  if (cells.count() == 0) return owned;
  for (size_t a = 0; a < 3; a++) {
    const int64_t end = cells.first[a] + cells.points[a];
    owned.first[a] = cells.first[a] == 0 ? 0 : cells.first[a] + 1;
    owned.points[a] = (end == all[a] ? end + 2 : end + 1) - owned.first[a];
  }
  return owned;
}

// Particles are a row of points.
Extent rowOf(uint64_t count) { return count > 0 ? Extent{{0, 0, 0}, {int64_t(count), 1, 1}} : Extent(); }

// Point i of an array of positions.
glm::dvec3 positionAt(const gxy_array& positions, size_t i) {
  glm::dvec3 p(0);
  const std::byte* at = static_cast<const std::byte*>(positions.data) + int64_t(i) * positions.stride[0];
  const auto read = [&](auto value) {
    const int64_t next = positions.component_stride != 0 ? positions.component_stride : int64_t(sizeof value);
    for (int a = 0; a < 3; a++, at += next) {
      std::memcpy(&value, at, sizeof value);
      p[a] = double(value);
    }
  };
  if (positions.type == GXY_FLOAT32)
    read(0.F);
  else
    read(0.0);
  return p;
}

Box boundsOf(const gxy_array& positions, uint64_t count) {
  Box bounds;
  for (uint64_t i = 0; i < count; i++) {
    const glm::dvec3 p = positionAt(positions, i);
    if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) bounds.extend(p);
  }
  return bounds;
}

void checkPositions(const std::string& what, const gxy_array& positions, uint64_t count) {
  if (count > kMostParticles)
    throw Error(what + ": " + std::to_string(count) + " points, expected at most 2^32 - 2");
  checkArray(what + ", positions", positions, rowOf(count));
  if (positions.components != 3)
    throw Error(what + ", positions: " + std::to_string(positions.components) + " components, expected 3");
}

std::string nameOf(Mesh::Kind kind) {
  if (kind == Mesh::Kind::Grid) return "is a grid";
  return kind == Mesh::Kind::Points ? "has particles" : "has cells";
}

size_t bytesSent(const Encodings& encodings, size_t mesh, const Array& array) {
  const bool isFloat = array.what == Array::What::Field && encodingIn(encodings, mesh, array.field);
  return isFloat ? sizeof(float) * size_t(array.components) : array.bytesPerPoint();
}

}  // namespace

Meshes::Data& Meshes::at(const std::string& mesh, const std::string& function) {
  const auto found = data_.find(mesh);
  if (found == data_.end())
    throw Error(function + ": there is no mesh \"" + mesh +
                "\", expected gxy_grid(), gxy_points() or gxy_cells() first");
  return found->second;
}

void Meshes::grid(const std::string& mesh, int block, int of, Grid grid, const Extent& owned, News news) {
  checkName(mesh, "mesh");
  if (block < 0) throw Error("gxy_grid: block " + std::to_string(block) + ", expected 0, 1, ...");
  Block described{owned, owned, {}};
  if (of == GXY_OF_CELLS) {
    described.owned = withRim(owned, grid.points);
    for (size_t a = 0; a < 3; a++) described.values.first[a]++;
    grid = centresOf(grid);
  }
  const auto known = data_.find(mesh);
  if (known != data_.end() && known->second.mesh.kind != Mesh::Kind::Grid)
    throw Error("gxy_grid: mesh \"" + mesh + "\" " + nameOf(known->second.mesh.kind) +
                ", expected another name");
  if (isDescribed() && known == data_.end())
    throw Error("gxy_grid: a new mesh \"" + mesh +
                "\" after the first step, expected one of those of before");
  const bool isOther = known != data_.end() && !(grid == known->second.mesh.grid);
  if (isOther && (!isDescribed() || grid.rim != known->second.mesh.grid.rim))
    throw Error("gxy_grid: a grid of " + sizeText(grid.points) + " points beside one of " +
                sizeText(known->second.mesh.grid.points) +
                ", another origin or spacing, or cells beside points: expected the same in all blocks");
  Mesh one;
  one.name = mesh;
  one.grid = grid;
  one.fields = {{"any", ScalarType::Float32, 1}};
  Part part;
  if (owned.count() != 0) part.blocks.push_back(described.owned);
  insitu::check({1, {one}, {part}});
  Data& data = data_[mesh];
  const auto old = data.blocks.find(block);
  const Extent ownedBefore = old != data.blocks.end() ? old->second.owned : Extent();
  const bool changes = isOther || ownedBefore != described.owned;
  if (isDescribed() && changes && news == News::None)
    throw Error(
        "gxy_grid: another grid or block after gxy_wanted, expected it before that, or after gxy_publish");
  if (isDescribed() && (changes || news == News::Each)) news_ = true;
  if (isOther) data.blocks.clear();
  data.mesh.name = mesh;
  data.mesh.grid = grid;
  Block& before = data.blocks[block];
  if (before.values == described.values)
    described.fields = std::move(before.fields);  // else they are of other arrays
  before = std::move(described);
}

void Meshes::points(const std::string& mesh, uint64_t count, const gxy_array& positions, const gxy_array& ids,
                    const Box& box) {
  checkName(mesh, "mesh");
  const std::string what = "gxy_points, \"" + mesh + "\"";
  checkPositions(what, positions, count);
  const bool hasIds = ids.components != 0;
  if (hasIds) checkArray(what + ", ids", ids, rowOf(count));
  if (hasIds && (ids.components != 1 || ids.type < GXY_INT32 || ids.type > GXY_UINT64))
    throw Error(what + ", ids: type " + std::to_string(ids.type) + " and " + std::to_string(ids.components) +
                " components, expected one integer of 32 or 64 bits, or 0 components for points without ids");
  Mesh one;
  one.name = mesh;
  one.kind = Mesh::Kind::Points;
  one.positions = ScalarType(positions.type);
  one.ids = hasIds;
  one.box = box;
  if (const Mesh* before = described(what, one))
    if (before->positions != one.positions || before->ids != one.ids || before->box != one.box)
      throw Error(what +
                  ": another type of positions, other ids or another box after the first step, expected "
                  "those of before");
  replace(one, count, positions).ids = ids;
}

void Meshes::cells(const std::string& mesh, uint64_t count, const gxy_array& positions,
                   const CellArrays& cells) {
  checkName(mesh, "mesh");
  const std::string what = "gxy_cells, \"" + mesh + "\"";
  checkPositions(what, positions, count);
  if (cells.count > kMostParticles)
    throw Error(what + ": " + std::to_string(cells.count) + " cells, expected at most 2^32 - 2");
  CellArrays arrays = cells;
  arrays.describe(what);
  Mesh one;
  one.name = mesh;
  one.kind = Mesh::Kind::Cells;
  one.positions = ScalarType(positions.type);
  one.shape = arrays.shape();
  if (const Mesh* before = described(what, one)) {
    const bool isShape = before->shape == Mesh::Shape::Unknown || one.shape == Mesh::Shape::Unknown ||
                         before->shape == one.shape;
    if (before->positions != one.positions || !isShape)
      throw Error(what +
                  ": another type of positions, or cells of another kind (lines, triangles or cells with a "
                  "volume), after "
                  "the first step, expected those of before");
  }
  Data& data = replace(one, count, positions);
  data.cells = arrays;
  for (auto& [name, values] : data.cellFields) values.data = nullptr;
}

const Mesh* Meshes::described(const std::string& what, const Mesh& mesh) const {
  insitu::check({1, {mesh}, {Part()}});
  const auto known = data_.find(mesh.name);
  if (known != data_.end() && known->second.mesh.kind != mesh.kind)
    throw Error(what + ": this mesh " + nameOf(known->second.mesh.kind) + ", expected another name");
  if (!isDescribed()) return nullptr;
  if (known == data_.end()) throw Error(what + ": a new mesh after the first step, expected those of before");
  return &known->second.mesh;
}

Meshes::Data& Meshes::replace(const Mesh& mesh, uint64_t points, const gxy_array& positions) {
  Data& data = data_[mesh.name];
  if (!isDescribed()) data.mesh = mesh;
  data.positions = positions;
  Block& all = data.blocks[0];
  all.owned = all.values = rowOf(points);
  for (auto& [name, values] : all.fields) values.data = nullptr;  // They are of other points.
  return data;
}

void Meshes::field(const std::string& mesh, int block, const std::string& name, int of,
                   const gxy_array& values) {
  checkName(name, "field");
  const std::string what = "gxy_field, \"" + name + "\"";
  Data& data = at(mesh, what);
  const auto found = data.blocks.find(block);
  if (found == data.blocks.end())
    throw Error(what + ": there is no block " + std::to_string(block) +
                " on this rank, expected gxy_grid() first");
  const bool hasBoth = data.mesh.kind == Mesh::Kind::Cells, ofCells = hasBoth && of == GXY_OF_CELLS;
  if (!hasBoth && (of == GXY_OF_CELLS) != data.mesh.grid.rim)
    throw Error(what + ": values of " + (data.mesh.grid.rim ? "points" : "cells") +
                " on a mesh that counts " + (data.mesh.grid.rim ? "cells" : "points") +
                ", expected the same so far");
  checkArray(what, values, ofCells ? rowOf(data.cells.count) : found->second.values);
  Arrays& known = ofCells ? data.cellFields : found->second.fields;
  const std::vector<Field>& fields = data.mesh.fields;
  const Field told{name, ScalarType(values.type), values.components, ofCells};
  if (isDescribed() && std::find(fields.begin(), fields.end(), told) == fields.end())
    throw Error(what +
                ": a new field, type or number of components after the first step, expected those of before");
  known[name] = values;
}

std::vector<Field> Meshes::fieldsOf(const Data& data) {
  std::vector<Field> fields;
  for (const auto& [number, block] : data.blocks) {
    std::vector<Field> here;
    for (const auto& [name, values] : block.fields)
      here.push_back({name, ScalarType(values.type), values.components});
    if (number != data.blocks.begin()->first && here != fields)
      throw Error("gxy_publish: the fields of block " + std::to_string(number) +
                  " differ from those of another block, expected the same names, types and components");
    fields = std::move(here);
  }
  for (const auto& [name, values] : data.cellFields)
    fields.push_back({name, ScalarType(values.type), values.components, true});
  if (fields.empty() && data.mesh.kind == Mesh::Kind::Grid)
    throw Error("gxy_publish: there is no field on mesh \"" + data.mesh.name +
                "\", expected gxy_field() first");
  return fields;
}

// After the first step, in which all of them had the same.
void Meshes::checkFields(const Data& data) {
  for (const auto& [number, block] : data.blocks)
    for (const Field& field : data.mesh.fields)
      if (block.values.count() > 0 && block.fields.count(field.name) == 0)
        throw Error("gxy_publish: block " + std::to_string(number) + " of mesh \"" + data.mesh.name +
                    "\" has no field \"" + field.name +
                    "\" since it has changed, expected gxy_field() after gxy_grid()");
}

void Meshes::checkNews() const {
  for (const auto& [name, data] : data_)
    if (data.mesh.kind == Mesh::Kind::Grid) checkFields(data);
}

Description Meshes::describe() {
  if (isDescribed()) checkNews();
  Description description = describeBlocks();
  lacksFields_ = false;
  return description;
}

Description Meshes::describeBlocks() {
  if (data_.empty())
    throw Error(
        "gxy_publish: there is no mesh, expected gxy_grid() and gxy_field(), gxy_points() or gxy_cells() "
        "first");
  Description description;
  for (auto& [name, data] : data_) {
    const bool isGrid = data.mesh.kind == Mesh::Kind::Grid;
    description.meshes.push_back(data.mesh);
    if (!isDescribed()) description.meshes.back().fields = fieldsOf(data);
    description.parts.emplace_back();
    if (isGrid)
      for (const auto& [number, block] : data.blocks)
        if (block.owned.count() > 0) description.parts.back().blocks.push_back(block.owned);
    if (isGrid) continue;
    if (!isDescribed()) data.bounds = boundsOf(data.positions, pointsOf(data));
    description.parts.back().bounds = data.bounds;
    if (isDescribed()) continue;
    if (data.mesh.kind ==
        Mesh::Kind::Cells)  // Wrong cells of the first step are told here, later ones by the server.
      description.meshes.back().shape =
          data.cells.checked("gxy_publish, cells \"" + name + "\"", pointsOf(data),
                             [&positions = data.positions](size_t i) { return positionAt(positions, i); });
  }
  insitu::check(description);
  checkVolumes(description.meshes);
  std::vector<const Data*> meshes;
  for (auto& [name, data] : data_) {
    data.mesh = description.meshes[meshes.size()];
    data.present.clear();
    for (const auto& [number, block] : data.blocks)
      if (block.owned.count() > 0 || data.mesh.kind != Mesh::Kind::Grid) data.present.push_back(&block);
    meshes.push_back(&data);
  }
  meshes_ = std::move(meshes);
  news_ = false;
  lacksFields_ = true;
  return description;
}

// The number of particles or cells may have grown since their fields were told.
void Meshes::check(const char* function) const {
  for (const auto& [name, data] : data_) {
    if (data.mesh.kind == Mesh::Kind::Grid) {
      if (lacksFields_ && !news_) checkFields(data);
      continue;
    }
    const auto checkAll = [&function](const Arrays& fields, const Extent& row) {
      if (row.count() == 0) return;
      for (const auto& [field, values] : fields)
        if (!values.data || values.stride[0] == 0)
          checkArray(std::string(function) + ", field \"" + field + "\"", values, row);
    };
    checkAll(data.blocks.at(0).fields, data.blocks.at(0).values);
    checkAll(data.cellFields, rowOf(data.cells.count));
  }
}

uint64_t Meshes::pointsOf(const Data& data) { return uint64_t(data.blocks.at(0).values.count()); }

Counts Meshes::counts() const {
  Counts counts(3 * meshes_.size());
  for (size_t m = 0; m < meshes_.size(); m++) {
    const Data& data = *meshes_[m];
    if (data.mesh.kind == Mesh::Kind::Grid) continue;
    counts[placeOf(m, Per::Point)] = pointsOf(data);
    counts[placeOf(m, Per::Cell)] = data.cells.count;
    counts[placeOf(m, Per::Corner)] = data.cells.corners();
  }
  return counts;
}

uint64_t Meshes::bytes(std::span<const Destination> destinations, const Encodings& encodings,
                       const Counts& counts) const {
  uint64_t bytes = 0;
  for (const Destination& d : destinations)
    for (const Piece& piece : d.pieces) {
      const Mesh& mesh = meshes_.at(size_t(piece.mesh))->mesh;
      for (const Array& array : arraysOf(mesh)) {
        const uint64_t count = mesh.kind == Mesh::Kind::Grid
                                   ? uint64_t(piece.points.count())
                                   : counts.at(placeOf(size_t(piece.mesh), array.per));
        bytes += count * bytesSent(encodings, size_t(piece.mesh), array);
      }
    }
  return bytes;
}

void Meshes::copy(const Data& data, const Array& array, uint64_t count, std::byte* to) {
  const Extent row = rowOf(count);
  switch (array.what) {
    case Array::What::Positions:
      return copyPoints(data.positions, row, row, to);
    case Array::What::Ids:
      return copyIds(data.ids, count, to);
    case Array::What::Types:
      return data.cells.copyTypes(to);
    case Array::What::Ends:
      return data.cells.copyEnds(to);
    case Array::What::Connectivity:
      return data.cells.copyConnectivity(count, to);
    case Array::What::Field:
      break;
  }
  copyPoints(array.ofCells ? data.cellFields.at(array.name) : data.blocks.at(0).fields.at(array.name), row,
             row, to);
}

void Meshes::copy(std::span<const Destination> destinations, const Encodings& encodings, const Counts& counts,
                  std::byte* to) const {
  for (const Destination& d : destinations)
    for (const Piece& piece : d.pieces) {
      const Data& data = *meshes_.at(size_t(piece.mesh));
      const Block& block = *data.present.at(size_t(piece.block));
      const bool isGrid = data.mesh.kind == Mesh::Kind::Grid;
      for (const Array& array : arraysOf(data.mesh)) {
        const uint64_t count =
            isGrid ? uint64_t(piece.points.count()) : counts.at(placeOf(size_t(piece.mesh), array.per));
        if (count == 0) continue;
        if (!isGrid)
          copy(data, array, count, to);
        else if (const FieldEncoding* e = encodingIn(encodings, size_t(piece.mesh), array.field))
          copyPointsAsFloats(block.fields.at(array.name), block.values, piece.points, e->shift, e->scale, to);
        else
          copyPoints(block.fields.at(array.name), block.values, piece.points, to);
        to += size_t(count) * bytesSent(encodings, size_t(piece.mesh), array);
      }
    }
}

void Meshes::keep() {
  std::vector<std::vector<std::byte>> kept;
  std::map<std::string, Data> copies = data_;
  const auto copy = [&](gxy_array& array, const Extent& values) {
    if (values.count() == 0 || array.components == 0) return;
    const Index3& n = values.points;
    const auto bytes = int64_t(bytesOf(ScalarType(array.type))) * array.components;
    kept.emplace_back(size_t(bytes * values.count()));
    copyPoints(array, values, values, kept.back().data());
    array = {
        kept.back().data(), array.type, array.components, {bytes, bytes * n[0], bytes * n[0] * n[1]}, 0, 0};
  };
  for (auto& [name, data] : copies)
    for (auto& [number, block] : data.blocks) {
      for (auto& [field, array] : block.fields) copy(array, block.values);
      copy(data.positions, block.values);
      copy(data.ids, block.values);
      for (auto& [field, array] : data.cellFields) copy(array, rowOf(data.cells.count));
      data.cells.keep(kept);
    }
  for (auto& [name, data] : data_) {
    Data& now = copies.at(name);
    data.positions = now.positions;
    data.ids = now.ids;
    data.cells = now.cells;
    data.cellFields.swap(now.cellFields);
    for (auto& [number, block] : data.blocks) block.fields.swap(now.blocks.at(number).fields);
  }
  kept_ = std::move(kept);
}

}  // namespace gxy::insitu
