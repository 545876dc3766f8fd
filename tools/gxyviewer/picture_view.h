// SPDX-License-Identifier: Apache-2.0
// The content of the user's window: the picture, a status line over it, and the help text.
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

/// Draws on the display in draw(). One thread uses it.
class PictureView {
 public:
  explicit PictureView(glm::ivec2 size);

  vtkRenderWindow& window() { return *window_; }
  vtkRenderer& renderer() { return *renderer_; }
  glm::ivec2 size() const;

  /// Places the texts for the present size of the window.
  void layOut();
  /// Sets the picture, with the overlay drawn over it.
  void setPicture(const Canvas& canvas, const Overlay& overlay);
  /// Sets the status line. Returns whether it has changed.
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
