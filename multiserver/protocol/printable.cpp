// SPDX-License-Identifier: Apache-2.0
#include "gxy/protocol/printable.h"

#include <cstdint>
#include <cstdio>

#include "gxy/protocol/json.h"

namespace gxy::protocol {

namespace {

// Of a character in UTF-8: whether it is U+0080 to U+009F.
bool isHighControl(std::string_view c) { return c.size() == 2 && c[0] == '\xC2' && uint8_t(c[1]) < 0xA0; }

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  for (size_t i = 0; i < text.size();) {
    size_t length = 1;
    while (length < 4 && !isUtf8(text.substr(i, length))) length++;
    const std::string_view c = text.substr(i, length);
    if (!isUtf8(c)) {
      out += "\uFFFD";
      i++;
      continue;
    }
    const bool control = (uint8_t(c[0]) < 0x20 && c != "\n" && c != "\t") || c == "\x7F" || isHighControl(c);
    out += control ? std::string_view("\uFFFD") : c;
    i += length;
  }
  return out;
}

std::string printableJson(std::string_view json) {
  std::string out;
  for (size_t i = 0; i < json.size(); i++) {
    const bool high = isHighControl(json.substr(i, 2));
    if (!high && json[i] != '\x7F') {
      out += json[i];
      continue;
    }
    if (high) i++;
    char escape[8];
    std::snprintf(escape, sizeof escape, "\\u%04x", unsigned(uint8_t(json[i])));
    out += escape;
  }
  return out;
}

}  // namespace gxy::protocol
