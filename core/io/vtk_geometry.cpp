// SPDX-License-Identifier: Apache-2.0
#include "gxy/io/vtk_geometry.h"

#include <vtkDataSetReader.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include "gxy/comm/error.h"
#include "gxy/io/file.h"
#include "gxy/io/vtk_messages.h"

namespace gxy {
namespace {

template <class Reader>
vtkSmartPointer<vtkPointSet> readWith(Reader* reader, const std::string& path, const VtkMessages& messages) {
  reader->SetFileName(path.c_str());
  reader->Update();
  messages.check(path);
  const auto points = vtkPointSet::SafeDownCast(reader->GetOutputDataObject(0));
  if (!points) throw Error(path + ": expected polygonal data or an unstructured grid");
  return points;
}

vtkSmartPointer<vtkPointSet> readLegacy(const std::string& path, const VtkMessages& messages) {
  const auto reader = vtkSmartPointer<vtkDataSetReader>::New();
  reader->ReadAllScalarsOn();
  reader->ReadAllVectorsOn();
  reader->ReadAllNormalsOn();
  reader->ReadAllFieldsOn();
  return readWith(reader.Get(), path, messages);
}

}  // namespace

vtkSmartPointer<vtkPointSet> readPointSet(const std::string& path) {
  File::open(path);
  VtkMessages messages;
  const std::string extension = extensionOf(path);
  vtkSmartPointer<vtkPointSet> set;
  if (extension == ".vtu") {
    set = readWith(vtkSmartPointer<vtkXMLUnstructuredGridReader>::New().Get(), path, messages);
  } else if (extension == ".vtp") {
    set = readWith(vtkSmartPointer<vtkXMLPolyDataReader>::New().Get(), path, messages);
  } else if (extension == ".vtk") {
    set = readLegacy(path, messages);
  } else if (extension == ".ply") {
    set = readWith(vtkSmartPointer<vtkPLYReader>::New().Get(), path, messages);
  } else if (extension == ".stl") {
    const auto reader = vtkSmartPointer<vtkSTLReader>::New();
    reader->MergingOff();  // every facet stays, in file order
    set = readWith(reader.Get(), path, messages);
  } else if (extension == ".obj") {
    set = readWith(vtkSmartPointer<vtkOBJReader>::New().Get(), path, messages);
  } else {
    throw Error(path +
                ": not a geometry file: expected .vtu, .vtp, .vtk, .ply, .stl, .obj, .pvtu, .pvtp or .part");
  }
  if (!vtkPolyData::SafeDownCast(set) && !vtkUnstructuredGrid::SafeDownCast(set))
    throw Error(path + ": expected polygonal data or an unstructured grid, found " + set->GetClassName());
  return set;
}

}  // namespace gxy
