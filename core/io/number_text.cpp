// SPDX-License-Identifier: Apache-2.0
#include "core/io/number_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/comm/parallel_for.h"

namespace gxy {
namespace {

bool isBlank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// The words of a stream. No word is longer than kLongest.
class StreamWords {
 public:
  explicit StreamWords(ByteStreamPtr text) : text_(std::move(text)), buffer_(size_t(64) << 10) {}

  /// Returns the next word, which is valid until the next call; empty at the end.
  std::string_view next() {
    for (;;) {
      while (at_ < filled_ && isBlank(buffer_[at_])) ++at_;
      size_t end = at_;
      while (end < filled_ && !isBlank(buffer_[end]) && buffer_[end] != '<') ++end;
      if (end < filled_ || ended_ || end - at_ > kLongest) {
        const std::string_view word(buffer_.data() + at_, end - at_);
        at_ = end;
        return word;
      }
      std::memmove(buffer_.data(), buffer_.data() + at_, filled_ - at_);
      filled_ -= at_;
      at_ = 0;
      const size_t n =
          text_->read(std::as_writable_bytes(std::span(buffer_.data() + filled_, buffer_.size() - filled_)));
      ended_ = n < buffer_.size() - filled_;
      filled_ += n;
    }
  }

 private:
  static constexpr size_t kLongest = 4096;
  ByteStreamPtr text_;
  std::vector<char> buffer_;
  size_t at_ = 0, filled_ = 0;
  bool ended_ = false;
};

template <class T>
std::optional<T> valueOf(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  T value{};
  const char* const last = word.data() + word.size();
  const auto [end, error] = std::from_chars(word.data(), last, value);
  if (end != last || error == std::errc::invalid_argument) return {};
  if (error == std::errc()) return value;
  if constexpr (std::is_integral_v<T>) return {};
  // The number is out of range: too small or too large for the type.
  double wide{};
  if (std::from_chars(word.data(), last, wide).ec == std::errc()) return T(wide);
  const size_t exponent = word.find_first_of("eE");
  const bool tiny = exponent != word.npos && word.substr(exponent + 1).starts_with('-');
  const T size = tiny                                   ? T(0)
                 : std::numeric_limits<T>::has_infinity ? std::numeric_limits<T>::infinity()
                                                        : T(0);
  return word.starts_with('-') ? T(-size) : size;
}

class NumbersOfText final : public ByteStream {
 public:
  /// The first `passed` words are passed over.
  NumbersOfText(ByteStreamPtr text, ScalarType type, std::string where, int64_t passed)
      : words_(std::move(text)), type_(type), where_(std::move(where)) {
    while (passed-- > 0 && !words_.next().empty()) {
    }
  }

  size_t read(std::span<std::byte> out) override {
    return withType(type_, [&](auto zero) { return readAs<decltype(zero)>(out); });
  }

 private:
  template <class T>
  size_t readAs(std::span<std::byte> out) {
    size_t made = 0;
    for (; made + sizeof(T) <= out.size(); made += sizeof(T)) {
      const std::string_view word = words_.next();
      if (word.empty()) break;
      const std::optional<T> value = valueOf<T>(word);
      if (!value)
        throw Error(where_ + ": found " + inQuotes(word.substr(0, 40)) + ", expected a number of type " +
                    nameOf(type_));
      std::memcpy(out.data() + made, &*value, sizeof(T));
    }
    return made;
  }

  StreamWords words_;
  const ScalarType type_;
  const std::string where_;
};

/// A word in a file, and how many words are before it.
struct WordPlace {
  int64_t position, number;
};

/// The words that begin in a part of a text.
struct WordsFound {
  int64_t count = 0;
  size_t first = 0;    ///< where the first one begins
  bool ended = false;  ///< there is a '<' behind them
};

/// `before`: the character before the part.
WordsFound wordsIn(std::string_view part, char before) {
  WordsFound found;
  const size_t end = part.find('<');
  found.ended = end != part.npos;
  part = part.substr(0, end);
  const auto begins = [&](size_t i) { return !isBlank(part[i]) && isBlank(i > 0 ? part[i - 1] : before); };
  while (found.first < part.size() && !begins(found.first)) found.first++;
  for (size_t i = std::max(found.first, size_t(1)); i < part.size(); i++)
    found.count += !isBlank(part[i]) && isBlank(part[i - 1]);
  if (found.first == 0 && !part.empty()) found.count++;
  return found;
}

/// Returns the first word of each part of a text, of parts in which words begin, up to its end or word number `words`.
std::vector<WordPlace> wordPlaces(const File& file, int64_t position, int64_t words) {
  constexpr size_t kPart = size_t(64) << 10, kParts = 64;  // 4 MiB are looked at together
  std::vector<WordPlace> places;
  std::string text;
  char before = ' ';
  int64_t number = 0;
  for (bool ended = false; !ended && number < words && position < file.size();) {
    text.resize(size_t(std::min(int64_t(kPart * kParts), file.size() - position)));
    file.readAt(position, std::as_writable_bytes(std::span(text)));
    std::array<WordsFound, kParts> found;
    const size_t parts = (text.size() + kPart - 1) / kPart;
    parallelFor(size_t(0), parts, [&](size_t i) {
      found[i] =
          wordsIn(std::string_view(text).substr(i * kPart, kPart), i > 0 ? text[i * kPart - 1] : before);
    });
    for (size_t i = 0; i < parts && !ended; i++) {
      if (found[i].count > 0) places.push_back({position + int64_t(i * kPart + found[i].first), number});
      number += found[i].count;
      ended = found[i].ended;
    }
    position += int64_t(text.size());
    before = text.back();
  }
  return places;
}

/// The numbers of a text in blocks of kEach.
class TextBlocks final : public BlockedBytes {
 public:
  TextBlocks(std::shared_ptr<const File> file, int64_t position, ScalarType type, int64_t bytes,
             std::string where)
      : file_(std::move(file)), position_(position), type_(type), bytes_(bytes), where_(std::move(where)) {}
  int64_t bytes() const override { return bytes_; }
  int64_t blockBytes() const override { return kEach * int64_t(bytesOf(type_)); }
  ByteStreamPtr open(int64_t block) const override {
    std::call_once(looked_, [&] {
      if (bytes_ > blockBytes()) places_ = wordPlaces(*file_, position_, bytes_ / int64_t(bytesOf(type_)));
    });
    WordPlace place{position_, 0};
    const auto behind =
        std::upper_bound(places_.begin(), places_.end(), block * kEach,
                         [](int64_t number, const WordPlace& p) { return number < p.number; });
    if (behind != places_.begin()) place = *std::prev(behind);
    return std::make_unique<NumbersOfText>(fileBytes(file_, place.position, file_->size()), type_, where_,
                                           block * kEach - place.number);
  }

 private:
  static constexpr int64_t kEach = 1 << 16;
  std::shared_ptr<const File> file_;
  int64_t position_;
  ScalarType type_;
  int64_t bytes_;
  std::string where_;
  mutable std::once_flag looked_;
  mutable std::vector<WordPlace> places_;  ///< in ascending order
};

}  // namespace

std::shared_ptr<const BlockedBytes> textBlocks(std::shared_ptr<const File> file, int64_t position,
                                               ScalarType type, int64_t bytes, const std::string& where) {
  return std::make_shared<TextBlocks>(std::move(file), position, type, bytes, where);
}

std::optional<double> valueOfText(std::string_view text) { return valueOf<double>(text); }

}  // namespace gxy
