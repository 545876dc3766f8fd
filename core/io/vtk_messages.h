// SPDX-License-Identifier: Apache-2.0
// Catches the messages that VTK would print while it reads or writes a file.
#pragma once
#include <string>

namespace gxy {

/// While one exists, it collects VTK's errors and warnings of this thread. VTK's messages outside of such a
/// scope, and on other threads, go where they went before.
class VtkMessages {
 public:
  VtkMessages();
  ~VtkMessages();
  VtkMessages(const VtkMessages&) = delete;
  VtkMessages& operator=(const VtkMessages&) = delete;

  /// Throws Error with `path` and the first error's text, if there was an error.
  void check(const std::string& path) const;
  const std::string& error() const { return error_; }

  void addError(const char* text);
  /// Keeps the warning as an error if it reports a failure, and ignores it otherwise.
  void addWarning(const char* text);

 private:
  VtkMessages* outer_;
  std::string error_;
};

}  // namespace gxy
