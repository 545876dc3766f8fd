// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/filter_runs.h"

#include <algorithm>
#include <optional>
#include <set>

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

std::vector<FilterRuns::Made> FilterRuns::make(Request& request, const std::vector<DatasetSpec>& entries,
                                               Scope scope) {
  PinnedData pinned;
  return makeAll(request, entries, scope, false, {}, pinned);
}

/// Inputs that `pinned` has not are pinned here.
FilterRuns::Made FilterRuns::makeOne(Request& request, const DatasetSpec& entry, Scope scope,
                                     PinnedData& pinned) {
  const std::string& tenant = request.session().tenant();
  const auto filter = serverRank_.filters.get(entry.filter);
  const auto exchange = serverRank_.exchanges.beginLong(request);
  const auto made = filter->schema.typeMadeBy(entry, [&](const std::string& name) {
    const auto known = pinned.find(name);
    return datasetTypeNamed(known != pinned.end() ? known->second.first.type
                                                  : serverRank_.datasets->get(tenant, name).type);
  });
  std::shared_ptr<const Datasets::Names> names;
  if (made) names = serverRank_.datasets->begin(request, *exchange, "make", scope, {{entry.name, *made}});
  // Inputs are pinned once the name is there: whoever had it may have published what an input is, which needs the room of what is
  // pinned.
  serverRank_.datasets->pin(tenant, namesIn(entry), pinned);
  checkInputs(filter->schema, entry,
              [&](const std::string& name) { return datasetTypeNamed(pinned.at(name).first.type); });
  MakeWork work{*exchange,
                names ? names->items() : json::array(),
                entry.filter,
                entry.properties,
                tenant,
                serverRank_.tenants.number(tenant),
                {}};
  for (const FilterInput& input : entry.inputs)
    for (const std::string& name : input.datasets) {
      const NamedDataset& dataset = pinned.at(name).first;
      work.sources.push_back({input.input, name, dataset.key.value, dataset.generation});
    }
  Made result;
  json& told = result.told;
  try {
    told = callAll(serverRank_, work).at(0);
  } catch (const Error&) {
    if (names) serverRank_.datasets->check(*names);  // if a name is why, this says more
    throw;
  }
  if (!names) return result;
  result.dataset = names->drafts().at(0);
  told.update({{"name", entry.name}, {"type", nameOf(*made)}, {"generation", result.dataset->generation}});
  return result;
}

/// Whether the tenant has under this name what the entry would make, or what no filter has made. Then it is pinned.
bool FilterRuns::isMade(const std::string& tenant, const DatasetSpec& entry, PinnedData& pinned) const {
  if (!serverRank_.datasets->find(tenant, entry.name)) return false;
  auto [named, pin] = serverRank_.datasets->getPinned(tenant, entry.name);
  const auto dataset = pin.get<Dataset>();
  const Provenance& made = dataset->provenance;
  const auto isRead = [&](const std::string& input, const std::string& name) {
    const auto read = pinned.find(name);
    return read != pinned.end() &&
           std::any_of(made.inputs.begin(), made.inputs.end(), [&](const Provenance::Input& i) {
             return i.input == input && i.key == read->second.first.key &&
                    i.generation == read->second.first.generation;
           });
  };
  size_t inputs = 0;
  bool same = made.filter == entry.filter && made.properties == entry.properties &&
              made.version == serverRank_.filters.get(entry.filter)->schema.version;
  for (const FilterInput& input : entry.inputs)
    for (const std::string& name : input.datasets) {
      same = same && isRead(input.input, name);
      inputs++;
    }
  if (!made.filter.empty() && !(same && inputs == made.inputs.size())) return false;
  pinned.insert_or_assign(entry.name, std::pair(std::move(named), std::move(pin)));
  return true;
}

std::vector<FilterRuns::Made> FilterRuns::makeAll(Request& request, const std::vector<DatasetSpec>& entries,
                                                  Scope scope, bool onlyMissing,
                                                  const std::vector<std::string>& shown, PinnedData& pinned) {
  const std::string& tenant = request.session().tenant();
  const std::vector<size_t> order = evaluationOrder(entries);
  std::set<std::string> sources(shown.begin(), shown.end());
  for (const DatasetSpec& entry : entries)
    for (const std::string& name : namesIn(entry)) sources.insert(name);
  for (const size_t i : order) sources.erase(entries[i].name);
  std::erase_if(sources, [&](const std::string& name) { return !serverRank_.datasets->find(tenant, name); });
  // One filter that is to be evaluated pins its inputs itself.
  if (onlyMissing || order.size() > 1)
    serverRank_.datasets->pin(tenant, {sources.begin(), sources.end()}, pinned);
  std::vector<Made> all;
  for (const size_t i : order) {
    if (onlyMissing && isMade(tenant, entries[i], pinned)) continue;
    Made made = makeOne(request, entries[i], scope, pinned);
    made.entry = i;
    if (made.dataset) {
      Pin pin = serverRank_.objects.pin(made.dataset->key, made.dataset->generation);
      NamedDataset named = serverRank_.datasets->get(tenant, entries[i].name);
      named.key = made.dataset->key;
      named.generation = made.dataset->generation;
      pinned.insert_or_assign(entries[i].name, std::pair(std::move(named), std::move(pin)));
    }
    all.push_back(std::move(made));
  }
  return all;
}

std::vector<std::string> FilterRuns::importAndMake(Request& request, Datasets::Import what,
                                                   const std::vector<std::string>& shown,
                                                   PinnedData& pinned) {
  std::vector<DatasetSpec> files, made;
  for (DatasetSpec& d : what.specs) {
    if (d.isLive() && !what.onlyMissing && !serverRank_.datasets->find(request.session().tenant(), d.name))
      throw Error(
          "dataset " + inQuotes(d.name) +
          ": there is none that you see, and its entry has neither `filename` nor `filter`; expected one "
          "of them, or a dataset of this name");
    if (!d.filename.empty())
      files.push_back(std::move(d));
    else if (!d.filter.empty() && !d.name.empty())  // What only tells numbers has nobody to tell them to.
      made.push_back(std::move(d));
  }
  evaluationOrder(made);  // throws for a cycle before anything is read
  const bool noEntries = what.specs.empty();
  what.specs = std::move(files);
  std::vector<std::string> warnings;
  if (!what.specs.empty() || noEntries) warnings = serverRank_.datasets->import(request, what);
  makeAll(request, made, what.scope, what.onlyMissing, shown, pinned);
  return warnings;
}

std::vector<std::string> FilterRuns::importAndMake(Request& request, Datasets::Import what) {
  PinnedData pinned;
  return importAndMake(request, std::move(what), {}, pinned);
}

}  // namespace gxy
