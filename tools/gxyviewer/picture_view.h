// SPDX-License-Identifier: Apache-2.0
// What the user's window shows: the picture, the line of status over it, and the help.
#pragma once
#include <vtkActor2D.h>
#include <vtkImageData.h>
#include <vtkImageMapper.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>

#include <string>

#include "core/annotate/overlay.h"
#include "tools/gxyviewer/canvas.h"

namespace gxy {

/// Draws on the display when it is told to. Of one thread.
class PictureView {
 public:
  explicit PictureView(glm::ivec2 size);

  vtkRenderWindow& window() { return *window_; }
  vtkRenderer& renderer() { return *renderer_; }
  glm::ivec2 size() const;

  /// Puts texts where they belong in a window of the size that it has now.
  void layOut();
  /// With the overlay over it.
  void setPicture(const Canvas& canvas, const Overlay& overlay);
  /// True if it is another than before.
  bool setStatus(const std::string& text);
  void turnHelp();
  void draw() { window_->Render(); }

 private:
  vtkNew<vtkImageData> image_;
  vtkNew<vtkImageMapper> mapper_;
  vtkNew<vtkActor2D> picture_;
  vtkNew<vtkTextActor> status_, help_;
  vtkNew<vtkRenderer> renderer_;
  vtkNew<vtkRenderWindow> window_;
  std::string text_;
};

}  // namespace gxy
