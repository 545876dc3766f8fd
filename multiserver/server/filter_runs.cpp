// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/filter_runs.h"

#include <algorithm>
#include <optional>

#include "core/comm/error.h"
#include "core/scene/filter_schema.h"
#include "multiserver/server/module.h"

namespace gxy {

using nlohmann::json;

namespace {

/// A dataset that a filter reads, as rank 0 tells the others.
struct SourceRef {
  std::string input, name;
  uint64_t key = 0, generation = 0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SourceRef, input, name, key, generation)

/// On each rank: evaluates a filter, and publishes what it makes.
struct MakeWork {
  static constexpr const char* name = "filters.make";
  static constexpr Work::Runs runs = Work::Runs::Long;
  uint64_t exchange = 0;
  json items;  ///< what is published; empty if the filter makes no dataset
  std::string filter, properties, tenant;
  uint32_t turn = 0;  ///< the tenant's number
  std::vector<SourceRef> sources;

  json action(ServerRank& serverRank, const Work::Call&) const {
    Exchanges::Part part = serverRank.exchanges.join(exchange);
    if (items.empty()) return evaluated(serverRank, part).told;
    Publication publication = serverRank.datasets->join(items, part.ranks);
    publication.reserve();
    FilterResult result = evaluated(serverRank, part);
    publication.stage(0, Payload(std::shared_ptr<const Dataset>(std::move(result.dataset))));
    serverRank.datasets->publish(publication, exchange);
    return result.told;
  }

  FilterResult evaluated(ServerRank& serverRank, Exchanges::Part& part) const {
    std::vector<Pin> pins;
    FilterRun::Inputs inputs;
    std::shared_ptr<const Filter> found;
    agree(part.ranks, [&] {
      found = serverRank.filters.get(filter);
      for (const SourceRef& s : sources) {
        pins.push_back(serverRank.objects.pin(Key{s.key}, s.generation));
        inputs[s.input].push_back({s.name, Key{s.key}, s.generation, pins.back().get<Dataset>()});
      }
    });
    FilterServices services;
    services.takeMemory = [&](const std::string& purpose, int64_t bytes) {
      return serverRank.takeMemory(tenant, purpose, bytes);
    };
    services.begin = [&](int64_t item, int64_t of, const std::string& text) {
      part.begin(item, of, text, item == 0);
    };
    services.tracer = &serverRank.tracer;
    services.fieldMaker = &serverRank.fieldMaker;
    services.tenant = tenant;
    services.turn = turn;
    services.sampler = serverRank.sampler.get();
    FilterRun run(part.ranks, std::move(inputs), std::move(services));
    return evaluate(*found, run, properties);
  }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(MakeWork, exchange, items, filter, properties, tenant, turn, sources)

std::vector<std::string> namesIn(const DatasetSpec& entry) {
  std::vector<std::string> names;
  for (const FilterInput& input : entry.inputs)
    names.insert(names.end(), input.datasets.begin(), input.datasets.end());
  return names;
}

}  // namespace

void FilterRuns::addWorks() {
  serverRank_.work.add(
      MakeWork::name,
      [this](const Work::Call& call) -> json {
        return call.parameters.get<MakeWork>().action(serverRank_, call);
      },
      MakeWork::runs);
}

json FilterRuns::make(Request& request, const DatasetSpec& entry, Scope scope) {
  const std::string& tenant = request.session().tenant();
  const auto filter = serverRank_.filters.get(entry.filter);
  const auto exchange = serverRank_.exchanges.beginLong(request);
  const auto made = filter->schema.typeMadeBy(entry, [&](const std::string& name) {
    return datasetTypeNamed(serverRank_.datasets->get(tenant, name).type);
  });
  std::shared_ptr<const Datasets::Names> names;
  if (made) names = serverRank_.datasets->begin(request, *exchange, "make", scope, {{entry.name, *made}});
  // Inputs are pinned once the name is there: whoever had it may have published what an input is, which needs the room of what is
  // pinned.
  const std::vector<std::string> read = namesIn(entry);
  const auto pinned = serverRank_.datasets->getPinned(tenant, read);
  checkInputs(filter->schema, entry, [&](const std::string& name) {
    return datasetTypeNamed(
        pinned[size_t(std::find(read.begin(), read.end(), name) - read.begin())].first.type);
  });
  MakeWork work{*exchange,
                names ? names->items() : json::array(),
                entry.filter,
                entry.properties,
                tenant,
                serverRank_.tenants.number(tenant),
                {}};
  size_t next = 0;
  for (const FilterInput& input : entry.inputs)
    for (const std::string& name : input.datasets) {
      const auto& [dataset, pin] = pinned[next++];
      work.sources.push_back({input.input, name, dataset.key.value, pin.generation()});
    }
  json told;
  try {
    told = callAll(serverRank_, work).at(0);
  } catch (const Error&) {
    if (names) serverRank_.datasets->check(*names);  // if a name is why, this says more
    throw;
  }
  if (names)
    told.update(
        {{"name", entry.name}, {"type", nameOf(*made)}, {"generation", names->drafts().at(0).generation}});
  return told;
}

std::vector<std::string> FilterRuns::importAndMake(Request& request, Datasets::Import what) {
  const std::vector<DatasetSpec> all = std::move(what.specs);
  const std::vector<size_t> order = evaluationOrder(all);
  const auto isThere = [&](const DatasetSpec& d) {
    return serverRank_.datasets->find(request.session().tenant(), d.name).has_value();
  };
  what.specs.clear();
  for (const DatasetSpec& d : all) {
    if (!d.filename.empty()) what.specs.push_back(d);
    if (d.isLive() && !what.onlyMissing && !isThere(d))
      throw Error(
          "dataset " + inQuotes(d.name) +
          ": there is none that you see, and its entry has neither `filename` nor `filter`; expected one "
          "of them, or a dataset of this name");
  }
  std::vector<std::string> warnings;
  if (!what.specs.empty() || all.empty()) warnings = serverRank_.datasets->import(request, what);
  for (const size_t i : order)
    if (!all[i].name.empty() && !(what.onlyMissing && isThere(all[i]))) make(request, all[i], what.scope);
  return warnings;
}

}  // namespace gxy
