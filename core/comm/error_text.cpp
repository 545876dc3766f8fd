// SPDX-License-Identifier: Apache-2.0
#include "core/comm/error_text.h"

#include <algorithm>

namespace gxy {

std::string inQuotes(std::string_view text, char quote) {
  constexpr size_t kLongest = 60;
  const bool cut = text.size() > kLongest;
  size_t length = std::min(text.size(), kLongest);
  while (cut && length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0) == 0x80) --length;
  const auto byte = [&](size_t i) { return i < length ? static_cast<unsigned char>(text[i]) : 0u; };
  std::string out(1, quote);
  for (size_t i = 0; i < length; i++) {
    const bool c1 = byte(i) == 0xC2 && byte(i + 1) >= 0x80 && byte(i + 1) <= 0x9F;  // U+0080 to U+009F
    out += c1 || byte(i) < 0x20 || byte(i) == 0x7F ? '?' : text[i];
    i += c1;
  }
  return out + (cut ? "..." : "") + quote;
}

}  // namespace gxy
