// SPDX-License-Identifier: Apache-2.0
#include "core/io/word_reader.h"

#include <algorithm>

#include "core/comm/error.h"

namespace gxy {

namespace {
constexpr size_t kLongestWord = size_t(64) << 10;
bool isWhite(int c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
}  // namespace

int WordReader::peek() {
  constexpr int64_t kBuffer = 64 << 10;
  if (at_ >= size_) return -1;
  if (at_ < buffered_ || at_ >= buffered_ + int64_t(buffer_.size())) {
    buffer_.resize(size_t(std::min(kBuffer, size_ - at_)));
    file_->readAt(at_, buffer_);
    buffered_ = at_;
  }
  return int(buffer_[size_t(at_ - buffered_)]);
}

std::string WordReader::word() {
  while (isWhite(peek())) ++at_;
  std::string text;
  for (int c = peek(); c >= 0 && !isWhite(c); c = peek()) {
    if (text.size() == kLongestWord) fail("a word of more than 65536 bytes");
    text += char(c);
    ++at_;
  }
  lineEnded_ = false;
  return text;
}

std::string WordReader::line() {
  std::string text = restOfLine();
  if (peek() == '\n') ++at_;
  lineEnded_ = true;
  return text;
}

std::string WordReader::restOfLine() {
  std::string text;
  for (int c = peek(); c >= 0 && c != '\n'; c = peek()) {
    if (text.size() == kLongestWord) fail("a line of more than 65536 bytes");
    text += char(c);
    ++at_;
  }
  while (!text.empty() && isWhite(text.back())) text.pop_back();
  text.erase(
      0, size_t(std::find_if(text.begin(), text.end(), [](char c) { return !isWhite(c); }) - text.begin()));
  return text;
}

void WordReader::dataBegins() {
  if (!lineEnded_ && !line().empty()) fail("expected the end of the line before data");
}

void WordReader::skipBytes(int64_t bytes) {
  if (bytes < 0 || bytes > size_ - at_)
    fail("the file ends, expected " + std::to_string(bytes) + " bytes of data, there are " +
         std::to_string(size_ - at_));
  at_ += bytes;
  lineEnded_ = false;
}

void WordReader::skipWords(int64_t words) {
  for (; words > 0; --words) {
    while (isWhite(peek())) ++at_;
    if (peek() < 0) fail("the file ends, expected " + std::to_string(words) + " more numbers");
    for (int c = peek(); c >= 0 && !isWhite(c); c = peek()) ++at_;
  }
  lineEnded_ = false;
}

void WordReader::fail(const std::string& what) const {
  throw Error(file_->path() + ": near byte " + std::to_string(at_) + ": " + what);
}

}  // namespace gxy
