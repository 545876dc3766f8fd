// SPDX-License-Identifier: Apache-2.0
#include "gxy/vulkan/vulkan_scene.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "gxy/comm/error.h"
#include "gxy/rays/fill_views.h"

namespace gxy::vulkan {

namespace {

constexpr size_t kMostVolumes = 8;  // MANY_VOLUMES of kernels/many.h

struct VulkanFrame final : DeviceFrame {
  Buffer buffer;
  DescriptorSet set;
  int lights = 0;
  bool depth = false;
  double worldPerRender = 1;
};

// Rays to lists by partition, in order of partition; `wanted` says which partitions.
template <class Wanted>
void distribute(const RayBlock* blocks, int count, bool primary, const Wanted& wanted,
                std::vector<LeavingRays>& out) {
  std::map<int, std::vector<int>> places;
  for (int i = 0; i < count; i++) {
    const int next = blocks[i / BLOCK_RAYS].next[i % BLOCK_RAYS];
    if (next >= 0 && wanted(next)) places[next].push_back(i);
  }
  for (const auto& [partition, which] : places) out.push_back({partition, primary, gather(blocks, which)});
}

}  // namespace

VulkanScene::VulkanScene(std::shared_ptr<Context> context, std::shared_ptr<const CompiledScene> scene,
                         int rank)
    : context_(std::move(context)), scene_(std::move(scene)), rank_(rank) {
  const auto& operators = scene_->operators;
  for (size_t i = 0; i < operators.size(); i++) {
    if (!operators[i].slices.empty()) slicedOperators_.push_back(int(i));
    if (!operators[i].isovalues.empty()) isoOperators_.push_back(int(i));
    if (operators[i].vis.type == VisType::Volume && operators[i].vis.volumeRendering)
      renderedOperators_.push_back(int(i));
  }
  surfacesInVolumes_ = !slicedOperators_.empty() || !isoOperators_.empty();
  if (renderedOperators_.size() > kMostVolumes)
    throw Error("a visualization renders " + std::to_string(renderedOperators_.size()) +
                " volumes at once; this backend takes at most " + std::to_string(kMostVolumes));
  anywhere_ = uploadPart(context_->device, context_->pipelines, *scene_, -1);
  for (int p : scene_->partitioning->owned(rank_))
    if (scene_->visible[size_t(p)])  // nothing is there where nothing can be seen
      parts_.emplace(p, uploadPart(context_->device, context_->pipelines, *scene_, p));
}

std::shared_ptr<const DeviceFrame> VulkanScene::makeFrame(const CompiledFrame& f) const {
  auto frame = std::make_shared<VulkanFrame>();
  frame->lights = int(f.lights.size());
  frame->depth = f.depth;
  frame->worldPerRender = f.worldPerRender;
  shader::FrameView v{};
  fillFrameView(v, *scene_, f);
  const auto lights = std::as_bytes(std::span(f.lights));
  // the shaders' array of lights begins right behind the structure
  frame->buffer =
      Buffer(context_->device, sizeof v + std::max<size_t>(lights.size(), 16), Place::Device, "a frame");
  upload(context_->device, frame->buffer, 0, std::as_bytes(std::span(&v, 1)));
  if (!lights.empty()) upload(context_->device, frame->buffer, sizeof v, lights);
  const VkDescriptorBufferInfo buffer{frame->buffer.get(), 0, VK_WHOLE_SIZE};
  frame->set =
      DescriptorSet(context_->device, context_->pipelines.setLayout(FRAME_SET), std::span(&buffer, 1));
  return frame;
}

void VulkanScene::spawn(const DeviceFrame& deviceFrame, const Tile& tile, Done done) const {
  const auto& frame = static_cast<const VulkanFrame&>(deviceFrame);
  TraceResult result;
  {
    const LanePool::Lease lane = context_->lanes.take();
    constexpr int kRays = kTile * kTile;
    lane->reserve(kRays, 1);
    lane->begin(anywhere_.set.get(), frame.set.get(), kRays);
    lane->run(Stage::Spawn, anywhere_.special, {tile.x0, tile.y0, tile.x1, tile.y1, tile.sample});
    lane->finish();
    result.counters.nsSpawn = lane->nanoseconds(Stage::Spawn);
    const auto mine = [&](int partition) { return scene_->partitioning->owner(partition) == rank_; };
    distribute(lane->leaving(), kRays, true, mine, result.leaving);
    for (const LeavingRays& l : result.leaving) result.counters.raysSpawned += uint64_t(l.rays.size());
  }
  done(std::move(result));
}

// A list of rays on its way through one partition.
class VulkanScene::Packet {
 public:
  Packet(const VulkanScene& scene, const PartOnDevice& part, const VulkanFrame& frame, bool primary)
      : scene_(scene), part_(part), frame_(frame), primary_(primary) {
    const Lighting& lighting = scene_.scene_->visualization.lighting;
    perHit_ = primary ? (lighting.shadows ? frame.lights : 0) + lighting.aoCount : 0;
  }

  TraceResult trace(const RayList& rays) {
    // a list that is too long for a binding goes in pieces
    const size_t perRay = sizeof(RayBlock) / BLOCK_RAYS * std::bit_ceil(size_t(std::max(perHit_, 1)));
    const size_t most = std::bit_floor(scene_.context_->device.limits().maxStorageBufferRange / perRay);
    for (size_t first = 0; first < size_t(rays.size()); first += most)
      tracePiece(rays, int(first), int(std::min(most, size_t(rays.size()) - first)));
    uint64_t leaving = 0;
    for (const LeavingRays& l : result_.leaving)
      if (l.primary == primary_) leaving += uint64_t(l.rays.size());
    result_.retired = uint64_t(rays.size()) - leaving;
    result_.counters.secondariesSpawned = result_.secondaries;
    return std::move(result_);
  }

 private:
  void tracePiece(const RayList& rays, int first, int count) {
    const LanePool::Lease lane = scene_.context_->lanes.take();
    lane->reserve(size_t(count), size_t(count) * size_t(std::max(perHit_, 1)));
    lane->load(rays, first, count);
    bool complete = rays.complete();
    while (count > 0) {
      lane->begin(part_.set.get(), frame_.set.get(), count);
      if (!complete) lane->run(Stage::Regenerate, part_.special);
      record(*lane);
      lane->finish();
      complete = true;
      take(*lane, count);
      count = int(lane->count(COUNT_ACTIVE));
      lane->swapLists();
    }
  }

  void record(Lane& lane) const {
    const bool opaque = scene_.scene_->opaqueSurfaces;
    lane.run(Stage::Bound, part_.special);
    if (part_.geometryKinds != 0) {
      Special special = part_.special;
      special.surfaces = part_.geometryKinds;
      special.anyHit = !primary_ && opaque;
      lane.run(Stage::Geometry, special);
    }
    for (int op : scene_.slicedOperators_)
      if (part_.hasBlock[size_t(op)]) lane.run(Stage::Slices, part_.special, {op});
    for (int op : scene_.isoOperators_)
      if (part_.hasBlock[size_t(op)]) lane.run(Stage::Isosurfaces, part_.special, {op});
    const std::vector<int>& volumes = scene_.renderedOperators_;
    if (std::any_of(volumes.begin(), volumes.end(), [&](int op) { return part_.hasBlock[size_t(op)]; })) {
      if (volumes.size() == 1)
        lane.run(Stage::Integrate, part_.special, {volumes[0]});
      else
        lane.run(Stage::IntegrateMany, part_.special, {int32_t(part_.volumeList), int32_t(volumes.size())});
    }
    Special special = part_.special;
    special.surfaces = part_.geometryKinds | (scene_.surfacesInVolumes_ ? SURFACE_FIELDS : 0);
    if (primary_ && special.surfaces != 0) {
      if (frame_.depth) lane.run(Stage::Depth, part_.special);
      lane.run(Stage::Shade, special);
    }
    lane.run(Stage::Finish, part_.special);
  }

  void take(const Lane& lane, int traced) {
    if (lane.count(COUNT_CUT) > 0)
      throw Error("Vulkan: device \"" + scene_.context_->device.info().name + "\" gave up on " +
                  std::to_string(lane.count(COUNT_CUT)) +
                  " rays, which take it more than 65535 steps; the embree backend has no such limit");
    TraceCounters& c = result_.counters;
    c.raysTraced += uint64_t(traced);
    const auto spent = [&](Stage stage) { return lane.nanoseconds(stage); };
    c.nsGeometry += spent(Stage::Geometry);
    c.nsSurfaces += spent(Stage::Slices) + spent(Stage::Isosurfaces);
    c.nsIntegrate += spent(Stage::Integrate) + spent(Stage::IntegrateMany);
    c.nsShade += spent(Stage::Shade) + spent(Stage::Depth) + spent(Stage::Finish);
    c.nsRoute += spent(Stage::Regenerate) + spent(Stage::Bound);
    c.raysShaded += lane.count(COUNT_SHADED);
    c.samples += lane.count(COUNT_SAMPLES);
    c.macrocells += lane.count(COUNT_MACROCELLS);
    c.macrocellsSkipped += lane.count(COUNT_SKIPPED);
    c.cells += lane.count(COUNT_CELLS);
    c.isoMacrocellsSkipped += lane.count(COUNT_ISO_SKIPPED);
    result_.secondaries += lane.count(COUNT_MADE);
    const auto all = [](int) { return true; };
    distribute(lane.leaving(), int(lane.count(COUNT_LEAVING)), primary_, all, result_.leaving);
    distribute(lane.made(), int(lane.count(COUNT_MADE)), false, all, result_.leaving);
    const int32_t* r = lane.records();
    for (uint32_t i = 0; i < lane.count(COUNT_RECORDS); i++, r += RECORD_WORDS)
      result_.contributions.push_back({uint32_t(r[0]), r[1], r[2], r[3], r[4]});
    const uint32_t* d = lane.depths();
    for (uint32_t i = 0; i < lane.count(COUNT_DEPTHS); i++, d += DEPTH_WORDS) {
      const auto distance = std::bit_cast<double>(uint64_t(d[2]) << 32 | d[1]);
      result_.depths.push_back({d[0], distance * frame_.worldPerRender});
    }
  }

  const VulkanScene& scene_;
  const PartOnDevice& part_;
  const VulkanFrame& frame_;
  const bool primary_;
  int perHit_ = 0;
  TraceResult result_;
};

void VulkanScene::trace(const DeviceFrame& frame, int partition, bool primary, RayList rays,
                        Done done) const {
  const auto part = parts_.find(partition);
  if (part == parts_.end())
    throw Error("rays came for partition " + std::to_string(partition) +
                ", which has nothing to see on this rank");
  done(Packet(*this, part->second, static_cast<const VulkanFrame&>(frame), primary).trace(rays));
}

size_t VulkanScene::bytes() const {
  const auto bytesOf = [](const PartOnDevice& p) {
    return p.scene.bytes() + p.samples.bytes() + p.geometry.bytes();
  };
  size_t n = bytesOf(anywhere_);
  for (const auto& [p, part] : parts_) n += bytesOf(part);
  return n;
}

}  // namespace gxy::vulkan
