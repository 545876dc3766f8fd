// SPDX-License-Identifier: Apache-2.0
// What VTK reports while it reads or writes a file, caught instead of printed.
#pragma once
#include <string>

namespace gxy {

/// While one exists, VTK's errors and warnings raised on this thread are kept here. Outside of such scopes,
/// and on other threads, VTK's messages go where they went before.
class VtkMessages {
 public:
  VtkMessages();
  ~VtkMessages();
  VtkMessages(const VtkMessages&) = delete;
  VtkMessages& operator=(const VtkMessages&) = delete;

  /// Throws Error with the first error's text, if there was any.
  void check(const std::string& path) const;
  const std::string& error() const { return error_; }

  void addError(const char* text);
  /// Kept only if it tells of a failure.
  void addWarning(const char* text);

 private:
  VtkMessages* outer_;
  std::string error_;
};

}  // namespace gxy
