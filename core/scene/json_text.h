// SPDX-License-Identifier: Apache-2.0
// JSON that remembers where everything stood, so that messages about a file's content can name line and
// column.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/comm/error_text.h"

namespace gxy {

/// Where a token starts in a text. Columns count characters (UTF-8 code points), both from 1.
struct TextPosition {
  int line = 1, column = 1;
  bool operator==(const TextPosition&) const = default;
};

struct JsonNumber {
  double value;
  bool integral;  ///< without fraction: 4, 4.0 and 4e0 alike
};

class JsonValue;
struct JsonMember;

/// One value of a JSON text. A plain value type: owns what is below it.
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

  /// The member of this name, or nullptr where there is none or this is no object.
  const JsonMember* find(std::string_view key) const;
  /// What this is, for a message: `"many"`, `3.5`, `an array of 4 values`; short whatever the value.
  std::string describe() const;
};

struct JsonMember {
  std::string key;
  TextPosition at;  ///< of the key
  JsonValue value;
};

// Bounds on what a hostile text can make us allocate or recurse into.
inline constexpr size_t kMaxJsonBytes = size_t{16} << 20;
inline constexpr size_t kMaxJsonValues = 1'000'000;
inline constexpr size_t kMaxJsonDepth = 64;

/// Parses RFC 8259 JSON (UTF-8, an optional byte order mark). Throws Error "SOURCE:LINE:COLUMN: ..." on a
/// syntax error, a key given twice in one object, a number beyond double, or a bound above. The position of a
/// syntax error is where the offending token starts; inside a string, the offending character.
JsonValue parseJson(std::string_view text, const std::string& sourceName);

/// "SOURCE:LINE:COLUMN: ", the start of every message about a text.
std::string locationPrefix(const std::string& sourceName, TextPosition at);

/// A number for a message: whole numbers without a point.
std::string numberText(double x);

}  // namespace gxy
