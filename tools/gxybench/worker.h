// SPDX-License-Identifier: Apache-2.0
// The processes that measure: new ones for each scene, backend and number of ranks, so that they have memory
// and threads of their own.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/render/framebuffer.h"
#include "tools/gxybench/scenes.h"
#include "tools/gxybench/table.h"

namespace gxy::bench {

/// The work of the measuring processes. All settings show the same data.
struct Job {
  std::string directory;  ///< folder of the data
  std::string backend = "auto";
  std::string device;    ///< BackendOptions::device
  int repeats = 3;       ///< least number of frames timed per setting
  double seconds = 0.5;  ///< least time that a setting is timed for, so that short frames are measured well
  int threads = 0;       ///< threads per rank; 0: the ranks share the cores
  std::string pictures;  ///< prefix of the pictures' files; whoever reads a file removes it
  std::vector<Setting> settings;
};

/// Receives times and counters of a setting, with the setting's picture. The row's errors are not filled in
/// yet.
using Measured = std::function<void(size_t setting, Row row, Picture picture)>;

/// Starts `ranks` processes of this program under `launcher` (directly, if that is empty), and calls
/// `measured` for each setting as its result arrives. Throws Error if they cannot be started or if they fail.
void measure(const Job& job, int ranks, const std::string& launcher, const Measured& measured);

/// Runs such a process on the file that measure() has written, and prints one line per setting. Returns its
/// exit status.
int work(const std::string& jobFile);

}  // namespace gxy::bench
