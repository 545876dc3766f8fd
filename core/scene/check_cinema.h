// SPDX-License-Identifier: Apache-2.0
// Checks Cinema databases (specification D).
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace gxy {

/// What was found in a database.
struct CinemaCheck {
  std::vector<std::string>
      problems;  ///< each "PLACE: what, expected what"; at most kMostCinemaProblems, then one with their number
  size_t rows = 0, parameters = 0, fileColumns = 0;
};

inline constexpr size_t kMostCinemaProblems = 100;

/// Checks a database: its folder ends with .cdb and has a data.csv without problems (cinema_table.h); the files that this names lie
/// in the folder, by relative paths, and are there, and pictures (.png, .exr) are whole. Reads the table whole, and of files their
/// ends. Throws nothing but std::bad_alloc: what cannot be read is a problem.
CinemaCheck checkCinema(const std::filesystem::path& database);

}  // namespace gxy
