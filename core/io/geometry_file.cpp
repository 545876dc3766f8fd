// SPDX-License-Identifier: Apache-2.0
#include "core/io/geometry_file.h"

#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIdList.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkUnsignedCharArray.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/data/cells.h"
#include "core/io/color_arrays.h"
#include "core/io/drawn_cells.h"
#include "core/io/file.h"
#include "core/io/listed_arrays.h"
#include "core/io/part_document.h"
#include "core/io/values_choice.h"
#include "core/io/vtk_geometry.h"
#include "core/io/xml_arrays.h"

namespace gxy {
namespace {

double magnitude(vtkDataArray* array, vtkIdType i) {
  if (array->GetNumberOfComponents() == 1) return array->GetComponent(i, 0);
  double sum = 0;
  for (int c = 0; c < array->GetNumberOfComponents(); ++c)
    sum += array->GetComponent(i, c) * array->GetComponent(i, c);
  return std::sqrt(sum);
}

std::vector<glm::dvec3> pointsOf(vtkPointSet* set) {
  const vtkIdType count = set->GetNumberOfPoints();
  std::vector<glm::dvec3> points(static_cast<size_t>(count));
  const auto doubles = count ? vtkDoubleArray::SafeDownCast(set->GetPoints()->GetData()) : nullptr;
  if (doubles && doubles->GetNumberOfComponents() == 3) {
    std::memcpy(points.data(), doubles->GetPointer(0), points.size() * sizeof points[0]);
    return points;
  }
  const auto floats = count ? vtkFloatArray::SafeDownCast(set->GetPoints()->GetData()) : nullptr;
  if (floats && floats->GetNumberOfComponents() == 3) {
    const float* from = floats->GetPointer(0);
    parallelFor(
        size_t(0), points.size(),
        [&](size_t i) {
          points[i] = {from[3 * i], from[3 * i + 1], from[3 * i + 2]};
        },
        [](double) {});
    return points;
  }
  for (vtkIdType i = 0; i < count; ++i) {
    const double* p = set->GetPoint(i);
    points[size_t(i)] = {p[0], p[1], p[2]};
  }
  return points;
}

/// Returns the array of values among the arrays that have been read; null if the file has no values.
vtkDataArray* valuesOf(vtkPointSet* set, const ValuesWanted& wanted, bool& ofCells, const std::string& path) {
  const ListedArrays points = listOf(set->GetPointData()), cells = listOf(set->GetCellData());
  const std::optional<ChosenArray> chosen = chooseValues(points, cells, wanted);
  if (!chosen && !wanted.array.empty() && !wanted.orNone)
    throw Error(path + ": no array '" + wanted.array + "' of points or cells; of points the file has " +
                namesOf(points) + ", of cells " + namesOf(cells));
  if (!chosen) return nullptr;
  ofCells = chosen->ofCells;
  vtkDataSetAttributes* data = set->GetPointData();
  if (ofCells) data = set->GetCellData();
  return data->GetArray(chosen->name.c_str());
}

/// Returns the array of radii among the arrays that have been read; null if none is wanted.
vtkDataArray* radiusValuesOf(vtkPointSet* set, const std::string& name, const std::string& path) {
  if (name.empty()) return nullptr;
  vtkDataArray* array = set->GetPointData()->GetArray(name.c_str());
  if (!array || isColors(array))
    throw Error(path + ": no array '" + name + "' of points with values for radii; the file has " +
                namesOf(listOf(set->GetPointData())));
  return array;
}

/// Returns the arrays that become fields among those that have been read.
std::vector<vtkDataArray*> fieldsOf(vtkPointSet* set, const std::vector<std::string>& names,
                                    const std::string& path) {
  std::vector<vtkDataArray*> arrays;
  for (const std::string& name : names) {
    arrays.push_back(set->GetPointData()->GetArray(name.c_str()));
    if (!arrays.back())
      throw Error(path + ": no array '" + name + "' of points for `fields`; the file has " +
                  namesOf(listOf(set->GetPointData())));
    if (isColors(arrays.back()))
      throw Error(path + ": array '" + name + "' for `fields` holds colours, expected an array of values");
    if (arrays.back()->GetNumberOfComponents() > kMostPointComponents)
      throw Error(path + ": array '" + name + "' for `fields` has " +
                  std::to_string(arrays.back()->GetNumberOfComponents()) + " components, expected at most " +
                  std::to_string(kMostPointComponents));
  }
  return arrays;
}

PointField fieldOf(vtkDataArray* array) {
  PointField field{array->GetName(), array->GetNumberOfComponents(), {}};
  const vtkIdType points = array->GetNumberOfTuples();
  field.values.reserve(size_t(points) * size_t(field.components));
  for (vtkIdType i = 0; i < points; ++i)
    for (int c = 0; c < field.components; ++c) field.values.push_back(float(array->GetComponent(i, c)));
  return field;
}

bool isNormals(vtkDataArray* array) {
  return array->GetName() && array->GetNumberOfComponents() == 3 && isNameOfNormals(array->GetName());
}

/// Returns unit normals, or none if the file has none or one of them has no direction.
std::vector<glm::vec3> unitNormals(vtkPointData* data, Flaws& flaws) {
  vtkDataArray* array = data->GetNormals();
  for (int i = 0; !array && i < data->GetNumberOfArrays(); ++i)
    if (data->GetArray(i) && isNormals(data->GetArray(i))) array = data->GetArray(i);
  std::vector<glm::vec3> normals;
  for (vtkIdType i = 0; array && i < array->GetNumberOfTuples(); ++i) {
    const glm::dvec3 n(array->GetComponent(i, 0), array->GetComponent(i, 1), array->GetComponent(i, 2));
    const double length = glm::length(n);
    if (!(length > 0) || !std::isfinite(length)) {
      flaws.add("the normals are not used, since this one has no direction",
                [&] { return "point " + std::to_string(i); });
      return {};
    }
    normals.push_back(glm::vec3(n / length));
  }
  return normals;
}

/// Returns an upper bound on the memory of a block with this many points and primitives. `fields` is how many floats further
/// fields have at each point.
int64_t bytesOf(size_t points, size_t primitives, GeometryKind kind, bool colors, bool radii, size_t fields) {
  const size_t cell = kind == GeometryKind::Triangles   ? sizeof(std::array<uint32_t, 3>)
                      : kind == GeometryKind::PathLines ? 2 * sizeof(std::array<uint32_t, 2>)
                                                        : 0;
  const size_t look =
      (colors ? sizeof(glm::vec3) : sizeof(float)) + (radii ? sizeof(float) : 0) + fields * sizeof(float);
  return int64_t(points * (sizeof(glm::dvec3) + sizeof(glm::vec3) + look) +
                 primitives * (cell + sizeof(uint64_t)));
}

bool isVertex(int type) { return type == VTK_VERTEX || type == VTK_POLY_VERTEX; }

/// Returns, for each point, the first vertex cell that it is in, or -1.
std::vector<vtkIdType> vertexCells(vtkPointSet* set) {
  std::vector<vtkIdType> cells(size_t(set->GetNumberOfPoints()), -1);
  const CellList list(set);
  const auto ids = vtkSmartPointer<vtkIdList>::New();
  for (vtkIdType cell = 0; cell < list.count(); ++cell) {
    if (!isVertex(list.type(cell))) continue;
    list.points(cell, ids);
    for (vtkIdType id : *ids)
      if (cells[size_t(id)] < 0) cells[size_t(id)] = cell;
  }
  return cells;
}

/// Removes points that are not drawn from a block of particles.
void dropGhostPoints(vtkPointSet* set, GeometryBlock& block) {
  vtkUnsignedCharArray* ghosts = set->GetPointGhostArray();
  if (!ghosts) return;
  size_t kept = 0;
  for (size_t i = 0; i < block.points.size(); ++i) {
    if (!isDrawn(ghosts, vtkIdType(i))) continue;
    block.points[kept] = block.points[i];
    if (!block.values.empty()) block.values[kept] = block.values[i];
    if (!block.colors.empty()) block.colors[kept] = block.colors[i];
    if (!block.radiusValues.empty()) block.radiusValues[kept] = block.radiusValues[i];
    for (PointField& f : block.fields)
      for (int c = 0, n = f.components; c < n; ++c)
        f.values[kept * size_t(n) + size_t(c)] = f.values[i * size_t(n) + size_t(c)];
    ++kept;
  }
  block.points.resize(kept);
  if (!block.values.empty()) block.values.resize(kept);
  if (!block.colors.empty()) block.colors.resize(kept);
  if (!block.radiusValues.empty()) block.radiusValues.resize(kept);
  for (PointField& f : block.fields) f.values.resize(kept * size_t(f.components));
}

/// Returns the number of triangles of a flat cell with this many points.
uint64_t trianglesOf(int type, uint64_t points) {
  if (const DrawnCellShape* shape = shapeOf(type)) return trianglesOf(shape->faces[0]);
  return points < 3 ? 0 : points - 2;
}

GeometrySummary::Array summariseArray(vtkDataArray* array, bool ofCells) {
  GeometrySummary::Array summary;
  summary.name = array->GetName() ? array->GetName() : "";
  summary.type = array->GetDataTypeAsString();
  summary.components = array->GetNumberOfComponents();
  summary.ofCells = ofCells;
  summary.colors = isColors(array);
  for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i) {
    if (summary.colors) {
      bool finite = true;
      for (int c = 0; c < 3; ++c) {
        summary.range.extend(array->GetComponent(i, c));
        finite = finite && std::isfinite(array->GetComponent(i, c));
      }
      summary.notFinite += !finite;
      continue;
    }
    const double value = magnitude(array, i);
    summary.range.extend(value);
    summary.notFinite += !std::isfinite(value);
  }
  return summary;
}

/// Returns the type of VTK's lists of pieces with an extension; null if there is none.
const char* typeOfXmlList(const std::string& extension) {
  if (extension == ".pvtu") return "PUnstructuredGrid";
  if (extension == ".pvts") return "PStructuredGrid";
  if (extension == ".pvtr") return "PRectilinearGrid";
  return extension == ".pvtp" ? "PPolyData" : nullptr;
}

}  // namespace

std::vector<std::string> geometryPieces(const std::string& path) {
  const std::string extension = extensionOf(path);
  if (const char* type = typeOfXmlList(extension)) return xmlPieces(path, type);
  if (extension != ".part") return {path};
  std::vector<std::string> files;
  for (const GeometryPart& part : parsePart(readText(path), path)) files.push_back(beside(path, part.file));
  return files;
}

std::optional<ValuesWanted> valuesOfList(const std::string& path, std::optional<bool> wantedOfCells) {
  const char* type = typeOfXmlList(extensionOf(path));
  if (!type) return {};
  const auto [points, cells] = arraysOfXmlList(path, type);
  const std::optional<ChosenArray> chosen = chooseValues(points, cells, ValuesWanted({}, wantedOfCells));
  if (!chosen) return {};
  return ValuesWanted{chosen->name, chosen->ofCells, true};
}

GeometryContent readGeometry(const std::string& path, GeometryKind kind, const ValuesWanted& wanted,
                             const TakeMemory& toTake) {
  GeometryContent content;
  Flaws flaws;
  const bool normals = kind != GeometryKind::Particles;
  const vtkSmartPointer<vtkPointSet> set =
      readPointSet(path, toTake, ArraysNeeded{wanted, normals}, &content.leftOut, &flaws);
  const vtkIdType count = set->GetNumberOfPoints();
  std::optional<DrawnCells> cells;
  if (kind != GeometryKind::Particles) cells.emplace(set, kind, toTake, flaws);
  vtkDataArray* values = count ? valuesOf(set, wanted, content.ofCells, path) : nullptr;
  vtkDataArray* radii = count ? radiusValuesOf(set, wanted.radii, path) : nullptr;
  const std::vector<vtkDataArray*> fields =
      count ? fieldsOf(set, wanted.fields, path) : std::vector<vtkDataArray*>();
  if (values && content.ofCells)
    for (const std::string& name : wanted.fields)
      if (name == values->GetName())
        throw Error(path + ": array '" + name +
                    "' for `fields` has the name of the array of cells that gives values, "
                    "expected other names");
  size_t fieldFloats = 0;
  for (vtkDataArray* field : fields) fieldFloats += size_t(field->GetNumberOfComponents());
  const bool split = values && content.ofCells && cells;
  const size_t primitives = cells ? cells->primitives() : size_t(count);
  const size_t most = size_t(count) + (split ? primitives * (kind == GeometryKind::PathLines ? 4 : 3) : 0);
  if (most >= std::numeric_limits<uint32_t>::max())
    throw Error(path + ": " + std::to_string(most) + " points; one file may have at most 2^32 - 2");
  const bool colored = values && isColors(values);
  if (toTake) toTake(bytesOf(most, primitives, kind, colored, radii, fieldFloats));
  GeometryBlock& block = content.block;
  // Most of the memory of particles is freed before they are copied, or as soon as they are: cells serve values of cells only.
  const bool isPoints = !cells && !content.ofCells;
  if (const auto mesh = vtkPolyData::SafeDownCast(set); mesh && isPoints) mesh->SetVerts(nullptr);
  block.points = pointsOf(set);
  if (isPoints) set->SetPoints(nullptr);
  if (values) content.array = values->GetName();
  std::optional<ColorsOf> colorOf;
  if (colored) colorOf.emplace(values, flaws);
  // Appends the value or colour of point or cell i of the array; -1 means that there is none.
  const auto give = [&](GeometryBlock& to, vtkIdType i) {
    if (colorOf)
      to.colors.push_back((*colorOf)(i));
    else
      to.values.push_back(i < 0 ? std::numeric_limits<float>::quiet_NaN() : float(magnitude(values, i)));
  };
  if (values && !split) {
    colored ? block.colors.reserve(size_t(count)) : block.values.reserve(size_t(count));
    const std::vector<vtkIdType> cellOf = content.ofCells ? vertexCells(set) : std::vector<vtkIdType>();
    const auto floats = vtkFloatArray::SafeDownCast(values);
    if (floats && !colored && !content.ofCells && floats->GetNumberOfComponents() == 1)
      block.values.assign(floats->GetPointer(0), floats->GetPointer(0) + count);
    else
      for (vtkIdType i = 0; i < count; ++i) give(block, content.ofCells ? cellOf[size_t(i)] : i);
  }
  block.radiusValues.reserve(radii ? size_t(count) : 0);
  for (vtkIdType i = 0; radii && i < count; ++i) block.radiusValues.push_back(float(magnitude(radii, i)));
  for (vtkDataArray* field : fields) block.fields.push_back(fieldOf(field));
  if (normals) block.normals = unitNormals(set->GetPointData(), flaws);

  if (!cells) {
    dropGhostPoints(set, block);
  } else {
    block.triangles.reserve(kind == GeometryKind::Triangles ? primitives : 0);
    block.segments.reserve(kind == GeometryKind::PathLines ? primitives : 0);
    block.neighbours.reserve(block.segments.capacity());
    std::vector<int64_t> cellOf;
    cells->addTo(block, split ? &cellOf : nullptr);
    if (split) splitByCell(block, kind, cellOf, give);
    content.unusedCells = cells->unused();
  }
  block.ids.resize(kind == GeometryKind::Particles   ? block.points.size()
                   : kind == GeometryKind::PathLines ? block.segments.size()
                                                     : block.triangles.size());
  std::iota(block.ids.begin(), block.ids.end(), uint64_t(0));
  content.warnings = flaws.warnings(path);
  return content;
}

GeometrySummary summariseGeometry(const std::string& path, const TakeMemory& toTake) {
  const vtkSmartPointer<vtkPointSet> set = readPointSet(path, toTake);
  GeometrySummary summary;
  summary.points = uint64_t(set->GetNumberOfPoints());
  for (vtkIdType i = 0; i < set->GetNumberOfPoints(); ++i) {
    const double* p = set->GetPoint(i);
    if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]))
      summary.box.extend({p[0], p[1], p[2]});
  }
  const auto ids = vtkSmartPointer<vtkIdList>::New();
  const CellList list(set);
  for (vtkIdType cell = 0; cell < list.count(); ++cell) {
    const int type = list.type(cell);
    ++summary.kinds[type];
    list.points(cell, ids);
    const uint64_t points = uint64_t(ids->GetNumberOfIds());
    if (isSolid(type))
      ++summary.solids;
    else if (isFlat(type))
      summary.triangles += trianglesOf(type, points);
    else if (isLine(type))
      summary.segments += points < 2 ? 0 : points - 1;
    else if (isVertex(type))
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
  if (summary.triangles || summary.solids) return GeometryKind::Triangles;
  return summary.segments ? GeometryKind::PathLines : GeometryKind::Particles;
}

}  // namespace gxy
