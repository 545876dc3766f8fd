// SPDX-License-Identifier: Apache-2.0
// Writes a State, and the reference tables of docs/state-file.md. Both are driven by the schema.
#include <algorithm>
#include <cmath>

#include "core/comm/error.h"
#include "core/scene/dataset_type.h"
#include "core/scene/filter_schema.h"
#include "core/scene/schema.h"
#include "core/scene/state_file.h"

namespace gxy {
namespace {

/// Numbers have the fewest digits that read back as the same double.
std::string onOneLine(const OrderedJson& value) {
  if (value.is_array()) {
    std::string out;
    for (const OrderedJson& item : value) out += (out.empty() ? "" : ", ") + onOneLine(item);
    return "[" + out + "]";
  }
  if (value.is_number_float() && !std::isfinite(value.get<double>())) {
    throw Error("state: a number that is not finite cannot be saved");
  }
  return value.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

/// Prints an object with one key a line, and a list on one line if it is short and contains no objects.
void print(const OrderedJson& value, const std::string& indent, std::string& out) {
  constexpr size_t kLineLength = 100;
  const std::string deeper = indent + "  ";
  const bool list = value.is_array();
  if (!list && !value.is_object()) {
    out += onOneLine(value);
    return;
  }
  const bool flat =
      list && std::none_of(value.begin(), value.end(), [](const auto& v) { return v.is_object(); });
  if (flat) {
    const std::string line = onOneLine(value);
    const bool leaf = std::none_of(value.begin(), value.end(), [](const auto& v) { return v.is_array(); });
    if (leaf || line.size() + indent.size() <= kLineLength) {
      out += line;
      return;
    }
  }
  out += list ? "[" : "{";
  bool first = true;
  for (const auto& [key, item] : value.items()) {
    out += (first ? "\n" : ",\n") + deeper;
    first = false;
    if (!list) out += OrderedJson(key).dump() + ": ";
    print(item, deeper, out);
  }
  out += (first ? "" : "\n" + indent) + (list ? "]" : "}");
}

std::string code(const std::string& text) { return "`" + text + "`"; }

std::string applicability(const KeyInfo& info) {
  if (info.appliesTo == ~0u) return "";
  std::string out;
  for (int i = 0; i < kDatasetTypes; ++i)
    if (info.appliesTo & bitOf(DatasetType(i)))
      out += (out.empty() ? "" : ", ") + std::string(nameOf(DatasetType(i)));
  return " (" + out + (info.needs.empty() ? "" : " with " + code(info.needs)) + ")";
}

template <class T>
std::string defaultOf(const KeyRow<T>& key) {
  if (key.info.required) return "required";
  return key.info.defaultText.empty() ? code(onOneLine(key.write(T{}))) : key.info.defaultText;
}

template <class T>
std::string table(const Schema<T>& schema) {
  std::string title = schema.title;
  title[0] = char(std::toupper(static_cast<unsigned char>(title[0])));
  std::string out = "### " + title + "\n\n| key | value | default | meaning |\n|---|---|---|---|\n";
  for (const KeyRow<T>& key : schema.keys) {
    std::string names = code(key.info.name);
    for (const std::string& alias : key.info.aliases) names += ", " + code(alias);
    out += "| " + names + " | " + key.info.type + " | " + defaultOf(key) + " | " + key.info.meaning +
           applicability(key.info) + " |\n";
  }
  return out;
}

}  // namespace

std::string writeState(const State& state) {
  std::string out;
  print(writeObject(state, stateSchema()), "", out);
  return out + "\n";
}

std::string stateReference() {
  return table(stateSchema()) + "\n" + table(datasetSchema()) + "\n" + table(filterEntrySchema()) + "\n" +
         table(rendererSchema()) + "\n" + table(visualizationSchema()) + "\n" + table(lightingSchema()) +
         "\n" + table(operatorSchema()) + "\n" + table(cameraSchema()) + "\n" + table(annotationsSchema());
}

}  // namespace gxy
