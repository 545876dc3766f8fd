// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/file_watch.h"

namespace gxy {

namespace {
constexpr std::chrono::milliseconds kBetweenLooks{500};
}

bool FileWatch::changed(Clock::time_point now) {
  if (now < next_) return false;
  next_ = now + kBetweenLooks;
  const auto mark = look();
  if (!mark || mark == seen_) return false;
  seen_ = mark;
  return true;
}

std::optional<FileWatch::Mark> FileWatch::look() const {
  std::error_code missing;
  const auto time = std::filesystem::last_write_time(path_, missing);
  if (missing) return std::nullopt;
  const auto size = std::filesystem::file_size(path_, missing);
  if (missing) return std::nullopt;
  return Mark{time, size};
}

}  // namespace gxy
