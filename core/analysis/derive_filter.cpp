// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/derive_filter.h"

#include <optional>

#include "core/comm/error.h"

namespace gxy {

std::vector<FieldInput> fieldsOf(const FilterRun& run, const std::string& filter) {
  std::vector<FieldInput> fields;
  for (const auto& [name, sources] : run.inputs())
    fields.push_back({name, sources.at(0).data->volume, sources.at(0).data->partitioning});
  if (fields.empty())
    throw Error(filter +
                ": there is no input, expected one or more: `\"inputs\": {\"f\": DATASET}` lets the "
                "expression call it `f`");
  return fields;
}

std::string readExpression(const Found& found) {
  const std::string& text = found.text();
  try {
    const Expression parsed(text);
  } catch (const Error& e) {
    found.context.fail(found.value.at, inQuotes(found.key, '`') + ": " + e.what());
  }
  return text;
}

std::function<void(int64_t)> WorkingMemory::teller() {
  return [this](int64_t bytes) {
    bytes_ += bytes;
    if (bytes > 0) {
      entries_.push_back(run_.takeMemory("derived", bytes));
      return;
    }
    // Memory that was given back is entered anew, as one entry.
    entries_.clear();
    if (bytes_ > 0) entries_.push_back(run_.takeMemory("derived", bytes_));
  };
}

FilterInfo Derive::info() {
  return {
      "Derive",
      1,
      "A field that an expression computes of others at each point of their grid: `curl(u)`, `sqrt(p / "
      "rho)`, `if(t > 300, t, nodata)`. "
      "Where there is no data in, or an operation has no result (division by 0), there is no data.",
      {{"any name", kVolumes, "A field; the expression calls it by this name.", FilterPort::Count::AnyName}},
      DatasetType::Volume};
}

std::vector<KeyRow<Derive>> Derive::properties() {
  return {customKey<Derive>(
              "expression", "text",
              "What is computed. [derived-fields.md](derived-fields.md) says what there is.",
              [](const Found& f, Derive& d) { d.expression = readExpression(f); },
              [](const Derive& d) { return OrderedJson(d.expression); })
              .require()};
}

FilterResult Derive::run(FilterRun& run) const {
  std::vector<FieldInput> fields;
  std::optional<Expression> parsed;
  run.begin(0, 1, "derived field");
  agree(run.ranks, [&] {
    fields = fieldsOf(run, "Derive");
    parsed.emplace(expression);
  });
  WorkingMemory working(run);
  DeriveOptions options;
  options.name = expression.size() <= 60 ? expression : expression.substr(0, 57) + "...";
  options.time = run.time();
  options.memory = working.teller();
  const DerivedField derived = derive(*parsed, fields, run.ranks, options);
  LedgerEntry memory;
  agree(run.ranks, [&] {
    working.giveBack();
    memory = run.takeMemory("volume", bytesOf(*derived.volume));
  });
  const Range& range = derived.volume->ranges.back();
  FilterResult result;
  result.dataset = run.made(derived.volume, fields.front().partitioning, std::move(memory));
  result.told = {{"range", range.empty() ? nlohmann::json() : nlohmann::json{range.min, range.max}},
                 {"no data", derived.noData},
                 {"components", derived.type.components()}};
  return result;
}

}  // namespace gxy
