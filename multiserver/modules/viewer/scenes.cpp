// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/viewer/scenes.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "core/comm/error.h"
#include "core/look/loaded_facts.h"
#include "core/scene/json_text.h"
#include "core/scene/state_file.h"

namespace gxy::viewer {

using nlohmann::json;

namespace {

constexpr int kLooks = 8;  // at names whose objects are replaced meanwhile, each time

}  // namespace

namespace {

void check(const char* what, int64_t value, int64_t most) {
  if (value > most)
    throw Error(std::string("rendering: ") + std::to_string(value) + " " + what + ", expected at most " +
                std::to_string(most));
}

}  // namespace

void checkCost(const RenderSettings& settings, glm::ivec2 size) {
  constexpr int64_t kRays = int64_t(1) << 31;
  check("primary rays", int64_t(size.x) * size.y * settings.raysPerPixel, kRays);
}

void checkCost(const Visualization& visualization) {
  constexpr int64_t kOcclusion = 256, kLights = 64;
  constexpr int64_t kOperators = 64, kSurfaces = 256, kClips = 64, kMapPoints = 65536;
  check("ambient-occlusion rays per hit", visualization.lighting.aoCount, kOcclusion);
  check("lights", int64_t(visualization.lighting.sources.size()), kLights);
  // Compiling looks at all data for each isovalue and slice.
  check("operators", int64_t(visualization.operators.size()), kOperators);
  size_t surfaces = 0, clips = 0, points = 0;
  for (const Vis& vis : visualization.operators) {
    surfaces += vis.isovalues.size() + vis.slices.size();
    clips += vis.clipPlanes.size();
    points += vis.colormap.points.size() + vis.opacitymap.points.size();
  }
  check("isovalues and slices", int64_t(surfaces), kSurfaces);
  check("clip planes", int64_t(clips), kClips);
  check("points of maps", int64_t(points), kMapPoints);
}

int64_t bytesOf(const Visualization& visualization) {
  size_t bytes = visualization.annotation.size() +
                 visualization.lighting.sources.size() * sizeof visualization.lighting.sources[0];
  for (const Vis& vis : visualization.operators)
    bytes += sizeof vis + vis.dataset.size() + vis.isovalues.size() * sizeof vis.isovalues[0] +
             (vis.slices.size() + vis.clipPlanes.size()) * sizeof vis.slices[0] +
             vis.colormap.points.size() * sizeof vis.colormap.points[0] +
             vis.opacitymap.points.size() * sizeof vis.opacitymap.points[0];
  return int64_t(bytes);
}

int64_t bytesOf(const State& state) {
  auto bytes = int64_t(state.visualizations.size() * sizeof(Visualization) +
                       state.cameras.size() * sizeof(Camera) + state.datasets.size() * sizeof(DatasetSpec));
  for (const Visualization& v : state.visualizations) bytes += bytesOf(v);
  return bytes;
}

SceneHandle::~SceneHandle() {
  node.work.broadcast("viewer.forget", {{"scene", id}}, [](std::vector<Work::Reply>) {});
}

const NamedDataset* SceneHandle::find(Key key, std::optional<Generation> generation) const {
  for (const NamedDataset& d : data)
    if (d.key == key && d.generation == generation.value_or(d.generation)) return &d;
  return nullptr;
}

Scenes::Scenes(Registration& registration) : node_(registration.node()) {
  registration.work(
      "viewer.make", [this](const Work::Call& call) { return make(call.parameters); }, Work::Runs::Waiting);
  registration.work("viewer.forget", [this](const Work::Call& call) { return forget(call.parameters); });
}

// Every rank: all make the same exchanges, whatever fails.
json Scenes::make(const json& p) {
  const auto id = p.at("scene").get<SceneId>();
  const auto tenant = p.at("tenant").get<std::string>();
  const json& keys = p.at("data");
  Exchanges::Part part = node_.exchanges.join(p.at("exchange").get<uint64_t>());
  RankCollectives& ranks = part.ranks;

  Visualization visualization;
  RenderSettings settings;
  std::shared_ptr<const Partitioning> partitioning;
  std::vector<std::shared_ptr<const Dataset>> datasets;
  agree(ranks, [&] {
    const State state = readState(p.at("state").get<std::string>(), "visualization").state;
    visualization = state.visualizations.at(0);
    settings = state.settings;
    for (const json& d : keys) {
      const Pin pin =
          node_.objects.pin(Key{d.at("key").get<uint64_t>()}, d.at("generation").get<Generation>());
      const auto dataset = datasets.emplace_back(pin.get<Dataset>());
      if (!partitioning) partitioning = dataset->partitioning;
      if (partitioning != dataset->partitioning && !(*partitioning == *dataset->partitioning))
        throw Error("visualization: " + inQuotes(visualization.operators[0].dataset) + " and " +
                    inQuotes(visualization.operators[datasets.size() - 1].dataset) +
                    " are partitioned differently, expected one partitioning; import one `like` the other");
    }
  });
  std::vector<OperatorData> data;
  std::shared_ptr<CompiledScene> scene;
  std::shared_ptr<const DeviceScene> device;
  Made made;  // goes before what it accounts for
  // What is told of: each geometry, and the scene twice.
  const int64_t of = 2 + std::count_if(datasets.begin(), datasets.end(),
                                       [](const auto& d) { return d->geometry != nullptr; });
  int64_t item = 0;
  for (size_t i = 0; i < datasets.size(); i++) {
    const Vis& vis = visualization.operators[i];
    const Dataset& dataset = *datasets[i];
    OperatorData& operand = data.emplace_back();
    operand.color = glm::dvec3(dataset.color);
    operand.volume = dataset.volume;
    if (!dataset.geometry) continue;
    part.begin(item++, of, "distributing " + vis.dataset);
    const Distribution distribution{tenant, keys[i].at("key"), keys[i].at("generation"), radiiOf(vis)};
    std::shared_ptr<const Distributed> known = distributed_.find(distribution);
    // One rank may have forgotten it already.
    const auto there = ranks.allGather(Bytes(1, std::byte(known != nullptr)));
    if (std::any_of(there.begin(), there.end(), [](const Bytes& b) { return b.at(0) == std::byte(0); })) {
      Distributed mine;
      mine.geometry = distribute(
          *dataset.geometry, *partitioning,
          [&vis](double value) { return vis.type == VisType::Triangles ? 0.0 : radiusOf(vis, value); },
          ranks);
      agree(ranks, [&] { mine.memory = node_.takeMemory(tenant, "geometry", bytesOf(*mine.geometry)); });
      known = distributed_.get(distribution, [&] { return std::move(mine); });
    }
    operand.geometry = known->geometry;
    made.geometry.push_back(known);
  }
  Bytes visible;
  part.begin(item++, of, "compiling the scene");
  agree(ranks, [&] {
    std::vector<std::shared_ptr<const CompiledScene>> others;
    {
      const std::lock_guard lock(mutex_);
      for (const auto& [known, made] : made_)
        if (auto other = made.scene.lock()) others.push_back(std::move(other));
    }
    scene = compileScene(visualization, data, partitioning, settings, others, advanceOf(ranks));
    for (const uint8_t v : scene->visible) visible.push_back(std::byte(v));
  });
  for (const Bytes& theirs : ranks.allGather(std::move(visible)))
    for (size_t i = 0; i < theirs.size(); i++) scene->visible[i] |= uint8_t(theirs[i]);
  part.begin(item++, of, "building the scene");
  agree(ranks, [&] {
    device = node_.backend->makeScene(scene, node_.rank(), advanceOf(ranks));
    made.memory = memory_.enter(*scene, *device,
                                [&](int64_t bytes) { return node_.takeMemory(tenant, "scene", bytes); });
    made.scene = scene;
    const std::lock_guard lock(mutex_);
    made_[id] = std::move(made);
    node_.renderer.addScene(id, scene, device);
  });
  return nullptr;
}

std::shared_ptr<const CompiledScene> Scenes::compiled(SceneId id) {
  const std::lock_guard lock(mutex_);
  const auto at = made_.find(id);
  auto scene = at == made_.end() ? nullptr : at->second.scene.lock();
  if (!scene) throw Error("the scene has been let go");
  return scene;
}

json Scenes::forget(const json& p) {
  const auto id = p.at("scene").get<SceneId>();
  {
    const std::lock_guard lock(mutex_);
    made_.erase(id);
  }
  node_.renderer.removeScene(id);
  return nullptr;
}

namespace {

std::vector<Pin> pinned(Node& node, const std::vector<NamedDataset>& data) {
  std::vector<Pin> pins;
  for (const NamedDataset& d : data) pins.push_back(node.objects.pin(d.key, d.generation));
  return pins;
}

}  // namespace

bool Scenes::namesMean(const std::string& tenant, const std::vector<NamedDataset>& data) const {
  return std::all_of(data.begin(), data.end(), [&](const NamedDataset& d) {
    const auto now = node_.datasets->find(tenant, d.name);
    return now && now->key == d.key;
  });
}

Scenes::Held Scenes::hold(const std::string& tenant, const Visualization& visualization,
                          ShownSoFar& shown) const {
  Held held;
  std::vector<DataFacts> facts;
  for (const Vis& vis : visualization.operators) {
    auto [dataset, pin] = node_.datasets->getPinned(tenant, vis.dataset);
    const auto content = pin.get<Dataset>();
    facts.push_back(content->volume ? factsOf(*content->volume) : factsOf(*content->geometry));
    held.data.push_back(std::move(dataset));
    held.pins.push_back(std::move(pin));
  }
  held.resolved = resolved(visualization, facts, shown);
  return held;
}

void Scenes::widen(const std::string& tenant, const Visualization& visualization, ShownSoFar& shown) const {
  hold(tenant, visualization, shown);
}

Scenes::Pinned Scenes::get(const std::string& tenant, const Visualization& visualization,
                           const RenderSettings& settings, const Asker& asker, ShownSoFar& shown,
                           const ScenePtr& known) {
  if (known && namesMean(tenant, known->data)) try {
      return {known, pinned(node_, known->data)};
    } catch (const Error&) {
      // its data have gone
    }
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
    Held held = hold(tenant, visualization, shown);
    state.visualizations = {std::move(held.resolved)};
    try {
      return {getOf(tenant, state, held.data, asker), std::move(held.pins)};
    } catch (const Error&) {
      // Dropped meanwhile, and perhaps replaced by others of the same names.
      if (namesMean(tenant, held.data) || looks == kLooks) throw;
    }
  }
}

ScenePtr Scenes::getOf(const std::string& tenant, const State& state, const std::vector<NamedDataset>& data,
                       const Asker& asker) {
  asker.check();
  const std::string text = writeState(state);
  std::string content = tenant + "\n" + text;  // whose memory it takes
  for (const NamedDataset& d : data)
    content += " " + std::to_string(d.key.value) + ":" + std::to_string(d.generation);

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
      start(making, content, tenant, text, data);
    } catch (const std::exception& e) {
      end(making, content, nullptr, e.what());
    }
  return waitFor(making, content, asker);
}

void Scenes::start(const MakingPtr& making, const std::string& content, const std::string& tenant,
                   const std::string& text, std::vector<NamedDataset> data) {
  SceneId id;
  {
    const std::lock_guard lock(mutex_);
    id = next_++;
  }
  auto scene = std::make_shared<SceneHandle>(node_, id);
  json keys = json::array();
  for (const NamedDataset& d : data) keys.push_back({{"key", d.key.value}, {"generation", d.generation}});
  scene->data = std::move(data);
  auto exchange =
      node_.exchanges.begin(Asker{[making] {
                                    if (!making->wanted) throw Error("cancelled");
                                  },
                                  [this, making](int64_t done, int64_t of, const std::string& what,
                                                 bool phase) { tell(*making, done, of, what, phase); }});
  making->exchange = *exchange;
  const json parameters{
      {"exchange", *exchange}, {"scene", id}, {"tenant", tenant}, {"state", text}, {"data", keys}};
  node_.work.broadcast("viewer.make", parameters,
                       [this, making, content, scene = ScenePtr(std::move(scene)),
                        exchange = std::move(exchange)](std::vector<Work::Reply> replies) mutable {
                         std::string error;
                         try {
                           node_.resultsOf(std::move(replies));
                         } catch (const std::exception& e) {
                           error = e.what();
                           scene = nullptr;
                         }
                         end(making, content, std::move(scene), error);
                       });
}

void Scenes::end(const MakingPtr& making, const std::string& content, ScenePtr scene,
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

void Scenes::tell(Making& making, int64_t done, int64_t of, const std::string& text, bool phase) {
  constexpr std::chrono::milliseconds kMoment{200};  // of which nobody wants to be told
  if (std::chrono::steady_clock::now() < making.begin + kMoment) return;
  const std::lock_guard lock(mutex_);
  making.told = of;
  for (const Asker* asker : making.askers) asker->progress(done, of, text, phase);
}

ScenePtr Scenes::waitFor(const MakingPtr& making, const std::string& content, const Asker& asker) {
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
    node_.exchanges.cancel(making->exchange);
    lock.lock();
    ended_.wait(lock, hasEnded);
  }
  if (givesUp) std::rethrow_exception(givesUp);
  if (!making->scene) throw Error(making->error);
  return making->scene;
}

}  // namespace gxy::viewer
