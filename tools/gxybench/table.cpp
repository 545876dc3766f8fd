// SPDX-License-Identifier: Apache-2.0
#include "tools/gxybench/table.h"

#include <charconv>
#include <map>
#include <sstream>

#include "core/comm/error.h"

namespace gxy::bench {
namespace {

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"") == std::string::npos) return text;
  std::string out = "\"";
  for (char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

/// The shortest text that reads back as the same number.
template <class Number>
std::string asText(Number x) {
  char digits[32];
  return std::string(digits, std::to_chars(digits, digits + sizeof digits, x).ptr);
}
std::string asText(const std::string& text) { return quoted(text); }

std::vector<std::string> fieldsOf(const std::string& line) {
  std::vector<std::string> fields(1);
  bool inside = false;
  for (size_t i = 0; i < line.size(); i++) {
    if (line[i] == '"') {
      if (inside && i + 1 < line.size() && line[i + 1] == '"')
        fields.back() += line[i++];
      else
        inside = !inside;
    } else if (line[i] == ',' && !inside) {
      fields.emplace_back();
    } else if (line[i] != '\r') {
      fields.back() += line[i];
    }
  }
  return fields;
}

template <class Number>
bool read(const std::string& text, Number& out) {
  const char* end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, out);
  return error == std::errc() && stopped == end && !text.empty();
}
bool read(const std::string& text, std::string& out) {
  out = text;
  return true;
}

}  // namespace

TableWriter::TableWriter(const std::string& path) : path_(path), out_(path) {
  std::string header;
  Row row;
  forEachColumn(
      row, [&](const char* name, const auto&) { header += (header.empty() ? "" : ",") + std::string(name); });
  out_ << header << '\n';
  if (!out_.flush()) throw Error(path + ": cannot be written");
}

void TableWriter::add(const Row& row) {
  std::string line;
  forEachColumn(row,
                [&](const char*, const auto& value) { line += (line.empty() ? "" : ",") + asText(value); });
  out_ << line << '\n';
  if (!out_.flush()) throw Error(path_ + ": cannot be written");
}

std::vector<Row> readTable(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw Error(path + ": cannot be read");
  std::string line;
  std::getline(in, line);
  std::map<std::string, size_t> columns;
  const std::vector<std::string> names = fieldsOf(line);
  for (size_t i = 0; i < names.size(); i++) columns[names[i]] = i;
  Row any;
  forEachColumn(any, [&](const char* name, auto&) {
    if (!columns.count(name))
      throw Error(path + ":1: there is no column " + name + "; expected a table of gxybench");
  });
  std::vector<Row> rows;
  for (int number = 2; std::getline(in, line); number++) {
    if (line.empty()) continue;
    const std::vector<std::string> fields = fieldsOf(line);
    Row row;
    forEachColumn(row, [&](const char* name, auto& value) {
      const size_t column = columns.at(name);
      const std::string text = column < fields.size() ? fields[column] : "";
      if (!read(text, value))
        throw Error(path + ":" + std::to_string(number) + ": " + name + ": expected a number, found '" +
                    text + "'");
    });
    rows.push_back(row);
  }
  if (rows.empty()) throw Error(path + ": it has no rows, expected what gxybench measured");
  return rows;
}

}  // namespace gxy::bench
