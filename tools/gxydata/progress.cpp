// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <set>

#include "core/comm/error.h"
#include "core/io/referenced_files.h"
#include "tools/gxydata/commands.h"

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

std::vector<std::string> filesOfPieces(const std::string& out, std::array<int, 3> lattice,
                                       const char* extension) {
  std::vector<std::string> files{out};
  const int pieces = lattice[0] * lattice[1] * lattice[2];
  for (int i = 0; i < pieces; ++i) files.push_back(pieceName(out, i, extension));
  return files;
}

void tellLoss(const Options& options, const std::string& what) {
  std::fprintf(stderr, "gxydata: %s: %s\n", options.in.c_str(), what.c_str());
}

void keepInput(const std::string& in, const std::vector<std::string>& written) {
  std::set<std::pair<dev_t, ino_t>> read;  // identified by device and inode, whatever their names
  struct stat status {};
  for (const std::string& file : filesOpenedFor(in))
    if (::stat(file.c_str(), &status) == 0) read.insert({status.st_dev, status.st_ino});
  for (const std::string& file : written)
    if (::stat(file.c_str(), &status) == 0 && read.count({status.st_dev, status.st_ino}))
      throw Error(file + ": it would be overwritten, but " + in +
                  " is read from it; give the output another name");
}

}  // namespace gxy::data_tool
