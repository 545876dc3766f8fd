// SPDX-License-Identifier: Apache-2.0
// Headers made of lines with a key and a value. Used inside core/io only.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/data/scalar.h"

namespace gxy {

/// Lines, one after the other, from text whose last bytes may be no text.
class HeaderLines {
 public:
  HeaderLines(std::string_view text, const std::string& where) : text_(text), where_(where) {}

  /// False at the end. A line is without its end ("\n" or "\r\n").
  bool next(std::string_view& line);
  /// Of the next line.
  size_t position() const { return at_; }
  /// Throws Error: where, the line's number, and what.
  [[noreturn]] void fail(const std::string& what) const;

  /// The numbers that a value consists of, `count` of them.
  std::vector<double> numbers(std::string_view value, size_t count) const;
  /// A whole number in a range.
  int64_t integer(std::string_view value, int64_t least, int64_t most) const;

 private:
  std::string_view text_;
  const std::string& where_;
  size_t at_ = 0;
  int line_ = 0;
};

/// Without white space at its ends.
std::string_view trimmed(std::string_view text);
std::string lowerCase(std::string_view text);
/// The words between white space.
std::vector<std::string_view> wordsOf(std::string_view text);

}  // namespace gxy
