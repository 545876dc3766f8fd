// SPDX-License-Identifier: Apache-2.0
#include "backends/vulkan/batch.h"

#include <algorithm>
#include <bit>
#include <map>
#include <optional>
#include <tuple>

#include "core/comm/error.h"

namespace gxy::vulkan {

namespace {

std::optional<Kernel> kernelOf(Stage stage) {
  switch (stage) {
    case Stage::Geometry:
      return Kernel::Geometry;
    case Stage::Slices:
      return Kernel::Slices;
    case Stage::Isosurfaces:
      return Kernel::Isosurfaces;
    case Stage::Integrate:
      return Kernel::Integrate;
    case Stage::IntegrateVolumes:
      return Kernel::IntegrateVolumes;
    case Stage::IntegrateMesh:
      return Kernel::IntegrateMesh;
    default:  // Shade is counted only if there is something to shade
      return {};
  }
}

// Destroys the rays first. Whoever is told may let go of everything else of the device; that would then go
// with the rays, on a thread that nobody waits for.
void tell(DeviceTask& request, TraceResult result) {
  request.rays = {};
  request.done(std::move(result));
}

}  // namespace

Batch::Batch(std::vector<DeviceTask> requests)
    : requests_(std::move(requests)),
      results_(requests_.size()),
      scene_(*requests_[0].scene),
      part_(*requests_[0].part),
      frame_(*requests_[0].frame),
      kind_(requests_[0].kind),
      primary_(requests_[0].primary()),
      spawns_(requests_[0].spawns()),
      perHit_(requests_[0].perHit()) {}

size_t Batch::rays() const {
  size_t rays = 0;
  for (const DeviceTask& r : requests_) rays += r.size();
  return rays;
}

void Batch::start(std::unique_ptr<Lane> lane) {
  lane_ = std::move(lane);
  lane_->reserve(rays(), perHit_, frame_.sampling ? frame_.sampling->words() : 0);
  if (kind_ == DeviceTask::Kind::Spawn) {
    std::vector<SpawnTile> tiles;
    for (const DeviceTask& r : requests_) tiles.push_back(r.tile);
    lane_->load(tiles);
    steps_.push_back(scene_.spawnStep(part_, int(tiles.size())));
    if (part_.partition >= 0) trace(List::Given, ~COUNT_SPAWNED, true);
  } else {
    size_t at = 0;
    for (size_t i = 0; i < requests_.size(); i++) {
      const RayList& rays = requests_[i].rays;
      if (rays.kept())
        steps_.push_back(lane_->take(static_cast<const KeptRays*>(rays.kept())->address(), rays.places(), at,
                                     uint32_t(i)));
      else
        lane_->load(rays, at, uint32_t(i));
      at += requests_[i].size();
      complete_ = complete_ && requests_[i].rays.complete();
    }
    if (kind_ == DeviceTask::Kind::Begin)
      steps_.push_back(scene_.beginStep(part_, int(at)));
    else
      trace(List::Given, int32_t(at), primary_);
  }
  submit(0, false);
}

// Adds the steps of a list, and behind primaries those of the secondaries that they make here.
void Batch::trace(List list, int32_t rays, bool primary) {
  scene_.addSteps(steps_, part_, frame_, list, rays, primary, complete_);
  complete_ = true;
  results_[0].counters.raysTraced += uint64_t(std::max(rays, 0));
  if (primary && perHit_ > 0) scene_.addSteps(steps_, part_, frame_, List::Here, ~COUNT_HERE, false, true);
}

void Batch::submit(size_t firstStep, bool resumed) {
  if (!resumed) {
    for (const Step& step : steps_)
      if (const auto kernel = kernelOf(step.stage)) results_[0].counters.runs(*kernel)++;
    scene_.keepRays(lane_->staying, rays() * (1 + perHit_));
  }
  lane_->submit(part_.set.get(), frame_.set.get(), steps_, firstStep, resumed);
}

bool Batch::advance(DeviceTime& time) {
  lane_->wait();
  TraceCounters& c = results_[0].counters;
  c.submissions++;
  const DeviceTime::Spent spent = time.worked(frame_.number, lane_->began(), lane_->ended());
  c.nsDevice += uint64_t(spent.busy);
  c.nsDeviceIdle += spent.idle;
  scene_.addTimes(c, *lane_);
  if (!requests_[0].urgent && c.submissions == 1 && kind_ != DeviceTask::Kind::Begin)
    scene_.batchSize().took(int(rays()), std::chrono::nanoseconds(lane_->ended() - lane_->began()));
  if (lane_->count(COUNT_STUCK) > 0)
    throw Error("device \"" + scene_.deviceName() + "\" gave up on " +
                std::to_string(lane_->count(COUNT_STUCK)) +
                " rays, of which it takes more than 65535 steps to do what cannot be done in parts");
  // A sampling ray may have thousands of hits, a submission each.
  if (frame_.sampling && frame_.cancelled()) return false;
  if (const uint32_t cut = lane_->count(COUNT_CUT)) {
    submit(~cut, true);
    return true;
  }
  take();
  steps_.clear();
  if (activeSecondaries_ > 0 && primary_) {
    here_ = otherOf(here_);
    trace(here_, int32_t(activeSecondaries_), false);
  } else if (activePrimaries_ + activeSecondaries_ > 0) {
    given_ = otherOf(given_);
    here_ = List::Here;
    trace(given_, int32_t(activePrimaries_ + activeSecondaries_), primary_);
  } else {
    return false;
  }
  submit(0, false);
  return true;
}

// Takes in what the last submission has made of the rays.
void Batch::take() {
  const Lane& lane = *lane_;
  TraceResult& all = results_[0];
  TraceCounters& c = all.counters;
  if (!frame_.sampling) {
    c.raysShaded += lane.count(COUNT_SHADED);
    c.runs(Kernel::Shade) += lane.count(COUNT_SHADED) > 0;
  }
  c.samples += lane.count(COUNT_SAMPLES);
  c.macrocells += lane.count(COUNT_MACROCELLS);
  c.macrocellsSkipped += lane.count(COUNT_SKIPPED);
  c.segmentsSkipped += lane.count(COUNT_SEGMENTS_SKIPPED);
  c.cells += lane.count(COUNT_CELLS);
  c.isoMacrocellsSkipped += lane.count(COUNT_ISO_SKIPPED);
  c.meshCells += lane.count(COUNT_MESH_CELLS);
  c.meshWalks += lane.count(COUNT_MESH_WALKS);
  c.nodes += lane.count(COUNT_NODES);
  c.primitives += lane.count(COUNT_PRIMITIVES);
  c.secondariesSpawned += lane.count(COUNT_MADE);
  c.secondariesSkipped += uint64_t(lane.count(COUNT_SHADED)) * perHit_ - lane.count(COUNT_MADE);
  c.raysEndedEarly += lane.count(COUNT_ENDED);
  c.raysTraced += lane.count(COUNT_SPAWNED) + lane.count(COUNT_HERE);
  if (kind_ == DeviceTask::Kind::Spawn)
    c.raysSpawned += lane.count(part_.partition < 0 ? COUNT_LEAVING : COUNT_SPAWNED);
  if (steps_[0].stage == Stage::Begin)
    c.raysSpawned += lane.count(COUNT_LEAVING) + lane.count(COUNT_ACTIVE_SECONDARIES);
  distribute();
  takeRecords();
  const uint32_t* d = lane.depths();
  for (uint32_t i = 0; i < lane.count(COUNT_DEPTHS); i++, d += DEPTH_WORDS)
    all.depths.push_back({d[0], std::bit_cast<double>(uint64_t(d[2]) << 32 | d[1]) * frame_.worldPerRender});
  activeSecondaries_ = lane.count(COUNT_ACTIVE_SECONDARIES);
  // Primaries that go on wait until none of their secondaries goes on.
  if (steps_[0].list == given_) activePrimaries_ = lane.count(COUNT_ACTIVE_PRIMARIES);
}

// Takes contributions to pixels, or samples.
void Batch::takeRecords() {
  const Lane& lane = *lane_;
  TraceResult& all = results_[0];
  const int32_t* r = lane.records();
  if (frame_.sampling) {
    const size_t words = lane.count(COUNT_RECORDS) * frame_.sampling->words();
    frame_.sampling->take({r, words}, part_.partition, all.samples.list);
    if (!all.samples.enter(frame_.enter, false)) frame_.cancel();
    return;
  }
  all.contributions.reserve(all.contributions.size() + lane.count(COUNT_RECORDS));
  for (uint32_t i = 0; i < lane.count(COUNT_RECORDS); i++, r += RECORD_WORDS)
    all.contributions.push_back({uint32_t(r[0]), r[1], r[2], r[3], r[4]});
}

// Hands rays that leave to the packets that they came with, by kind and partition. Those that stay on the
// rank are named by their places only.
void Batch::distribute() {
  const RayBlock* blocks = lane_->leaving();
  std::map<std::tuple<uint32_t, bool, int>, std::vector<int>> places;
  std::tuple<uint32_t, bool, int> last{};
  std::vector<int>* list = nullptr;
  for (int i = 0; i < int(lane_->count(COUNT_LEAVING)); i++) {
    const RayBlock& b = blocks[i / BLOCK_RAYS];
    const int k = i % BLOCK_RAYS;
    const std::tuple key(b.packet[k], RAY_KIND(b.info[k]) == RAY_PRIMARY, int(b.next[k]));
    if (!list || key != last) list = &places[key];
    last = key;
    list->push_back(i);
  }
  bool kept = false;
  for (const auto& [key, which] : places) {
    const auto& [packet, primary, partition] = key;
    const bool stays = lane_->staying && scene_.isHere(partition);
    kept = kept || stays;
    if (!stays) results_[0].counters.raysRead += which.size();
    results_[packet].leaving.push_back(
        {partition, primary,
         stays ? RayList(lane_->staying, {which.begin(), which.end()}) : gather(blocks, which)});
  }
  if (kept) scene_.release(std::move(lane_->staying));
}

void Batch::answer() {
  TraceCounters& c = results_[0].counters;
  c.raysRetired = (spawns_ ? c.raysSpawned : rays()) + c.secondariesSpawned;
  for (const TraceResult& result : results_)
    for (const LeavingRays& l : result.leaving) c.raysRetired -= uint64_t(l.rays.size());
  for (size_t i = 0; i < requests_.size(); i++) {
    TraceResult& result = results_[i];
    uint64_t left = 0;
    for (const LeavingRays& l : result.leaving)
      (l.primary == primary_ ? left : result.created) += uint64_t(l.rays.size());
    if (spawns_)
      result.created = 0;
    else
      result.retired = uint64_t(requests_[i].rays.size()) - left;
    tell(requests_[i], std::move(result));
  }
}

void endUndone(std::vector<DeviceTask>& requests, const std::string& error) {
  for (DeviceTask& r : requests) {
    TraceResult result;
    result.error = error;
    result.retired = r.spawns() ? 0 : uint64_t(r.rays.size());
    tell(r, std::move(result));
  }
}

}  // namespace gxy::vulkan
