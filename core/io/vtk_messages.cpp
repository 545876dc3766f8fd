// SPDX-License-Identifier: Apache-2.0
#include "core/io/vtk_messages.h"

#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <mutex>
#include <string_view>

#include "core/comm/error.h"

namespace gxy {
namespace {

thread_local VtkMessages* scope = nullptr;  ///< innermost on this thread

/// Passes messages to the scope of the calling thread, or else to the window that was set before.
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
    if (scope)
      scope->addWarning(text);
    else
      previous_->DisplayWarningText(text);
  }
  void DisplayGenericWarningText(const char* text) override {
    if (scope)
      scope->addWarning(text);
    else
      previous_->DisplayGenericWarningText(text);
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

/// VTK's logger prints to standard error in addition to the window. While any scope lives, it is silent in
/// the whole process; afterwards it gets its verbosity back.
class QuietLogger {
 public:
  void enter() {
    const std::lock_guard lock(mutex_);
    if (scopes_++ > 0) return;
    before_ = vtkLogger::GetCurrentVerbosityCutoff();
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  }
  void leave() {
    const std::lock_guard lock(mutex_);
    if (--scopes_ == 0) vtkLogger::SetStderrVerbosity(before_);
  }

 private:
  std::mutex mutex_;
  int scopes_ = 0;
  vtkLogger::Verbosity before_ = vtkLogger::VERBOSITY_INFO;
};
QuietLogger logger;

}  // namespace

VtkMessages::VtkMessages() : outer_(scope) {
  installOnce();
  logger.enter();
  scope = this;
}

VtkMessages::~VtkMessages() {
  scope = outer_;
  logger.leave();
}

void VtkMessages::addWarning(const char* text) {
  // The legacy readers report truncated data as a warning only.
  const std::string_view warning(text);
  for (const char* failure : {"Error", "error", "remature", "annot read", "Unable"})
    if (warning.find(failure) != std::string_view::npos) return addError(text);
}

void VtkMessages::check(const std::string& path) const {
  if (error_.empty()) return;
  // Readers get open files by File::opened(), but users know them by their paths.
  const std::string opened = "/proc/self/fd/";
  std::string text = error_;
  for (size_t at = text.find(opened); at != std::string::npos; at = text.find(opened, at + path.size()))
    text.replace(at, text.find_first_not_of("0123456789", at + opened.size()) - at, path);
  throw Error(path + ": " + text);
}

void VtkMessages::addError(const char* text) {
  if (!error_.empty()) return;
  // The text is "ERROR: In file.cxx, line 12\nvtkClass (0x1234): what happened\n\n". Only "what happened" is
  // kept, on one line.
  error_ = text;
  if (const size_t object = error_.find("): "); object != std::string::npos) error_.erase(0, object + 3);
  while (!error_.empty() && (error_.back() == '\n' || error_.back() == ' ')) error_.pop_back();
  for (char& c : error_)
    if (c == '\n' || c == '\r') c = ' ';
  if (error_.empty()) error_ = "the file could not be processed";
}

}  // namespace gxy
