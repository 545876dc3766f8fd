// SPDX-License-Identifier: Apache-2.0
// Parses JSON and keeps the position of every value, so that messages about a file's content can name
// line and column.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/comm/error_text.h"

namespace gxy {

/// The position where a token starts in a text. Both numbers start at 1; columns count characters (UTF-8 code
/// points).
struct TextPosition {
  int line = 1, column = 1;
  bool operator==(const TextPosition&) const = default;
};

struct JsonNumber {
  double value;
  bool integral;  ///< the number has no fraction, however it is written: 4, 4.0, 4e0
};

class JsonValue;
struct JsonMember;

/// One value of a JSON text. It owns the values inside it.
class JsonValue {
 public:
  using Array = std::vector<JsonValue>;
  using Object = std::vector<JsonMember>;  ///< in the text's order, keys unique

  TextPosition at;
  std::variant<std::nullptr_t, bool, JsonNumber, std::string, Array, Object> value;

  const bool* boolean() const { return std::get_if<bool>(&value); }
  const JsonNumber* number() const { return std::get_if<JsonNumber>(&value); }
  const std::string* string() const { return std::get_if<std::string>(&value); }
  const Array* array() const { return std::get_if<Array>(&value); }
  const Object* object() const { return std::get_if<Object>(&value); }

  /// Returns the member with this key, or nullptr if there is none or this is no object.
  const JsonMember* find(std::string_view key) const;
  /// Describes the value in a message: `"many"`, `3.5`, `an array of 4 values`. The text is short for any value.
  std::string describe() const;
};

struct JsonMember {
  std::string key;
  TextPosition at;  ///< position of the key
  JsonValue value;
};

// Bounds on the memory and the recursion depth that a malicious text can cause.
inline constexpr size_t kMaxJsonBytes = size_t{16} << 20;
inline constexpr size_t kMaxJsonValues = 1'000'000;
inline constexpr size_t kMaxJsonDepth = 64;

/// Parses RFC 8259 JSON in UTF-8 with an optional byte order mark. Throws Error "SOURCE:LINE:COLUMN: ..." for
/// a syntax error, a key given twice in one object, a number beyond the range of double, or a text beyond the
/// bounds above. The position of a syntax error is the start of the offending token, or the offending
/// character inside a string.
JsonValue parseJson(std::string_view text, const std::string& sourceName);

/// Returns "SOURCE:LINE:COLUMN: ", the start of every message about a text.
std::string locationPrefix(const std::string& sourceName, TextPosition at);

/// Returns a number as text for messages, whole numbers without a decimal point.
std::string numberText(double x);

}  // namespace gxy
