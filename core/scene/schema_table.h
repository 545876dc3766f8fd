// SPDX-License-Identifier: Apache-2.0
// Tables of the reference, made from a schema: in Markdown for readers, in JSON for programs that make forms of them.
#pragma once
#include <cctype>
#include <span>
#include <string>

#include "core/scene/schema.h"

namespace gxy {

/// Returns JSON on one line. Numbers have the fewest digits that read back as the same double. Throws Error for NaN and infinity.
std::string jsonOnOneLine(const OrderedJson& value);

/// The names of the types to which a key applies, in the order of the bits of KeyInfo::appliesTo.
using TypeNames = std::span<const char* const>;

namespace detail {

inline std::string inCode(const std::string& text) { return "`" + text + "`"; }

inline std::string applicability(const KeyInfo& info, TypeNames types) {
  if (info.appliesTo == ~0u) return "";
  std::string out;
  for (unsigned i = 0; i < types.size(); ++i) {
    if (info.appliesTo & (1u << i)) out += (out.empty() ? "" : ", ") + std::string(types[i]);
  }
  return " (" + out + (info.needs.empty() ? "" : " with " + inCode(info.needs)) + ")";
}

template <class T>
std::string defaultOf(const KeyRow<T>& key) {
  if (key.info.required) return "required";
  return key.info.defaultText.empty() ? inCode(jsonOnOneLine(key.write(T{}))) : key.info.defaultText;
}

}  // namespace detail

/// Returns the table of a schema, with its title.
template <class T>
std::string schemaTable(const Schema<T>& schema, TypeNames types) {
  std::string title = schema.title;
  title[0] = char(std::toupper(static_cast<unsigned char>(title[0])));
  std::string out = "### " + title + "\n\n| key | value | default | meaning |\n|---|---|---|---|\n";
  for (const KeyRow<T>& key : schema.keys) {
    std::string names = detail::inCode(key.info.name);
    for (const std::string& alias : key.info.aliases) names += ", " + detail::inCode(alias);
    out += "| " + names + " | " + key.info.type + " | " + detail::defaultOf(key) + " | " + key.info.meaning +
           detail::applicability(key.info, types) + " |\n";
  }
  return out;
}

/// Returns what schemaTable() says, as an object: `section` (the title), and `keys`, a list of objects with `key`, `aliases`, `type`,
/// `default`, `required`, `advanced`, `help` and, where the key applies to some types only, `types` and, perhaps, `needs`.
template <class T>
OrderedJson schemaJson(const Schema<T>& schema, TypeNames types) {
  OrderedJson keys = OrderedJson::array();
  for (const KeyRow<T>& key : schema.keys) {
    const KeyInfo& info = key.info;
    OrderedJson& out = keys.emplace_back(OrderedJson{{"key", info.name},
                                                     {"aliases", info.aliases},
                                                     {"type", info.type},
                                                     {"default", info.required ? "" : detail::defaultOf(key)},
                                                     {"required", info.required},
                                                     {"advanced", info.advanced},
                                                     {"help", info.meaning}});
    if (!info.needs.empty()) out["needs"] = info.needs;
    if (info.appliesTo == ~0u) continue;
    out["types"] = OrderedJson::array();
    for (unsigned i = 0; i < types.size(); ++i)
      if (info.appliesTo & (1u << i)) out["types"].push_back(types[i]);
  }
  return {{"section", schema.title}, {"keys", keys}};
}

}  // namespace gxy
