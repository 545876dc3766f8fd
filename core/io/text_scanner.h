// SPDX-License-Identifier: Apache-2.0
// Reads bytes in memory as words, lines, numbers and binary blocks, and never beyond their end. Numbers are
// parsed alike in every locale. ReadWatch's check is called once per megabyte. Used inside core/io only.
#pragma once
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/comm/error.h"
#include "core/io/file.h"

namespace gxy {

/// Neither the bytes nor the path are copied; both must outlive the scanner.
class TextScanner {
 public:
  TextScanner(std::string_view bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  /// Returns the next word between white space; empty at the end.
  std::string_view word() {
    while (at_ < bytes_.size() && isSpace(bytes_[at_])) ++at_;
    begin();
    while (at_ < bytes_.size() && !isSpace(bytes_[at_])) ++at_;
    return bytes_.substr(last_, at_ - last_);
  }

  /// Returns the rest of the current line without its end ("\n" or "\r\n"), and moves to the next line.
  std::string_view line() {
    begin();
    const size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    std::string_view text = bytes_.substr(at_, end - at_);
    at_ = std::min(end + 1, bytes_.size());
    if (text.ends_with('\r')) text.remove_suffix(1);
    return text;
  }

  /// The same for lines that may also end with "\r" alone.
  std::string_view lineOfAnyEnd() {
    begin();
    const size_t end = std::min(bytes_.find_first_of("\r\n", at_), bytes_.size());
    const std::string_view text = bytes_.substr(at_, end - at_);
    at_ = std::min(end + (bytes_.substr(end).starts_with("\r\n") ? 2 : 1), bytes_.size());
    return text;
  }

  /// Skips the byte-order mark that some programs write at the beginning of UTF-8 text.
  void passByteOrderMark() {
    if (at_ == 0 && bytes_.starts_with("\xef\xbb\xbf")) at_ = 3;
  }

  /// Returns the next word as a number. The whole word must be a number, with an optional sign. `what` says
  /// in errors what was expected.
  template <class T>
  T number(std::string_view what) {
    const std::string_view text = word();
    T value{};
    if (!parse(text, value))
      fail((text.empty() ? "the file ends" : "found '" + std::string(text.substr(0, 40)) + "'") +
           ", expected " + std::string(what));
    return value;
  }

  /// Returns the next `count` bytes as they are. `what` says in errors what they are.
  std::string_view take(size_t count, std::string_view what) {
    if (count > left()) fail("the file ends before " + std::string(what));
    begin();
    at_ += count;
    return bytes_.substr(last_, count);
  }

  const std::string& path() const { return path_; }
  size_t left() const { return bytes_.size() - at_; }

  /// Returns "line n": the line where the last word, line or block began.
  std::string place() const {
    size_t lines = 1;
    for (size_t i = 0; i < last_; ++i)
      lines += bytes_[i] == '\n' || (bytes_[i] == '\r' && bytes_.substr(i + 1, 1) != "\n");
    return "line " + std::to_string(lines);
  }

  /// Throws Error "path: line n: what".
  [[noreturn]] void fail(const std::string& what) const { throw Error(path_ + ": " + place() + ": " + what); }

  template <class T>
  static bool parse(std::string_view text, T& value) {
    if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size();
  }

 private:
  static constexpr size_t kWatched = size_t(1) << 20;

  // The next word, line or block begins here.
  void begin() {
    last_ = at_;
    if (at_ < watched_) return;
    watched_ = at_ + kWatched;
    ReadWatch::check();
  }
  static bool isSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  std::string_view bytes_;
  const std::string& path_;
  size_t at_ = 0, last_ = 0, watched_ = kWatched;
};

}  // namespace gxy
