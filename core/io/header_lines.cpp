// SPDX-License-Identifier: Apache-2.0
#include "core/io/header_lines.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/io/number_text.h"

namespace gxy {

namespace {
constexpr std::string_view kWhite = " \t\r\v\f\n";
}

bool HeaderLines::next(std::string_view& line) {
  if (at_ >= text_.size()) return false;
  const size_t end = std::min(text_.find('\n', at_), text_.size());
  line = text_.substr(at_, end - at_);
  at_ = std::min(end + 1, text_.size());
  if (line.ends_with('\r')) line.remove_suffix(1);
  ++line_;
  return true;
}

void HeaderLines::fail(const std::string& what) const {
  throw Error(where_ + ":" + std::to_string(line_) + ": " + what);
}

std::vector<double> HeaderLines::numbers(std::string_view value, size_t count) const {
  std::vector<double> numbers;
  for (const std::string_view word : wordsOf(value)) {
    const auto number = valueOfText(word);
    if (!number) fail("found " + inQuotes(word.substr(0, 40)) + ", expected a number");
    numbers.push_back(*number);
  }
  if (numbers.size() != count)
    fail("there are " + std::to_string(numbers.size()) + " numbers, expected " + std::to_string(count));
  return numbers;
}

int64_t HeaderLines::integer(std::string_view value, int64_t least, int64_t most) const {
  const double number = numbers(value, 1)[0];
  if (!(number >= double(least) && number <= double(most)) || number != std::floor(number))
    fail("found " + inQuotes(trimmed(value).substr(0, 40)) + ", expected a whole number from " +
         std::to_string(least) + " to " + std::to_string(most));
  return int64_t(number);
}

std::string_view trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(kWhite);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(kWhite) - first + 1);
}

std::string lowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = char(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

std::vector<std::string_view> wordsOf(std::string_view text) {
  std::vector<std::string_view> words;
  for (size_t at = text.find_first_not_of(kWhite); at != text.npos; at = text.find_first_not_of(kWhite, at)) {
    const size_t end = std::min(text.find_first_of(kWhite, at), text.size());
    words.push_back(text.substr(at, end - at));
    at = end;
  }
  return words;
}

}  // namespace gxy
