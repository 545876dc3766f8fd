// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/filter.h"

#include <cmath>

#include "core/comm/error.h"
#include "core/data/geometry_bytes.h"
#include "core/scene/dataset_type.h"

namespace gxy {
namespace {

std::vector<const FilterSource*> sourcesOf(const FilterRun& run) {
  std::vector<const FilterSource*> sources;
  for (const auto& [port, list] : run.inputs())
    for (const FilterSource& source : list) sources.push_back(&source);
  return sources;
}

void checkTypes(const FilterSchema& schema, const FilterRun& run) {
  DatasetSpec entry;
  entry.filter = schema.name;
  std::map<std::string, DatasetType> types;
  for (const auto& [name, list] : run.inputs()) {
    FilterInput& input = entry.inputs.emplace_back(FilterInput{name, {}});
    const FilterPort* port = schema.port(name);
    for (const FilterSource& source : list) {
      if (!port || !(port->types & kUnstructured))
        refuseMesh(*source.data, source.name, "filter " + schema.name);
      input.datasets.push_back(source.name);
      types[source.name] = typeOf(*source.data);
    }
  }
  checkInputs(schema, entry, [&](const std::string& name) { return types.at(name); });
}

std::vector<Origin> originsOf(const FilterRun& run) {
  std::vector<InputOrigins> origins;
  for (const FilterSource* source : sourcesOf(run)) origins.push_back({source->name, source->data->origins});
  return originsOf(origins);
}

}  // namespace

const FilterSource* FilterRun::optional(const std::string& name) const {
  const auto found = inputs_.find(name);
  return found == inputs_.end() || found->second.empty() ? nullptr : &found->second.front();
}

double FilterRun::time() const {
  double time = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [port, list] : inputs_)
    for (const FilterSource& source : list) {
      const double other = source.data->time;
      if (std::isnan(other)) continue;
      if (!std::isnan(time) && time != other) return std::numeric_limits<double>::quiet_NaN();
      time = other;
    }
  return time;
}

Sampler& FilterRun::sampler() const {
  if (!services_.sampler) throw Error("this program cannot send rays for filters");
  return *services_.sampler;
}

std::shared_ptr<Dataset> FilterRun::made(std::shared_ptr<const Volume> volume,
                                         std::shared_ptr<const Partitioning> partitioning,
                                         LedgerEntry memory) const {
  const auto dataset = std::make_shared<Dataset>();
  dataset->bytes = bytesOf(*volume);
  dataset->volume = std::move(volume);
  dataset->partitioning = std::move(partitioning);
  dataset->memory = std::move(memory);
  dataset->memory.resize(dataset->bytes);
  return dataset;
}

std::shared_ptr<Dataset> FilterRun::made(std::shared_ptr<const OwnedGeometry> geometry,
                                         std::shared_ptr<const Partitioning> partitioning,
                                         LedgerEntry memory) const {
  const auto dataset = std::make_shared<Dataset>();
  dataset->bytes = bytesOf(geometry->block);
  dataset->geometry = std::move(geometry);
  dataset->partitioning = std::move(partitioning);
  dataset->memory = std::move(memory);
  dataset->memory.resize(dataset->bytes);
  return dataset;
}

FilterResult evaluate(const Filter& filter, FilterRun& run, const std::string& properties) {
  std::vector<Origin> origins;
  agree(run.ranks, [&] {
    checkTypes(filter.schema, run);
    origins = originsOf(run);
  });
  FilterResult result = filter.run(run, properties);
  if (!result.dataset) return result;
  Dataset& made = *result.dataset;
  made.origins = std::move(origins);
  if (std::isnan(made.time)) made.time = run.time();
  made.provenance = {filter.schema.name, filter.schema.version, properties, {}};
  for (const auto& [port, list] : run.inputs())
    for (const FilterSource& source : list)
      made.provenance.inputs.push_back({port, source.name, source.key, source.generation});
  return result;
}

std::string detail::sortedText(const OrderedJson& properties) {
  return nlohmann::json(properties).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void Filters::add(std::shared_ptr<const Filter> filter) {
  const std::string name = filter->schema.name;
  const std::lock_guard lock(mutex_);
  if (!filters_.emplace(name, std::move(filter)).second)
    throw Error("there is a filter " + inQuotes(name) + " already, expected another name");
}

const FilterSchema* Filters::find(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = filters_.find(name);
  return found == filters_.end() ? nullptr : &found->second->schema;
}

std::vector<std::string> Filters::names() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  for (const auto& [name, filter] : filters_) names.push_back(name);
  return names;
}

std::shared_ptr<const Filter> Filters::get(const std::string& name) const {
  {
    const std::lock_guard lock(mutex_);
    const auto found = filters_.find(name);
    if (found != filters_.end()) return found->second;
  }
  std::string known;
  for (const std::string& other : names()) known += (known.empty() ? "" : ", ") + inQuotes(other);
  throw Error("there is no filter " + inQuotes(name) + suggestion(name, names()) + "; expected one of " +
              known);
}

}  // namespace gxy
