// SPDX-License-Identifier: Apache-2.0
// The folder of a Cinema database that grows step by step.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/cinema_table.h"

namespace gxy {

/// A database NAME.cdb: its table, data.csv, and its page, index.html. Whoever reads it meanwhile finds the table of the last write(),
/// whose pictures are all there. Used by one rank.
class CinemaDatabase {
 public:
  /// Makes the folder, or goes on with the database that is there. Throws Error if that is broken or has other columns.
  CinemaDatabase(std::filesystem::path folder, const CinemaTable::Row& columns);

  /// Throws Error if a row of these parameters would not fit the rows that there are.
  void expectFits(const CinemaTable::Row& parameters) const {
    table_.expectFits(parameters, (folder_ / "data.csv").string());
  }
  /// Whether there is a row of these parameters, and all its files.
  bool has(const CinemaTable::Row& parameters) const;
  void put(CinemaTable::Row row) { table_.put(std::move(row)); }
  /// Replaces the table, and then the page. Throws Error if they cannot be written.
  void write() const;
  size_t rows() const { return table_.rows().size(); }

 private:
  static CinemaTable tableIn(const std::filesystem::path& folder, const CinemaTable::Row& columns);

  const std::filesystem::path folder_;
  CinemaTable table_;
};

/// Returns the folder of the database of this name: NAME.cdb, or NAME if it ends so already.
std::filesystem::path cinemaFolder(const std::string& name);

}  // namespace gxy
