// SPDX-License-Identifier: Apache-2.0
// Reads headers made of lines with a key and a value. Used inside core/io only.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/data/scalar.h"

namespace gxy {

/// Reads the lines of a text one after the other. The bytes after the last line that is read may be binary.
class HeaderLines {
 public:
  HeaderLines(std::string_view text, const std::string& where) : text_(text), where_(where) {}

  /// Gets the next line without its end ("\n" or "\r\n"). Returns false at the end of the text.
  bool next(std::string_view& line);
  /// The position of the next line in the text.
  size_t position() const { return at_; }
  /// Throws Error with `where`, the line's number, and `what`.
  [[noreturn]] void fail(const std::string& what) const;

  /// Parses a value that consists of `count` numbers.
  std::vector<double> numbers(std::string_view value, size_t count) const;
  /// Parses a whole number from `least` to `most`.
  int64_t integer(std::string_view value, int64_t least, int64_t most) const;

 private:
  std::string_view text_;
  const std::string& where_;
  size_t at_ = 0;
  int line_ = 0;
};

/// Removes white space at both ends.
std::string_view trimmed(std::string_view text);
std::string lowerCase(std::string_view text);
/// Returns the words between white space.
std::vector<std::string_view> wordsOf(std::string_view text);

}  // namespace gxy
