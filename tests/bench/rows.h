// SPDX-License-Identifier: Apache-2.0
// Rows and folders for tests of gxybench.
#pragma once
#include <string>

#include "tests/support/temporary_folder.h"
#include "tools/gxybench/table.h"

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

using gxy::test::TemporaryFolder;

}  // namespace gxy::bench::test
