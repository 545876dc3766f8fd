// SPDX-License-Identifier: Apache-2.0
// The table of a Cinema database (specification D): data.csv, its types and its rules.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace gxy {

/// The types that readers of Cinema databases tell apart by the text of a cell.
enum class TableCellType : uint8_t { Integer, Float, Text };
TableCellType cellType(std::string_view cell);
/// In words: "an integer", "a number with a point", "a text".
const char* describe(TableCellType type);

/// Returns a number as it stands in a table: the fewest digits that read back as the same double, always with a point, so that
/// readers take its column for one of floats whatever its first value is. `x` is finite.
std::string floatCell(double x);

/// Whether a column has names of files.
inline bool isFileColumn(std::string_view name) { return name.starts_with("FILE"); }

/// A record of a text in RFC 4180, and the line that it begins on, from 1.
struct CsvRecord {
  size_t line = 0;
  std::vector<std::string> cells;
};

/// Something that is wrong with a table.
struct TableProblem {
  size_t line = 0;  ///< 0: with the whole
  std::string what;
};

/// Returns the records of a text. Lines may end with CR LF or LF. Mistakes are appended to `problems`.
std::vector<CsvRecord> readCsv(std::string_view text, std::vector<TableProblem>& problems);

/// Returns all that is wrong with a table, but for its files: columns without a name, named twice, with a number for a name or
/// blanks around it; columns of files that are missing or not the last; no rows; rows of another length; cells of another type
/// than their column's first; parameters that two rows have.
std::vector<TableProblem> problemsOfTable(const std::vector<CsvRecord>& records);

/// A table without those problems: parameters, then files. One thread at a time changes it.
class CinemaTable {
 public:
  using Row = std::vector<std::string>;

  /// Throws Error if these columns would be a problem.
  explicit CinemaTable(Row columns);
  /// Reads a table. Throws Error "SOURCE:LINE: ..." with the first problem.
  static CinemaTable read(std::string_view text, const std::string& sourceName);

  const Row& columns() const { return columns_; }
  const std::vector<Row>& rows() const { return rows_; }
  /// The number of columns that are not of files.
  size_t parameters() const { return parameters_; }

  /// Adds a row, or replaces that of the same parameters in its place. Throws Error for a row of another length, or for a cell of
  /// another type than its column has.
  void put(Row row);
  /// Throws Error "SOURCE: ..." if a row with these parameters, and whatever files, would have a cell of another type than its column.
  void expectFits(const Row& parameters, const std::string& sourceName) const;
  /// The row with these parameters, or null. It is valid until the next put().
  const Row* find(const Row& parameters) const;

  /// The text of data.csv, in RFC 4180.
  std::string text() const;

 private:
  std::string keyOf(const Row& row) const;
  Row columns_;
  size_t parameters_ = 0;
  std::vector<Row> rows_;
  std::unordered_map<std::string, size_t> places_;  ///< of rows, by their parameters
};

/// Returns how many bytes it takes at most to read a table of this text and to write it again with its page.
int64_t memoryOfTable(std::string_view text);

/// Returns the table that a sweep goes on with: the one whose text there is already, else an empty one. Throws Error if that one is
/// broken, or has other columns.
CinemaTable continuedTable(const std::optional<std::string>& text, const CinemaTable::Row& columns,
                           const std::string& sourceName);

/// Returns the name of the file of a row without its extension, relative to the database. It follows from the parameters, and
/// differs where they differ. With `time`, the number of the column of the time, the files of a step have a folder of their own.
/// The name has '/' for the folder, letters, digits and "+-.=_" only. Throws Error if it has more than 200
/// bytes after the folder, which may be too long for a file system.
std::string cinemaFileName(const std::vector<std::string>& parameters, std::optional<size_t> time);

}  // namespace gxy
