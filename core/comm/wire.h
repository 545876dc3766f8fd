// SPDX-License-Identifier: Apache-2.0
// Messages as bytes. Values stand one after the other in the machine's own representation, since all ranks of
// a job run the same program. Lengths are 64-bit. Reading is bounds-checked: no message, however malformed,
// makes the reader read out of bounds or allocate more than the message's own size.
#pragma once
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/transport.h"

namespace gxy {

/// A type whose values can be written as their bytes. It must not contain pointers, which the compiler cannot
/// check.
template <class T>
concept Plain = std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>;

/// Appends values to a message.
class Writer {
 public:
  template <Plain T>
  Writer& write(const T& value) {
    append(&value, sizeof(T));
    return *this;
  }

  /// Writes the number of elements, then the elements.
  template <Plain T>
  Writer& write(std::span<const T> values) {
    write(uint64_t(values.size()));
    append(values.data(), values.size_bytes());
    return *this;
  }
  template <Plain T>
  Writer& write(const std::vector<T>& values) {
    return write(std::span<const T>(values));
  }
  Writer& write(std::string_view text) { return write(std::span<const char>(text)); }
  Writer& write(const std::string& text) { return write(std::string_view(text)); }
  Writer& write(const char* text) { return write(std::string_view(text)); }

  /// Moves the message out. The writer is empty afterwards.
  Bytes take() { return std::exchange(bytes_, {}); }

 private:
  void append(const void* data, size_t size);

  Bytes bytes_;
};

/// Reads values from a message. The message and `what` must outlive the reader. `what` names the message in
/// errors ("frame start").
class Reader {
 public:
  Reader(std::span<const std::byte> message, std::string_view what) : rest_(message), what_(what) {}

  /// Throws Error if too few bytes are left, or if a bool is neither 0 nor 1. The caller checks enumerations.
  template <Plain T>
  T read() {
    if constexpr (std::is_same_v<T, bool>) {
      const auto value = read<uint8_t>();
      if (value > 1) fail("a flag is " + std::to_string(value) + ", expected 0 or 1");
      return value == 1;
    } else {
      T value;
      std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
      return value;
    }
  }

  /// Reads a list that Writer wrote. Throws Error if the list is longer than the rest of the message.
  template <Plain T>
  std::vector<T> readVector() {
    const auto count = read<uint64_t>();
    if (count > rest_.size() / sizeof(T))
      fail("a list of " + std::to_string(count) + " elements of " + std::to_string(sizeof(T)) +
           " bytes was announced, expected at most the " + std::to_string(rest_.size()) +
           " bytes that are left");
    std::vector<T> values(count);
    const auto bytes = take(count * sizeof(T));
    if (count) std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }
  std::string readString() {
    const auto text = readVector<char>();
    return {text.begin(), text.end()};
  }

  /// The bytes that have not been read.
  std::span<const std::byte> rest() const { return rest_; }

  /// Throws Error unless everything has been read.
  void expectEnd() const {
    if (!rest_.empty()) fail(std::to_string(rest_.size()) + " bytes follow, expected the end of the message");
  }

  /// Throws an Error about this message.
  [[noreturn]] void fail(const std::string& reason) const;

 private:
  std::span<const std::byte> take(size_t size);

  std::span<const std::byte> rest_;
  std::string_view what_;
};

}  // namespace gxy
