// SPDX-License-Identifier: Apache-2.0
// Whether a file has been written.
#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>

namespace gxy {

/// Looks at a file's time and size, twice a second at most.
class FileWatch {
 public:
  using Clock = std::chrono::steady_clock;

  explicit FileWatch(std::filesystem::path path) : path_(std::move(path)), seen_(look()) {}

  /// True once for each change since it was made. One that is not there has not changed.
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
