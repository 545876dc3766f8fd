// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/picture_view.h"

#include <vtkProperty2D.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>

#include "tools/gxyviewer/keys.h"

namespace gxy {

namespace {

void place(vtkTextActor& text, int fontSize, int left, bool fixedWidth) {
  vtkTextProperty& p = *text.GetTextProperty();
  p.SetFontSize(fontSize);
  p.SetColor(1, 1, 1);
  p.SetBackgroundColor(0, 0, 0);
  p.SetBackgroundOpacity(0.6);
  if (fixedWidth) p.SetFontFamilyToCourier();
  text.SetPosition(left, 8);
}

}  // namespace

PictureView::PictureView(glm::ivec2 size) {
  renderer_->SetBackground(0, 0, 0);
  mapper_->SetColorWindow(255);
  mapper_->SetColorLevel(127.5);
  mapper_->SetInputData(image_);
  picture_->SetMapper(mapper_);
  picture_->GetProperty()->SetDisplayLocationToBackground();
  place(*status_, 14, 10, false);
  place(*help_, 15, 0, true);
  help_->SetInput(kKeyHelp);
  help_->GetTextProperty()->SetVerticalJustificationToTop();
  help_->VisibilityOff();
  renderer_->AddActor2D(picture_);
  renderer_->AddActor2D(status_);
  renderer_->AddActor2D(help_);
  window_->AddRenderer(renderer_);
  window_->SetMultiSamples(0);
  window_->SetSize(size.x, size.y);
  window_->SetWindowName("gxyviewer");
}

glm::ivec2 PictureView::size() const {
  const int* const size = window_->GetSize();
  return {size[0], size[1]};
}

// The help text is in the upper left corner, as large as fits into the window.
void PictureView::layOut() {
  const glm::ivec2 now = size();
  help_->GetTextProperty()->SetFontSize(std::clamp(std::min(now.x / 40, now.y / 30), 7, 15));
  help_->SetPosition(10, now.y - 10);
}

// The picture is blended over black, as in JPEG.
void PictureView::setPicture(const Canvas& canvas, const Overlay& overlay) {
  const int width = canvas.size().x, height = canvas.size().y;
  if (image_->GetDimensions()[0] != width || image_->GetDimensions()[1] != height ||
      !image_->GetScalarPointer()) {
    image_->SetDimensions(width, height, 1);
    image_->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  }
  auto* to = static_cast<uint8_t*>(image_->GetScalarPointer());
  const std::span<const uint8_t> from = canvas.rgba();
  for (size_t i = 0; i < from.size(); i += 4)
    for (size_t c = 0; c < 3; c++) *to++ = uint8_t((from[i + c] * from[i + 3] + 127) / 255);
  auto* const rgb = static_cast<uint8_t*>(image_->GetScalarPointer());
  gxy::draw(overlay, canvas.size(), [&](int x, int y, const glm::dvec3& color, double coverage) {
    uint8_t* const pixel = rgb + 3 * (size_t(y) * size_t(width) + size_t(x));
    for (int c = 0; c < 3; c++)
      pixel[c] = uint8_t(std::lround(255 * coverage * color[c] + (1 - coverage) * pixel[c]));
  });
  image_->Modified();
}

bool PictureView::setStatus(const std::string& text) {
  if (text == text_) return false;
  text_ = text;
  status_->SetInput(text.c_str());
  return true;
}

void PictureView::turnHelp() {
  help_->SetVisibility(!help_->GetVisibility());
  draw();
}

}  // namespace gxy
