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

Box boundsOf(const gxy_array& positions, uint64_t count) {
  Box bounds;
  const size_t bytes = bytesOf(ScalarType(positions.type)) * 3;
  std::vector<std::byte> some(bytes * std::min<uint64_t>(count, 4096));
  for (uint64_t begin = 0; begin < count; begin += 4096) {
    const Extent points{{int64_t(begin), 0, 0}, {int64_t(std::min<uint64_t>(count - begin, 4096)), 1, 1}};
    copyPoints(positions, rowOf(count), points, some.data());
    for (int64_t i = 0; i < points.points[0]; i++) {
      glm::dvec3 p;
      for (int a = 0; a < 3; a++)
        withType(ScalarType(positions.type), [&](auto value) {
          std::memcpy(&value, some.data() + size_t(i) * bytes + size_t(a) * sizeof value, sizeof value);
          p[a] = double(value);
        });
      if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) bounds.extend(p);
    }
  }
  return bounds;
}

// Copies integers of any type as those of 64 bits.
void copyIds(const gxy_array& ids, uint64_t count, std::byte* to) {
  std::vector<std::byte> row(count * bytesOf(ScalarType(ids.type)));
  copyPoints(ids, rowOf(count), rowOf(count), row.data());
  withType(ScalarType(ids.type), [&](auto value) {
    for (uint64_t i = 0; i < count; i++) {
      std::memcpy(&value, row.data() + i * sizeof value, sizeof value);
      const auto wide = uint64_t(int64_t(value));
      std::memcpy(to + i * sizeof wide, &wide, sizeof wide);
    }
  });
}

}  // namespace

Meshes::Data& Meshes::at(const std::string& mesh, const std::string& function) {
  const auto found = data_.find(mesh);
  if (found == data_.end())
    throw Error(function + ": there is no mesh \"" + mesh + "\", expected gxy_grid() or gxy_points() first");
  return found->second;
}

void Meshes::grid(const std::string& mesh, int block, int of, Grid grid, const Extent& owned) {
  checkName(mesh, "mesh");
  if (isDescribed()) throw Error("gxy_grid after the first step: a decomposition cannot change so far");
  if (block < 0) throw Error("gxy_grid: block " + std::to_string(block) + ", expected 0, 1, ...");
  Block described{owned, owned, {}};
  if (of == GXY_OF_CELLS) {
    described.owned = withRim(owned, grid.points);
    for (size_t a = 0; a < 3; a++) described.values.first[a]++;
    grid = centresOf(grid);
  }
  const auto known = data_.find(mesh);
  if (known != data_.end() && known->second.mesh.kind != Mesh::Kind::Grid)
    throw Error("gxy_grid: mesh \"" + mesh + "\" has particles, expected another name");
  if (known != data_.end() && !(grid == known->second.mesh.grid))
    throw Error("gxy_grid: a grid of " + sizeText(grid.points) + " points beside one of " +
                sizeText(known->second.mesh.grid.points) +
                ", another origin or spacing, or cells beside points: expected the same in all blocks");
  Mesh one;
  one.name = mesh;
  one.grid = grid;
  one.fields = {{"any", ScalarType::Float32, 1}};
  Part part;
  if (owned.count() != 0) part.blocks.push_back(described.owned);
  insitu::check({{one}, {part}});
  one.fields = {};
  Data& data = data_[mesh];
  data.mesh = std::move(one);
  Block& before = data.blocks[block];
  if (before.values == described.values)
    described.fields = std::move(before.fields);  // else they are of other arrays
  before = std::move(described);
}

void Meshes::points(const std::string& mesh, uint64_t count, const gxy_array& positions, const gxy_array& ids,
                    const Box& box) {
  checkName(mesh, "mesh");
  const std::string what = "gxy_points, \"" + mesh + "\"";
  if (count > kMostParticles)
    throw Error(what + ": " + std::to_string(count) + " points, expected at most 2^32 - 2");
  checkArray(what + ", positions", positions, rowOf(count));
  if (positions.components != 3)
    throw Error(what + ", positions: " + std::to_string(positions.components) + " components, expected 3");
  const bool hasIds = ids.components != 0;
  if (hasIds) checkArray(what + ", ids", ids, rowOf(count));
  if (hasIds && (ids.components != 1 || ids.type < GXY_INT32 || ids.type > GXY_UINT64))
    throw Error(what + ", ids: type " + std::to_string(ids.type) + " and " + std::to_string(ids.components) +
                " components, expected one integer of 32 or 64 bits, or 0 components for points without ids");
  const Mesh one{mesh, Mesh::Kind::Points, {}, {}, ScalarType(positions.type), hasIds, box};
  insitu::check({{one}, {Part()}});
  const auto known = data_.find(mesh);
  if (known != data_.end() && known->second.mesh.kind != Mesh::Kind::Points)
    throw Error(what + ": this mesh is a grid, expected another name");
  if (isDescribed()) {
    if (known == data_.end())
      throw Error(what + ": a new mesh after the first step, expected those of before");
    const Mesh& before = known->second.mesh;
    if (before.positions != one.positions || before.ids != one.ids || before.box != one.box)
      throw Error(what +
                  ": another type of positions, other ids or another box after the first step, expected "
                  "those of before");
  }
  Data& data = data_[mesh];
  if (!isDescribed()) data.mesh = one;
  data.positions = positions;
  data.ids = ids;
  Block& all = data.blocks[0];
  all.owned = all.values = rowOf(count);
  for (auto& [name, values] : all.fields) values.data = nullptr;  // They are of other particles.
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
  if ((of == GXY_OF_CELLS) != data.mesh.grid.rim)
    throw Error(what + ": values of " + (data.mesh.grid.rim ? "points" : "cells") +
                " on a mesh that counts " + (data.mesh.grid.rim ? "cells" : "points") +
                ", expected the same so far");
  checkArray(what, values, found->second.values);
  Arrays& known = found->second.fields;
  const auto before = known.find(name);
  if (isDescribed() && (before == known.end() || before->second.type != values.type ||
                        before->second.components != values.components))
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
  if (fields.empty() && data.mesh.kind == Mesh::Kind::Grid)
    throw Error("gxy_publish: there is no field on mesh \"" + data.mesh.name +
                "\", expected gxy_field() first");
  return fields;
}

Description Meshes::describe() {
  if (data_.empty())
    throw Error("gxy_publish: there is no mesh, expected gxy_grid() and gxy_field(), or gxy_points(), first");
  Description description;
  for (const auto& [name, data] : data_) {
    description.meshes.push_back(data.mesh);
    description.meshes.back().fields = fieldsOf(data);
    description.parts.emplace_back();
    if (data.mesh.kind == Mesh::Kind::Points)
      description.parts.back().bounds = boundsOf(data.positions, particlesOf(data));
    else
      for (const auto& [number, block] : data.blocks)
        if (block.owned.count() > 0) description.parts.back().blocks.push_back(block.owned);
  }
  insitu::check(description);
  std::vector<const Data*> meshes;
  for (auto& [name, data] : data_) {
    data.mesh.fields = description.meshes[meshes.size()].fields;
    for (const auto& [number, block] : data.blocks)
      if (block.owned.count() > 0 || data.mesh.kind == Mesh::Kind::Points) data.present.push_back(&block);
    meshes.push_back(&data);
  }
  meshes_ = std::move(meshes);
  return description;
}

// The number of particles may have grown since their fields were told.
void Meshes::check(const char* function) const {
  for (const auto& [name, data] : data_) {
    if (data.mesh.kind != Mesh::Kind::Points || particlesOf(data) == 0) continue;
    for (const auto& [field, values] : data.blocks.at(0).fields)
      if (!values.data || values.stride[0] == 0)
        checkArray(std::string(function) + ", field \"" + field + "\"", values, data.blocks.at(0).values);
  }
}

uint64_t Meshes::particlesOf(const Data& data) { return uint64_t(data.blocks.at(0).values.count()); }

std::vector<uint64_t> Meshes::particles() const {
  std::vector<uint64_t> counts;
  for (const Data* data : meshes_)
    counts.push_back(data->mesh.kind == Mesh::Kind::Points ? particlesOf(*data) : 0);
  return counts;
}

uint64_t Meshes::bytes(std::span<const Destination> destinations) const {
  uint64_t bytes = 0;
  for (const Destination& d : destinations)
    for (const Piece& piece : d.pieces) {
      const Data& data = *meshes_.at(size_t(piece.mesh));
      const bool isGrid = data.mesh.kind == Mesh::Kind::Grid;
      const uint64_t points = isGrid ? uint64_t(piece.points.count()) : particlesOf(data);
      for (const Field& array : arraysOf(data.mesh)) bytes += points * array.bytesPerPoint();
    }
  return bytes;
}

void Meshes::copy(std::span<const Destination> destinations, std::byte* to) const {
  for (const Destination& d : destinations)
    for (const Piece& piece : d.pieces) {
      const Data& data = *meshes_.at(size_t(piece.mesh));
      const Block& block = *data.present.at(size_t(piece.block));
      const bool isGrid = data.mesh.kind == Mesh::Kind::Grid;
      const Extent& points = isGrid ? piece.points : block.values;
      const auto put = [&](const gxy_array& array) {
        copyPoints(array, block.values, points, to);
        to += size_t(points.count()) * bytesOf(ScalarType(array.type)) * size_t(array.components);
      };
      if (points.count() == 0) continue;
      if (!isGrid) put(data.positions);
      if (!isGrid && data.mesh.ids) {
        copyIds(data.ids, uint64_t(points.count()), to);
        to += size_t(points.count()) * sizeof(uint64_t);
      }
      for (const Field& field : data.mesh.fields) put(block.fields.at(field.name));
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
    }
  for (auto& [name, data] : data_) {
    Data& now = copies.at(name);
    data.positions = now.positions;
    data.ids = now.ids;
    for (auto& [number, block] : data.blocks) block.fields.swap(now.blocks.at(number).fields);
  }
  kept_ = std::move(kept);
}

}  // namespace gxy::insitu
