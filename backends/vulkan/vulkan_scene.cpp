// SPDX-License-Identifier: Apache-2.0
#include "backends/vulkan/vulkan_scene.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <mutex>

#include "backends/vulkan/batch.h"
#include "core/comm/error.h"
#include "core/rays/fill_views.h"

namespace gxy::vulkan {

namespace {

constexpr size_t kMostSpare = 4;    // room for rays may be this many times as large as a batch needs
constexpr size_t kPartForKept = 8;  // waiting rays may take one part in this many of a device's memory

// The rays of a batch: so many that a device's cores are busy, and so few that the lists of three batches,
// with their secondaries, are small against its memory.
size_t batchRaysOf(const Device& device) { return device.isSoftware() ? size_t(1) << 15 : size_t(1) << 17; }

// Joins the answers to the parts of a request into one. Thread safe.
class Joined {
 public:
  Joined(size_t parts, uint64_t rays, DeviceScene::Done done)
      : left_(parts), rays_(rays), done_(std::move(done)) {}

  void take(TraceResult part) {
    {
      std::lock_guard lock(mutex_);
      if (!part.error.empty()) all_.error = part.error;
      append(all_.leaving, part.leaving);
      append(all_.contributions, part.contributions);
      append(all_.depths, part.depths);
      all_.samples.append(std::move(part.samples));
      all_.retired += part.retired;
      all_.created += part.created;
      all_.counters += part.counters;
      if (--left_ > 0) return;
    }
    if (all_.error.empty()) return done_(std::move(all_));
    TraceResult failed;
    failed.error = all_.error;
    failed.retired = rays_;
    done_(std::move(failed));
  }

 private:
  template <class T>
  static void append(std::vector<T>& to, std::vector<T>& from) {
    to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
  }

  std::mutex mutex_;
  size_t left_;
  const uint64_t rays_;
  TraceResult all_;
  const DeviceScene::Done done_;
};

}  // namespace

Context::Context(const VulkanOptions& options)
    : device(options),
      pipelines(device, options.keptPipelines),
      time(device.clockRound()),
      countsNodes(options.countsNodes),
      mostKept(options.keptBytes > 0 ? options.keptBytes : device.info().memory / kPartForKept),
      tracer(device, pipelines, time, batchRaysOf(device)) {}

VulkanScene::VulkanScene(std::shared_ptr<Context> context, std::shared_ptr<const CompiledScene> scene,
                         int rank, const Advance& advance)
    : context_(std::move(context)),
      scene_(std::move(scene)),
      rank_(rank),
      batchSize_(int(batchRaysOf(context_->device)),
                 context_->device.isSoftware() ? kTile * kTile : int(batchRaysOf(context_->device))) {
  for (const CompiledOperator& op : scene_->operators) isClipped_ = isClipped_ || !op.clips.empty();
  const auto upload = [&](int partition, const Advance& uploading) {
    return uploadPart(context_->device, context_->pipelines, context_->shared, *scene_, partition, rank_,
                      uploading);
  };
  // Nothing is uploaded where nothing can be seen.
  std::vector<int> seen = scene_->partitioning->owned(rank_);
  std::erase_if(seen, [&](int p) { return !scene_->visible[size_t(p)]; });
  expectRoom(context_->device, context_->shared, *scene_, seen);
  for (size_t i = 0; i < seen.size(); i++)
    parts_.emplace(seen[i], upload(seen[i], partOf(advance, i, seen.size())));
  if (parts_.size() != 1) anywhere_ = upload(-1, [](double) {});
  size_t bytes = anywhere_.scene.bytes();
  for (const auto& [p, part] : parts_) bytes += part.scene.bytes();
  charge_ = Charge(context_->device, bytes);
  if (!scene_->sampled) compile(advance);
}

// The steps are those of batches (batch.cpp). If there is one partition, its rays are spawned in it; if there
// are several, they come from where they wait on the device.
void VulkanScene::compile(const Advance& advance) {
  VulkanFrame usual;
  usual.lights = int(scene_->visualization.lighting.sources.size());
  std::vector<Step> steps;
  const bool several = parts_.size() > 1;
  if (!parts_.empty()) steps.push_back(spawnStep(spawningPart(), 1));
  if (several) steps.push_back(Lane::takeStep(context_->device));
  for (const auto& [p, part] : parts_) {
    addSteps(steps, part, usual, List::Given, several ? 1 : ~COUNT_SPAWNED, true, true);
    if (secondariesPerHit(usual) > 0) addSteps(steps, part, usual, List::Here, ~COUNT_HERE, false, true);
  }
  for (const Step& step : steps) {
    advance(1);  // may throw, which ends it
    pipelines_.push_back(context_->pipelines.get(step.stage, step.special));
  }
}

const PartitionOnDevice& VulkanScene::spawningPart() const {
  return parts_.size() == 1 ? parts_.begin()->second : anywhere_;
}

std::vector<SharedBytes> VulkanScene::sharedBytes() const {
  std::vector<SharedBytes> shared;
  const auto add = [&](const auto& data) {
    if (data) shared.push_back({data.get(), data->charge.bytes()});
  };
  for (const auto& [p, part] : parts_) {
    add(part.samples);
    add(part.geometry);
  }
  return shared;
}

std::shared_ptr<const DeviceFrame> VulkanScene::makeFrame(const CompiledFrame& f) const {
  auto frame = std::make_shared<VulkanFrame>();
  frame->number = ++context_->frames;
  frame->time = &context_->time;
  frame->lights = int(f.lights.size());
  frame->depth = f.depth;
  frame->worldPerRender = f.worldPerRender;
  shader::FrameView v{};
  fillFrameView(v, *scene_, f);
  const auto lights = std::as_bytes(std::span(f.lights));
  // The shaders' array of lights begins right behind the structure.
  frame->buffer =
      Buffer(context_->device, sizeof v + std::max<size_t>(lights.size(), 16), Place::Written, "a frame");
  std::memcpy(frame->buffer.mapped(), &v, sizeof v);
  if (!lights.empty()) std::memcpy(frame->buffer.mapped() + sizeof v, lights.data(), lights.size());
  const Binding buffer{{frame->buffer.get(), 0, VK_WHOLE_SIZE}};
  frame->set =
      DescriptorSet(context_->device, context_->pipelines.setLayout(FRAME_SET), std::span(&buffer, 1));
  return frame;
}

std::shared_ptr<const DeviceFrame> VulkanScene::makeSampling(std::shared_ptr<const CompiledSampling> sampling,
                                                             EnterMemory enter) const {
  std::vector<int> partitions;
  for (const auto& [p, part] : parts_) partitions.push_back(p);
  auto frame = std::make_shared<VulkanFrame>();
  frame->enter = std::move(enter);
  try {
    frame->sampling = std::make_unique<const VulkanSampling>(
        context_->device, context_->pipelines, context_->shared, std::move(sampling), partitions, rank_);
    const std::vector<int32_t> view = frame->sampling->view();
    const auto bytes = std::as_bytes(std::span(view));
    // The shader's array begins right behind the structure, and is never empty.
    frame->buffer = Buffer(context_->device, bytes.size() + 16, Place::Written, "a sampling");
    std::memcpy(frame->buffer.mapped(), bytes.data(), bytes.size());
    const Binding buffer{{frame->buffer.get(), 0, VK_WHOLE_SIZE}};
    frame->set =
        DescriptorSet(context_->device, context_->pipelines.setLayout(FRAME_SET), std::span(&buffer, 1));
    std::vector<Step> steps{beginStep(spawningPart(), 1)};
    for (const auto& [p, part] : parts_)
      addSteps(steps, part, *frame, List::Given, ~COUNT_ACTIVE_SECONDARIES, false, true);
    for (const Step& step : steps)
      frame->pipelines.push_back(context_->pipelines.get(step.stage, step.special));
  } catch (const Error& error) {
    spdlog::warn("device \"{}\" cannot sample: {}", deviceName(), error.what());
    return nullptr;
  }
  frame->number = ++context_->frames;
  frame->time = &context_->time;
  return frame;
}

void VulkanScene::spawnRays(const DeviceFrame& deviceFrame, RayList rays, Done done) const {
  const auto& frame = static_cast<const VulkanFrame&>(deviceFrame);
  askInParts({this, &spawningPart(), &frame, DeviceTask::Kind::Begin, std::move(rays), {}, {}}, 0,
             std::move(done));
}

void VulkanScene::spawn(const DeviceFrame& deviceFrame, const SpawnTile& tile, Done done) const {
  const auto& frame = static_cast<const VulkanFrame&>(deviceFrame);
  const PartitionOnDevice& part = spawningPart();
  std::vector<DeviceTask> parts;
  std::vector<SpawnTile> tiles{tile};
  while (!tiles.empty()) {
    const SpawnTile t = tiles.back();
    tiles.pop_back();
    DeviceTask request{this, &part, &frame, DeviceTask::Kind::Spawn, {}, t, {}};
    if (pixelsOf(t) <= mostAtOnce(request)) {
      parts.push_back(std::move(request));
      continue;
    }
    const bool inRows = t.y1 - t.y0 > 1;
    const int x = (t.x0 + t.x1) / 2, y = (t.y0 + t.y1) / 2;
    tiles.push_back(inRows ? SpawnTile{t.x0, t.y0, t.x1, y, t.sample}
                           : SpawnTile{t.x0, t.y0, x, t.y1, t.sample});
    tiles.push_back(inRows ? SpawnTile{t.x0, y, t.x1, t.y1, t.sample}
                           : SpawnTile{x, t.y0, t.x1, t.y1, t.sample});
  }
  ask(std::move(parts), 0, std::move(done));
}

void VulkanScene::trace(const DeviceFrame& deviceFrame, int partition, bool primary, RayList rays,
                        Done done) const {
  const auto& frame = static_cast<const VulkanFrame&>(deviceFrame);
  const auto part = parts_.find(partition);
  if (part == parts_.end())
    throw Error("rays came for partition " + std::to_string(partition) +
                ", which has nothing to see on this rank");
  const auto kind = primary ? DeviceTask::Kind::Primaries : DeviceTask::Kind::Secondaries;
  const auto size = uint64_t(rays.size());
  askInParts({this, &part->second, &frame, kind, std::move(rays), {}, {}}, size, std::move(done));
}

// `rays`, here and below: how many have ended if the device fails.
void VulkanScene::askInParts(DeviceTask whole, uint64_t rays, Done done) const {
  std::vector<DeviceTask> parts;
  if (const size_t most = mostAtOnce(whole); whole.size() > most)
    for (RayList& some : whole.rays.split(int(most)))
      parts.push_back({this, whole.part, whole.frame, whole.kind, std::move(some), {}, {}});
  else
    parts.push_back(std::move(whole));
  ask(std::move(parts), rays, std::move(done));
}

// The most rays of a request that fit a list with all secondaries that they may make. At least one: the
// device then says that it is too much.
size_t VulkanScene::mostAtOnce(const DeviceTask& request) const {
  return std::max<size_t>(1, mostRays(context_->device) / (1 + request.perHit()));
}

void VulkanScene::ask(std::vector<DeviceTask> parts, uint64_t rays, Done done) const {
  if (parts.size() == 1) {
    parts[0].done = std::move(done);
  } else {
    const auto joined = std::make_shared<Joined>(parts.size(), rays, std::move(done));
    for (DeviceTask& part : parts)
      part.done = [joined](TraceResult result) { joined->take(std::move(result)); };
  }
  for (DeviceTask& part : parts) context_->tracer.add(std::move(part));
}

size_t VulkanScene::secondariesPerHit(const VulkanFrame& frame) const {
  const Lighting& lighting = scene_->visualization.lighting;
  if (frame.sampling) return 0;
  return size_t((lighting.shadows ? frame.lights : 0) + lighting.aoCount);
}

void VulkanScene::keepRays(std::shared_ptr<KeptRays>& room, size_t rays) const {
  const size_t bytes = listBytes(rays);
  if (parts_.size() > 1 && room && room->bytes() >= bytes && room->bytes() / kMostSpare <= bytes) return;
  room.reset();
  if (parts_.size() < 2 || context_->bytesKept + bytes > context_->mostKept) return;
  try {
    room = std::make_shared<KeptRays>(context_->device, context_->bytesKept, bytes);
  } catch (const Error&) {  // the device is full
  }
}

Step VulkanScene::spawnStep(const PartitionOnDevice& part, int tiles) {
  Step step{Stage::Spawn, part.special};
  step.push[PUSH_RAYS] = tiles * kTile * kTile;
  step.push[PUSH_PARTITION] = part.partition;
  step.push[PUSH_TILES] = tiles;
  step.push[PUSH_MINE] = int32_t(part.mine);
  return step;
}

Step VulkanScene::beginStep(const PartitionOnDevice& part, int rays) {
  Step step{Stage::Begin, part.special};
  step.push[PUSH_RAYS] = rays;
  step.push[PUSH_PARTITION] = part.partition;
  step.push[PUSH_MINE] = int32_t(part.mine);
  return step;
}

void VulkanScene::addSteps(std::vector<Step>& steps, const PartitionOnDevice& part, const VulkanFrame& frame,
                           List list, int32_t rays, bool primary, bool complete) const {
  const auto add = [&](Stage stage, const Special& special, int32_t op = 0, int32_t count = 0) {
    Step& step = steps.emplace_back(Step{stage, special, list});
    step.push[PUSH_RAYS] = rays;
    step.push[PUSH_PARTITION] = part.partition;
    step.push[PUSH_OPERATOR] = op;
    step.push[PUSH_COUNT] = count;
    step.push[PUSH_MINE] = int32_t(part.mine);
  };
  const auto isHere = [&](int op) { return part.hasBlock[size_t(op)]; };
  const Special& special = part.special;
  const int32_t clipped = isClipped_ ? SURFACE_CLIPPED : 0;
  if (rays < 0) add(Stage::Groups, special);
  if (!complete) add(Stage::Regenerate, special);
  add(Stage::Bound, special);
  const uint32_t anyHit = !primary && !frame.sampling && scene_->opaqueSurfaces;
  if (part.geometryKinds != 0) {
    Special meets = special;
    meets.surfaces = part.geometryKinds | clipped | (context_->countsNodes ? SURFACE_COUNTS : 0);
    meets.anyHit = anyHit;
    add(Stage::Geometry, meets);
  }
  for (int op : scene_->sliced)
    if (isHere(op)) add(Stage::Slices, special, op);
  Special crosses = special;
  crosses.surfaces = primary ? 0 : SURFACE_STARTS;
  crosses.anyHit = anyHit;
  for (int op : scene_->isosurfaces)
    if (part.hasIsosurface[size_t(op)]) add(Stage::Isosurfaces, crosses, op);
  const std::vector<int32_t>& volumes = scene_->rendered;
  if (volumes.size() == 1 && part.hasCells[size_t(volumes[0])]) {
    Special marches = special;
    marches.surfaces = viewKindOf(scene_->operators[size_t(volumes[0])]) == KIND_HEX_MESH ? SURFACE_HEXES : 0;
    add(Stage::IntegrateMesh, marches, volumes[0]);
  } else if (std::any_of(volumes.begin(), volumes.end(), isHere)) {
    if (volumes.size() == 1)
      add(Stage::Integrate, special, volumes[0]);
    else
      add(Stage::IntegrateVolumes, special, int32_t(part.volumeList), int32_t(volumes.size()));
  }
  const bool surfacesInVolumes = !scene_->sliced.empty() || !scene_->isosurfaces.empty();
  Special shades = special;
  shades.surfaces = part.geometryKinds | (surfacesInVolumes ? SURFACE_FIELDS : 0);
  Special ends = special;
  ends.surfaces = frame.sampling ? SURFACE_SAMPLED : 0;
  add(Stage::Finish, ends);
  if (frame.sampling && shades.surfaces != 0) {
    const PartitionOnDevice& fields = frame.sampling->part(part.partition);
    rays = ~COUNT_SHADED;
    add(Stage::Groups, special);
    add(Stage::Sample, fields.special);
    steps.back().scene = fields.set.get();
  } else if (primary && shades.surfaces != 0) {
    shades.surfaces |= clipped | (secondariesPerHit(frame) > 0 ? SURFACE_CASTS : 0);
    rays = ~COUNT_SHADED;
    add(Stage::Groups, special);
    if (frame.depth) add(Stage::Depth, special);
    add(Stage::Shade, shades);
  }
}

void VulkanScene::addTimes(TraceCounters& c, const Lane& lane) {
  const auto spent = [&](Stage stage) { return lane.nanoseconds(stage); };
  c.nsSpawn += spent(Stage::Spawn) + spent(Stage::Begin);
  c.nsGeometry += spent(Stage::Geometry);
  c.nsSurfaces += spent(Stage::Slices) + spent(Stage::Isosurfaces);
  c.nsIntegrate += spent(Stage::Integrate) + spent(Stage::IntegrateVolumes) + spent(Stage::IntegrateMesh);
  c.nsShade += spent(Stage::Shade) + spent(Stage::Sample) + spent(Stage::Depth) + spent(Stage::Finish);
  c.nsRoute += spent(Stage::Regenerate) + spent(Stage::Bound) + spent(Stage::Groups) + spent(Stage::Take);
}

}  // namespace gxy::vulkan
