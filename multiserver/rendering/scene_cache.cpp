// SPDX-License-Identifier: Apache-2.0
#include "multiserver/rendering/scene_cache.h"

#include <algorithm>
#include <exception>
#include <tuple>
#include <utility>

#include "core/comm/error.h"
#include "core/look/loaded_facts.h"
#include "core/scene/json_text.h"
#include "core/scene/state_file.h"

namespace gxy {

using nlohmann::json;

namespace {

constexpr int kLooks = 8;  // at names whose objects are replaced meanwhile, each time

}  // namespace

SceneHandle::~SceneHandle() {
  serverRank.work.broadcast("rendering.forget_scene", {{"scene", id}}, [](std::vector<Work::Reply>) {});
}

const NamedDataset* SceneHandle::find(Key key, std::optional<Generation> generation) const {
  for (const NamedDataset& d : data)
    if (d.key == key && d.generation == generation.value_or(d.generation)) return &d;
  return nullptr;
}

std::string textOfTwoPartitionings(const std::string& first, const std::string& other) {
  return "visualization: " + inQuotes(first) + " and " + inQuotes(other) +
         " are partitioned differently, expected one partitioning; import one `like` the other";
}

SceneCache::SceneCache(Registration& registration)
    : serverRank_(registration.serverRank()), builder_(*serverRank_.backend, serverRank_.rank()) {
  registration.work(
      "rendering.make_scene", [this](const Work::Call& call) { return make(call.parameters); },
      Work::Runs::Waiting);
  registration.work("rendering.forget_scene",
                    [this](const Work::Call& call) { return forget(call.parameters); });
}

// Reads what rank 0 asks for, and finds this rank's part of the data.
SceneSource SceneCache::sourceOf(const json& p) const {
  SceneSource source;
  const State state = readState(p.at("state").get<std::string>(), "visualization").state;
  source.visualization = state.visualizations.at(0);
  source.settings = state.settings;
  for (const json& d : p.at("data")) {
    const auto key = d.at("key").get<uint64_t>();
    const auto generation = d.at("generation").get<Generation>();
    const auto dataset = serverRank_.objects.pin(Key{key}, generation).get<Dataset>();
    if (!source.partitioning) source.partitioning = dataset->partitioning;
    const auto& operators = source.visualization.operators;
    if (source.partitioning != dataset->partitioning && !(*source.partitioning == *dataset->partitioning))
      throw Error(textOfTwoPartitionings(operators[0].dataset, operators[source.data.size()].dataset));
    OperatorSource& shown = source.data.emplace_back();
    shown.data.color = glm::dvec3(dataset->color);
    if (const auto color = d.find("color"); color != d.end())
      for (int c = 0; c < 3; c++) shown.data.color[c] = color->at(size_t(c)).get<double>();
    shown.data.volume = dataset->volume;
    shown.data.mesh = dataset->mesh;
    if (!dataset->geometry) continue;
    const auto tenant = p.at("tenant").get<std::string>();  // whose memory it takes
    shown.geometry = {tenant + " " + d.at("id").get<std::string>(), dataset->geometry};
  }
  return source;
}

// Every rank: all ranks make the same collective calls, whatever fails.
json SceneCache::make(const json& p) {
  const auto id = p.at("scene").get<SceneId>();
  const auto tenant = p.at("tenant").get<std::string>();
  Exchanges::Part part = serverRank_.exchanges.join(p.at("exchange").get<uint64_t>());
  RankCollectives& ranks = part.ranks;

  SceneSource source;
  agree(ranks, [&] { source = sourceOf(p); });
  const SceneBuilder::OnItem onItem = [&part](int64_t item, int64_t of, const std::string& text) {
    part.begin(item, of, text);
  };
  const EnterMemory enter = [this, &tenant](const char* purpose, int64_t bytes) {
    return serverRank_.takeMemory(tenant, purpose, bytes);
  };
  BuiltScene built = builder_.build(std::move(source), ranks, enter, onItem);
  const std::lock_guard lock(mutex_);
  serverRank_.renderer.addScene(id, built.compiled, built.device);
  built_[id] = std::move(built);
  return nullptr;
}

std::shared_ptr<const CompiledScene> SceneCache::compiled(SceneId id) {
  const std::lock_guard lock(mutex_);
  const auto at = built_.find(id);
  if (at == built_.end()) throw Error("the scene has been let go");
  return at->second.compiled;
}

json SceneCache::forget(const json& p) {
  const auto id = p.at("scene").get<SceneId>();
  {
    std::map<SceneId, BuiltScene>::node_type gone;  // outside the lock
    const std::lock_guard lock(mutex_);
    gone = built_.extract(id);
  }
  serverRank_.renderer.removeScene(id);
  return nullptr;
}

namespace {

std::string idOf(const NamedDataset& d) {
  return std::to_string(d.key.value) + ":" + std::to_string(d.generation);
}

bool showsThese(const SceneHandle& scene, const SceneCache::GivenData& given) {
  return std::equal(scene.data.begin(), scene.data.end(), given.begin(), given.end(),
                    [](const NamedDataset& d, const SceneCache::Given& g) {
                      return d.key == g.data->shown().key && d.generation == g.data->shown().generation;
                    });
}

std::vector<Pin> pinned(ServerRank& serverRank, const std::vector<NamedDataset>& data) {
  std::vector<ObjectGeneration> generations;
  for (const NamedDataset& d : data) generations.push_back({d.key, d.generation});
  return serverRank.objects.pin(generations);
}

}  // namespace

bool SceneCache::namesMean(const std::string& tenant, const std::vector<NamedDataset>& data) const {
  return std::all_of(data.begin(), data.end(), [&](const NamedDataset& d) {
    const auto now = serverRank_.datasets->find(tenant, d.name);
    return now && now->key == d.key;
  });
}

// Data that are adopted meanwhile may be gone from where they were.
std::pair<std::vector<ObjectGeneration>, std::vector<Pin>> SceneCache::pinnedOf(
    const GivenData& given) const {
  const auto whereAll = [&] {
    std::vector<ObjectGeneration> where;
    for (const Given& g : given) where.push_back(g.data->where());
    return where;
  };
  for (std::vector<ObjectGeneration> where = whereAll();;) try {
      return {where, serverRank_.objects.pin(where)};
    } catch (const Error&) {
      std::vector<ObjectGeneration> now = whereAll();
      if (now == where) throw;
      where = std::move(now);
    }
}

SceneCache::HeldData SceneCache::hold(const std::string& tenant, const Visualization& visualization,
                                      ShownSoFar& shown, const PinnedData* known,
                                      const GivenData* given) const {
  HeldData held;
  if (given) {
    for (const Given& g : *given) held.data.push_back(g.data->shown());
    std::tie(held.where, held.pins) = pinnedOf(*given);
  } else {
    const auto isKnown = [&](const std::string& name) { return known && known->contains(name); };
    std::vector<std::string> names;
    for (const Vis& vis : visualization.operators)
      if (!isKnown(vis.dataset)) names.push_back(vis.dataset);
    auto newest = serverRank_.datasets->getPinned(tenant, names);
    auto next = newest.begin();
    for (const Vis& vis : visualization.operators) {
      if (isKnown(vis.dataset)) {
        held.data.push_back(known->at(vis.dataset).first);
        held.pins.push_back(std::move(pinned(serverRank_, {held.data.back()}).front()));
      } else {
        held.data.push_back(std::move(next->first));
        held.pins.push_back(std::move(next->second));
        ++next;
      }
      held.where.push_back({held.data.back().key, held.data.back().generation});
    }
  }
  std::vector<DataFacts> facts;
  for (const Pin& pin : held.pins) {
    const auto content = pin.get<Dataset>();
    facts.push_back(factsOf(*content));
  }
  held.resolved = resolved(visualization, facts, shown);
  return held;
}

void SceneCache::widen(const std::string& tenant, const Visualization& visualization, ShownSoFar& shown,
                       const GivenData* given) const {
  hold(tenant, visualization, shown, nullptr, given);
}

std::optional<SceneCache::Pinned> SceneCache::pin(const std::string& tenant, const ScenePtr& scene) const {
  if (!namesMean(tenant, scene->data)) return std::nullopt;
  try {
    return Pinned{scene, pinned(serverRank_, scene->data)};
  } catch (const Error&) {
    return std::nullopt;  // its data have gone
  }
}

SceneCache::Pinned SceneCache::get(const std::string& tenant, const Visualization& visualization,
                                   const RenderSettings& settings, const Asker& asker, ShownSoFar& shown,
                                   const ScenePtr& known, const PinnedData* pinnedData,
                                   const GivenData* given) {
  if (known && given && showsThese(*known, *given)) return {known, {}};
  if (known && !given)
    if (auto pinned = pin(tenant, known)) return *std::move(pinned);
  if (visualization.operators.empty())
    throw Error("visualization: it has no operators, expected one or more");
  State state;
  state.settings = settings;
  for (const Vis& vis : visualization.operators) {
    // Names belong to tenants, contents do not; the reader wants every name to be a dataset's.
    DatasetSpec spec;
    spec.name = vis.dataset;
    spec.type = DatasetType(vis.type);
    spec.filename = "-";
    if (std::none_of(state.datasets.begin(), state.datasets.end(),
                     [&](const DatasetSpec& d) { return d.name == spec.name; }))
      state.datasets.push_back(spec);
  }
  for (int looks = 1;; looks++) {
    HeldData held = hold(tenant, visualization, shown, pinnedData, given);
    held.resolved.view = {};  // Views differ in it, and their scene does not.
    state.visualizations = {std::move(held.resolved)};
    try {
      return {getOf(tenant, state, held, given, asker), std::move(held.pins)};
    } catch (const Error&) {
      // Dropped meanwhile, and perhaps replaced by others of the same names.
      if (given || namesMean(tenant, held.data) || looks == kLooks) throw;
    }
  }
}

ScenePtr SceneCache::getOf(const std::string& tenant, const State& state, const HeldData& held,
                           const GivenData* given, const Asker& asker) {
  asker.check();
  const std::string text = writeState(state);
  std::string content = tenant + "\n" + text;  // whose memory it takes
  for (const NamedDataset& d : held.data) content += " " + idOf(d);
  if (given)
    for (const Given& g : *given) content += " " + json{g.color.r, g.color.g, g.color.b}.dump();

  MakingPtr making;
  bool begins = false;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(known_, [](const auto& k) { return k.second.expired(); });
    if (const auto at = known_.find(content); at != known_.end())
      if (ScenePtr scene = at->second.lock()) return scene;
    MakingPtr& underWay = underWay_[content];
    begins = !underWay;
    if (begins) underWay = std::make_shared<Making>();
    making = underWay;
    making->askers.push_back(&asker);
  }
  if (begins) try {
      start(making, content, tenant, text, held, given);
    } catch (const std::exception& e) {
      end(making, content, nullptr, e.what());
    }
  return waitFor(making, content, asker);
}

void SceneCache::start(const MakingPtr& making, const std::string& content, const std::string& tenant,
                       const std::string& text, const HeldData& held, const GivenData* given) {
  SceneId id;
  {
    const std::lock_guard lock(mutex_);
    id = next_++;
  }
  auto scene = std::make_shared<SceneHandle>(serverRank_, id);
  json keys = json::array();
  for (size_t i = 0; i < held.data.size(); i++) {
    keys.push_back({{"key", held.where[i].key.value},
                    {"generation", held.where[i].generation},
                    {"id", idOf(held.data[i])}});
    if (!given) continue;
    const glm::dvec4& color = (*given)[i].color;
    keys.back()["color"] = {color.r, color.g, color.b};
  }
  scene->data = held.data;
  auto exchange = serverRank_.exchanges.begin(
      Asker{[making] {
              if (!making->wanted) throw Error("cancelled");
            },
            [this, making](int64_t done, int64_t of, const std::string& what, bool phase) {
              tell(*making, done, of, what, phase);
            }});
  making->exchange = *exchange;
  const json parameters{
      {"exchange", *exchange}, {"scene", id}, {"tenant", tenant}, {"state", text}, {"data", keys}};
  serverRank_.work.broadcast("rendering.make_scene", parameters,
                             [this, making, content, scene = ScenePtr(std::move(scene)),
                              exchange = std::move(exchange)](std::vector<Work::Reply> replies) mutable {
                               std::string error;
                               try {
                                 serverRank_.resultsOf(std::move(replies));
                               } catch (const std::exception& e) {
                                 error = e.what();
                                 scene = nullptr;
                               }
                               end(making, content, std::move(scene), error);
                             });
}

void SceneCache::end(const MakingPtr& making, const std::string& content, ScenePtr scene,
                     const std::string& error) {
  if (scene && making->told) tell(*making, making->told, making->told, "done", true);
  const std::lock_guard lock(mutex_);
  if (making->wanted) {  // else there may be another by now
    underWay_.erase(content);
    if (scene) known_[content] = scene;
  }
  making->scene = std::move(scene);
  making->error = error;
  making->ended = true;
  ended_.notify_all();
}

void SceneCache::tell(Making& making, int64_t done, int64_t of, const std::string& text, bool phase) {
  constexpr std::chrono::milliseconds kMoment{200};  // of which nobody wants to be told
  if (std::chrono::steady_clock::now() < making.begin + kMoment) return;
  const std::lock_guard lock(mutex_);
  making.told = of;
  for (const Asker* asker : making.askers) asker->progress(done, of, text, phase);
}

ScenePtr SceneCache::waitFor(const MakingPtr& making, const std::string& content, const Asker& asker) {
  std::unique_lock lock(mutex_);
  const auto hasEnded = [&] { return making->ended; };
  std::exception_ptr givesUp;
  while (!givesUp && !ended_.wait_for(lock, std::chrono::milliseconds(20), hasEnded)) {
    lock.unlock();
    try {
      asker.check();
    } catch (...) {
      givesUp = std::current_exception();
    }
    lock.lock();
  }
  std::erase(making->askers, &asker);
  if (givesUp && making->askers.empty() && !making->ended) {
    making->wanted = false;
    underWay_.erase(content);
    lock.unlock();
    serverRank_.exchanges.cancel(making->exchange);
    lock.lock();
    ended_.wait(lock, hasEnded);
  }
  if (givesUp) std::rethrow_exception(givesUp);
  if (!making->scene) throw Error(making->error);
  return making->scene;
}

}  // namespace gxy
