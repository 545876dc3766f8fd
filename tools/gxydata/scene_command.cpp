// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "core/comm/error.h"
#include "core/look/file_facts.h"
#include "core/scene/data_files.h"
#include "core/scene/state_file.h"
#include "tools/gxydata/commands.h"

namespace gxy::data_tool {

void printScene(const Options& options) {
  const auto steps = stepsOf(options.files);
  for (const std::string& file : steps[0].files)
    if (isStateFile(file)) throw Error(file + ": this is a state file, expected data files");
  if (steps.size() > 1)
    std::fprintf(stderr, "gxydata: of %zu steps the first is used, since a state file shows one\n",
                 steps.size());
  const std::string text = writeState(
      firstLook(factsOfFiles(steps[0].files, options.array, options.look.looksInside()), options.look));
  std::fputs(text.c_str(), stdout);
  if (std::fflush(stdout) != 0) throw Error("standard output: cannot be written");
}

}  // namespace gxy::data_tool
