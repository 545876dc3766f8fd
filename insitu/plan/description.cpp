// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/description.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/wire.h"
#include "core/data/mesh_kinds.h"

namespace gxy::insitu {

namespace {

std::string text(const Index3& i) {
  return std::to_string(i[0]) + " x " + std::to_string(i[1]) + " x " + std::to_string(i[2]);
}

bool isUtf8(const std::string& text) {
  try {
    return !nlohmann::json(text).dump().empty();
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

void checkGrid(const Grid& grid) {
  for (int a = 0; a < 3; a++) {
    const size_t axis = size_t(a);
    const int64_t least = grid.rim ? 3 : 2;
    if (grid.points[axis] < least || grid.points[axis] > kMostPoints)
      throw Error("grid of " + text(grid.points) + " points" +
                  (grid.rim ? ", the layer around cells included" : "") + ", expected " +
                  std::to_string(least) + " to 2^31 by axis");
    const double end = grid.origin[a] + grid.spacing[a] * double(grid.points[axis] - 1);
    if (!std::isfinite(grid.origin[a]) || !std::isfinite(end) || !(grid.spacing[a] > 0))
      throw Error("grid with origin " + std::to_string(grid.origin[a]) + " and spacing " +
                  std::to_string(grid.spacing[a]) + " on axis " + std::to_string(a) +
                  ", expected finite numbers and a spacing above 0");
  }
  if (grid.points[0] > kMostInAll / grid.points[1] / grid.points[2])
    throw Error("grid of " + text(grid.points) + " points, expected at most 2^46 in all");
}

void checkFields(const std::vector<Field>& fields, size_t fewest) {
  if (fields.size() < fewest || fields.size() > kMostFields)
    throw Error(std::to_string(fields.size()) + " fields, expected " + std::to_string(fewest) + " to " +
                std::to_string(kMostFields));
  std::set<std::pair<std::string, bool>> names;
  for (const Field& f : fields) {
    checkName(f.name, "field");
    const bool marksCells = f.name == kGhostArray && f.ofCells;  // points may have it, too
    if (!names.emplace(f.name, marksCells).second) throw Error("field \"" + f.name + "\" is there twice");
    if (f.type > ScalarType::Float64)
      throw Error("field \"" + f.name + "\": type " + std::to_string(int(f.type)) + ", expected 0 to 9");
    if (f.components < 1 || f.components > kMostComponents)
      throw Error("field \"" + f.name + "\": " + std::to_string(f.components) +
                  " components, expected 1 to " + std::to_string(kMostComponents));
  }
}

void checkBlock(const Extent& block, const Grid& grid) {
  for (size_t a = 0; a < 3; a++)
    if (block.points[a] < 1 || block.first[a] < 0 || block.first[a] > grid.points[a] ||
        block.points[a] > grid.points[a] - block.first[a])
      throw Error("block of " + text(block.points) + " points from (" + std::to_string(block.first[0]) +
                  ", " + std::to_string(block.first[1]) + ", " + std::to_string(block.first[2]) +
                  "), expected it inside the grid of " + text(grid.points) + " points");
}

bool isFinite(const Box& box) {
  return std::isfinite(box.lo.x + box.lo.y + box.lo.z) && std::isfinite(box.hi.x + box.hi.y + box.hi.z);
}

void checkGridPart(const Mesh& mesh, const Part& part) {
  checkGrid(mesh.grid);
  checkFields(mesh.fields, 1);
  if (part.blocks.size() > kMostBlocks)
    throw Error(std::to_string(part.blocks.size()) + " blocks, expected at most 2^20");
  for (const Extent& block : part.blocks) checkBlock(block, mesh.grid);
}

// Of points and cells.
void checkPointsPart(const Mesh& mesh, const Part& part) {
  checkFields(mesh.fields, 0);
  const std::string kind = mesh.kind == Mesh::Kind::Points ? "points" : "cells";
  if (mesh.positions != ScalarType::Float32 && mesh.positions != ScalarType::Float64)
    throw Error(kind + " \"" + mesh.name + "\": positions of type " + std::to_string(int(mesh.positions)) +
                ", expected float32 or float64");
  for (const Box& box : {mesh.box, part.bounds})
    if (box != Box() && (box.empty() || !isFinite(box)))
      throw Error(kind + " \"" + mesh.name +
                  "\": the box is not finite, or its lower corner is above its upper one");
}

}  // namespace

void checkName(const std::string& name, const std::string& what) {
  const bool controls = std::any_of(name.begin(), name.end(),
                                    [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  const bool isText = isUtf8(name) && !controls;
  if (name.empty() || name.size() > kMostName || !isText)
    throw Error("the name of a " + what + " has " + std::to_string(name.size()) + " bytes" +
                (isText ? "" : " that are no text, or control characters") + ", expected 1 to " +
                std::to_string(kMostName) + " bytes of text");
}

std::vector<Array> arraysOf(const Mesh& mesh) {
  using What = Array::What;
  std::vector<Array> arrays;
  const auto addFields = [&](Per per) {
    for (size_t f = 0; f < mesh.fields.size(); f++)
      if (mesh.fields[f].ofCells == (per == Per::Cell))
        arrays.push_back({mesh.fields[f], What::Field, per, f});
  };
  if (mesh.kind != Mesh::Kind::Grid)
    arrays.push_back({{"positions", mesh.positions, 3}, What::Positions, Per::Point, 0});
  if (mesh.ids) arrays.push_back({{"ids", ScalarType::UInt64, 1}, What::Ids, Per::Point, 0});
  addFields(Per::Point);
  if (mesh.kind != Mesh::Kind::Cells) return arrays;
  arrays.push_back({{"types", ScalarType::UInt8, 1}, What::Types, Per::Cell, 0});
  arrays.push_back({{"ends", ScalarType::UInt32, 1}, What::Ends, Per::Cell, 0});
  addFields(Per::Cell);
  arrays.push_back({{"connectivity", ScalarType::UInt32, 1}, What::Connectivity, Per::Corner, 0});
  return arrays;
}

const char* nameOf(Mesh::Shape shape) {
  switch (shape) {
    case Mesh::Shape::Lines:
      return "lines";
    case Mesh::Shape::Triangles:
      return "triangles";
    case Mesh::Shape::Volume:
      return "cells with a volume";
    case Mesh::Shape::Unknown:
      break;
  }
  return "no cells";
}

void checkVolumes(std::span<const Mesh> meshes) {
  for (const Mesh& mesh : meshes) {
    if (mesh.kind != Mesh::Kind::Cells || mesh.shape != Mesh::Shape::Volume) continue;
    const std::string what = "cells \"" + mesh.name + "\": ";
    bool hasValues = false;
    for (const Field& field : mesh.fields) {
      const bool marks = isGhosts(mesh, field);
      hasValues = hasValues || !marks;
      if (marks && (field.type != ScalarType::UInt8 || field.components != 1))
        throw Error(what + "field \"" + field.name + "\" has type " + std::to_string(int(field.type)) +
                    " and " + std::to_string(field.components) +
                    " components, expected one uint8 (1), whose bits mark ghosts as in VTK");
    }
    if (!hasValues)
      throw Error(what +
                  "cells with a volume without a field, expected one or more fields of points or cells");
  }
}

bool isGhosts(const Mesh& mesh, const Field& field) {
  const bool mayBeVolume = mesh.shape == Mesh::Shape::Volume || mesh.shape == Mesh::Shape::Unknown;
  return mesh.kind == Mesh::Kind::Cells && mayBeVolume && field.name == kGhostArray;
}

bool isNormals(const Mesh& mesh, const Field& field) {
  return mesh.kind == Mesh::Kind::Cells && mesh.shape != Mesh::Shape::Volume && !field.ofCells &&
         field.components == 3 && (field.name == "Normals" || field.name == "Normals_");
}

void mergeMeshes(std::vector<Mesh>& meshes, const std::vector<Mesh>& others, int rank) {
  std::vector<Mesh> merged = meshes;
  for (size_t m = 0; m < std::min(meshes.size(), others.size()); m++) {
    const Mesh::Shape shape = others[m].shape;
    if (merged[m].shape == Mesh::Shape::Unknown) merged[m].shape = shape;
    if (shape == Mesh::Shape::Unknown || shape == merged[m].shape) continue;
    throw Error("cells \"" + meshes[m].name + "\": rank " + std::to_string(rank) + " has " + nameOf(shape) +
                ", and a rank before has " + nameOf(merged[m].shape) + ", expected the same on all ranks");
  }
  std::vector<Mesh> same = others;
  for (size_t m = 0; m < std::min(merged.size(), same.size()); m++) same[m].shape = merged[m].shape;
  if (merged != same)
    throw Error(
        "rank " + std::to_string(rank) +
        " has other meshes or fields than a rank before, expected the same meshes in the same order, each "
        "with the same size, "
        "origin and spacing or type of positions, ids and box, and names, types and components of fields");
  meshes = std::move(merged);
}

void checkContinues(const std::vector<Mesh>& before, const std::vector<Mesh>& now) {
  std::vector<Mesh> same = now;
  for (size_t m = 0; m < std::min(before.size(), now.size()); m++) {
    same[m].grid.points = before[m].grid.points;
    same[m].grid.origin = before[m].grid.origin;
    same[m].grid.spacing = before[m].grid.spacing;
    if (before[m].shape == Mesh::Shape::Unknown || now[m].shape == Mesh::Shape::Unknown)
      same[m].shape = before[m].shape;
  }
  if (before != same)
    throw Error(
        "other meshes or fields than before, expected the same with the same fields, of points or cells as "
        "before, and only other blocks, sizes, origins and spacings of grids");
}

std::vector<Publishes> datasetsOf(std::span<const Mesh> meshes) {
  std::vector<Publishes> datasets;
  for (size_t m = 0; m < meshes.size(); m++) {
    const size_t before = datasets.size();
    for (size_t f = 0; f < meshes[m].fields.size(); f++)
      if (!isNormals(meshes[m], meshes[m].fields[f]) && !isGhosts(meshes[m], meshes[m].fields[f]))
        datasets.push_back({m, f, meshes[m].fields[f].name});
    if (datasets.size() == before) datasets.push_back({m, std::nullopt, meshes[m].name});
  }
  std::set<std::string> names;
  for (const Publishes& d : datasets)
    if (!names.insert(d.name).second)
      throw Error("two meshes have \"" + d.name +
                  "\", expected fields of different names, as the name becomes that of a dataset");
  return datasets;
}

void check(const Description& description) {
  if (description.meshes.empty() || description.meshes.size() > kMostMeshes)
    throw Error(std::to_string(description.meshes.size()) + " meshes, expected 1 to " +
                std::to_string(kMostMeshes));
  if (description.parts.size() != description.meshes.size())
    throw Error("a mesh without its part, expected one for each");
  std::set<std::string> names;
  for (size_t m = 0; m < description.meshes.size(); m++) {
    const Mesh& mesh = description.meshes[m];
    checkName(mesh.name, "mesh");
    if (!names.insert(mesh.name).second) throw Error("mesh \"" + mesh.name + "\" is there twice");
    if (mesh.kind == Mesh::Kind::Grid)
      checkGridPart(mesh, description.parts[m]);
    else
      checkPointsPart(mesh, description.parts[m]);
  }
  datasetsOf(description.meshes);
}

Bytes written(std::span<const Mesh> meshes) {
  Writer w;
  w.write(uint32_t(meshes.size()));
  for (const Mesh& mesh : meshes) {
    w.write(mesh.name).write(uint8_t(mesh.kind));
    if (mesh.kind == Mesh::Kind::Grid)
      w.write(mesh.grid.origin).write(mesh.grid.spacing).write(mesh.grid.points).write(mesh.grid.rim);
    else if (mesh.kind == Mesh::Kind::Points)
      w.write(uint8_t(mesh.positions)).write(mesh.ids).write(mesh.box);
    else
      w.write(uint8_t(mesh.positions)).write(uint8_t(mesh.shape));
    w.write(uint32_t(mesh.fields.size()));
    for (const Field& f : mesh.fields) {
      w.write(f.name).write(uint8_t(f.type)).write(uint32_t(f.components));
      if (mesh.kind == Mesh::Kind::Cells) w.write(f.ofCells);
    }
  }
  return w.take();
}

Bytes written(const Description& description) {
  Writer w;
  w.write(description.from).write(written(description.meshes));
  for (size_t m = 0; m < description.meshes.size(); m++) {
    if (description.meshes[m].kind == Mesh::Kind::Grid)
      w.write(description.parts[m].blocks);
    else
      w.write(description.parts[m].bounds);
  }
  return w.take();
}

std::vector<Mesh> readMeshes(std::span<const std::byte> message) {
  Reader r(message, "meshes of a simulation");
  const auto count = r.read<uint32_t>();
  if (count > kMostMeshes) r.fail(std::to_string(count) + " meshes, expected at most 16");
  std::vector<Mesh> meshes(count);
  for (Mesh& mesh : meshes) {
    mesh.name = r.readString();
    const auto kind = r.read<uint8_t>();
    if (kind > uint8_t(Mesh::Kind::Cells))
      r.fail("kind " + std::to_string(int(kind)) + " of a mesh, expected 0 to 2");
    mesh.kind = Mesh::Kind(kind);
    if (mesh.kind == Mesh::Kind::Grid) {
      mesh.grid.origin = r.read<glm::dvec3>();
      mesh.grid.spacing = r.read<glm::dvec3>();
      mesh.grid.points = r.read<Index3>();
      mesh.grid.rim = r.read<bool>();
    } else {
      mesh.positions = ScalarType(r.read<uint8_t>());
      if (mesh.kind == Mesh::Kind::Points) {
        mesh.ids = r.read<bool>();
        mesh.box = r.read<Box>();
      } else {
        const auto shape = r.read<uint8_t>();
        if (shape > uint8_t(Mesh::Shape::Volume))
          r.fail("shape " + std::to_string(int(shape)) + " of cells, expected 0 to 3");
        mesh.shape = Mesh::Shape(shape);
      }
    }
    const auto fields = r.read<uint32_t>();
    if (fields > kMostFields) r.fail(std::to_string(fields) + " fields, expected at most 64");
    for (uint32_t i = 0; i < fields; i++) {
      Field f;
      f.name = r.readString();
      f.type = ScalarType(r.read<uint8_t>());
      f.components = int(std::min<uint32_t>(r.read<uint32_t>(), uint32_t(kMostComponents) + 1));
      if (mesh.kind == Mesh::Kind::Cells) f.ofCells = r.read<bool>();
      mesh.fields.push_back(std::move(f));
    }
  }
  r.expectEnd();
  return meshes;
}

Description readDescription(std::span<const std::byte> message) {
  Reader r(message, "description of a simulation's data");
  Description d;
  d.from = r.read<uint64_t>();
  if (d.from == 0) r.fail("from publish 0, expected 1 or more");
  d.meshes = readMeshes(r.readVector<std::byte>());
  for (const Mesh& mesh : d.meshes) {
    d.parts.emplace_back();
    if (mesh.kind == Mesh::Kind::Grid)
      d.parts.back().blocks = r.readVector<Extent>();
    else
      d.parts.back().bounds = r.read<Box>();
  }
  r.expectEnd();
  check(d);
  return d;
}

}  // namespace gxy::insitu
