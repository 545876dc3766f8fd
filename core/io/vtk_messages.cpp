// SPDX-License-Identifier: Apache-2.0
#include "gxy/io/vtk_messages.h"

#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <mutex>

#include "gxy/comm/error.h"

namespace gxy {
namespace {

thread_local VtkMessages* scope = nullptr;  ///< innermost on this thread

/// Hands messages to the scope of the calling thread, or to the window that was there before.
class CapturingWindow : public vtkOutputWindow {
 public:
  static CapturingWindow* New();
  vtkTypeMacro(CapturingWindow, vtkOutputWindow);
  void DisplayText(const char* text) override {
    if (!scope) previous_->DisplayText(text);
  }
  void DisplayErrorText(const char* text) override {
    if (scope)
      scope->addError(text);
    else
      previous_->DisplayErrorText(text);
  }
  void DisplayWarningText(const char* text) override {
    if (!scope) previous_->DisplayWarningText(text);
  }
  void DisplayGenericWarningText(const char* text) override {
    if (!scope) previous_->DisplayGenericWarningText(text);
  }
  void DisplayDebugText(const char* text) override {
    if (!scope) previous_->DisplayDebugText(text);
  }

  vtkSmartPointer<vtkOutputWindow> previous_;
};
vtkStandardNewMacro(CapturingWindow);

void installOnce() {
  static std::once_flag installed;
  std::call_once(installed, [] {
    const auto window = vtkSmartPointer<CapturingWindow>::New();
    window->previous_ = vtkOutputWindow::GetInstance();
    vtkOutputWindow::SetInstance(window);
  });
}

}  // namespace

VtkMessages::VtkMessages() : outer_(scope) {
  installOnce();
  scope = this;
}

VtkMessages::~VtkMessages() { scope = outer_; }

void VtkMessages::check(const std::string& path) const {
  if (!error_.empty()) throw Error(path + ": " + error_);
}

void VtkMessages::addError(const char* text) {
  if (!error_.empty()) return;
  // "ERROR: In file.cxx, line 12\nvtkClass (0x1234): what happened\n\n": keep what happened, on one line.
  error_ = text;
  if (const size_t object = error_.find("): "); object != std::string::npos) error_.erase(0, object + 3);
  while (!error_.empty() && (error_.back() == '\n' || error_.back() == ' ')) error_.pop_back();
  for (char& c : error_)
    if (c == '\n' || c == '\r') c = ' ';
  if (error_.empty()) error_ = "the file could not be processed";
}

}  // namespace gxy
