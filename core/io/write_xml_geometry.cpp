// SPDX-License-Identifier: Apache-2.0
// Writes geometry as VTK's XML files, whose arrays are appended as bytes. VTK's own writers would need all arrays once more, in
// their form.
#include <algorithm>
#include <bit>
#include <functional>

#include "core/io/file.h"
#include "core/io/vtk_scalars.h"
#include "core/io/write_geometry.h"

namespace gxy {
namespace {

/// Is given the bytes of an array, in as many pieces as there are.
using Sink = std::function<void(std::span<const std::byte>)>;

/// An array of a file.
struct Array {
  ScalarType type;
  std::string name;
  int components;
  size_t values;  ///< numbers, not entries
  std::function<void(const Sink&)> write;
};

template <class T>
Array arrayOf(ScalarType type, std::string name, int components, const std::vector<T>& from) {
  return {type, std::move(name), components, from.size() * sizeof(T) / bytesOf(type),
          [&from](const Sink& sink) { sink(std::as_bytes(std::span(from))); }};
}

/// An array of numbers that are made while they are written: numberOf(i) is the i-th.
template <class T, class NumberOf>
Array arrayOf(ScalarType type, std::string name, int components, size_t values, NumberOf numberOf) {
  return {type, std::move(name), components, values, [values, numberOf](const Sink& sink) {
            constexpr size_t kPiece = size_t(1) << 16;
            std::vector<T> piece;
            for (size_t i = 0; i < values; i += piece.size()) {
              piece.resize(std::min(kPiece, values - i));
              for (size_t k = 0; k < piece.size(); k++) piece[k] = numberOf(i + k);
              sink(std::as_bytes(std::span(piece)));
            }
          }};
}

/// The points of cells one after the other, and where each cell ends.
struct Cells {
  Array connectivity, offsets;
  size_t count;
};

template <class PointOf>
Cells cellsOfOneSize(size_t count, size_t points, PointOf pointOf) {
  return {arrayOf<int64_t>(ScalarType::Int64, "connectivity", 1, count * points, pointOf),
          arrayOf<int64_t>(ScalarType::Int64, "offsets", 1, count,
                           [points](size_t i) { return int64_t((i + 1) * points); }),
          count};
}

/// Segments that continue each other are one line.
Cells linesOf(const GeometryBlock& block) {
  std::vector<int64_t> points, ends;
  const auto& segments = block.segments;
  for (size_t i = 0; i < segments.size(); i++) {
    const bool continues = i > 0 && segments[i - 1][1] == segments[i][0] &&
                           block.neighbours[i][0] == segments[i - 1][0] &&
                           block.neighbours[i - 1][1] == segments[i][1];
    if (!continues) {
      if (i > 0) ends.push_back(int64_t(points.size()));
      points.push_back(segments[i][0]);
    }
    points.push_back(segments[i][1]);
  }
  if (!segments.empty()) ends.push_back(int64_t(points.size()));
  const size_t size = points.size(), count = ends.size();
  return {arrayOf<int64_t>(ScalarType::Int64, "connectivity", 1, size,
                           [points = std::move(points)](size_t i) { return points[i]; }),
          arrayOf<int64_t>(ScalarType::Int64, "offsets", 1, count,
                           [ends = std::move(ends)](size_t i) { return ends[i]; }),
          count};
}

Cells cellsOf(const GeometryBlock& block, GeometryKind kind) {
  if (kind == GeometryKind::PathLines) return linesOf(block);
  if (kind == GeometryKind::Particles)
    return cellsOfOneSize(block.points.size(), 1, [](size_t i) { return int64_t(i); });
  return cellsOfOneSize(block.triangles.size(), 3,
                        [&block](size_t i) { return int64_t(block.triangles[i / 3][i % 3]); });
}

Array colorsOf(const std::vector<glm::vec3>& colors, bool bytes) {
  if (!bytes) return arrayOf(ScalarType::Float32, "RGB", 3, colors);
  return arrayOf<uint8_t>(ScalarType::UInt8, "RGB", 3, 3 * colors.size(),
                          [&colors](size_t i) { return byteOf(colors[i / 3][int(i % 3)]); });
}

/// A file while its arrays are listed.
class XmlFile {
 public:
  explicit XmlFile(const char* type) {
    text_ = std::string("<?xml version=\"1.0\"?>\n<VTKFile type=\"") + type +
            "\" version=\"1.0\" byte_order=\"" +
            (std::endian::native == std::endian::big ? "BigEndian" : "LittleEndian") +
            "\" header_type=\"UInt64\">\n  <" + type + ">\n    <Piece";
  }

  void attribute(const char* name, size_t value) {
    text_ += std::string(" ") + name + "=\"" + std::to_string(value) + "\"";
  }
  void endAttributes() { text_ += ">\n"; }

  /// An element with arrays. `attributes` are its, as text.
  void list(const std::string& element, const std::string& attributes, std::vector<Array> arrays) {
    text_ += "      <" + element + attributes + ">\n";
    for (Array& array : arrays) {
      text_ += std::string("        <DataArray type=\"") + xmlWord(array.type) + "\" Name=\"" +
               escaped(array.name) + "\" NumberOfComponents=\"" + std::to_string(array.components) +
               "\" format=\"appended\" offset=\"" + std::to_string(offset_) + "\"/>\n";
      offset_ += sizeof(uint64_t) + array.values * bytesOf(array.type);
      arrays_.push_back(std::move(array));
    }
    text_ += "      </" + element + ">\n";
  }

  void write(const std::string& path, const char* type) {
    const File file = File::create(path);
    int64_t at = 0;
    const auto append = [&](std::span<const std::byte> bytes) {
      file.writeAt(at, bytes);
      at += int64_t(bytes.size());
    };
    text_ += std::string("    </Piece>\n  </") + type + ">\n  <AppendedData encoding=\"raw\">\n    _";
    append(std::as_bytes(std::span(text_)));
    for (const Array& array : arrays_) {
      const uint64_t bytes = array.values * bytesOf(array.type);
      append(std::as_bytes(std::span(&bytes, 1)));
      array.write(append);
    }
    const std::string end = "\n  </AppendedData>\n</VTKFile>\n";
    append(std::as_bytes(std::span(end)));
  }

 private:
  std::string text_;
  uint64_t offset_ = 0;
  std::vector<Array> arrays_;
};

void listPoints(XmlFile& file, const GeometryBlock& block, const std::string& array, bool bytes) {
  std::vector<Array> arrays;
  std::string active;
  if (!block.values.empty()) arrays.push_back(arrayOf(ScalarType::Float32, array, 1, block.values));
  if (!block.colors.empty()) arrays.push_back(colorsOf(block.colors, bytes));
  if (!arrays.empty()) active = " Scalars=\"" + escaped(arrays[0].name) + "\"";
  for (const PointField& f : block.fields)
    if (!repeatsValues(block, f, array))
      arrays.push_back(arrayOf(ScalarType::Float32, f.name, f.components, f.values));
  if (!block.normals.empty()) {
    active += " Normals=\"Normals\"";
    arrays.push_back(arrayOf(ScalarType::Float32, "Normals", 3, block.normals));
  }
  file.list("PointData", active, std::move(arrays));
  file.list("Points", "", {arrayOf(ScalarType::Float64, "Points", 3, block.points)});
}

}  // namespace

void writeVtp(const std::string& path, const GeometryBlock& block, GeometryKind kind,
              const std::string& array, bool bytes) {
  XmlFile file("PolyData");
  Cells cells = cellsOf(block, kind);
  file.attribute("NumberOfPoints", block.points.size());
  file.attribute("NumberOfVerts", kind == GeometryKind::Particles ? cells.count : 0);
  file.attribute("NumberOfLines", kind == GeometryKind::PathLines ? cells.count : 0);
  file.attribute("NumberOfStrips", 0);
  file.attribute("NumberOfPolys", kind == GeometryKind::Triangles ? cells.count : 0);
  file.endAttributes();
  listPoints(file, block, array, bytes);
  const char* list = kind == GeometryKind::Particles   ? "Verts"
                     : kind == GeometryKind::PathLines ? "Lines"
                                                       : "Polys";
  file.list(list, "", {std::move(cells.connectivity), std::move(cells.offsets)});
  file.write(path, "PolyData");
}

void writeVtu(const std::string& path, const GeometryBlock& block, GeometryKind kind,
              const std::string& array, bool bytes) {
  XmlFile file("UnstructuredGrid");
  Cells cells = cellsOf(block, kind);
  file.attribute("NumberOfPoints", block.points.size());
  file.attribute("NumberOfCells", cells.count);
  file.endAttributes();
  listPoints(file, block, array, bytes);
  constexpr uint8_t kVertex = 1, kPolyLine = 4, kTriangle = 5;  // in VTK's numbers
  const uint8_t type = kind == GeometryKind::Particles   ? kVertex
                       : kind == GeometryKind::PathLines ? kPolyLine
                                                         : kTriangle;
  file.list("Cells", "",
            {std::move(cells.connectivity), std::move(cells.offsets),
             arrayOf<uint8_t>(ScalarType::UInt8, "types", 1, cells.count, [type](size_t) { return type; })});
  file.write(path, "UnstructuredGrid");
}

}  // namespace gxy
