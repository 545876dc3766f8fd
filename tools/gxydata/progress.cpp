// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cstdio>
#include <filesystem>

#include "commands.h"

namespace gxy::data_tool {

Progress::Progress(std::string what, int64_t total)
    : what_(std::move(what)), total_(total > 0 ? total : 1), terminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (terminal_) std::fprintf(stderr, "\r\033[K");
}

void Progress::advance(int64_t done) {
  const int64_t now = done_ += done;
  if (terminal_ && now * 100 / total_ != (now - done) * 100 / total_)
    std::fprintf(stderr, "\r%s %d %%", what_.c_str(), int(now * 100 / total_));
}

std::string stepName(const Options& options, int step) {
  if (options.steps == 0) return options.out;
  char number[16];
  std::snprintf(number, sizeof number, "_%04d", step);
  const std::filesystem::path path(options.out);
  return (path.parent_path() / (path.stem().string() + number + path.extension().string())).string();
}

std::string pieceName(const std::string& out, int piece, const char* extension) {
  const std::filesystem::path path(out);
  return (path.parent_path() / (path.stem().string() + "_" + std::to_string(piece) + extension)).string();
}

}  // namespace gxy::data_tool
