// SPDX-License-Identifier: Apache-2.0
// Processes of this machine, and whether they have ended.
#pragma once
#include <cstdint>
#include <string>

namespace gxy {

/// Names a process to others: they can watch it if they are on the same machine.
struct ProcessId {
  std::string machine;  ///< its boot and its space of process numbers; empty: nobody can watch it
  int32_t number = 0;

  static ProcessId ofThis();
};

/// Watches another process (Linux's pidfd). Knows nothing of one on another machine, and of this process itself.
class WatchedProcess {
 public:
  WatchedProcess() = default;
  explicit WatchedProcess(const ProcessId& id);
  ~WatchedProcess();
  WatchedProcess(WatchedProcess&& other) noexcept;
  WatchedProcess& operator=(WatchedProcess&& other) noexcept;

  /// It has certainly ended. True as soon as the kernel has ended it, before its parent is told.
  bool ended() const;

 private:
  int file_ = -1;
};

}  // namespace gxy
