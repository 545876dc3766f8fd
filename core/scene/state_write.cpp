// SPDX-License-Identifier: Apache-2.0
// Writes a State, and the reference tables of docs/state-file.md. Both are driven by the schema.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/comm/error.h"
#include "core/scene/dataset_type.h"
#include "core/scene/filter_schema.h"
#include "core/scene/schema.h"
#include "core/scene/schema_table.h"
#include "core/scene/state_file.h"

namespace gxy {
namespace {

/// Prints an object with one key a line, and a list on one line if it is short and contains no objects.
void print(const OrderedJson& value, const std::string& indent, std::string& out) {
  constexpr size_t kLineLength = 100;
  const std::string deeper = indent + "  ";
  const bool list = value.is_array();
  if (!list && !value.is_object()) {
    out += jsonOnOneLine(value);
    return;
  }
  const bool flat =
      list && std::none_of(value.begin(), value.end(), [](const auto& v) { return v.is_object(); });
  if (flat) {
    const std::string line = jsonOnOneLine(value);
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

std::array<const char*, kDatasetTypes> typeNames() {
  std::array<const char*, kDatasetTypes> types{};
  for (int i = 0; i < kDatasetTypes; ++i) types[size_t(i)] = nameOf(DatasetType(i));
  return types;
}

template <class T>
std::string table(const Schema<T>& schema) {
  return schemaTable(schema, typeNames());
}

}  // namespace

std::string jsonOnOneLine(const OrderedJson& value) {
  if (value.is_array()) {
    std::string out;
    for (const OrderedJson& item : value) out += (out.empty() ? "" : ", ") + jsonOnOneLine(item);
    return "[" + out + "]";
  }
  if (value.is_number_float() && !std::isfinite(value.get<double>())) {
    throw Error("state: a number that is not finite cannot be saved");
  }
  return value.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

std::string writeState(const State& state) {
  std::string out;
  print(writeObject(state, stateSchema()), "", out);
  return out + "\n";
}

std::string stateTables() {
  const auto json = [](const auto& schema) { return schemaJson(schema, typeNames()); };
  return OrderedJson::array({json(datasetSchema()), json(filterEntrySchema()), json(rendererSchema()),
                             json(visualizationSchema()), json(lightingSchema()), json(operatorSchema()),
                             json(cameraSchema()), json(annotationsSchema()), json(outputSchema())})
      .dump();
}

std::string stateReference() {
  return table(stateSchema()) + "\n" + table(datasetSchema()) + "\n" + table(filterEntrySchema()) + "\n" +
         table(rendererSchema()) + "\n" + table(visualizationSchema()) + "\n" + table(lightingSchema()) +
         "\n" + table(operatorSchema()) + "\n" + table(cameraSchema()) + "\n" + table(annotationsSchema()) +
         "\n" + table(outputSchema());
}

}  // namespace gxy
