// SPDX-License-Identifier: Apache-2.0
// The commands convert, partition and info for particles, path lines and triangles.
#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>

#include "core/comm/collectives.h"
#include "core/comm/error.h"
#include "core/data/mesh_counts.h"
#include "core/data/mesh_kinds.h"
#include "core/data/partitioning.h"
#include "core/io/file.h"
#include "core/io/geometry_file.h"
#include "core/io/import_geometry.h"
#include "core/io/import_mesh.h"
#include "core/io/write_geometry.h"
#include "core/look/file_facts.h"
#include "tools/gxydata/commands.h"

namespace gxy::data_tool {
namespace {

struct Input {
  OwnedGeometry geometry;
  std::string array;        ///< name of the values
  bool ofCells = false;     ///< the values belong to cells
  GeometrySummary summary;  ///< summary of a piece that represents all (tellingPiece())
};

Input load(const Options& options) {
  const auto [piece, summary] = tellingPiece(options.in);
  const GeometryKind kind = likelyKind(summary);
  SingleRank rank;
  OwnedGeometry geometry = loadGeometry(options.in, kind, options.array, rank).geometry;
  const auto listed = valuesOfList(options.in);
  const GeometryContent content =
      readGeometry(piece, kind, options.array.empty() && listed ? *listed : ValuesWanted(options.array));
  Input input{std::move(geometry), content.array, content.ofCells, summary};
  if (input.array.empty()) input.array = "data";
  return input;
}

/// Reports the content of the input that files with this extension cannot represent.
void tellLosses(const Options& options, const Input& input, const std::string& extension) {
  const auto tell = [&](const std::string& what) { tellLoss(options, what); };
  const GeometryBlock& block = input.geometry.block;
  const bool bare = extension == ".stl";
  const GeometrySummary& s = input.summary;
  if (bare) tell("coordinates are rounded to float");
  for (const GeometrySummary::Array& array : s.arrays) {
    const std::string name = (array.ofCells ? "cell array '" : "array '") + array.name + "'";
    const bool normals = array.components == 3 && (array.name == "Normals" || array.name == "Normals_");
    if (!array.ofCells && normals && !block.normals.empty() && !bare) continue;
    const bool isShown = array.ofCells == input.ofCells && array.name == input.array &&
                         !(block.values.empty() && block.colors.empty());
    if (!isShown || bare) {
      if (options.array.empty() || array.name == options.array) tell(name + " is left out");
      continue;
    }
    if (array.ofCells) tell(name + " becomes an array of points, of which each cell gets its own");
    if (array.colors) {
      if (array.components == 4) tell("the opacity in " + name + " is left out");
      if (array.name != "RGB" && extension != ".ply") tell(name + " becomes the array 'RGB'");
      if (array.type == "double") tell(name + " is rounded from double to float");
      continue;
    }
    if (array.components > 1)
      tell(name + " becomes the magnitude of its " + std::to_string(array.components) + " components");
    if (array.type != "float") tell(name + " is rounded from " + array.type + " to float");
  }
  uint64_t used = s.vertices;
  const char* kept = "points";
  if (input.geometry.kind == GeometryKind::PathLines) used = s.segments, kept = "lines";
  if (input.geometry.kind == GeometryKind::Triangles) {
    used = s.triangles, kept = "triangles";
    if (s.solids) tell("of solid cells only the outer surface is kept");
  }
  if (s.vertices + s.segments + s.triangles + s.others > used)
    tell("cells other than " + std::string(kept) + " are left out");
}

/// Returns the cell of a lattice over `box` that contains p.
size_t cellOf(const Box& box, const std::array<int, 3>& lattice, glm::dvec3 p) {
  size_t cell = 0;
  for (int a = 2; a >= 0; --a) {
    const double side = box.hi[a] - box.lo[a];
    const double place = side > 0 ? (p[a] - box.lo[a]) / side * lattice[size_t(a)] : 0;
    cell = cell * size_t(lattice[size_t(a)]) + size_t(std::clamp(int(place), 0, lattice[size_t(a)] - 1));
  }
  return cell;
}

/// Returns numbers of cells for decompose(), in proportion to the box, so that pieces are nearly cubes.
std::array<int64_t, 3> proportions(const Box& box) {
  const glm::dvec3 side = box.hi - box.lo;
  const double longest = std::max({side.x, side.y, side.z, std::numeric_limits<double>::min()});
  std::array<int64_t, 3> cells;
  for (int a = 0; a < 3; ++a)
    cells[size_t(a)] = std::max(int64_t(1), int64_t(std::ceil(side[a] / longest * 1e6)));
  return cells;
}

}  // namespace

void convertGeometry(const Options& options) {
  keepInput(options.in, {options.out});
  if (options.array.empty() && copyGeometry(options.in, options.out)) return;
  const Input input = load(options);
  tellLosses(options, input, extensionOf(options.out));
  writeGeometry(options.out, input.geometry.block, input.geometry.kind, input.array);
}

void partitionGeometry(const Options& options, int parts, std::array<int, 3> lattice) {
  const Input input = load(options);
  const GeometryBlock& block = input.geometry.block;
  const Box& box = input.geometry.box;
  if (box.empty()) throw Error(options.in + ": there is nothing to partition");
  if (lattice[0] == 0) lattice = decompose(parts, proportions(box));
  std::vector<std::vector<uint32_t>> members(size_t(lattice[0]) * size_t(lattice[1]) * size_t(lattice[2]));
  for (size_t p = 0; p < block.ids.size(); ++p) {
    const PrimitivePoints corners = primitivePoints(block, input.geometry.kind, p);
    glm::dvec3 middle(0);
    for (uint32_t point : corners) middle += block.points[point] / double(corners.count);
    members[cellOf(box, lattice, middle)].push_back(uint32_t(p));
  }
  const char* extension = extensionOf(options.out) == ".pvtp" ? ".vtp" : ".vtu";
  keepInput(options.in, filesOfPieces(options.out, lattice, extension));
  tellLosses(options, input, extension);
  std::vector<GeometryPiece> pieces;
  Progress progress("partitioning", int64_t(members.size()));
  const glm::dvec3 side = box.hi - box.lo;
  for (int k = 0; k < lattice[2]; ++k)
    for (int j = 0; j < lattice[1]; ++j)
      for (int i = 0; i < lattice[0]; ++i, progress.advance()) {
        const std::string name = pieceName(options.out, int(pieces.size()), extension);
        writeGeometry(name, subset(block, input.geometry.kind, members[pieces.size()]), input.geometry.kind,
                      input.array, &block);
        const glm::dvec3 cells(lattice[0], lattice[1], lattice[2]), at(i, j, k);
        pieces.push_back({{box.lo + side * (at / cells), box.lo + side * ((at + 1.0) / cells)},
                          std::filesystem::path(name).filename().string()});
      }
  writeGeometryPieces(options.out, pieces, block, input.array);
}

// What an import of the file as a volume finds in its mesh.
void printMesh(const Options& options) {
  SingleRank alone;
  std::vector<std::string> warnings;  // They say the same.
  try {
    LoadedMesh loaded = loadMesh(options.in, options.array, alone, {}, &warnings);
    const Partitioning whole = Partitioning::single(loaded.box);
    const std::shared_ptr<const Mesh> mesh = meshOf(std::move(loaded), whole, alone, {}, &warnings);
    std::printf("as a volume %s, values of %s\n", mesh->name.c_str(), mesh->ofCells ? "cells" : "points");
    std::printf("  %-20s %" PRIu64 "\n", "points", mesh->report.points);
    for (const auto& [name, count] : namedCounts(mesh->report))
      std::printf("  %-20s %" PRIu64 "\n", name, count);
  } catch (const std::exception& e) {  // too large for the memory, too
    std::printf("as a volume not possible: %s\n", e.what());
  }
}

void infoGeometry(const Options& options) {
  const std::vector<std::string> pieces = geometryPieces(options.in);
  uint64_t solids = 0;
  for (const std::string& piece : pieces) {
    const GeometrySummary s = summariseGeometry(piece);
    if (&piece == &pieces.front()) {  // Print this only after a piece could be read.
      std::printf("file        %s: geometry", options.in.c_str());
      std::printf(pieces.size() > 1 ? ", %zu pieces\n" : "\n", pieces.size());
    }
    if (pieces.size() > 1) std::printf("piece       %s\n", piece.c_str());
    std::printf("points      %" PRIu64 " (%" PRIu64 " in vertex cells)\n", s.points, s.vertices);
    std::printf("segments    %" PRIu64 "\ntriangles   %" PRIu64 "\nother cells %" PRIu64 "\n", s.segments,
                s.triangles, s.others);
    solids += s.solids;
    if (s.solids) std::printf("solid cells %" PRIu64 " (their outer surface is shown)\n", s.solids);
    if (!s.kinds.empty()) std::printf("cells       %s\n", describe(s.kinds).c_str());
    if (!s.box.empty())
      std::printf("box         %.9g %.9g %.9g to %.9g %.9g %.9g\n", s.box.lo.x, s.box.lo.y, s.box.lo.z,
                  s.box.hi.x, s.box.hi.y, s.box.hi.z);
    for (const GeometrySummary::Array& array : s.arrays) {
      if (!options.array.empty() && array.name != options.array) continue;
      const char* what = array.colors ? "s, colours" : array.components > 1 ? "s, magnitude" : ",";
      std::printf("%s array '%s': %s, %d component%s", array.ofCells ? "cell " : "point", array.name.c_str(),
                  array.type.c_str(), array.components, what);
      if (array.range.empty())
        std::printf(" no finite value");
      else
        std::printf(" %.9g to %.9g", array.range.min, array.range.max);
      std::printf(", not finite %" PRIu64 "\n", array.notFinite);
    }
  }
  if (solids > 0 && isMeshFile(options.in)) printMesh(options);
}

}  // namespace gxy::data_tool
