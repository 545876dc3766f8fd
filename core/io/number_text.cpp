// SPDX-License-Identifier: Apache-2.0
#include "core/io/number_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/error_text.h"

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
  NumbersOfText(ByteStreamPtr text, ScalarType type, std::string where)
      : words_(std::move(text)), type_(type), where_(std::move(where)) {}

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

class TextBlock final : public BlockedBytes {
 public:
  TextBlock(std::shared_ptr<const File> file, int64_t position, ScalarType type, int64_t bytes,
            std::string where)
      : file_(std::move(file)), position_(position), type_(type), bytes_(bytes), where_(std::move(where)) {}
  int64_t bytes() const override { return bytes_; }
  int64_t blockBytes() const override { return std::max<int64_t>(bytes_, 1); }
  ByteStreamPtr open(int64_t) const override {
    return numbersOfText(fileBytes(file_, position_, file_->size()), type_, where_);
  }

 private:
  std::shared_ptr<const File> file_;
  int64_t position_;
  ScalarType type_;
  int64_t bytes_;
  std::string where_;
};

}  // namespace

std::shared_ptr<const BlockedBytes> textBlock(std::shared_ptr<const File> file, int64_t position,
                                              ScalarType type, int64_t bytes, const std::string& where) {
  return std::make_shared<TextBlock>(std::move(file), position, type, bytes, where);
}

std::optional<double> valueOfText(std::string_view text) { return valueOf<double>(text); }

ByteStreamPtr numbersOfText(ByteStreamPtr text, ScalarType type, const std::string& where) {
  return std::make_unique<NumbersOfText>(std::move(text), type, where);
}

}  // namespace gxy
