// SPDX-License-Identifier: Apache-2.0
// Filters that compute nothing, for tests of documents and graphs.
#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/flow/document.h"

namespace gxy::test {

struct Amount {
  double by = 1;
};
inline const Schema<Amount>& amountSchema() {
  static const Schema<Amount> schema{"filter", {numberKey("by", &Amount::by, kAny, "How far.")}};
  return schema;
}

/// Shift and Add make volumes of volumes, Scatter makes particles, Trace makes lines of a volume and particles, Count makes numbers. All
/// have the property `by`, which only Scatter requires.
class FewFilters final : public FilterSchemas {
 public:
  FewFilters() {
    using Count = FilterPort::Count;
    add("Shift", {{"field", kVolumes, "."}}, DatasetType::Volume);
    add("Add", {{"fields", kVolumes, ".", Count::Many}}, DatasetType::Volume);
    add("Scatter", {{"field", kVolumes, "."}}, DatasetType::Particles, true);
    add("Trace", {{"vectors", kVolumes, "."}, {"seeds", kParticles, "."}}, DatasetType::PathLines);
    add("Count", {{"field", kVolumes | kParticles, "."}}, std::nullopt);
  }
  const FilterSchema* find(const std::string& name) const override {
    const auto found = filters_.find(name);
    return found == filters_.end() ? nullptr : &found->second;
  }
  std::vector<std::string> names() const override {
    std::vector<std::string> names;
    for (const auto& [name, filter] : filters_) names.push_back(name);
    return names;
  }
  FilterSchema& operator[](const std::string& name) { return filters_.at(name); }

 private:
  void add(const std::string& name, std::vector<FilterPort> inputs, std::optional<DatasetType> makes,
           bool required = false) {
    FilterSchema& filter = filters_[name];
    filter.name = name;
    filter.inputs = std::move(inputs);
    filter.makes = makes;
    filter.properties = {amountSchema().keys[0].info};
    filter.properties[0].required = required;
    filter.read = [](ReadContext& context, const JsonValue& own) {
      Amount amount;
      readObject(context, own, amountSchema(), amount);
      return writeObject(amount, amountSchema()).dump();
    };
  }
  std::map<std::string, FilterSchema> filters_;
};

inline DatasetSpec live(const std::string& name, DatasetType type = DatasetType::Volume) {
  DatasetSpec spec;
  spec.name = name;
  spec.type = type;
  return spec;
}

inline DatasetSpec made(const std::string& name, const std::string& filter, std::vector<FilterInput> inputs,
                        const std::string& properties = "") {
  DatasetSpec spec;
  spec.name = name;
  spec.filter = filter;
  spec.inputs = std::move(inputs);
  spec.properties = properties;
  return spec;
}

}  // namespace gxy::test
