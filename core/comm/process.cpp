// SPDX-License-Identifier: Apache-2.0
#include "core/comm/process.h"

#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

namespace gxy {

ProcessId ProcessId::ofThis() {
  std::string boot;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> boot;
  std::error_code failed;
  const auto space = std::filesystem::read_symlink("/proc/self/ns/pid", failed);
  if (boot.empty() || failed) return {};
  return {boot + " " + space.string(), int32_t(getpid())};
}

WatchedProcess::WatchedProcess(const ProcessId& id) {
  const ProcessId here = ProcessId::ofThis();
  if (id.machine.empty() || id.machine != here.machine || id.number == here.number) return;
  file_ = int(syscall(SYS_pidfd_open, id.number, 0));
}

WatchedProcess::~WatchedProcess() {
  if (file_ >= 0) close(file_);
}

WatchedProcess::WatchedProcess(WatchedProcess&& other) noexcept : file_(std::exchange(other.file_, -1)) {}

WatchedProcess& WatchedProcess::operator=(WatchedProcess&& other) noexcept {
  std::swap(file_, other.file_);
  return *this;
}

bool WatchedProcess::ended() const {
  pollfd asked{file_, POLLIN, 0};
  return file_ >= 0 && poll(&asked, 1, 0) == 1;
}

}  // namespace gxy
