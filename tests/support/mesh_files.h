// SPDX-License-Identifier: Apache-2.0
// Files of meshes for tests.
#pragma once
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/data/mesh_blocks.h"

namespace gxy::test {

inline std::string shortest(double value) {
  std::array<char, 40> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

/// An unstructured grid as a text: points, cells by their numbers of VTK, and arrays.
struct GridFile {
  struct Array {
    std::string name, type;
    int components;
    std::vector<double> values;
  };
  std::vector<glm::dvec3> points;
  std::vector<std::pair<int, std::vector<uint32_t>>> cells;
  std::vector<Array> pointArrays, cellArrays;
  std::string scalars;  ///< the active ones of points

  /// The text of a .vtu.
  std::string vtu() const {
    std::string text =
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\"><UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
        std::to_string(points.size()) + "\" NumberOfCells=\"" + std::to_string(cells.size()) + "\">\n";
    std::vector<double> places, ids, offsets, types;
    for (const glm::dvec3& p : points) places.insert(places.end(), {p.x, p.y, p.z});
    for (const auto& [type, corners] : cells) {
      ids.insert(ids.end(), corners.begin(), corners.end());
      offsets.push_back(double(ids.size()));
      types.push_back(type);
    }
    text += "<Points>\n" + xml({"Points", "Float64", 3, places}) + "</Points>\n<Cells>\n" +
            xml({"connectivity", "Int64", 1, ids}) + xml({"offsets", "Int64", 1, offsets}) +
            xml({"types", "UInt8", 1, types}) + "</Cells>\n<PointData" +
            (scalars.empty() ? "" : " Scalars=\"" + scalars + "\"") + ">\n";
    for (const Array& array : pointArrays) text += xml(array);
    text += "</PointData>\n<CellData>\n";
    for (const Array& array : cellArrays) text += xml(array);
    return text + "</CellData>\n</Piece></UnstructuredGrid></VTKFile>\n";
  }

 private:
  static std::string xml(const Array& array) {
    std::string text = "<DataArray type=\"" + array.type + "\" Name=\"" + array.name +
                       "\" NumberOfComponents=\"" + std::to_string(array.components) +
                       "\" format=\"ascii\">\n";
    for (const double v : array.values) text += shortest(v) + " ";
    return text + "\n</DataArray>\n";
  }
};

/// Cells `first` to `last` of a mesh, with their points and values, which are array `name`.
inline GridFile gridOf(const MeshPiece& mesh, size_t first, size_t last, const std::string& name = "value") {
  constexpr std::array<int, kCellTypes> kTypes{10, 14, 13, 12};
  GridFile file;
  file.pointArrays.push_back({name, "Float32", mesh.components, {}});
  std::vector<uint32_t> taken;
  for (size_t cell = first; cell < last; cell++) {
    const auto corners = mesh.cells.pointsOf(uint32_t(cell));
    taken.insert(taken.end(), corners.begin(), corners.end());
  }
  std::sort(taken.begin(), taken.end());
  taken.erase(std::unique(taken.begin(), taken.end()), taken.end());
  for (const uint32_t p : taken) {
    file.points.push_back(mesh.points[p]);
    for (int c = 0; c < mesh.components; c++)
      file.pointArrays[0].values.push_back(double(mesh.values[p * size_t(mesh.components) + size_t(c)]));
  }
  for (size_t cell = first; cell < last; cell++) {
    const int type = kTypes[size_t(mesh.cells.typeOf(uint32_t(cell)))];
    auto& corners = file.cells.emplace_back(type, std::vector<uint32_t>()).second;
    for (const uint32_t p : mesh.cells.pointsOf(uint32_t(cell)))
      corners.push_back(uint32_t(std::lower_bound(taken.begin(), taken.end(), p) - taken.begin()));
  }
  return file;
}

/// A .pvtu of pieces with these names, which declares one array of points; empty: none.
inline std::string pvtu(const std::vector<std::string>& pieces, const std::string& array) {
  std::string text =
      "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
      "<PUnstructuredGrid GhostLevel=\"0\">\n<PPointData>\n";
  if (!array.empty())
    text += "<PDataArray type=\"Float32\" Name=\"" + array + "\" NumberOfComponents=\"1\"/>\n";
  text += "</PPointData>\n<PPoints><PDataArray type=\"Float64\" NumberOfComponents=\"3\"/></PPoints>\n";
  for (const std::string& piece : pieces) text += "<Piece Source=\"" + piece + "\"/>\n";
  return text + "</PUnstructuredGrid></VTKFile>\n";
}

}  // namespace gxy::test
