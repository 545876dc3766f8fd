// SPDX-License-Identifier: Apache-2.0
#include "core/io/vtk_geometry.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkCommand.h>
#include <vtkDataArraySelection.h>
#include <vtkDataSetAttributes.h>
#include <vtkDataSetReader.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkRectilinearGrid.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLRectilinearGridReader.h>
#include <vtkXMLStructuredGridReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <new>
#include <span>
#include <stdexcept>

#include "core/comm/error.h"
#include "core/io/file.h"
#include "core/io/legacy_vtk.h"
#include "core/io/obj_reader.h"
#include "core/io/off_reader.h"
#include "core/io/ply_reader.h"
#include "core/io/point_table.h"
#include "core/io/stl_reader.h"
#include "core/io/volume_file.h"
#include "core/io/vtk_messages.h"
#include "core/io/vtk_scalars.h"
#include "core/io/vtk_xml_array.h"
#include "core/io/xml_arrays.h"

namespace gxy {
namespace {

constexpr const char* kExpected =
    "expected polygonal data or an unstructured, structured or rectilinear grid";

/// Converts a rectilinear grid to a structured grid, which stores its points.
vtkSmartPointer<vtkPointSet> withPoints(vtkRectilinearGrid* grid, const std::string& path,
                                        const TakeMemory& toTake) {
  int n[3];
  grid->GetDimensions(n);
  vtkDataArray* axes[3] = {grid->GetXCoordinates(), grid->GetYCoordinates(), grid->GetZCoordinates()};
  for (int a = 0; a < 3; ++a)
    if (!axes[a] || axes[a]->GetNumberOfTuples() != n[a] || axes[a]->GetNumberOfComponents() != 1)
      throw Error(path + ": an axis has " + std::to_string(axes[a] ? axes[a]->GetNumberOfTuples() : 0) +
                  " coordinates, expected " + std::to_string(n[a]));
  if (toTake) toTake(grid->GetNumberOfPoints() * int64_t(3 * sizeof(double)));
  const auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(grid->GetNumberOfPoints());
  vtkIdType p = 0;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i, ++p)
        points->SetPoint(p, axes[0]->GetComponent(i, 0), axes[1]->GetComponent(j, 0),
                         axes[2]->GetComponent(k, 0));
  const auto set = vtkSmartPointer<vtkStructuredGrid>::New();
  set->SetDimensions(n);
  set->SetPoints(points);
  set->GetPointData()->ShallowCopy(grid->GetPointData());
  set->GetCellData()->ShallowCopy(grid->GetCellData());
  return set;
}

/// Calls ReadWatch's check whenever a VTK reader reports progress. An exception from it ends the reader.
class WatchedProgress : public vtkCommand {
 public:
  static WatchedProgress* New() { return new WatchedProgress; }
  void Execute(vtkObject* reader, unsigned long, void*) override {
    if (thrown_) return;
    try {
      ReadWatch::check();
    } catch (...) {  // No exception may pass through VTK.
      thrown_ = std::current_exception();
      static_cast<vtkAlgorithm*>(reader)->AbortExecuteOn();
    }
  }
  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  std::exception_ptr thrown_;
};

template <class Reader>
vtkSmartPointer<vtkPointSet> outputOf(Reader* reader, const std::string& path, const VtkMessages& messages,
                                      const TakeMemory& toTake) {
  messages.check(path);
  const auto output = reader->GetOutputDataObject(0);
  if (const auto grid = vtkRectilinearGrid::SafeDownCast(output)) return withPoints(grid, path, toTake);
  const auto points = vtkPointSet::SafeDownCast(output);
  if (!points) throw Error(path + ": " + kExpected);
  return points;
}

template <class Reader>
void update(Reader* reader) {
  const auto progress = vtkSmartPointer<WatchedProgress>::New();
  reader->AddObserver(vtkCommand::ProgressEvent, progress);
  reader->Update();
  progress->rethrow();
}

/// VTK's reader of a kind of dataset in XML. What takes long is done here instead: the file has been parsed already, and arrays
/// are read by readXmlArray(). Field data, which are not used and whose sizes are not checked, are not read.
template <class Reader>
class XmlReader final : public Reader {
 public:
  static XmlReader* New() { VTK_STANDARD_NEW_BODY(XmlReader); }

  /// `xml` must be there until the last update.
  void setXml(const VtkXml& xml) {
    xml_ = &xml;
    this->SetFileName(xml.file()->opened().c_str());
  }
  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 protected:
  void CreateXMLParser() override {
    this->XMLParser = xml_->parser();
    this->XMLParser->Register(nullptr);
  }

  int ReadPrimaryElement(vtkXMLDataElement* primary) override {
    const int read = Reader::ReadPrimaryElement(primary);
    this->FieldDataElement = nullptr;
    return read;
  }

  /// Fills `count` values of `array` from number `at` on with those of an element from number `from` on.
  int ReadArrayValues(vtkXMLDataElement* element, vtkIdType at, vtkAbstractArray* array, vtkIdType from,
                      vtkIdType count, typename Reader::FieldType of) override {
    const auto type = scalarOfXmlWord(attribute(element, "type"));
    // Bits, and pieces whose types differ in size, are left to VTK.
    if (!type || int(bytesOf(*type)) != array->GetDataTypeSize() || from != 0)
      return Reader::ReadArrayValues(element, at, array, from, count, of);
    if (this->GetAbortExecute()) return 0;
    try {
      // The array has the type of the first piece.
      const bool isFloat = *type == ScalarType::Float32 || *type == ScalarType::Float64;
      if (isFloat != (array->GetDataType() == VTK_FLOAT || array->GetDataType() == VTK_DOUBLE))
        throw Error(xml_->path() + ": array '" + attribute(element, "Name") + "' is of type " +
                    nameOf(*type) + " in one piece and of another one in another, expected one type");
      const auto values = static_cast<std::byte*>(array->GetVoidPointer(at));
      array->Modified();
      return readXmlArray(*xml_, element, *type, {values, size_t(count) * bytesOf(*type)});
    } catch (...) {  // No exception may pass through VTK.
      thrown_ = std::current_exception();
      this->AbortExecuteOn();
      return 0;
    }
  }

 private:
  const VtkXml* xml_ = nullptr;
  std::exception_ptr thrown_;
};

template <class Reader>
vtkSmartPointer<vtkPointSet> readXml(const std::string& path, const char* type, const TakeMemory& toTake,
                                     const VtkMessages& messages, const std::optional<ArraysNeeded>& needed,
                                     LeftOut* leftOut) {
  const VtkXml xml(path, type);
  const XmlArrays arrays(xml, needed);
  if (toTake) toTake(std::max(arrays.bytes(), xml.file()->size()));
  if (leftOut) *leftOut += arrays.leftOut();
  const auto reader = vtkSmartPointer<XmlReader<Reader>>::New();
  reader->setXml(xml);
  reader->UpdateInformation();
  for (const std::string& name : arrays.pointArraysToPassOver())
    reader->GetPointDataArraySelection()->DisableArray(name.c_str());
  for (const std::string& name : arrays.cellArraysToPassOver())
    reader->GetCellDataArraySelection()->DisableArray(name.c_str());
  update(reader.Get());
  reader->rethrow();
  return outputOf(reader.Get(), path, messages, toTake);
}

std::string bytesOf(const std::string& path, const TakeMemory& toTake) {
  if (toTake) toTake(File::open(path).size());
  return readText(path, std::numeric_limits<int64_t>::max());
}

vtkSmartPointer<vtkPointSet> readLegacy(const std::string& path, const TakeMemory& toTake,
                                        const VtkMessages& messages) {
  std::string bytes = bytesOf(path, toTake);
  if (bytes.size() > size_t(std::numeric_limits<int>::max()))
    throw Error(path + ": " + std::to_string(bytes.size()) +
                " bytes; a file in VTK's legacy form may have at most 2^31 - 1, use .vtu or .vtp");
  checkLegacyVtk(bytes, path);
  const auto reader = vtkSmartPointer<vtkDataSetReader>::New();
  reader->ReadFromInputStringOn();
  reader->SetBinaryInputString(bytes.data(), int(bytes.size()));
  reader->ReadAllScalarsOn();
  reader->ReadAllVectorsOn();
  reader->ReadAllNormalsOn();
  reader->ReadAllFieldsOn();
  update(reader.Get());
  return outputOf(reader.Get(), path, messages, toTake);
}

/// Throws Error unless the offsets rise from 0 to the number of ids, and the ids are those of existing points.
void checkCells(vtkCellArray* cells, vtkIdType points, const std::string& path) {
  if (!cells) return;
  const auto check = [&](const auto* offsets, const auto* ids) {
    const vtkIdType count = offsets->GetNumberOfValues(), idCount = ids->GetNumberOfValues();
    bool ordered =
        count == 0 ? idCount == 0 : offsets->GetValue(0) == 0 && offsets->GetValue(count - 1) == idCount;
    for (vtkIdType i = 1; ordered && i < count; ++i)
      ordered = offsets->GetValue(i - 1) <= offsets->GetValue(i);
    if (!ordered)
      throw Error(path + ": the offsets of the cells do not rise from 0 to the " + std::to_string(idCount) +
                  " point ids that there are");
    for (vtkIdType cell = 0; cell + 1 < count; ++cell) {
      const vtkIdType begin = offsets->GetValue(cell), end = offsets->GetValue(cell + 1);
      for (vtkIdType i = begin; i < end; ++i)
        if (ids->GetValue(i) < 0 || ids->GetValue(i) >= points)
          throw Error(path + ": cell " + std::to_string(cell) + " refers to point " +
                      std::to_string(ids->GetValue(i)) + " of " + std::to_string(points));
    }
  };
  if (cells->IsStorage64Bit())
    check(cells->GetOffsetsArray64(), cells->GetConnectivityArray64());
  else
    check(cells->GetOffsetsArray32(), cells->GetConnectivityArray32());
}

/// Throws Error unless every array, ghost arrays included, has one entry for each of `count` points or cells.
void checkArrays(vtkFieldData* data, vtkIdType count, const char* of, const std::string& path) {
  for (int i = 0; i < data->GetNumberOfArrays(); ++i)
    if (vtkAbstractArray* array = data->GetAbstractArray(i); array->GetNumberOfTuples() != count)
      throw Error(path + ": array '" + (array->GetName() ? array->GetName() : "") + "' has " +
                  std::to_string(array->GetNumberOfTuples()) + " entries for " + std::to_string(count) + " " +
                  of);
}

/// Checks the assumptions of VTK's datasets and of this code that VTK's readers do not check.
void check(vtkPointSet* set, const std::string& path) {
  const vtkIdType points = set->GetNumberOfPoints();
  if (const auto mesh = vtkPolyData::SafeDownCast(set)) {
    checkCells(mesh->GetVerts(), points, path);
    checkCells(mesh->GetLines(), points, path);
    checkCells(mesh->GetPolys(), points, path);
    checkCells(mesh->GetStrips(), points, path);
  } else if (const auto grid = vtkUnstructuredGrid::SafeDownCast(set)) {
    checkCells(grid->GetCells(), points, path);
    const vtkUnsignedCharArray* types = grid->GetCellTypesArray();
    const vtkIdType cells = grid->GetNumberOfCells();
    if (const vtkIdType typed = types ? types->GetNumberOfValues() : 0; typed != cells)
      throw Error(path + ": " + std::to_string(typed) + " cell types for " + std::to_string(cells) +
                  " cells");
    for (vtkIdType cell = 0; cell < cells; ++cell)
      if (types->GetValue(cell) == VTK_PIXEL && grid->GetCells()->GetCellSize(cell) != 4)
        throw Error(path + ": cell " + std::to_string(cell) + " is a pixel, but has not 4 points");
  } else if (const auto lattice = vtkStructuredGrid::SafeDownCast(set)) {
    int n[3];
    lattice->GetDimensions(n);
    if (const vtkIdType wanted = vtkIdType(n[0]) * n[1] * n[2]; points != wanted)
      throw Error(path + ": the grid has " + std::to_string(points) + " points, expected " +
                  std::to_string(wanted));
  } else {
    throw Error(path + ": " + kExpected + ", found " + set->GetClassName());
  }
  checkArrays(set->GetPointData(), points, "points", path);
  checkArrays(set->GetCellData(), set->GetNumberOfCells(), "cells", path);
}

vtkSmartPointer<vtkPointSet> readByExtension(const std::string& path, const TakeMemory& toTake,
                                             const std::optional<ArraysNeeded>& needed, LeftOut* leftOut,
                                             Flaws& flaws) {
  const VtkMessages messages;
  const std::string extension = extensionOf(path);
  if (extension == ".vtu")
    return readXml<vtkXMLUnstructuredGridReader>(path, "UnstructuredGrid", toTake, messages, needed, leftOut);
  if (extension == ".vtp")
    return readXml<vtkXMLPolyDataReader>(path, "PolyData", toTake, messages, needed, leftOut);
  if (extension == ".vts")
    return readXml<vtkXMLStructuredGridReader>(path, "StructuredGrid", toTake, messages, needed, leftOut);
  if (extension == ".vtr")
    return readXml<vtkXMLRectilinearGridReader>(path, "RectilinearGrid", toTake, messages, needed, leftOut);
  if (extension == ".vtk") return readLegacy(path, toTake, messages);
  if (extension == ".ply") return readPly(bytesOf(path, toTake), path, flaws);
  if (extension == ".stl") return readStl(bytesOf(path, toTake), path, flaws);
  if (extension == ".obj") return readObj(bytesOf(path, toTake), path, flaws);
  if (extension == ".off") return readOff(bytesOf(path, toTake), path, flaws);
  if (extension == ".csv") return readCsv(bytesOf(path, toTake), path, flaws);
  if (extension == ".xyz") return readXyz(bytesOf(path, toTake), path, flaws);
  throw Error(path + ": this kind of file cannot be read: expected " + readableFormats());
}

}  // namespace

vtkSmartPointer<vtkPointSet> readPointSet(const std::string& path, const TakeMemory& toTake,
                                          const std::optional<ArraysNeeded>& needed, LeftOut* leftOut,
                                          Flaws* flaws) {
  try {
    Flaws ignored;
    const vtkSmartPointer<vtkPointSet> set =
        readByExtension(path, toTake, needed, leftOut, flaws ? *flaws : ignored);
    check(set, path);
    return set;
  } catch (const std::bad_alloc&) {
    throw Error(path + ": what the file states needs more memory than there is");
  } catch (const std::length_error&) {
    throw Error(path + ": what the file states needs more memory than there is");
  }
}

}  // namespace gxy
