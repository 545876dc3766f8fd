// SPDX-License-Identifier: Apache-2.0
#include "gxy/io/geometry_file.h"

#include <spdlog/spdlog.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkIdList.h>
#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>

#include "gxy/comm/error.h"
#include "gxy/io/file.h"
#include "gxy/io/part_document.h"
#include "gxy/io/vtk_geometry.h"
#include "gxy/io/vtk_xml.h"

namespace gxy {
namespace {

/// Cells that VTK does not draw either: another piece's, those that finer ones stand for, hidden ones.
constexpr unsigned char kCellsNotDrawn = vtkDataSetAttributes::DUPLICATECELL |
                                         vtkDataSetAttributes::REFINEDCELL | vtkDataSetAttributes::HIDDENCELL;
/// Points that are no particles: another piece's and hidden ones. Cells of hidden points are not drawn.
constexpr unsigned char kPointsNotDrawn =
    vtkDataSetAttributes::DUPLICATEPOINT | vtkDataSetAttributes::HIDDENPOINT;

double magnitude(vtkDataArray* array, vtkIdType i) {
  if (array->GetNumberOfComponents() == 1) return array->GetComponent(i, 0);
  double sum = 0;
  for (int c = 0; c < array->GetNumberOfComponents(); ++c)
    sum += array->GetComponent(i, c) * array->GetComponent(i, c);
  return std::sqrt(sum);
}

bool isNormals(vtkDataArray* array) {
  return array->GetName() && array->GetNumberOfComponents() == 3 && isNameOfNormals(array->GetName());
}

vtkDataArray* chooseValues(vtkPointData* data, const std::string& wanted, const std::string& path) {
  std::string names;
  vtkDataArray *first = nullptr, *standard = nullptr;
  for (int i = 0; i < data->GetNumberOfArrays(); ++i) {
    vtkDataArray* array = data->GetArray(i);
    if (!array || !array->GetName()) continue;
    if (wanted == array->GetName()) return array;
    names += std::string(names.empty() ? "'" : ", '") + array->GetName() + "'";
    if (isNormals(array) || array == data->GetNormals() || array == data->GetTCoords() ||
        std::strcmp(array->GetName(), vtkDataSetAttributes::GhostArrayName()) == 0)
      continue;
    if (std::strcmp(array->GetName(), "data") == 0) standard = array;
    if (!first) first = array;
  }
  if (!wanted.empty())
    throw Error(path + ": no point array '" + wanted + "'; the file has " + (names.empty() ? "none" : names));
  if (data->GetScalars()) return data->GetScalars();
  return standard ? standard : first;
}

/// Unit normals, or none if the file has none or one of them has no direction.
std::vector<glm::vec3> unitNormals(vtkPointData* data, const std::string& path) {
  vtkDataArray* array = data->GetNormals();
  for (int i = 0; !array && i < data->GetNumberOfArrays(); ++i)
    if (data->GetArray(i) && isNormals(data->GetArray(i))) array = data->GetArray(i);
  std::vector<glm::vec3> normals;
  for (vtkIdType i = 0; array && i < array->GetNumberOfTuples(); ++i) {
    const glm::dvec3 n(array->GetComponent(i, 0), array->GetComponent(i, 1), array->GetComponent(i, 2));
    const double length = glm::length(n);
    if (!(length > 0) || !std::isfinite(length)) {
      spdlog::warn("{}: the normals are not used: that of point {} has no direction", path, i);
      return {};
    }
    normals.push_back(glm::vec3(n / length));
  }
  return normals;
}

void addPolyline(GeometryBlock& block, vtkIdList* ids) {
  const vtkIdType n = ids->GetNumberOfIds();
  const auto point = [&](vtkIdType i) { return uint32_t(ids->GetId(std::clamp(i, vtkIdType(0), n - 1))); };
  for (vtkIdType i = 0; i + 1 < n; ++i) {
    block.segments.push_back({point(i), point(i + 1)});
    block.neighbours.push_back({point(i - 1), point(i + 2)});
  }
}

/// The corners of triangle i of a cell with n points; false when there are no more.
bool triangleOf(int type, vtkIdType n, vtkIdType i, std::array<vtkIdType, 3>& corner) {
  if (i + 2 >= n) return false;
  if (type == VTK_TRIANGLE_STRIP)
    corner = i % 2 ? std::array{i + 1, i, i + 2} : std::array{i, i + 1, i + 2};
  else if (type == VTK_PIXEL)
    corner = i ? std::array<vtkIdType, 3>{0, 3, 2} : std::array<vtkIdType, 3>{0, 1, 3};
  else
    corner = {0, i + 1, i + 2};
  return true;
}

bool isSurface(int type) {
  return type == VTK_TRIANGLE || type == VTK_QUAD || type == VTK_POLYGON || type == VTK_TRIANGLE_STRIP ||
         type == VTK_PIXEL;
}

bool isLine(int type) { return type == VTK_LINE || type == VTK_POLY_LINE; }

bool hasHiddenPoint(vtkUnsignedCharArray* ghosts, vtkIdList* ids) {
  return ghosts && std::any_of(ids->begin(), ids->end(), [&](vtkIdType id) {
           return ghosts->GetValue(id) & vtkDataSetAttributes::HIDDENPOINT;
         });
}

void addCells(vtkPointSet* set, GeometryKind kind, GeometryContent& content) {
  GeometryBlock& block = content.block;
  vtkUnsignedCharArray *ghosts = set->GetCellGhostArray(), *ghostPoints = set->GetPointGhostArray();
  const auto ids = vtkSmartPointer<vtkIdList>::New();
  for (vtkIdType cell = 0; cell < set->GetNumberOfCells(); ++cell) {
    const int type = set->GetCellType(cell);
    if (ghosts && (ghosts->GetValue(cell) & kCellsNotDrawn)) continue;
    const bool wanted = kind == GeometryKind::PathLines ? isLine(type) : isSurface(type);
    if (!wanted) {
      ++content.unusedCells;
      continue;
    }
    set->GetCellPoints(cell, ids);
    if (hasHiddenPoint(ghostPoints, ids)) continue;
    if (kind == GeometryKind::PathLines) {
      addPolyline(block, ids);
      continue;
    }
    std::array<vtkIdType, 3> c;
    for (vtkIdType i = 0; triangleOf(type, ids->GetNumberOfIds(), i, c); ++i)
      block.triangles.push_back(
          {uint32_t(ids->GetId(c[0])), uint32_t(ids->GetId(c[1])), uint32_t(ids->GetId(c[2]))});
  }
}

/// How many primitives the cells become, ghosts among them.
size_t primitivesOf(vtkPointSet* set, GeometryKind kind) {
  if (kind == GeometryKind::Particles) return size_t(set->GetNumberOfPoints());
  const vtkIdType fewer = kind == GeometryKind::PathLines ? 1 : 2;
  vtkIdType primitives = 0;
  const auto ids = vtkSmartPointer<vtkIdList>::New();
  for (vtkIdType cell = 0; cell < set->GetNumberOfCells(); ++cell) {
    const int type = set->GetCellType(cell);
    if (kind == GeometryKind::PathLines ? !isLine(type) : !isSurface(type)) continue;
    set->GetCellPoints(cell, ids);
    primitives += std::max(vtkIdType(0), ids->GetNumberOfIds() - fewer);
  }
  return size_t(primitives);
}

/// The most that a block with so many points and primitives takes.
int64_t bytesOf(size_t points, size_t primitives, GeometryKind kind) {
  const size_t cell = kind == GeometryKind::Triangles   ? sizeof(std::array<uint32_t, 3>)
                      : kind == GeometryKind::PathLines ? 2 * sizeof(std::array<uint32_t, 2>)
                                                        : 0;
  return int64_t(points * (sizeof(glm::dvec3) + sizeof(glm::vec3) + sizeof(float)) +
                 primitives * (cell + sizeof(uint64_t)));
}

/// Points that are not drawn are left out of a set of particles.
void dropGhostPoints(vtkPointSet* set, GeometryBlock& block) {
  vtkUnsignedCharArray* ghosts = set->GetPointGhostArray();
  if (!ghosts) return;
  size_t kept = 0;
  for (size_t i = 0; i < block.points.size(); ++i) {
    if (ghosts->GetValue(vtkIdType(i)) & kPointsNotDrawn) continue;
    block.points[kept] = block.points[i];
    if (!block.values.empty()) block.values[kept] = block.values[i];
    ++kept;
  }
  block.points.resize(kept);
  if (!block.values.empty()) block.values.resize(kept);
}

GeometrySummary::Array summariseArray(vtkDataArray* array, bool ofCells) {
  GeometrySummary::Array summary;
  summary.name = array->GetName() ? array->GetName() : "";
  summary.type = array->GetDataTypeAsString();
  summary.components = array->GetNumberOfComponents();
  summary.ofCells = ofCells;
  for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i) {
    const double value = magnitude(array, i);
    summary.range.extend(value);
    summary.notFinite += !std::isfinite(value);
  }
  return summary;
}

}  // namespace

std::vector<std::string> xmlPieces(const std::string& path, const char* type) {
  const VtkXml xml(path, type);
  std::vector<std::string> files;
  for (int i = 0; i < xml.data()->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* piece = xml.data()->GetNestedElement(i);
    if (std::strcmp(piece->GetName(), "Piece") != 0) continue;
    if (!piece->GetAttribute("Source")) throw Error(path + ": a <Piece> has no attribute Source");
    files.push_back(beside(path, piece->GetAttribute("Source")));
  }
  return files;
}

std::vector<std::string> geometryPieces(const std::string& path) {
  const std::string extension = extensionOf(path);
  if (extension == ".pvtu") return xmlPieces(path, "PUnstructuredGrid");
  if (extension == ".pvtp") return xmlPieces(path, "PPolyData");
  if (extension != ".part") return {path};
  std::vector<std::string> files;
  for (const GeometryPart& part : parsePart(readText(path), path)) files.push_back(beside(path, part.file));
  return files;
}

GeometryContent readGeometry(const std::string& path, GeometryKind kind, const std::string& wanted,
                             const TakeMemory& toTake) {
  GeometryContent content;
  const bool normals = kind != GeometryKind::Particles;
  const vtkSmartPointer<vtkPointSet> set =
      readPointSet(path, toTake, ArraysNeeded{wanted, normals}, &content.leftOut);
  const vtkIdType count = set->GetNumberOfPoints();
  if (uint64_t(count) >= std::numeric_limits<uint32_t>::max())
    throw Error(path + ": " + std::to_string(count) + " points; one file may have at most 2^32 - 2");
  const size_t primitives = primitivesOf(set, kind);
  if (toTake) toTake(bytesOf(size_t(count), primitives, kind));
  GeometryBlock& block = content.block;
  block.points.reserve(size_t(count));
  for (vtkIdType i = 0; i < count; ++i) {
    const double* p = set->GetPoint(i);
    block.points.push_back({p[0], p[1], p[2]});
  }
  vtkPointData* data = set->GetPointData();
  if (vtkDataArray* values = count ? chooseValues(data, wanted, path) : nullptr) {
    content.array = values->GetName() ? values->GetName() : "";
    block.values.reserve(size_t(count));
    for (vtkIdType i = 0; i < values->GetNumberOfTuples(); ++i)
      block.values.push_back(float(magnitude(values, i)));
  }
  if (normals) block.normals = unitNormals(data, path);

  if (kind == GeometryKind::Particles) {
    dropGhostPoints(set, block);
  } else {
    block.triangles.reserve(kind == GeometryKind::Triangles ? primitives : 0);
    block.segments.reserve(kind == GeometryKind::PathLines ? primitives : 0);
    block.neighbours.reserve(block.segments.capacity());
    addCells(set, kind, content);
  }
  block.ids.resize(kind == GeometryKind::Particles   ? block.points.size()
                   : kind == GeometryKind::PathLines ? block.segments.size()
                                                     : block.triangles.size());
  std::iota(block.ids.begin(), block.ids.end(), uint64_t(0));
  return content;
}

GeometrySummary summariseGeometry(const std::string& path) {
  const vtkSmartPointer<vtkPointSet> set = readPointSet(path);
  GeometrySummary summary;
  summary.points = uint64_t(set->GetNumberOfPoints());
  for (vtkIdType i = 0; i < set->GetNumberOfPoints(); ++i) {
    const double* p = set->GetPoint(i);
    if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]))
      summary.box.extend({p[0], p[1], p[2]});
  }
  const auto ids = vtkSmartPointer<vtkIdList>::New();
  for (vtkIdType cell = 0; cell < set->GetNumberOfCells(); ++cell) {
    const int type = set->GetCellType(cell);
    set->GetCellPoints(cell, ids);
    const uint64_t points = uint64_t(ids->GetNumberOfIds());
    if (isSurface(type))
      summary.triangles += points < 3 ? 0 : points - 2;
    else if (isLine(type))
      summary.segments += points < 2 ? 0 : points - 1;
    else if (type == VTK_VERTEX || type == VTK_POLY_VERTEX)
      summary.vertices += points;
    else
      ++summary.others;
  }
  for (int i = 0; i < set->GetPointData()->GetNumberOfArrays(); ++i)
    if (vtkDataArray* array = set->GetPointData()->GetArray(i))
      summary.arrays.push_back(summariseArray(array, false));
  for (int i = 0; i < set->GetCellData()->GetNumberOfArrays(); ++i)
    if (vtkDataArray* array = set->GetCellData()->GetArray(i))
      summary.arrays.push_back(summariseArray(array, true));
  return summary;
}

GeometryKind likelyKind(const GeometrySummary& summary) {
  if (summary.triangles) return GeometryKind::Triangles;
  return summary.segments ? GeometryKind::PathLines : GeometryKind::Particles;
}

}  // namespace gxy
