// SPDX-License-Identifier: Apache-2.0
// Legacy VTK structured points. The format gives no positions of its arrays, so the file is read as a whole
// at once.
#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredPoints.h>
#include <vtkStructuredPointsReader.h>

#include "gxy/comm/error.h"
#include "gxy/io/file.h"
#include "gxy/io/volume_description.h"
#include "gxy/io/volume_formats.h"
#include "gxy/io/vtk_messages.h"
#include "gxy/io/vtk_scalars.h"

namespace gxy {
namespace {

class ArraySamples final : public SampleSource {
 public:
  ArraySamples(vtkDataArray* array, const Extent& whole, size_t bytesPerPoint)
      : array_(array), whole_(whole), bytesPerPoint_(bytesPerPoint) {}
  void read(std::span<const Extent> wanted, const TakeSamples& take) const override {
    const std::span data(static_cast<const std::byte*>(array_->GetVoidPointer(0)),
                         size_t(whole_.count()) * bytesPerPoint_);
    for (size_t w = 0; w < wanted.size(); ++w)
      forPieces(wanted[w], kReadBytes / int64_t(bytesPerPoint_), [&](const Extent& piece) {
        take({w, piece, whole_, data});
      });
  }

 private:
  vtkSmartPointer<vtkDataArray> array_;
  Extent whole_;
  size_t bytesPerPoint_;
};

}  // namespace

VolumeFile openLegacyVolume(const std::string& path, const std::string& arrayName) {
  const File opened = File::open(path);
  VtkMessages messages;
  const auto reader = vtkSmartPointer<vtkStructuredPointsReader>::New();
  reader->SetFileName(opened.opened().c_str());
  if (!reader->IsFileStructuredPoints())
    throw Error(path + ": expected a legacy VTK file of STRUCTURED_POINTS");
  reader->ReadAllScalarsOn();
  reader->ReadAllVectorsOn();
  reader->ReadAllFieldsOn();
  reader->Update();
  messages.check(path);
  vtkImageData* image = reader->GetOutput();

  VolumeFile file;
  file.path = path;
  int dimensions[3];
  image->GetDimensions(dimensions);
  for (int a = 0; a < 3; ++a) {
    file.grid.points[size_t(a)] = dimensions[a];
    file.grid.origin[a] = image->GetOrigin()[a];
    file.grid.spacing[a] = image->GetSpacing()[a];
  }
  vtkPointData* data = image->GetPointData();
  for (int i = 0; i < data->GetNumberOfArrays(); ++i) {
    vtkDataArray* array = data->GetArray(i);
    const auto type = array ? scalarOfVtk(array->GetDataType()) : std::nullopt;
    if (type && array->GetName())
      file.arrays.push_back({array->GetName(), *type, array->GetNumberOfComponents(), {}});
  }
  vtkDataArray* active = data->GetScalars();
  file.array =
      chooseArray(file.arrays, arrayName, active && active->GetName() ? active->GetName() : "", path);
  checkGrid(file.grid, file.array.type, file.array.components, path);
  vtkDataArray* chosen = data->GetArray(file.array.name.c_str());
  const Extent whole = wholeOf(file.grid);
  if (chosen->GetNumberOfTuples() != whole.count())
    throw Error(path + ": array '" + file.array.name + "' has " +
                std::to_string(chosen->GetNumberOfTuples()) + " values, expected " +
                std::to_string(whole.count()));
  file.source = std::make_shared<ArraySamples>(chosen, whole, file.bytesPerPoint());
  return file;
}

}  // namespace gxy
