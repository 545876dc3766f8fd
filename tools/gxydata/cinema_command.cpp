// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "core/comm/error.h"
#include "core/scene/check_cinema.h"
#include "tools/gxydata/commands.h"

namespace gxy::data_tool {

void checkCinemaDatabases(const std::vector<std::string>& folders) {
  size_t wrong = 0;
  for (const std::string& folder : folders) {
    const CinemaCheck check = checkCinema(folder);
    for (const std::string& problem : check.problems) std::fprintf(stderr, "%s\n", problem.c_str());
    wrong += !check.problems.empty();
    if (check.problems.empty())
      std::printf("%s: %zu row%s, %zu parameter%s, %zu column%s of files: valid\n", folder.c_str(),
                  check.rows, check.rows == 1 ? "" : "s", check.parameters, check.parameters == 1 ? "" : "s",
                  check.fileColumns, check.fileColumns == 1 ? "" : "s");
  }
  if (std::fflush(stdout) != 0) throw Error("standard output: cannot be written");
  if (wrong > 0)
    throw Error("check-cinema: of " + std::to_string(folders.size()) + " database(s) " +
                std::to_string(wrong) + " not valid");
}

}  // namespace gxy::data_tool
