// SPDX-License-Identifier: Apache-2.0
// The process that measures: one for each scene, backend and number of ranks, so that memory and threads are
// its own.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "core/render/framebuffer.h"
#include "tools/gxybench/scenes.h"
#include "tools/gxybench/table.h"

namespace gxy::bench {

/// What is to be measured. All settings show the same data.
struct Job {
  std::string directory;  ///< of the data
  std::string backend = "auto";
  std::string device;    ///< BackendOptions::device
  int repeats = 3;       ///< frames timed per setting, at least
  double seconds = 0.5;  ///< that a setting is timed for, at least, so that short frames are measured well
  int threads = 0;       ///< per rank; 0: the cores shared by the ranks
  std::string pictures;  ///< prefix of the files that pictures go to; the reader removes them
  std::vector<Setting> settings;
};

/// Times and counters of a setting, with the setting's picture. The row's errors are still to be found.
using Measured = std::function<void(size_t setting, Row row, Picture picture)>;

/// Starts `ranks` processes of this program under `launcher` (without it, if that is empty), and calls
/// `measured` for each setting as it comes. Throws Error where they cannot be started or fail.
void measure(const Job& job, int ranks, const std::string& launcher, const Measured& measured);

/// What such a process does, given the file that measure() has written; its exit status. Prints one line a
/// setting.
int work(const std::string& jobFile);

}  // namespace gxy::bench
