// SPDX-License-Identifier: Apache-2.0
#include "gxy/io/vtk_geometry.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataArraySelection.h>
#include <vtkDataSetAttributes.h>
#include <vtkDataSetReader.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <limits>
#include <new>
#include <set>
#include <stdexcept>

#include "gxy/comm/error.h"
#include "gxy/io/file.h"
#include "gxy/io/legacy_vtk.h"
#include "gxy/io/obj_reader.h"
#include "gxy/io/ply_reader.h"
#include "gxy/io/stl_reader.h"
#include "gxy/io/volume_file.h"
#include "gxy/io/vtk_messages.h"
#include "gxy/io/vtk_xml.h"

namespace gxy {
namespace {

template <class Reader>
vtkSmartPointer<vtkPointSet> outputOf(Reader* reader, const std::string& path, const VtkMessages& messages) {
  reader->Update();
  messages.check(path);
  const auto points = vtkPointSet::SafeDownCast(reader->GetOutputDataObject(0));
  if (!points) throw Error(path + ": expected polygonal data or an unstructured grid");
  return points;
}

/// What VTK's readers of .vtp and .vtu would allocate for a file, array by array, and which arrays they are not to read.
/// Walks through all that stands in the pieces, as of two elements of one name a reader may take either.
class Arrays {
 public:
  Arrays(const VtkXml& xml, const std::optional<ArraysNeeded>& needed) : xml_(xml), all_(!needed) {
    std::vector<vtkXMLDataElement*> pieces;
    for (int i = 0; i < xml.data()->GetNumberOfNestedElements(); ++i)
      if (isNamed(xml.data()->GetNestedElement(i), "Piece"))
        pieces.push_back(xml.data()->GetNestedElement(i));
    several_ = pieces.size() > 1;
    for (vtkXMLDataElement* piece : pieces)
      for (int i = 0; needed && i < piece->GetNumberOfNestedElements(); ++i)
        if (isNamed(piece->GetNestedElement(i), "PointData")) choose(piece->GetNestedElement(i), *needed);
    for (vtkXMLDataElement* piece : pieces) addPiece(piece);
  }

  int64_t bytes() const { return bytes_; }
  /// Names of arrays that are not needed, and of those of strings, which take what no attribute states, and of unknown
  /// types, of which no use is made.
  const std::set<std::string>& pointArraysToPassOver() const { return points_; }
  const std::set<std::string>& cellArraysToPassOver() const { return cells_; }
  const LeftOut& leftOut() const { return leftOut_; }

 private:
  static bool isNamed(vtkXMLDataElement* element, std::string_view name) {
    return element->GetName() == name;
  }

  bool holdsNumbers(vtkXMLDataElement* array) const { return xml_.statedBytes(array, 1) != 0; }

  // Of a list of point arrays, what geometry is made of: as chooseValues() and unitNormals() choose when all are there.
  void choose(vtkXMLDataElement* list, const ArraysNeeded& needed) {
    const std::string scalars = attribute(list, "Scalars"), normals = attribute(list, "Normals"),
                      textures = attribute(list, "TCoords");
    std::string first;
    std::set<std::string> names;
    for (int i = 0; i < list->GetNumberOfNestedElements(); ++i) {
      vtkXMLDataElement* array = list->GetNestedElement(i);
      const std::string name = attribute(array, "Name");
      if (name.empty() || !holdsNumbers(array)) continue;
      names.insert(name);
      if (isNameOfNormals(name) || name == normals) {
        if (needed.normals) chosen_.insert(name);
        if (name == normals || attribute(array, "NumberOfComponents") == "3") continue;
      }
      if (first.empty() && name != textures && name != vtkDataSetAttributes::GhostArrayName()) first = name;
    }
    if (needed.values.empty()) {
      chosen_.insert(names.count(scalars) ? scalars : names.count("data") ? "data" : first);
    } else if (names.count(needed.values)) {
      chosen_.insert(needed.values);
    } else {
      all_ = true;  // and who asked says what there is
    }
  }

  bool isPassedOver(vtkXMLDataElement* array, bool ofCells) const {
    const std::string name = attribute(array, "Name");
    if (!holdsNumbers(array)) return true;
    return !all_ && name != vtkDataSetAttributes::GhostArrayName() && (ofCells || !chosen_.count(name));
  }

  int64_t count(vtkXMLDataElement* piece, const char* attribute) const {
    long long n = 0;
    if (piece->GetAttribute(attribute) && (!piece->GetScalarAttribute(attribute, n) || n < 0))
      throw Error(xml_.path() + ": attribute " + attribute + " of a <Piece>: expected a number, 0 or more");
    return n;
  }

  void addPiece(vtkXMLDataElement* piece) {
    const int64_t points = count(piece, "NumberOfPoints"), gridCells = count(piece, "NumberOfCells");
    int64_t cells = gridCells;
    for (const char* kind : kKinds) {
      const int64_t some = count(piece, (std::string("NumberOf") + kind).c_str());
      cells = sum(cells, some);
      add(some, sizeof(int64_t));  // where vtkPolyData finds its cells
      for (int i = 0; i < piece->GetNumberOfNestedElements(); ++i)
        if (isNamed(piece->GetNestedElement(i), kind)) addCells(piece->GetNestedElement(i), some);
    }
    for (int i = 0; i < piece->GetNumberOfNestedElements(); ++i) {
      vtkXMLDataElement* group = piece->GetNestedElement(i);
      if (isNamed(group, "Points") || isNamed(group, "PointData")) addArrays(group, points);
      if (isNamed(group, "CellData")) addArrays(group, cells);
      if (isNamed(group, "Cells")) addCells(group, gridCells);
    }
  }

  void addArrays(vtkXMLDataElement* group, int64_t tuples) {
    std::set<std::string> names;
    for (int i = 0; i < group->GetNumberOfNestedElements(); ++i) {
      vtkXMLDataElement* array = group->GetNestedElement(i);
      const std::string name = attribute(array, "Name");
      // VTK's readers count arrays, but make one of those of one name, and look for the others of cells nowhere.
      if (isNamed(group, "CellData") && array->GetAttribute("Name") && !names.insert(name).second)
        throw Error(xml_.path() + ": array '" + name + "' is there twice in one list");
      const bool ofCells = isNamed(group, "CellData");
      if (isNamed(group, "Points") ? !holdsNumbers(array) : isPassedOver(array, ofCells)) {
        (ofCells ? cells_ : points_).insert(name);
        leftOut_ += {.arrays = 1, .bytes = uint64_t(xml_.statedBytes(array, tuples))};
        continue;
      }
      const int64_t bytes = xml_.statedBytes(array, tuples);
      xml_.checkCompressed(array, bytes);
      add(bytes, 1);
    }
  }

  void addCells(vtkXMLDataElement* group, int64_t cells) {
    for (int i = 0; i < group->GetNumberOfNestedElements(); ++i) {
      vtkXMLDataElement* array = group->GetNestedElement(i);
      const std::string name = attribute(array, "Name");
      if (cells == 0 && name != "types") continue;  // VTK's readers pass over them
      int64_t bytes = 0;
      if (name == "offsets" || name == "types" || name == "faceoffsets") {
        bytes = xml_.statedBytes(array, cells);
        xml_.checkCompressed(array, bytes);
      } else if (name == "connectivity" || name == "faces") {
        bytes = xml_.dataBytes(array);  // as long as the last offset says, which is not known yet
      }
      add(bytes, 1);
      const int64_t each = xml_.statedBytes(array, 1);
      if (each == 0 || name == "types") continue;
      // Copied to what vtkCellArray may have instead, and when the cells of further pieces are appended.
      if (attribute(array, "type") != "Int64" || several_) add(bytes / each, sizeof(int64_t));
    }
  }

  int64_t sum(int64_t a, int64_t b) const {
    if (__builtin_add_overflow(a, b, &a)) tooLarge();
    return a;
  }
  void add(int64_t n, int64_t each) {
    if (__builtin_mul_overflow(n, each, &n)) tooLarge();
    bytes_ = sum(bytes_, n);
  }
  [[noreturn]] void tooLarge() const { throw Error(xml_.path() + ": its arrays have more than 2^63 bytes"); }

  static constexpr const char* kKinds[] = {"Verts", "Lines", "Strips", "Polys"};

  const VtkXml& xml_;
  int64_t bytes_ = 0;
  bool several_ = false, all_;
  std::set<std::string> chosen_;  ///< of points
  std::set<std::string> points_, cells_;
  LeftOut leftOut_;
};

template <class Reader>
vtkSmartPointer<vtkPointSet> readXml(const std::string& path, const char* type, const TakeMemory& toTake,
                                     const VtkMessages& messages, const std::optional<ArraysNeeded>& needed,
                                     LeftOut* leftOut) {
  const auto reader = vtkSmartPointer<WithoutFieldData<Reader>>::New();
  std::shared_ptr<const File> file;
  {
    const VtkXml xml(path, type);
    const Arrays arrays(xml, needed);
    if (toTake) toTake(std::max(arrays.bytes(), xml.file()->size()));
    if (leftOut) *leftOut += arrays.leftOut();
    file = xml.file();
    reader->SetFileName(file->opened().c_str());
    reader->UpdateInformation();
    for (const std::string& name : arrays.pointArraysToPassOver())
      reader->GetPointDataArraySelection()->DisableArray(name.c_str());
    for (const std::string& name : arrays.cellArraysToPassOver())
      reader->GetCellDataArraySelection()->DisableArray(name.c_str());
  }
  return outputOf(reader.Get(), path, messages);
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
  return outputOf(reader.Get(), path, messages);
}

/// Offsets that rise from 0 to the number of ids, cells of at least `least` ids, and ids that are those of
/// points.
void checkCells(vtkCellArray* cells, vtkIdType least, vtkIdType points, const std::string& path) {
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
      if (end - begin < least)
        throw Error(path + ": cell " + std::to_string(cell) + " has " + std::to_string(end - begin) +
                    " points, expected at least " + std::to_string(least));
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

/// One entry for each of `count` points or cells in every array, that of ghosts included.
void checkArrays(vtkFieldData* data, vtkIdType count, const char* of, const std::string& path) {
  for (int i = 0; i < data->GetNumberOfArrays(); ++i)
    if (vtkAbstractArray* array = data->GetAbstractArray(i); array->GetNumberOfTuples() != count)
      throw Error(path + ": array '" + (array->GetName() ? array->GetName() : "") + "' has " +
                  std::to_string(array->GetNumberOfTuples()) + " entries for " + std::to_string(count) + " " +
                  of);
}

/// What VTK's readers do not check and its data sets, and we, rely on.
void check(vtkPointSet* set, const std::string& path) {
  const vtkIdType points = set->GetNumberOfPoints();
  if (const auto mesh = vtkPolyData::SafeDownCast(set)) {
    checkCells(mesh->GetVerts(), 1, points, path);
    checkCells(mesh->GetLines(), 2, points, path);
    checkCells(mesh->GetPolys(), 3, points, path);
    checkCells(mesh->GetStrips(), 3, points, path);
  } else if (const auto grid = vtkUnstructuredGrid::SafeDownCast(set)) {
    checkCells(grid->GetCells(), 0, points, path);
    const vtkUnsignedCharArray* types = grid->GetCellTypesArray();
    const vtkIdType cells = grid->GetNumberOfCells();
    if (const vtkIdType typed = types ? types->GetNumberOfValues() : 0; typed != cells)
      throw Error(path + ": " + std::to_string(typed) + " cell types for " + std::to_string(cells) +
                  " cells");
    for (vtkIdType cell = 0; cell < cells; ++cell)
      if (types->GetValue(cell) == VTK_PIXEL && grid->GetCells()->GetCellSize(cell) != 4)
        throw Error(path + ": cell " + std::to_string(cell) + " is a pixel, but has not 4 points");
  } else {
    throw Error(path + ": expected polygonal data or an unstructured grid, found " + set->GetClassName());
  }
  checkArrays(set->GetPointData(), points, "points", path);
  checkArrays(set->GetCellData(), set->GetNumberOfCells(), "cells", path);
}

vtkSmartPointer<vtkPointSet> readByExtension(const std::string& path, const TakeMemory& toTake,
                                             const std::optional<ArraysNeeded>& needed, LeftOut* leftOut) {
  const VtkMessages messages;
  const std::string extension = extensionOf(path);
  if (extension == ".vtu")
    return readXml<vtkXMLUnstructuredGridReader>(path, "UnstructuredGrid", toTake, messages, needed, leftOut);
  if (extension == ".vtp")
    return readXml<vtkXMLPolyDataReader>(path, "PolyData", toTake, messages, needed, leftOut);
  if (extension == ".vtk") return readLegacy(path, toTake, messages);
  if (extension == ".ply") return readPly(bytesOf(path, toTake), path);
  if (extension == ".stl") return readStl(bytesOf(path, toTake), path);
  if (extension == ".obj") return readObj(bytesOf(path, toTake), path);
  throw Error(path + ": this kind of file cannot be read: expected " + readableFormats());
}

}  // namespace

bool isNameOfNormals(std::string_view name) { return name == "Normals" || name == "Normals_"; }

vtkSmartPointer<vtkPointSet> readPointSet(const std::string& path, const TakeMemory& toTake,
                                          const std::optional<ArraysNeeded>& needed, LeftOut* leftOut) {
  try {
    const vtkSmartPointer<vtkPointSet> set = readByExtension(path, toTake, needed, leftOut);
    check(set, path);
    return set;
  } catch (const std::bad_alloc&) {
    throw Error(path + ": what the file states needs more memory than there is");
  } catch (const std::length_error&) {
    throw Error(path + ": what the file states needs more memory than there is");
  }
}

}  // namespace gxy
