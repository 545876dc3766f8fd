// SPDX-License-Identifier: Apache-2.0
#include "gxy/protocol/json.h"

#include "gxy/comm/error.h"
#include "gxy/scene/json_text.h"

namespace gxy::protocol {

nlohmann::json parseObject(std::string_view text, const std::string& what) {
  const JsonValue checked = parseJson(text, what);
  if (!checked.object())
    throw Error(locationPrefix(what, checked.at) + "expected a JSON object, found " + checked.describe());
  return nlohmann::json::parse(text);
}

std::string dump(const nlohmann::json& value) {
  return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

bool isUtf8(std::string_view text) {
  for (size_t i = 0; i < text.size();) {
    const auto first = uint8_t(text[i]);
    const int length = first < 0x80             ? 1
                       : (first & 0xE0) == 0xC0 ? 2
                       : (first & 0xF0) == 0xE0 ? 3
                       : (first & 0xF8) == 0xF0 ? 4
                                                : 0;
    if (length == 0 || i + size_t(length) > text.size()) return false;
    uint32_t point = length == 1 ? first : first & (0x7F >> length);
    for (int k = 1; k < length; k++) {
      const auto next = uint8_t(text[i + size_t(k)]);
      if ((next & 0xC0) != 0x80) return false;
      point = point << 6 | (next & 0x3F);
    }
    constexpr uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
    if (point < kLeast[length] || point > 0x10FFFF || (point >= 0xD800 && point < 0xE000)) return false;
    i += size_t(length);
  }
  return true;
}

}  // namespace gxy::protocol
