// SPDX-License-Identifier: Apache-2.0
#include "backends/embree/embree_scene.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <limits>

#include "backends/embree/embree_sampling.h"
#include "core/comm/error.h"
#include "core/rays/fill_views.h"
#include "core/rays/view_pointers.h"
#include "fields_ispc.h"
#include "geometry_ispc.h"
#include "integrate_ispc.h"
#include "integrate_mesh_ispc.h"
#include "integrate_volumes_ispc.h"
#include "shade_ispc.h"
#include "spawn_ispc.h"

namespace gxy {

namespace {

struct EmbreeFrame final : DeviceFrame {
  single::FrameView view{};
  std::vector<std::array<float, 4>> lights;
  bool depth = false;
  double worldPerRender = 1;
  std::unique_ptr<const EmbreeSampling> sampling;  // null unless its rays sample
  EnterMemory enter;                               // of a sampling
};

// Adds the time that it lives to a counter.
class Stopwatch {
 public:
  explicit Stopwatch(uint64_t& sum) : sum_(sum) {}
  ~Stopwatch() {
    sum_ += uint64_t(std::chrono::nanoseconds(std::chrono::steady_clock::now() - start_).count());
  }

 private:
  uint64_t& sum_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

void addContributions(const RayView& r, std::span<const int> which, const std::vector<int32_t>& sums,
                      std::vector<Contribution>& out) {
  for (size_t k = 0; k < which.size(); k++) {
    const int32_t* s = &sums[4 * k];
    if (s[0] | s[1] | s[2] | s[3]) out.push_back({r.pixel[which[k]], s[0], s[1], s[2], s[3]});
  }
}

// Sorts rays into one list per destination, in order of partition. A list that goes to one place is not
// copied.
void distribute(RayList rays, bool primary, std::vector<LeavingRays>& out) {
  const int32_t* next = rays.view().next;
  std::map<int, std::vector<int>> places;
  std::vector<int>* place = nullptr;
  int last = END_DONE;
  for (int i = 0; i < rays.size(); i++) {
    if (next[i] < 0) continue;
    if (next[i] != last) {
      last = next[i];
      place = &places[last];
    }
    place->push_back(i);
  }
  if (places.size() == 1 && places.begin()->second.size() == size_t(rays.size())) {
    out.push_back({last, primary, std::move(rays)});
    return;
  }
  for (const auto& [partition, which] : places) out.push_back({partition, primary, rays.gather(which)});
}

}  // namespace

EmbreeScene::EmbreeScene(std::shared_ptr<EmbreeShared> shared, std::shared_ptr<const CompiledScene> scene,
                         int rank, const Advance& advance)
    : shared_(std::move(shared)), scene_(std::move(scene)), rank_(rank) {
  const auto& operators = scene_->operators;
  ViewPointers pointers;
  fillSceneView(anywhere_, *scene_, -1, pointers);
  const std::vector<int> owned = scene_->partitioning->owned(rank_);
  for (size_t k = 0; k < owned.size(); k++) {
    const int p = owned[k];
    if (!scene_->visible[p]) continue;  // nothing is built where nothing can be seen
    PartitionViews& part = parts_[p];
    fillSceneView(part.view, *scene_, p, pointers);
    part.operators.resize(operators.size());
    part.fields.resize(operators.size());
    for (size_t i = 0; i < operators.size(); i++) {
      const CompiledOperator& op = operators[i];
      const auto found = op.parts.find(p);
      const OperatorInPartition* mine = found == op.parts.end() ? nullptr : &found->second;
      fillVolumeView(part.fields[i], op, mine, pointers);
      fillOperatorView(part.operators[i], op, pointers);
      if (!mine) continue;
      const Advance building = partOf(advance, k * operators.size() + i, owned.size() * operators.size());
      const auto treeOver = [&](const GeometryInPartition& primitives, int kind) {
        part.trees.push_back(shared_->trees.get(
            &primitives, [&] { return buildGeometryTree(kind, primitives, ispc::gangWidth(), building); },
            [&] { building(0); }));
        return GeometryTreeView{part.trees.back()->nodes.data(), part.trees.back()->leaves.data()};
      };
      const GeometryInPartition* primitives = mine->geometry.get();
      if (primitives) fillPrimitives(part.operators[i], *primitives, pointers);
      if (op.data.mesh) {
        if (primitives) {
          part.shellViews.resize(operators.size());
          part.shellViews[i] =
              treeOver(*primitives, viewKindOf(op) == KIND_MESH ? KIND_SHELL : KIND_HEX_SHELL);
          part.operators[i].shellHierarchy = &part.shellViews[i];
        }
        primitives = mine->surfaces.get();
        if (primitives) fillSurfaces(part.operators[i], *primitives, pointers);
      }
      if (!primitives) continue;
      part.treeViews.resize(operators.size());
      part.treeViews[i] = treeOver(*primitives, part.operators[i].kind);
    }
    part.view.operators = int(operators.size());
    part.view.operator_ = part.operators.data();
    part.view.field = part.fields.data();
    part.view.hierarchy = part.treeViews.empty() ? nullptr : part.treeViews.data();
  }
}

std::shared_ptr<const DeviceFrame> EmbreeScene::makeFrame(const CompiledFrame& f) const {
  auto frame = std::make_shared<EmbreeFrame>();
  frame->lights = f.lights;
  frame->depth = f.depth;
  frame->worldPerRender = f.worldPerRender;
  single::FrameView& v = frame->view;
  fillFrameView(v, *scene_, f);
  v.light = reinterpret_cast<const float*>(frame->lights.data());
  return frame;
}

std::shared_ptr<const DeviceFrame> EmbreeScene::makeSampling(std::shared_ptr<const CompiledSampling> sampling,
                                                             EnterMemory enter) const {
  std::vector<int> partitions;
  for (const auto& [p, part] : parts_) partitions.push_back(p);
  auto frame = std::make_shared<EmbreeFrame>();
  frame->sampling = std::make_unique<const EmbreeSampling>(std::move(sampling), partitions);
  frame->enter = std::move(enter);
  return frame;
}

void EmbreeScene::spawn(const DeviceFrame& deviceFrame, const SpawnTile& tile, Done done) const {
  const auto& frame = static_cast<const EmbreeFrame&>(deviceFrame);
  TraceResult result;
  {
    Stopwatch time(result.counters.nsSpawn);
    RayList rays(kTile * kTile);
    RayView view = rays.view();
    rays.resize(
        ispc::spawnRays(&anywhere_, &frame.view, tile.x0, tile.y0, tile.x1, tile.y1, tile.sample, &view));
    for (int i = 0; i < rays.size(); i++)
      if (scene_->partitioning->owner(view.next[i]) != rank_) view.next[i] = END_DONE;
    distribute(std::move(rays), true, result.leaving);
    for (const LeavingRays& l : result.leaving) result.counters.raysSpawned += uint64_t(l.rays.size());
  }
  done(std::move(result));
}

void EmbreeScene::spawnRays(const DeviceFrame&, RayList rays, Done done) const {
  TraceResult result;
  {
    Stopwatch time(result.counters.nsSpawn);
    RayView view = rays.view();
    std::fill_n(view.tLast, rays.size(), -1.0f);
    std::fill_n(view.tResume, rays.size(), -1.0f);
    std::fill_n(view.A, rays.size(), 0.0f);
    ispc::routeRays(&anywhere_, &view, rays.size(), true);
    distribute(std::move(rays), false, result.leaving);
    for (const LeavingRays& l : result.leaving) result.counters.raysSpawned += uint64_t(l.rays.size());
  }
  done(std::move(result));
}

// A list of rays on its way through one partition.
class EmbreeScene::Packet {
 public:
  Packet(const EmbreeScene& scene, int partition, const PartitionViews& part, const EmbreeFrame& frame,
         bool primary)
      : scene_(scene),
        partition_(partition),
        part_(part),
        frame_(frame),
        primary_(primary),
        anyHit_(!primary && !frame.sampling && scene.scene_->opaqueSurfaces) {}

  TraceResult trace(RayList rays) {
    const int start = rays.size();
    if (!rays.complete()) {
      RayView view = rays.view();
      ispc::regenerateRays(&frame_.view, &view, rays.size());
      rays.setComplete();
    }
    // A sampling ray may have thousands of hits, whose flight may end meanwhile.
    while (rays.size() > 0 && !(frame_.sampling && frame_.cancelled())) {
      result_.counters.raysTraced += uint64_t(rays.size());
      meet(rays);
      rays = settle(std::move(rays));
    }
    uint64_t leaving = 0;
    for (const LeavingRays& l : result_.leaving)
      if (l.primary == primary_) leaving += uint64_t(l.rays.size());
    result_.retired = result_.counters.raysRetired = uint64_t(start) - leaving;
    for (RayList& made : secondaries_) distribute(std::move(made), false, result_.leaving);
    return std::move(result_);
  }

 private:
  // Finds what each ray meets in the partition: bounds, nearest surface, and volumes in front of it.
  void meet(RayList& rays) {
    RayView view = rays.view();
    const int n = rays.size();
    TraceCounters& c = result_.counters;
    ispc::boundRays(&part_.view, &view, n);
    if (!part_.treeViews.empty()) {
      Stopwatch time(c.nsGeometry);
      c.runs(Kernel::Geometry)++;
      ispc::hitGeometry(&part_.view, &view, n, anyHit_);
    }
    const CompiledScene& scene = *scene_.scene_;
    if (!scene.sliced.empty() || !scene.isosurfaces.empty()) {
      Stopwatch time(c.nsSurfaces);
      for (int op : scene.sliced)
        if (part_.fields[op].samples) {
          c.runs(Kernel::Slices)++;
          ispc::hitSlices(&part_.view, &view, n, op);
        }
      int64_t counts[2] = {0, 0};
      for (int op : scene.isosurfaces)
        if (part_.fields[op].isoMask) {
          c.runs(Kernel::Isosurfaces)++;
          ispc::hitIsosurfaces(&part_.view, &view, n, op, anyHit_, counts);
        }
      c.cells += uint64_t(counts[0]);
      c.isoMacrocellsSkipped += uint64_t(counts[1]);
    }
    const std::vector<int32_t>& volumes = scene.rendered;
    if (volumes.size() == 1 && scene.operators[size_t(volumes[0])].data.mesh) {
      if (part_.operators[size_t(volumes[0])].primitives > 0) integrateMesh(view, n, volumes[0]);
    } else if (std::any_of(volumes.begin(), volumes.end(),
                           [&](int op) { return part_.fields[op].samples; })) {
      Stopwatch time(c.nsIntegrate);
      c.runs(volumes.size() == 1 ? Kernel::Integrate : Kernel::IntegrateVolumes)++;
      int64_t counts[4] = {};
      if (volumes.size() == 1)
        ispc::integrateRays(&part_.view, &view, n, volumes[0], counts);
      else
        ispc::integrateRaysOfVolumes(&part_.view, &view, n, volumes.data(), int(volumes.size()), counts);
      c.samples += uint64_t(counts[0]);
      c.macrocells += uint64_t(counts[1]);
      c.macrocellsSkipped += uint64_t(counts[2]);
      c.segmentsSkipped += uint64_t(counts[3]);
    }
    ispc::routeRays(&part_.view, &view, n, false);
  }

  void integrateMesh(RayView& view, int n, int op) {
    TraceCounters& c = result_.counters;
    Stopwatch time(c.nsIntegrate);
    c.runs(Kernel::IntegrateMesh)++;
    int64_t counts[3] = {};
    if (part_.operators[size_t(op)].kind == KIND_MESH)
      ispc::integrateRaysOfMesh(&part_.view, &view, n, op, counts);
    else
      ispc::integrateRaysOfHexahedra(&part_.view, &view, n, op, counts);
    c.samples += uint64_t(counts[0]);
    c.meshCells += uint64_t(counts[1]);
    c.meshWalks += uint64_t(counts[2]);
  }

  // Shades or samples hits, deposits light and forwards rays. Returns the rays that go on behind a surface.
  RayList settle(RayList rays) {
    RayView view = rays.view();
    const int n = rays.size();
    TraceCounters& c = result_.counters;
    Stopwatch time(c.nsShade);
    std::vector<int> which;
    for (int i = 0; i < n; i++)
      if (view.next[i] == END_SURFACE) which.push_back(i);
    if (!which.empty()) {
      if (primary_) shade(rays, which);
      if (frame_.sampling)
        record(view, which);
      else
        ispc::passSurfaces(&part_.view, &view, n);
    }
    which.clear();
    std::vector<int> active;
    for (int i = 0; i < n; i++) {
      if (view.next[i] == END_DONE) {
        which.push_back(i);
        c.raysEndedEarly += 1.0f - view.A[i] < part_.view.tMin;
      }
      if (view.next[i] == END_ACTIVE) active.push_back(i);
    }
    if (!which.empty() && !frame_.sampling) {
      sums_.assign(4 * which.size(), 0);
      ispc::settleRays(&part_.view, &view, which.data(), int(which.size()), sums_.data());
      addContributions(view, which, sums_, result_.contributions);
    }
    RayList rest = rays.gather(active);
    for (size_t k = 0; k < active.size(); k++) {
      rest.view().lastOperator[k] = view.lastOperator[active[k]];
      rest.view().lastPrimitive[k] = view.lastPrimitive[active[k]];
    }
    if (which.size() + active.size() < size_t(n)) distribute(std::move(rays), primary_, result_.leaving);
    return rest;
  }

  void record(RayView& view, const std::vector<int>& which) {
    frame_.sampling->record(part_.view, partition_, view, which, result_.samples.list);
    if (!result_.samples.enter(frame_.enter, false)) frame_.cancel();
  }

  void shade(RayList& rays, const std::vector<int>& which) {
    RayView view = rays.view();
    const int hits = int(which.size());
    const Lighting& lighting = scene_.scene_->visualization.lighting;
    const int64_t perHit = int64_t(lighting.shadows ? frame_.view.lights : 0) + lighting.aoCount;
    const int64_t most = hits * perHit + 16;
    if (most > std::numeric_limits<int>::max())
      throw Error(std::to_string(perHit) + " shadow and ambient-occlusion rays of each of " +
                  std::to_string(hits) + " hits are more than one packet can make");
    RayList made{int(most)};
    RayView out = made.view();
    sums_.assign(4 * which.size(), 0);
    if (frame_.depth) addDepths(view, which);
    TraceCounters& c = result_.counters;
    c.runs(Kernel::Shade)++;
    made.resize(ispc::shadeHits(&part_.view, &frame_.view, &view, which.data(), hits, sums_.data(), &out));
    addContributions(view, which, sums_, result_.contributions);
    c.raysShaded += uint64_t(hits);
    c.secondariesSkipped += uint64_t(hits * perHit);
    if (made.size() == 0) return;
    ispc::routeRays(&part_.view, &out, made.size(), true);
    uint64_t going = 0;
    for (int i = 0; i < made.size(); i++)
      going += out.next[i] >= 0;  // the others leave the visible domain at once
    result_.created += going;
    c.secondariesSpawned += going;
    c.secondariesSkipped -= going;
    secondaries_.push_back(std::move(made));
  }

  void addDepths(RayView& view, const std::vector<int>& which) {
    std::vector<int> first;
    for (int i : which)
      if (RAY_SAMPLE_NUMBER(view.info[i]) == 0 && view.tLast[i] < 0) first.push_back(i);
    std::vector<double> distances(first.size());
    ispc::eyeDistances(&frame_.view, &view, first.data(), int(first.size()), distances.data());
    for (size_t k = 0; k < first.size(); k++)
      result_.depths.push_back({view.pixel[first[k]], distances[k] * frame_.worldPerRender});
  }

  const EmbreeScene& scene_;
  const int partition_;
  const PartitionViews& part_;
  const EmbreeFrame& frame_;
  const bool primary_;
  const bool anyHit_;  ///< rays only ask whether they meet a surface
  TraceResult result_;
  std::vector<int32_t> sums_;
  std::vector<RayList> secondaries_;
};

void EmbreeScene::trace(const DeviceFrame& frame, int partition, bool primary, RayList rays,
                        Done done) const {
  const auto part = parts_.find(partition);
  if (part == parts_.end())
    throw Error("rays came for partition " + std::to_string(partition) +
                ", which has nothing to see on this rank");
  done(Packet(*this, partition, part->second, static_cast<const EmbreeFrame&>(frame), primary)
           .trace(std::move(rays)));
}

size_t EmbreeScene::bytes() const {
  size_t n = 0;
  for (const auto& [p, part] : parts_)
    n += part.operators.size() * sizeof(single::OperatorView) +
         part.fields.size() * sizeof(single::VolumeView);
  return n;
}

std::vector<SharedBytes> EmbreeScene::sharedBytes() const {
  std::vector<SharedBytes> shared;
  for (const auto& [p, part] : parts_)
    for (const auto& tree : part.trees) shared.push_back({tree.get(), tree->bytes()});
  return shared;
}

}  // namespace gxy
