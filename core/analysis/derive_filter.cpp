// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/derive_filter.h"

#include <optional>
#include <span>

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

std::vector<MeshInput> meshFieldsOf(const FilterRun& run, const std::string& filter) {
  std::vector<MeshInput> fields;
  for (const auto& [name, sources] : run.inputs())
    if (sources.at(0).data->mesh)
      fields.push_back({name, sources.at(0).data->mesh, sources.at(0).data->partitioning});
  if (!fields.empty() && fields.size() < run.inputs().size())
    throw Error(filter + ": " + inQuotes(fields[0].name, '`') +
                " is an unstructured volume, and another input is on a grid, expected fields of one of both; "
                "Resample puts a field on a grid");
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
  return {"Derive",
          1,
          "A field that an expression computes of others at each point of their grid: `curl(u)`, `sqrt(p / "
          "rho)`, `if(t > 300, t, nodata)`. "
          "Where there is no data in, or an operation has no result (division by 0), there is no data. "
          "Fields of one unstructured "
          "volume give another on the same points and cells, without differentials.",
          {{"any name", kVolumes | kUnstructured, "A field; the expression calls it by this name.",
            FilterPort::Count::AnyName}},
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

namespace {

nlohmann::json toldOf(const Range& range, int64_t noData, ValueType type) {
  return {{"range", range.empty() ? nlohmann::json() : nlohmann::json{range.min, range.max}},
          {"no data", noData},
          {"components", type.components()}};
}

// What datasets have in common with others of their mesh is accounted for once.
FilterResult derivedMesh(FilterRun& run, const Expression& parsed, std::span<const MeshInput> fields,
                         const DeriveOptions& options, WorkingMemory& working) {
  const DerivedMesh derived = derive(parsed, fields, run.ranks, options);
  const Dataset& like = *run.inputs().begin()->second.at(0).data;
  FilterResult result;
  agree(run.ranks, [&] {
    working.giveBack();
    const auto dataset = std::make_shared<Dataset>();
    dataset->bytes = bytesOf(*derived.mesh);
    dataset->sharedMemory = like.sharedMemory;
    dataset->memory =
        run.takeMemory("volume", like.sharedMemory ? bytesOfValues(*derived.mesh) : dataset->bytes);
    dataset->mesh = derived.mesh;
    dataset->partitioning = fields.front().partitioning;
    result.dataset = dataset;
  });
  result.told = toldOf(derived.mesh->ranges.back(), derived.noData, derived.type);
  return result;
}

}  // namespace

FilterResult Derive::run(FilterRun& run) const {
  std::vector<FieldInput> fields;
  std::vector<MeshInput> meshFields;
  std::optional<Expression> parsed;
  run.begin(0, 1, "derived field");
  agree(run.ranks, [&] {
    meshFields = meshFieldsOf(run, "Derive");
    if (meshFields.empty()) fields = fieldsOf(run, "Derive");
    parsed.emplace(expression);
  });
  WorkingMemory working(run);
  DeriveOptions options;
  options.name = expression.size() <= 60 ? expression : expression.substr(0, 57) + "...";
  options.time = run.time();
  options.memory = working.teller();
  if (!meshFields.empty()) return derivedMesh(run, *parsed, meshFields, options, working);
  const DerivedField derived = derive(*parsed, fields, run.ranks, options);
  LedgerEntry memory;
  agree(run.ranks, [&] {
    working.giveBack();
    memory = run.takeMemory("volume", bytesOf(*derived.volume));
  });
  FilterResult result;
  result.dataset = run.made(derived.volume, fields.front().partitioning, std::move(memory));
  result.told = toldOf(derived.volume->ranges.back(), derived.noData, derived.type);
  return result;
}

}  // namespace gxy
