// SPDX-License-Identifier: Apache-2.0
#include "core/io/write_geometry.h"

#include <spdlog/spdlog.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIdList.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <algorithm>
#include <cstring>

#include "core/comm/error.h"
#include "core/io/cell_list.h"
#include "core/io/color_arrays.h"
#include "core/io/file.h"
#include "core/io/flaws.h"
#include "core/io/geometry_file.h"
#include "core/io/part_document.h"
#include "core/io/vtk_geometry.h"
#include "core/io/vtk_messages.h"
#include "core/io/vtk_scalars.h"

namespace gxy {
namespace {

template <class Writer>
void writeXml(const std::string& path, vtkDataObject* data) {
  VtkMessages messages;
  File::create(path);  // throws Error with the reason if the folder is missing or not writable
  const auto writer = vtkSmartPointer<Writer>::New();
  writer->SetFileName(path.c_str());
  writer->SetInputData(data);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToNone();
  writer->SetHeaderTypeToUInt64();
  const bool written = writer->Write() == 1;
  messages.check(path);
  if (!written) throw Error(path + ": cannot write the file");
}

}  // namespace

void writeGeometry(const std::string& path, const GeometryBlock& block, GeometryKind kind,
                   const std::string& array, const GeometryBlock* whole) {
  validate(block, kind);
  const std::string extension = extensionOf(path);
  if (extension == ".ply" || extension == ".stl") {
    if (kind != GeometryKind::Triangles)
      throw Error(path + ": a " + extension + " file holds triangles only");
    return extension == ".ply" ? writePly(path, block) : writeStl(path, block);
  }
  if (extension == ".csv") {
    if (kind != GeometryKind::Particles) throw Error(path + ": a .csv file holds particles only");
    return writeCsv(path, block, array);
  }
  const bool bytes = haveBytes(whole ? whole->colors : block.colors);
  if (extension == ".vtp") return writeVtp(path, block, kind, array, bytes);
  if (extension == ".vtu") return writeVtu(path, block, kind, array, bytes);
  throw Error(path + ": cannot write this kind of geometry: expected .vtp, .vtu, .csv, .ply or .stl");
}

namespace {

template <class Array>
vtkSmartPointer<vtkDataArray> arrayOf(const std::vector<std::byte>& bytes, int components) {
  const auto array = vtkSmartPointer<Array>::New();
  array->SetNumberOfComponents(components);
  const size_t values = bytes.size() / sizeof(typename Array::ValueType);
  array->SetNumberOfTuples(vtkIdType(values / size_t(components)));
  if (!bytes.empty()) std::memcpy(array->GetPointer(0), bytes.data(), bytes.size());
  return array;
}

template <class T>
vtkSmartPointer<vtkTypeInt64Array> integers(const std::vector<T>& values) {
  const auto array = vtkSmartPointer<vtkTypeInt64Array>::New();
  array->SetNumberOfValues(vtkIdType(values.size()));
  std::copy(values.begin(), values.end(), array->GetPointer(0));
  return array;
}

}  // namespace

void writeMesh(const std::string& path, const GatheredMesh& mesh, const std::string& array, ScalarType type,
               int components, bool ofCells) {
  const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  const auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(vtkIdType(mesh.points.size()));
  for (size_t i = 0; i < mesh.points.size(); ++i)
    points->SetPoint(vtkIdType(i), mesh.points[i].x, mesh.points[i].y, mesh.points[i].z);
  grid->SetPoints(points);
  const auto types = vtkSmartPointer<vtkUnsignedCharArray>::New();
  types->SetNumberOfValues(vtkIdType(mesh.types.size()));
  std::copy(mesh.types.begin(), mesh.types.end(), types->GetPointer(0));
  const auto cells = vtkSmartPointer<vtkCellArray>::New();
  cells->SetData(integers(mesh.offsets), integers(mesh.connectivity));
  grid->SetCells(types, cells);
  const auto values = type == ScalarType::Float32 ? arrayOf<vtkFloatArray>(mesh.values, components)
                                                  : arrayOf<vtkDoubleArray>(mesh.values, components);
  values->SetName(array.c_str());
  if (ofCells)
    grid->GetCellData()->AddArray(values);
  else
    grid->GetPointData()->AddArray(values);
  writeXml<vtkXMLUnstructuredGridWriter>(path, grid);
}

namespace {

/// Returns the type of a cell, even if VTK reports it as empty, as it does for hidden cells of grids.
int shownType(int type, vtkIdType points) {
  if (type != VTK_EMPTY_CELL) return type;
  return points == 8 ? VTK_HEXAHEDRON : points == 4 ? VTK_QUAD : points == 2 ? VTK_LINE : type;
}

/// Converts a set to an unstructured grid with all its cells. Points and arrays are shared.
vtkSmartPointer<vtkUnstructuredGrid> unstructured(vtkPointSet* set) {
  if (const auto grid = vtkUnstructuredGrid::SafeDownCast(set)) return grid;
  const auto grid = vtkSmartPointer<vtkUnstructuredGrid>::New();
  const CellList cells(set);
  grid->SetPoints(set->GetPoints());
  grid->Allocate(cells.count());
  const auto ids = vtkSmartPointer<vtkIdList>::New();
  for (vtkIdType cell = 0; cell < cells.count(); ++cell) {
    cells.points(cell, ids);
    grid->InsertNextCell(shownType(cells.type(cell), ids->GetNumberOfIds()), ids);
  }
  grid->GetPointData()->ShallowCopy(set->GetPointData());
  grid->GetCellData()->ShallowCopy(set->GetCellData());
  return grid;
}

/// Converts colours that our readers have turned into floating-point numbers back to bytes, if all of
/// them were bytes.
void putColorsInBytes(vtkDataSetAttributes* data) {
  for (int i = 0; i < data->GetNumberOfArrays(); ++i) {
    vtkDataArray* array = data->GetArray(i);
    if (!array || !isColors(array) || array->GetDataType() == VTK_UNSIGNED_CHAR) continue;
    const auto bytes = vtkSmartPointer<vtkUnsignedCharArray>::New();
    bytes->SetName(array->GetName());
    bytes->SetNumberOfComponents(array->GetNumberOfComponents());
    bytes->SetNumberOfTuples(array->GetNumberOfTuples());
    bool all = true;
    for (vtkIdType k = 0; all && k < array->GetNumberOfTuples(); ++k)
      for (int c = 0; c < array->GetNumberOfComponents(); ++c) {
        const double color = array->GetComponent(k, c);
        all = all && color >= 0 && color <= 1 && float(byteOf(float(color)) / 255.0) == float(color);
        if (all) bytes->SetTypedComponent(k, c, byteOf(float(color)));
      }
    if (!all) continue;
    const bool active = array == data->GetScalars();
    data->AddArray(bytes);  // It replaces the array of that name.
    if (active) data->SetActiveScalars(bytes->GetName());
  }
}

}  // namespace

bool copyGeometry(const std::string& from, const std::string& to) {
  const std::string extension = extensionOf(to);
  if ((extension != ".vtp" && extension != ".vtu") || geometryPieces(from) != std::vector{from}) return false;
  Flaws flaws;
  const vtkSmartPointer<vtkPointSet> set = readPointSet(from, {}, {}, nullptr, &flaws);
  if (const std::string kind = extensionOf(from); !kind.starts_with(".vt")) {
    putColorsInBytes(set->GetPointData());
    putColorsInBytes(set->GetCellData());
  }
  const bool surface = vtkPolyData::SafeDownCast(set);
  if (extension == ".vtp" && !surface) return false;
  if (extension == ".vtp")
    writeXml<vtkXMLPolyDataWriter>(to, set);
  else
    writeXml<vtkXMLUnstructuredGridWriter>(to, unstructured(set));
  for (const std::string& warning : flaws.warnings(from)) spdlog::warn("{}", warning);
  return true;
}

void writeGeometryPieces(const std::string& path, const std::vector<GeometryPiece>& pieces,
                         const GeometryBlock& like, const std::string& array) {
  const std::string extension = extensionOf(path);
  if (extension == ".part") {
    std::vector<GeometryPart> parts;
    for (const GeometryPiece& piece : pieces) parts.push_back({piece.extent, piece.file});
    return writeText(path, formatPart(parts));
  }
  if (extension != ".pvtu" && extension != ".pvtp")
    throw Error(path + ": the pieces of a geometry need a .part, .pvtu or .pvtp");
  const std::string type = extension == ".pvtu" ? "PUnstructuredGrid" : "PPolyData";
  std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + type +
                     "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <" + type +
                     " GhostLevel=\"0\">\n    <PPoints>\n      <PDataArray type=\"Float64\" Name=\"Points\" "
                     "NumberOfComponents=\"3\"/>\n    </PPoints>\n    <PPointData>\n";
  if (!like.values.empty()) text += "      <PDataArray type=\"Float32\" Name=\"" + escaped(array) + "\"/>\n";
  if (!like.colors.empty())
    text += "      <PDataArray type=\"" + std::string(haveBytes(like.colors) ? "UInt8" : "Float32") +
            "\" Name=\"RGB\" NumberOfComponents=\"3\"/>\n";
  for (const PointField& f : like.fields)
    if (!repeatsValues(like, f, array))
      text += "      <PDataArray type=\"Float32\" Name=\"" + escaped(f.name) + "\" NumberOfComponents=\"" +
              std::to_string(f.components) + "\"/>\n";
  if (!like.normals.empty())
    text += "      <PDataArray type=\"Float32\" Name=\"Normals\" NumberOfComponents=\"3\"/>\n";
  text += "    </PPointData>\n";
  for (const GeometryPiece& piece : pieces) text += "    <Piece Source=\"" + escaped(piece.file) + "\"/>\n";
  writeText(path, text + "  </" + type + ">\n</VTKFile>\n");
}

}  // namespace gxy
