// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/filter_runs.h"

#include <algorithm>
#include <future>
#include <mutex>
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
    const auto takeMemory = [&](const std::string& purpose, int64_t bytes) {
      return serverRank.takeMemory(tenant, purpose, bytes);
    };
    std::vector<Pin> pins;
    if (items.empty()) return evaluated(serverRank, part, pins, takeMemory).told;
    Publication publication = serverRank.datasets->join(items, part.ranks);
    publication.reserve();
    FilterResult result = evaluated(serverRank, part, pins, takeMemory);
    publication.stage(0, Payload(std::shared_ptr<const Dataset>(std::move(result.dataset))));
    serverRank.datasets->publish(publication, exchange);
    return result.told;
  }

  using TakeMemory = std::function<LedgerEntry(const std::string& purpose, int64_t bytes)>;
  FilterResult evaluated(
      ServerRank& serverRank, Exchanges::Part& part, std::vector<Pin>& pins, const TakeMemory& takeMemory,
      const std::function<void()>& taken = [] {}) const {
    FilterRun::Inputs inputs;
    std::shared_ptr<const Filter> found;
    agree(part.ranks, [&] {
      found = serverRank.filters.get(filter);
      for (const SourceRef& s : sources) {
        pins.push_back(serverRank.objects.pin(Key{s.key}, s.generation));
        inputs[s.input].push_back({s.name, Key{s.key}, s.generation, pins.back().get<Dataset>()});
      }
    });
    taken();
    FilterServices services;
    services.takeMemory = takeMemory;
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

/// On each rank: the same for a graph. The output is an object without a name.
struct EvaluateWork {
  static constexpr const char* name = "filters.evaluate";
  static constexpr Work::Runs runs = Work::Runs::Long;
  MakeWork make;
  uint64_t key = 0;  ///< of the object; 0: the filter makes no dataset
  std::string label, purpose;

  // What the ledger refuses on this rank is told as such, since room may be made for it.
  json action(ServerRank& serverRank, const std::function<void()>& taken) const {
    Exchanges::Part part = serverRank.exchanges.join(make.exchange);
    std::mutex mutex;
    std::string noRoom;
    const auto takeMemory = [&](const std::string&, int64_t bytes) {
      try {
        return serverRank.takeMemory(make.tenant, purpose, bytes);
      } catch (const Error& e) {
        const std::lock_guard lock(mutex);
        noRoom = e.what();
        throw;
      }
    };
    try {
      return evaluated(serverRank, part, takeMemory, taken);
    } catch (const Error&) {
      if (noRoom.empty()) throw;
      return {{"no room", noRoom}};
    }
  }

  json evaluated(ServerRank& serverRank, Exchanges::Part& part, const MakeWork::TakeMemory& takeMemory,
                 const std::function<void()>& taken) const {
    std::vector<Pin> pins;
    // Whoever asks keeps the data. Pins of this rank would keep a publisher from its buffers after a graph has adopted these.
    const FilterResult result = make.evaluated(serverRank, part, pins, takeMemory, [&] {
      pins.clear();
      taken();
    });
    if (!result.dataset) return {{"told", result.told}, {"bytes", 0}};
    const json type = int(typeOf(*result.dataset));
    const int64_t bytes = result.dataset->bytes;
    Publication publication(serverRank.objects, part.ranks, {{Key{key}, 1, label}});
    publication.stage(0, Payload(std::shared_ptr<const Dataset>(result.dataset)));
    publication.commit();
    return {{"told", result.told}, {"bytes", bytes}, {"type", type}};
  }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(EvaluateWork, make, key, label, purpose)

std::vector<std::string> namesIn(const DatasetSpec& entry) {
  std::vector<std::string> names;
  for (const FilterInput& input : entry.inputs)
    names.insert(names.end(), input.datasets.begin(), input.datasets.end());
  return names;
}

}  // namespace

json describedFilter(const FilterSchema& filter) {
  json inputs = json::array(), properties = json::array();
  for (const FilterPort& port : filter.inputs)
    inputs.push_back({{"name", port.name},
                      {"takes", namesOf(port.types)},
                      {"optional", port.count == FilterPort::Count::Optional},
                      {"many", port.count == FilterPort::Count::Many},
                      {"any name", port.count == FilterPort::Count::AnyName},
                      {"help", port.help}});
  for (const KeyInfo& key : filter.properties)
    properties.push_back({{"key", key.name},
                          {"type", key.type},
                          {"default", key.defaultText},
                          {"required", key.required},
                          {"help", key.meaning}});
  return {{"name", filter.name}, {"version", filter.version},
          {"help", filter.help}, {"makes", filter.makes ? json(filter.madeText()) : json()},
          {"inputs", inputs},    {"properties", properties}};
}

void FilterRuns::addWorks() {
  serverRank_.work.add(
      MakeWork::name,
      [this](const Work::Call& call) -> json {
        return call.parameters.get<MakeWork>().action(serverRank_, call);
      },
      MakeWork::runs);
  serverRank_.work.add(
      EvaluateWork::name,
      [this](const Work::Call& call) -> json {
        const auto work = call.parameters.get<EvaluateWork>();
        return work.action(serverRank_, [&] { taken(work.make.exchange); });
      },
      EvaluateWork::runs);
}

// Rank 0: all ranks have what an evaluation reads.
void FilterRuns::taken(uint64_t exchange) {
  std::vector<Pin> pins;  // let go of without the lock
  const std::lock_guard lock(mutex_);
  if (const auto found = reading_.find(exchange); found != reading_.end()) pins.swap(found->second);
}

FilterRuns::Evaluated FilterRuns::evaluate(const Asker& asker, const Evaluation& what) {
  const auto filter = serverRank_.filters.get(what.filter);
  const auto exchange = serverRank_.exchanges.beginLong(what.tenant, asker);
  what.begun(*exchange);
  EvaluateWork work;
  work.make = {*exchange,   json::array(),
               what.filter, what.properties,
               what.tenant, serverRank_.tenants.number(what.tenant),
               {}};
  work.label = what.label;
  work.purpose = what.purpose;
  if (filter->schema.makes) work.key = serverRank_.keys.next().value;
  {
    std::vector<Pin> pins;
    for (Evaluation::Source& source : what.sources()) {
      work.make.sources.push_back({source.input, source.name, source.data.key.value, source.data.generation});
      pins.push_back(std::move(source.pin));
    }
    const std::lock_guard lock(mutex_);
    reading_[*exchange] = std::move(pins);
  }
  const std::shared_ptr<void> forget(nullptr, [&](void*) {
    std::map<uint64_t, std::vector<Pin>>::node_type pins;
    const std::lock_guard lock(mutex_);
    pins = reading_.extract(*exchange);
  });
  json parameters;
  to_json(parameters, work);
  const auto replies = std::make_shared<std::promise<std::vector<Work::Reply>>>();
  serverRank_.work.broadcast(EvaluateWork::name, parameters,
                             [replies](std::vector<Work::Reply> all) { replies->set_value(std::move(all)); });
  std::vector<Work::Reply> all = replies->get_future().get();
  for (const Work::Reply& reply : all)
    if (reply.ok() && reply.result.contains("no room"))
      throw NoRoom((serverRank_.ranks() > 1 ? "rank " + std::to_string(reply.rank) + ": " : std::string()) +
                   reply.result.at("no room").get<std::string>());
  const std::vector<json> results = serverRank_.resultsOf(std::move(all));
  Evaluated made{Key{work.key}, DatasetType::Volume, 0, results.at(0).at("told")};
  for (const json& result : results) made.bytes += result.at("bytes").get<int64_t>();
  if (results[0].contains("type")) made.type = DatasetType(results[0].at("type").get<int>());
  return made;
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
