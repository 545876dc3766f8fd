// SPDX-License-Identifier: Apache-2.0
// libFuzzer target: a document and edits of it, as JSON in two lines. Any edits give an Error, or a document that the inverse edits make
// what it was.
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/comm/error.h"
#include "multiserver/graph/document_edits.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using nlohmann::json;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const size_t end = text.find('\n');
  if (end == std::string_view::npos) return 0;
  const json document = json::parse(text.substr(0, end), nullptr, false);
  const json edits = json::parse(text.substr(end + 1), nullptr, false);
  if (!document.is_object() || edits.is_discarded()) return 0;  // A graph's document is an object.
  gxy::EditedDocument made;
  try {
    made = gxy::edited(document, edits);
  } catch (const gxy::Error&) {
    return 0;
  }
  if (gxy::edited(made.document, made.inverse).document != document) std::abort();
  return 0;
}
