// SPDX-License-Identifier: Apache-2.0
#include "multiserver/protocol/json.h"

#include <algorithm>
#include <cstdio>

#include "core/comm/error.h"
#include "core/scene/json_text.h"

namespace gxy::protocol {

nlohmann::json parseObject(std::string_view text, const std::string& what) {
  const JsonValue checked = parseJson(text, what);
  if (!checked.object())
    throw Error(locationPrefix(what, checked.at) + "expected a JSON object, found " + checked.describe());
  return nlohmann::json::parse(text);
}

namespace {

// Parsing works for any depth, but functions that visit the value afterwards are recursive.
bool tooDeep(std::string_view text) {
  size_t depth = 0;
  bool inString = false;
  for (size_t i = 0; i < text.size(); i++) {
    const char c = text[i];
    if (inString) {
      i += c == '\\';
      inString = c != '"';
    } else if (c == '"') {
      inString = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxJsonDepth) return true;
    } else if (c == ']' || c == '}') {
      depth -= depth > 0;
    }
  }
  return false;
}

}  // namespace

nlohmann::json parseAnswer(std::string_view text, const std::string& what) {
  if (tooDeep(text))
    throw Error(what + ": expected arrays and objects at most " + std::to_string(kMaxJsonDepth) + " deep");
  try {
    nlohmann::json value = nlohmann::json::parse(text);
    if (value.is_object()) return value;
    throw Error("expected a JSON object, found " + std::string(value.type_name()));
  } catch (const std::exception& e) {
    throw Error(what + ": " + e.what());
  }
}

std::string dump(const nlohmann::json& value) {
  return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

namespace {

struct Character {
  uint32_t point = 0;
  size_t bytes = 0;  ///< 0: not UTF-8
};

// Returns the first character of a text.
Character firstOf(std::string_view text) {
  const auto first = uint8_t(text[0]);
  const size_t length = first < 0x80             ? 1
                        : (first & 0xE0) == 0xC0 ? 2
                        : (first & 0xF0) == 0xE0 ? 3
                        : (first & 0xF8) == 0xF0 ? 4
                                                 : 0;
  if (length == 0 || length > text.size()) return {};
  uint32_t point = length == 1 ? first : first & (0x7F >> length);
  for (size_t k = 1; k < length; k++) {
    const auto next = uint8_t(text[k]);
    if ((next & 0xC0) != 0x80) return {};
    point = point << 6 | (next & 0x3F);
  }
  constexpr uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  if (point < kLeast[length] || point > 0x10FFFF || (point >= 0xD800 && point < 0xE000)) return {};
  return {point, length};
}

bool isControl(uint32_t point) { return point < 0x20 || (point >= 0x7F && point < 0xA0); }

}  // namespace

bool isUtf8(std::string_view text) {
  while (!text.empty()) {
    const Character c = firstOf(text);
    if (c.bytes == 0) return false;
    text.remove_prefix(c.bytes);
  }
  return true;
}

bool hasControls(std::string_view text) {
  while (!text.empty()) {
    const Character c = firstOf(text);
    if (c.bytes > 0 && isControl(c.point)) return true;
    text.remove_prefix(std::max(c.bytes, size_t(1)));
  }
  return false;
}

std::string printable(std::string_view text) {
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const Character c = firstOf(text);
    const bool blank = c.point == '\n' || c.point == '\t';
    if (c.bytes == 0 || (isControl(c.point) && !blank))
      shown += "\uFFFD";
    else
      shown += text.substr(0, c.bytes);
    text.remove_prefix(std::max(c.bytes, size_t(1)));
  }
  return shown;
}

std::string printableJson(std::string_view json) {
  std::string shown;
  shown.reserve(json.size());
  while (!json.empty()) {
    const Character c = firstOf(json);
    const size_t bytes = std::max(c.bytes, size_t(1));
    if (c.point >= 0x7F && isControl(c.point)) {
      char escape[8];
      std::snprintf(escape, sizeof escape, "\\u%04x", unsigned(c.point));
      shown += escape;
    } else {
      shown += json.substr(0, bytes);
    }
    json.remove_prefix(bytes);
  }
  return shown;
}

}  // namespace gxy::protocol
