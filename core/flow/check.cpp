// SPDX-License-Identifier: Apache-2.0
// What an edit must not say.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/flow/document.h"
#include "core/scene/json_text.h"

namespace gxy::flow {
namespace {

void checkEachOnce(std::set<std::string>& names, const std::string& name, const std::string& kind) {
  if (name.empty()) throw Error(kind + " without a name; expected one by which others can call it");
  if (!names.insert(name).second)
    throw Error("two " + kind + "s named " + inQuotes(name) + "; expected each name once");
}

bool hasKey(const nlohmann::json& own, const KeyInfo& info) {
  return own.contains(info.name) ||
         std::any_of(info.aliases.begin(), info.aliases.end(),
                     [&](const std::string& alias) { return own.contains(alias); });
}

nlohmann::json objectOf(const DatasetSpec& dataset) {
  const std::string text = dataset.properties.empty() ? "{}" : dataset.properties;
  nlohmann::json own = nlohmann::json::parse(text, nullptr, false);
  if (!own.is_object())
    throw Error("dataset " + inQuotes(dataset.name) + ": properties: expected a JSON object, found " +
                inQuotes(text));
  return own;
}

}  // namespace

void checkNamesAndLimits(const Document& document) {
  const size_t nodes = document.datasets.size() + document.views.size() + document.outputs.size();
  if (nodes > kMostNodes)
    throw Error("the graph has " + std::to_string(nodes) + " nodes; expected at most " +
                std::to_string(kMostNodes));
  size_t edges = document.outputs.size();
  std::set<std::string> datasets, views, outputs;
  for (const DatasetSpec& dataset : document.datasets) {
    checkEachOnce(datasets, dataset.name, "dataset");
    for (const FilterInput& input : dataset.inputs) edges += input.datasets.size();
  }
  for (const ViewSpec& view : document.views) {
    checkEachOnce(views, view.name, "view");
    edges += view.datasets.size();
  }
  for (const OutputSpec& output : document.outputs) checkEachOnce(outputs, output.name, "output");
  if (edges > kMostEdges)
    throw Error("the graph has " + std::to_string(edges) + " edges; expected at most " +
                std::to_string(kMostEdges));
}

void checkTypes(const Document& document, const FilterSchemas& filters) {
  std::map<std::string, const DatasetSpec*> byName;
  for (const DatasetSpec& dataset : document.datasets) byName[dataset.name] = &dataset;
  const auto makesNone = [&](const std::string& name) {
    const auto found = byName.find(name);
    if (found == byName.end() || found->second->filter.empty()) return false;
    const FilterSchema* filter = filters.find(found->second->filter);
    return filter && !filter->makes;
  };
  // Nothing is known of what a filter makes that this program does not have.
  const auto typeOf = [&](const std::string& name) -> std::optional<DatasetType> {
    const auto found = byName.find(name);
    if (found == byName.end()) return std::nullopt;
    if (found->second->filter.empty()) return found->second->type;
    const FilterSchema* filter = filters.find(found->second->filter);
    return filter ? filter->makes : std::nullopt;
  };
  for (const DatasetSpec& dataset : document.datasets) {
    const FilterSchema* filter = dataset.filter.empty() ? nullptr : filters.find(dataset.filter);
    if (!filter) continue;
    checkInputs(*filter, dataset, typeOf, Missing::Allowed);
    for (const FilterInput& input : dataset.inputs)
      for (const std::string& name : input.datasets)
        if (makesNone(name))
          throw Error("dataset " + inQuotes(dataset.name) + ": input " + inQuotes(input.input, '`') +
                      ": expected " + namesOf(filter->port(input.input)->types) + ", found " +
                      inQuotes(name) + ", of which filter " + byName[name]->filter + " makes numbers only");
  }
  for (const ViewSpec& view : document.views)
    for (const std::string& name : view.datasets)
      if (makesNone(name))
        throw Error("view " + inQuotes(view.name) + ": expected datasets, found " + inQuotes(name) +
                    ", of which filter " + byName[name]->filter + " makes numbers only");
}

std::optional<std::string> canonicalProperties(const DatasetSpec& dataset, const FilterSchema& filter,
                                               std::string& missing, std::vector<std::string>& warnings) {
  const nlohmann::json own = objectOf(dataset);
  for (const KeyInfo& info : filter.properties)
    if (info.required && !hasKey(own, info)) {
      missing = info.name;
      return std::nullopt;
    }
  ReadContext context;
  context.sourceName = "dataset " + inQuotes(dataset.name);
  const std::string text = filter.read(
      context, parseJson(dataset.properties.empty() ? "{}" : dataset.properties, context.sourceName));
  warnings.insert(warnings.end(), context.warnings.begin(), context.warnings.end());
  return nlohmann::json::parse(text).dump();  // keys sorted
}

}  // namespace gxy::flow
