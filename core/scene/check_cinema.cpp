// SPDX-License-Identifier: Apache-2.0
#include "core/scene/check_cinema.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <string_view>

#include "core/comm/error_text.h"
#include "core/scene/cinema_table.h"

namespace gxy {
namespace {

namespace fs = std::filesystem;

/// The first and the last bytes of a file, as many as there are.
struct FileEnds {
  std::string first, last;
};

bool readEnds(const fs::path& path, FileEnds& ends) {
  std::ifstream in(path, std::ios::binary);
  std::array<char, 16> bytes{};
  if (!in) return false;
  in.read(bytes.data(), bytes.size());
  ends.first.assign(bytes.data(), size_t(in.gcount()));
  in.clear();
  in.seekg(0, std::ios::end);
  const auto size = std::streamoff(in.tellg());
  in.seekg(std::max<std::streamoff>(size - std::streamoff(bytes.size()), 0));
  in.read(bytes.data(), bytes.size());
  ends.last.assign(bytes.data(), size_t(in.gcount()));
  return size >= 0;
}

/// Says what is wrong with a file that a table names, or nothing.
std::string flawOf(const fs::path& database, const std::string& name) {
  if (name.empty()) return "there is no name of a file";
  const fs::path relative(name);
  const bool leaves =
      relative.is_absolute() ||
      std::any_of(relative.begin(), relative.end(), [](const fs::path& part) { return part == ".."; });
  if (leaves) return "file " + inQuotes(name) + ": expected a path relative to the database, without \"..\"";
  std::error_code error;
  const fs::path path = database / relative;
  if (!fs::exists(path, error)) return "file " + inQuotes(name) + ": it is missing";
  if (!fs::is_regular_file(path, error)) return "file " + inQuotes(name) + ": it is not a regular file";
  FileEnds ends;
  if (!readEnds(path, ends)) return "file " + inQuotes(name) + ": it cannot be read";
  if (ends.first.empty()) return "file " + inQuotes(name) + ": it is empty";
  using namespace std::string_view_literals;
  const bool png = relative.extension() == ".png", exr = relative.extension() == ".exr";
  if (png && !ends.first.starts_with("\x89PNG\r\n\x1a\n"sv))
    return "file " + inQuotes(name) + ": it is no .png";
  if (png && ends.last.find("IEND"sv) == std::string::npos)
    return "file " + inQuotes(name) + ": its end is missing";
  if (exr && !ends.first.starts_with("\x76\x2f\x31\x01"sv))
    return "file " + inQuotes(name) + ": it is no .exr";
  return {};
}

/// Collects problems, up to a limit.
class Problems {
 public:
  explicit Problems(CinemaCheck& check) : check_(check) {}
  void add(const std::string& place, const std::string& what) {
    if (check_.problems.size() < kMostCinemaProblems)
      check_.problems.push_back(place + ": " + what);
    else
      more_++;
  }
  void end() {
    if (more_ > 0) check_.problems.push_back("and " + std::to_string(more_) + " more problems");
  }

 private:
  CinemaCheck& check_;
  size_t more_ = 0;
};

}  // namespace

CinemaCheck checkCinema(const fs::path& given) {
  CinemaCheck check;
  Problems problems(check);
  const fs::path database = given.has_filename() ? given : given.parent_path();  // NAME.cdb/
  const std::string place = database.string();
  std::error_code error;
  if (!fs::is_directory(database, error)) {
    problems.add(place, fs::exists(database, error) ? "it is no folder, expected a database NAME.cdb"
                                                    : "there is no such folder");
    return check;
  }
  if (database.extension() != ".cdb") problems.add(place, "expected a name that ends with .cdb");
  const fs::path csv = database / "data.csv";
  std::ifstream in(csv, std::ios::binary);
  if (!fs::is_regular_file(csv, error) || !in) {
    problems.add(place, "there is no data.csv that can be read");
    return check;
  }
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  std::vector<TableProblem> found;
  const std::vector<CsvRecord> records = readCsv(text, found);
  for (TableProblem& p : problemsOfTable(records)) found.push_back(std::move(p));
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.line < b.line; });
  const auto placeOf = [&](size_t line) {
    return csv.string() + (line > 0 ? ":" + std::to_string(line) : "");
  };
  for (const TableProblem& p : found) problems.add(placeOf(p.line), p.what);
  if (!records.empty()) {
    const auto& columns = records[0].cells;
    check.fileColumns = size_t(std::count_if(columns.begin(), columns.end(), isFileColumn));
    check.parameters = columns.size() - check.fileColumns;
    check.rows = records.size() - 1;
    for (size_t r = 1; r < records.size(); r++)
      for (size_t c = 0; c < std::min(records[r].cells.size(), columns.size()); c++)
        if (isFileColumn(columns[c]))
          if (const std::string flaw = flawOf(database, records[r].cells[c]); !flaw.empty())
            problems.add(placeOf(records[r].line), flaw);
  }
  problems.end();
  return check;
}

}  // namespace gxy
