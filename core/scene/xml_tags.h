// SPDX-License-Identifier: Apache-2.0
// Reads start tags and attributes of the small XML files that ParaView writes. Used inside core/scene only.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "core/comm/error.h"

namespace gxy {

/// Calls use(tag) for each tag in order. `tag` starts with < and does not include the closing >. Comments are
/// left out. Throws Error if the text ends inside a tag.
template <class Use>
void forEachTag(std::string_view text, const std::string& sourceName, const Use& use) {
  for (size_t open = text.find('<'); open != std::string_view::npos; open = text.find('<', open + 1)) {
    const bool comment = text.substr(open).starts_with("<!--");
    const size_t close = text.find(comment ? "-->" : ">", open);
    if (close == std::string_view::npos) throw Error(sourceName + ": ends inside a tag");
    if (!comment) use(text.substr(open, close - open));
    open = close;
  }
}

/// Returns the value of an attribute of a tag, with XML's entities replaced by characters, or nothing.
inline std::optional<std::string> attributeOf(std::string_view tag, std::string_view name) {
  for (size_t at = tag.find(name); at != std::string_view::npos; at = tag.find(name, at + 1)) {
    const std::string_view rest = tag.substr(at + name.size());
    const bool begins = at > 0 && std::string_view(" \t\r\n").find(tag[at - 1]) != std::string_view::npos;
    if (!begins || rest.size() < 3 || rest[0] != '=' || (rest[1] != '"' && rest[1] != '\'')) continue;
    const size_t end = rest.find(rest[1], 2);
    if (end == std::string_view::npos) return {};
    std::string value(rest.substr(2, end - 2));
    for (const auto& [entity, character] :
         {std::pair("&lt;", "<"), {"&gt;", ">"}, {"&quot;", "\""}, {"&apos;", "'"}, {"&amp;", "&"}})
      for (size_t i = 0; (i = value.find(entity, i)) != std::string::npos; i++)
        value.replace(i, std::string_view(entity).size(), character);
    return value;
  }
  return {};
}

}  // namespace gxy
