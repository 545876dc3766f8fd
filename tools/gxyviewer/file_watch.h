// SPDX-License-Identifier: Apache-2.0
// Notices changes of a file.
#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>

namespace gxy {

/// Checks a file's modification time and size, at most twice a second.
class FileWatch {
 public:
  using Clock = std::chrono::steady_clock;

  explicit FileWatch(std::filesystem::path path) : path_(std::move(path)), seen_(look()) {}

  /// Returns true once after each change of the file since construction. A file that does not exist
  /// counts as unchanged.
  bool changed(Clock::time_point now);

 private:
  struct Mark {
    std::filesystem::file_time_type time;
    uintmax_t size;
    bool operator==(const Mark&) const = default;
  };
  std::optional<Mark> look() const;

  const std::filesystem::path path_;
  std::optional<Mark> seen_;
  Clock::time_point next_{};
};

}  // namespace gxy
