// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyrender/cinema_database.h"

#include <algorithm>
#include <optional>
#include <span>

#include "core/comm/error.h"
#include "core/image/replace_file.h"
#include "core/io/file.h"
#include "core/scene/cinema_page.h"

namespace gxy {

namespace fs = std::filesystem;

namespace {
constexpr int64_t kLongestTable = int64_t(4) << 30;
}

CinemaDatabase::CinemaDatabase(fs::path folder, const CinemaTable::Row& columns)
    : folder_(std::move(folder)), table_(tableIn(folder_, columns)) {}

CinemaTable CinemaDatabase::tableIn(const fs::path& folder, const CinemaTable::Row& columns) {
  std::error_code failed;
  fs::create_directory(folder, failed);
  if (!fs::is_directory(folder))
    throw Error(folder.string() + ": no folder can be made there" + (failed ? ": " + failed.message() : ""));
  const std::string csv = (folder / "data.csv").string();
  std::optional<std::string> text;
  if (fs::exists(csv)) text = readText(csv, kLongestTable);
  return continuedTable(text, columns, csv);
}

bool CinemaDatabase::has(const CinemaTable::Row& parameters) const {
  const CinemaTable::Row* row = table_.find(parameters);
  return row && std::all_of(row->begin() + std::ptrdiff_t(table_.parameters()), row->end(),
                            [&](const std::string& file) { return fs::is_regular_file(folder_ / file); });
}

void CinemaDatabase::write() const {
  if (table_.rows().empty()) return;
  const auto replace = [&](const char* name, const std::string& text) {
    replaceFile((folder_ / name).string(), std::as_bytes(std::span(text)));
  };
  replace("data.csv", table_.text());
  replace("index.html", cinemaPage(table_, folder_.filename().string()));
}

fs::path cinemaFolder(const std::string& name) {
  fs::path folder(name);
  if (!folder.has_filename()) folder = folder.parent_path();  // NAME.cdb/
  if (folder.extension() != ".cdb") folder += ".cdb";
  return folder;
}

}  // namespace gxy
