// SPDX-License-Identifier: Apache-2.0
#include "multiserver/web/opening.h"

#include <algorithm>
#include <string_view>

namespace gxy {

Opening openingOf(std::span<const std::byte> first) {
  const std::string_view text(reinterpret_cast<const char*>(first.data()),
                              std::min(first.size(), kOpeningBytes));
  const auto begins = [&](std::string_view word) { return word.starts_with(text); };
  const bool whole = text.size() == kOpeningBytes;
  if (begins("GALA")) return whole ? Opening::Galaxy : Opening::Unknown;
  // Methods that are not served are here, too, so that they get the answer 405.
  for (const std::string_view method :
       {"GET ", "HEAD", "POST", "PUT ", "DELE", "OPTI", "PATC", "TRAC", "CONN"})
    if (begins(method)) return whole ? Opening::Web : Opening::Unknown;
  return Opening::Neither;
}

}  // namespace gxy
