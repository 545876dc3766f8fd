// SPDX-License-Identifier: Apache-2.0
#include "core/scene/cinema_table.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/comm/error.h"
#include "core/comm/error_text.h"

namespace gxy {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

std::string_view withoutBlanks(std::string_view text) {
  const size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

bool isDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// Stands for a value that is missing, also in a column of texts.
bool isNan(std::string_view cell) {
  return cell.size() == 3 && std::equal(cell.begin(), cell.end(), "nan", [](char a, char b) {
           return std::tolower(static_cast<unsigned char>(a)) == b;
         });
}

/// Whether a cell may stand in a column of this type.
bool fits(std::string_view cell, TableCellType column) {
  return cellType(cell) == column || (column == TableCellType::Text && isNan(cell));
}

/// Says why it may not.
std::string misfit(const std::string& column, const std::string& cell, TableCellType type) {
  return "column " + inQuotes(column) + ": " + inQuotes(cell) + " is " + describe(cellType(cell)) +
         ", expected " + describe(type) + " as in the first row";
}

/// A cell in quotes if it needs them.
std::string csvCell(const std::string& cell) {
  if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
  std::string out = "\"";
  for (const char c : cell) out.append(c == '"' ? 2 : 1, c);
  return out + "\"";
}

/// Reads one text, record by record.
class CsvReader {
 public:
  CsvReader(std::string_view text, std::vector<TableProblem>& problems) : text_(text), problems_(problems) {}

  std::vector<CsvRecord> read() {
    std::vector<CsvRecord> records;
    if (text_.starts_with("\xEF\xBB\xBF"))
      problems_.push_back({1, "there is a byte order mark, expected the name of the first column"});
    while (at_ < text_.size()) {
      CsvRecord record{line_, {}};
      const size_t begin = at_;
      do record.cells.push_back(cell());
      while (take(','));
      const bool blank = at_ == begin;
      if (!take('\r') || !take('\n')) take('\n');
      line_++;
      if (blank)
        problems_.push_back({record.line, "the line is blank, expected a row"});
      else if (closed_)
        records.push_back(std::move(record));
    }
    return records;
  }

 private:
  bool take(char c) {
    const bool there = at_ < text_.size() && text_[at_] == c;
    at_ += there;
    return there;
  }
  /// Whether a cell ends here.
  bool atEnd() const {
    return at_ == text_.size() || text_[at_] == ',' || text_[at_] == '\n' ||
           (text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n');
  }

  std::string cell() {
    std::string out;
    if (!take('"')) {
      for (; !atEnd(); at_++) out += text_[at_];
      if (out.find('"') != std::string::npos)
        problems_.push_back({line_, "there is a quote in a cell without quotes around it: " + inQuotes(out)});
      return out;
    }
    const size_t begin = line_;
    for (;;) {
      if (at_ == text_.size()) {
        problems_.push_back({begin, "a quote is not closed"});
        closed_ = false;
        return out;
      }
      if (take('"')) {
        if (!take('"')) break;
        out += '"';
        continue;
      }
      line_ += text_[at_] == '\n';
      out += text_[at_++];
    }
    if (!atEnd()) {
      problems_.push_back({line_, "there is something behind a closing quote, expected a comma"});
      while (!atEnd()) at_++;
    }
    return out;
  }

  const std::string_view text_;
  std::vector<TableProblem>& problems_;
  size_t at_ = 0, line_ = 1;
  bool closed_ = true;
};

void checkColumns(const CsvRecord& header, std::vector<TableProblem>& problems) {
  const auto& columns = header.cells;
  std::set<std::string> known;
  bool file = false;
  for (size_t c = 0; c < columns.size(); c++) {
    const std::string& name = columns[c];
    const auto wrong = [&](const std::string& what) {
      problems.push_back(
          {header.line, "column " + std::to_string(c + 1) + ", " + inQuotes(name) + ": " + what});
    };
    if (name.empty()) wrong("it has no name");
    if (!name.empty() && withoutBlanks(name) != name) wrong("expected no blanks around the name");
    if (!name.empty() && cellType(name) != TableCellType::Text) wrong("expected a name that is no number");
    if (!known.insert(name).second) wrong("another column has this name, expected each once");
    if (file && !isFileColumn(name)) wrong("expected the columns of files to be the last");
    file = file || isFileColumn(name);
  }
  if (!file)
    problems.push_back({header.line, "there is no column of files, expected a last column named FILE"});
}

size_t parametersIn(const std::vector<std::string>& columns) {
  return size_t(std::find_if(columns.begin(), columns.end(), isFileColumn) - columns.begin());
}

std::string joinedCells(const std::vector<std::string>& cells, size_t count) {
  std::string key;
  for (size_t c = 0; c < count; c++) key += std::to_string(cells[c].size()) + ":" + cells[c];
  return key;
}

}  // namespace

TableCellType cellType(std::string_view cell) {
  std::string text(withoutBlanks(cell));
  for (size_t i = 1; i + 1 < text.size(); i++)  // 1_000 is a number to some readers
    if (text[i] == '_' && isDigit(text[i - 1]) && isDigit(text[i + 1])) text.erase(i, 1);
  const size_t sign = !text.empty() && (text[0] == '+' || text[0] == '-') ? 1 : 0;
  if (text.size() > sign && std::all_of(text.begin() + std::ptrdiff_t(sign), text.end(), isDigit))
    return TableCellType::Integer;
  // strtod() reads more than others do: 0x1p3, nan(...).
  if (text.empty() || text.find_first_of("xX(") != std::string::npos) return TableCellType::Text;
  char* end = nullptr;
  std::strtod(text.c_str(), &end);
  return end == text.c_str() + text.size() ? TableCellType::Float : TableCellType::Text;
}

const char* describe(TableCellType type) {
  return type == TableCellType::Integer ? "an integer"
         : type == TableCellType::Float ? "a number with a point"
                                        : "a text";
}

std::string floatCell(double x) {
  std::string text = nlohmann::json(x).dump();
  if (text.find('.') != std::string::npos) return text;
  const size_t exponent = std::min(text.find('e'), text.size());
  return text.insert(exponent, ".0");
}

std::vector<CsvRecord> readCsv(std::string_view text, std::vector<TableProblem>& problems) {
  return CsvReader(text, problems).read();
}

std::vector<TableProblem> problemsOfTable(const std::vector<CsvRecord>& records) {
  std::vector<TableProblem> problems;
  if (records.empty()) return {{0, "the table is empty, expected a line with the names of the columns"}};
  const auto& columns = records[0].cells;
  checkColumns(records[0], problems);
  if (records.size() == 1) problems.push_back({0, "there are no rows, expected one at least"});
  const size_t parameters = parametersIn(columns);
  std::map<std::string, size_t> lines;  // of rows, by their parameters
  for (size_t r = 1; r < records.size(); r++) {
    const CsvRecord& row = records[r];
    if (row.cells.size() != columns.size()) {
      problems.push_back({row.line, std::to_string(row.cells.size()) + " cells, expected " +
                                        std::to_string(columns.size()) + " as in the first line"});
      continue;
    }
    for (size_t c = 0; c < parameters; c++) {
      if (c >= records[1].cells.size()) break;
      const TableCellType type = cellType(records[1].cells[c]);
      if (!fits(row.cells[c], type)) problems.push_back({row.line, misfit(columns[c], row.cells[c], type)});
    }
    const auto [at, added] = lines.emplace(joinedCells(row.cells, parameters), row.line);
    if (!added)
      problems.push_back({row.line, "its parameters are those of line " + std::to_string(at->second) +
                                        ", expected each combination once"});
  }
  return problems;
}

CinemaTable::CinemaTable(Row columns) : columns_(std::move(columns)), parameters_(parametersIn(columns_)) {
  std::vector<TableProblem> problems;
  checkColumns({1, columns_}, problems);
  if (!problems.empty()) throw Error("table: " + problems[0].what);
}

CinemaTable CinemaTable::read(std::string_view text, const std::string& sourceName) {
  std::vector<TableProblem> problems;
  const std::vector<CsvRecord> records = readCsv(text, problems);
  if (problems.empty()) problems = problemsOfTable(records);
  if (!problems.empty())
    throw Error(sourceName + (problems[0].line > 0 ? ":" + std::to_string(problems[0].line) : "") + ": " +
                problems[0].what);
  CinemaTable table(records[0].cells);
  for (size_t r = 1; r < records.size(); r++) table.put(records[r].cells);
  return table;
}

std::string CinemaTable::keyOf(const Row& row) const { return joinedCells(row, parameters_); }

void CinemaTable::put(Row row) {
  if (row.size() != columns_.size())
    throw Error("table: a row of " + std::to_string(row.size()) + " cells, expected " +
                std::to_string(columns_.size()));
  expectFits(row, "table");
  const auto [at, added] = places_.emplace(keyOf(row), rows_.size());
  if (added)
    rows_.push_back(std::move(row));
  else
    rows_[at->second] = std::move(row);
}

void CinemaTable::expectFits(const Row& parameters, const std::string& sourceName) const {
  for (size_t c = 0; c < parameters_ && !rows_.empty(); c++)
    if (const TableCellType type = cellType(rows_[0][c]); !fits(parameters.at(c), type))
      throw Error(sourceName + ": " + misfit(columns_[c], parameters.at(c), type));
}

const CinemaTable::Row* CinemaTable::find(const Row& parameters) const {
  if (parameters.size() < parameters_) return nullptr;
  const auto at = places_.find(keyOf(parameters));
  return at == places_.end() ? nullptr : &rows_[at->second];
}

std::string CinemaTable::text() const {
  std::string out;
  const auto add = [&](const Row& row) {
    for (size_t c = 0; c < row.size(); c++) out += (c == 0 ? "" : ",") + csvCell(row[c]);
    if (row.size() == 1 && row[0].empty()) out += "\"\"";  // or the line would be blank
    out += "\r\n";
  };
  add(columns_);
  for (const Row& row : rows_) add(row);
  return out;
}

int64_t memoryOfTable(std::string_view text) {
  constexpr int64_t kBytesOfACell = 256;     // in records, rows and keys, whose lists grow, or in a problem
  constexpr int64_t kBytesOfACharacter = 8;  // in cells, keys, and the texts of the table and the page
  const auto cells = std::count_if(text.begin(), text.end(), [](char c) { return c == ',' || c == '\n'; });
  return int64_t(cells) * kBytesOfACell + int64_t(text.size()) * kBytesOfACharacter;
}

CinemaTable continuedTable(const std::optional<std::string>& text, const CinemaTable::Row& columns,
                           const std::string& sourceName) {
  if (!text) return CinemaTable(columns);
  CinemaTable table = CinemaTable::read(*text, sourceName);
  const auto listed = [](const CinemaTable::Row& names) {
    std::string all;
    for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
    return all;
  };
  if (table.columns() != columns)
    throw Error(sourceName + ": its columns are " + listed(table.columns()) + ", expected " +
                listed(columns) +
                " as the sweep makes them; give the database another name, or remove this one");
  return table;
}

std::string cinemaFileName(const std::vector<std::string>& parameters, std::optional<size_t> time) {
  const auto safe = [](const std::string& cell) {
    std::string out;
    for (const char c : cell) {
      const bool plain = std::isalnum(static_cast<unsigned char>(c)) || c == '+' || c == '-' || c == '.';
      char code[8];
      std::snprintf(code, sizeof code, "=%02X", unsigned(static_cast<unsigned char>(c)));
      out += plain && static_cast<unsigned char>(c) < 0x80 ? std::string(1, c) : std::string(code);
    }
    return out;
  };
  std::string name;
  for (size_t c = 0; c < parameters.size(); c++)
    if (c != time) name += (name.empty() ? "" : "_") + safe(parameters[c]);
  if (name.empty()) name = "picture";
  // Of NAME_MAX, 255: less "_depth.exr", and 30 bytes that a server's partial file has in addition (DataFolders::NewFile).
  constexpr size_t kLongest = 200;
  if (name.size() > kLongest)
    throw Error("the parameters " + inQuotes(name) + " make a name of " + std::to_string(name.size()) +
                " bytes for a picture, expected at most " + std::to_string(kLongest) +
                "; give shorter labels");
  return (time ? "time=" + safe(parameters.at(*time)) : "pictures") + "/" + name;
}

}  // namespace gxy
