// SPDX-License-Identifier: Apache-2.0
// Rows and folders for tests of gxybench.
#pragma once
#include <stdlib.h>

#include <filesystem>
#include <string>

#include "gxybench/table.h"

namespace gxy::bench::test {

/// A row of a scene that one rank renders.
inline Row row(const std::string& method, const std::string& setting, double cpu, double rms,
               double spread = 0) {
  Row r;
  r.scene = "scene", r.method = method, r.setting = setting, r.backend = "embree";
  r.tolerance = 1, r.repeats = 5;
  r.cpu = cpu, r.cpuSpread = spread, r.wall = 2 * cpu, r.wallSpread = spread;
  r.rmsError = rms, r.maxError = 10 * rms, r.p999Error = 5 * rms;
  return r;
}

/// A folder of its own, gone with the object.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "gxybench-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string at(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace gxy::bench::test
