// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/png.h"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>

#include "core/comm/error.h"
#include "core/image/replace_file.h"

namespace gxy {

void writePng(const std::string& path, const Canvas& canvas, const Overlay& overlay) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(canvas.size().x, canvas.size().y, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 4);
  std::copy(canvas.rgba().begin(), canvas.rgba().end(), static_cast<uint8_t*>(image->GetScalarPointer()));
  auto* const rgba = static_cast<uint8_t*>(image->GetScalarPointer());
  draw(overlay, canvas.size(), [&](int x, int y, const glm::dvec3& color, double coverage) {
    uint8_t* const pixel = rgba + 4 * (size_t(y) * size_t(canvas.size().x) + size_t(x));
    const double behind = (1 - coverage) * pixel[3] / 255, alpha = coverage + behind;
    for (int c = 0; c < 3; c++)
      pixel[c] = uint8_t(std::lround((255 * coverage * color[c] + behind * pixel[c]) / alpha));
    pixel[3] = uint8_t(std::lround(255 * alpha));
  });
  vtkNew<vtkPNGWriter> writer;
  writer->WriteToMemoryOn();
  writer->SetInputData(image);
  writer->Write();
  vtkUnsignedCharArray* const bytes = writer->GetResult();
  if (!bytes || bytes->GetNumberOfValues() == 0) throw Error(path + ": the picture could not be encoded");
  replaceFile(path, std::as_bytes(std::span(bytes->GetPointer(0), size_t(bytes->GetNumberOfValues()))));
}

}  // namespace gxy
