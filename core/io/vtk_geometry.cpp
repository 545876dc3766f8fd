// SPDX-License-Identifier: Apache-2.0
#include "gxy/io/vtk_geometry.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDataSetReader.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <limits>
#include <new>
#include <stdexcept>

#include "gxy/comm/error.h"
#include "gxy/io/file.h"
#include "gxy/io/legacy_vtk.h"
#include "gxy/io/obj_reader.h"
#include "gxy/io/ply_reader.h"
#include "gxy/io/stl_reader.h"
#include "gxy/io/vtk_messages.h"

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

template <class Reader>
vtkSmartPointer<vtkPointSet> readXml(const std::string& path, const VtkMessages& messages) {
  const File file = File::open(path);
  const auto reader = vtkSmartPointer<Reader>::New();
  reader->SetFileName(file.opened().c_str());
  return outputOf(reader.Get(), path, messages);
}

std::string bytesOf(const std::string& path) { return readText(path, std::numeric_limits<int64_t>::max()); }

vtkSmartPointer<vtkPointSet> readLegacy(const std::string& path, const VtkMessages& messages) {
  std::string bytes = bytesOf(path);
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

vtkSmartPointer<vtkPointSet> readByExtension(const std::string& path) {
  const VtkMessages messages;
  const std::string extension = extensionOf(path);
  if (extension == ".vtu") return readXml<vtkXMLUnstructuredGridReader>(path, messages);
  if (extension == ".vtp") return readXml<vtkXMLPolyDataReader>(path, messages);
  if (extension == ".vtk") return readLegacy(path, messages);
  if (extension == ".ply") return readPly(bytesOf(path), path);
  if (extension == ".stl") return readStl(bytesOf(path), path);
  if (extension == ".obj") return readObj(bytesOf(path), path);
  throw Error(path +
              ": not a geometry file: expected .vtu, .vtp, .vtk, .ply, .stl, .obj, .pvtu, .pvtp or .part");
}

}  // namespace

vtkSmartPointer<vtkPointSet> readPointSet(const std::string& path) {
  try {
    const vtkSmartPointer<vtkPointSet> set = readByExtension(path);
    check(set, path);
    return set;
  } catch (const std::bad_alloc&) {
    throw Error(path + ": what the file states needs more memory than there is");
  } catch (const std::length_error&) {
    throw Error(path + ": what the file states needs more memory than there is");
  }
}

}  // namespace gxy
