// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/filter_runs.h"

#include <algorithm>
#include <future>
#include <mutex>
#include <optional>
#include <set>
#include <tuple>

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

json describedFilter(const FilterSchema& filter) {
  json inputs = json::array(), properties = json::array();
  for (const FilterPort& port : filter.inputs)
    inputs.push_back({{"name", port.name},
                      {"takes", namesOf(port.types)},
                      {"optional", port.mayLack() && port.count != FilterPort::Count::AnyName},
                      {"many", port.takesMany()},
                      {"any name", port.count == FilterPort::Count::AnyName},
                      {"help", port.help}});
  for (const KeyInfo& key : filter.properties)
    properties.push_back({{"key", key.name},
                          {"type", key.type},
                          {"default", key.defaultText},
                          {"required", key.required},
                          {"advanced", key.advanced},
                          {"help", key.meaning}});
  return {{"name", filter.name}, {"version", filter.version},
          {"help", filter.help}, {"makes", filter.makes ? json(filter.madeText()) : json()},
          {"inputs", inputs},    {"properties", properties}};
}

}  // namespace

json described(const Filters& filters) {
  json all = json::array();
  std::string text = "filters:";
  for (const std::string& name : filters.names()) {
    const FilterSchema& filter = *filters.find(name);
    all.push_back(describedFilter(filter));
    text += "\n" + name + ": " + filter.help;
  }
  return {{"filters", all}, {"text", text}};
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
  // A single filter pins its inputs once the name is there: whoever had it may have published what an input is, which needs the room of
  // what is pinned. The filters of a document have pinned them at their one moment.
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
  NamedDataset named;
  Pin pin;
  try {
    std::tie(named, pin) = serverRank_.datasets->getPinned(tenant, entry.name);
  } catch (const Error&) {
    return false;  // There is none.
  }
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

bool FilterRuns::makesDataset(const DatasetSpec& entry) const {
  const FilterSchema& schema = serverRank_.filters.get(entry.filter)->schema;
  return !entry.name.empty() && (schema.makes || !schema.makesLike.empty());
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
    else if (!d.filter.empty() && makesDataset(d))  // What only tells numbers has nobody to tell them to.
      made.push_back(std::move(d));
  }
  for (const auto* entries : {&files, &made})
    for (const DatasetSpec& d : *entries)
      if (!what.onlyMissing || !serverRank_.datasets->find(request.session().tenant(), d.name))
        request.session().expectMayChange("dataset " + inQuotes(d.name));
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
