// SPDX-License-Identifier: Apache-2.0
#include "png.h"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>

#include "gxy/comm/error.h"
#include "gxy/io/replace_file.h"

namespace gxy {

void writePng(const std::string& path, const Canvas& canvas) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(canvas.size().x, canvas.size().y, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 4);
  std::copy(canvas.rgba().begin(), canvas.rgba().end(), static_cast<uint8_t*>(image->GetScalarPointer()));
  vtkNew<vtkPNGWriter> writer;
  writer->WriteToMemoryOn();
  writer->SetInputData(image);
  writer->Write();
  vtkUnsignedCharArray* const bytes = writer->GetResult();
  if (!bytes || bytes->GetNumberOfValues() == 0) throw Error(path + ": the picture could not be encoded");
  replaceFile(path, std::as_bytes(std::span(bytes->GetPointer(0), size_t(bytes->GetNumberOfValues()))));
}

}  // namespace gxy
