// SPDX-License-Identifier: Apache-2.0
// Watches processes of this machine for their end.
#pragma once
#include <cstdint>
#include <string>

namespace gxy {

/// Names a process, so that other processes on the same machine can watch it.
struct ProcessId {
  std::string machine;  ///< boot id and process-id namespace; empty: nobody can watch the process
  int32_t number = 0;

  static ProcessId ofThis();
};

/// Watches another process on this machine (Linux's pidfd). It cannot watch a process on another machine, nor
/// its own process: ended() is false for these.
class WatchedProcess {
 public:
  WatchedProcess() = default;
  explicit WatchedProcess(const ProcessId& id);
  ~WatchedProcess();
  WatchedProcess(WatchedProcess&& other) noexcept;
  WatchedProcess& operator=(WatchedProcess&& other) noexcept;

  /// True if the process has certainly ended: as soon as the kernel has ended it, before its parent is told.
  bool ended() const;

 private:
  int file_ = -1;
};

}  // namespace gxy
