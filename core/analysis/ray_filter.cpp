// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/ray_filter.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "core/analysis/made_geometry.h"
#include "core/analysis/sampled_points.h"
#include "core/comm/error.h"

namespace gxy {

namespace {

const FilterSource& rayInput(const FilterRun& run, const std::string& name, const std::string& of) {
  const auto found = run.inputs().find(name);
  if (found == run.inputs().end() || found->second.empty())
    throw Error("RaySampler: " + of + " is of the input " + inQuotes(name) +
                ", which the entry does not have");
  return found->second.front();
}

const FilterSource& rayVolume(const FilterRun& run, const std::string& name, const std::string& of) {
  const FilterSource& source = rayInput(run, name, of);
  if (!source.data->volume)
    throw Error("RaySampler: " + of + " is of " + inQuotes(source.name) + ", expected a volume");
  return source;
}

// What an evaluation needs besides the rays.
class RayPlan {
 public:
  RayPlan(const RaySampler& filter, const FilterRun& run) : filter_(filter), run_(run) {
    if (filter.operators.empty()) throw Error("RaySampler: there are no `operators`, expected one or more");
    std::vector<FilterSource> values;
    for (const std::string& name : filter.values) {
      values.push_back(rayVolume(run, name, "`values`"));
      take(values.back());
      values.back().name = name;  // what the entry calls it
    }
    recorded = sampledVolumes(values, "RaySampler");
    source.fields = recorded.sampled;
    source.recorded = int(recorded.sampled.size());
    source.gradient = filter.gradient;
    for (const RaySampler::Target& target : filter.operators) add(target);
    source.scene.partitioning = partitioning_;
    source.priority.tenant = run.services().turn;
    source.account = run.services().tenant;
  }

  SamplingSource source;
  SampledVolumes recorded;
  Box box;       ///< of all that can be met
  Box firstBox;  ///< of the first operator's dataset
  std::shared_ptr<const Partitioning> partitioning() const { return partitioning_; }

 private:
  void take(const FilterSource& from) {
    if (!partitioning_) partitioning_ = from.data->partitioning;
    if (from.data->volume && !(*from.data->partitioning == *partitioning_))
      throw Error("RaySampler: " + inQuotes(from.name) +
                  " is cut differently than the others, expected volumes on the same partitions");
  }

  int fieldOf(const std::string& name, const std::string& of) {
    const FilterSource& from = rayVolume(run_, name, of);
    take(from);
    for (size_t i = 0; i < source.fields.size(); i++)
      if (source.fields[i].volume == from.data->volume && source.fields[i].component < 0) return int(i);
    source.fields.push_back({from.data->volume, -1});
    return int(source.fields.size()) - 1;
  }

  void add(const RaySampler::Target& target) {
    const FilterSource& from = rayInput(run_, target.dataset, "an operator");
    const Dataset& data = *from.data;
    take(from);
    Vis vis;
    vis.dataset = from.name;
    vis.component = target.component;
    vis.clipPlanes = target.clipPlanes;
    OperatorSource operand;
    if (data.volume) {
      if (target.isovalues.empty() && target.planes.empty())
        throw Error("RaySampler: the operator of " + inQuotes(from.name) +
                    " has nothing to meet, expected `isovalues` or `planes`");
      vis.isovalues = target.isovalues;
      vis.slices = target.planes;
      operand.data.volume = data.volume;
    } else {
      if (data.geometry->kind != GeometryKind::Triangles)
        throw Error("RaySampler: an operator is of " + inQuotes(from.name) +
                    ", expected a volume or triangles");
      vis.type = VisType::Triangles;
      operand.geometry = GeometrySource{
          "sampled " + std::to_string(from.key.value) + " " + std::to_string(from.generation), data.geometry};
    }
    HitRule rule{{}, target.hits};
    for (const RaySampler::Condition& c : target.conditions)
      rule.conditions.push_back({fieldOf(c.field, "a condition"), c.least, c.largest});
    if (source.rules.empty()) firstBox = data.box();
    box.extend(data.box());
    source.scene.visualization.operators.push_back(std::move(vis));
    source.scene.data.push_back(std::move(operand));
    source.rules.push_back(std::move(rule));
  }

  const RaySampler& filter_;
  const FilterRun& run_;
  std::shared_ptr<const Partitioning> partitioning_;
};

std::vector<SampleRay> raysFrom(const RaySampler& filter, const FilterRun& run) {
  const FilterSource& from = rayInput(run, filter.points, "`points`");
  if (!from.data->geometry || from.data->geometry->kind != GeometryKind::Particles)
    throw Error("RaySampler: `points` is " + inQuotes(from.name) + ", expected particles");
  const GeometryBlock& block = from.data->geometry->block;
  std::vector<SampleRay> rays;
  rays.reserve(block.ids.size());
  for (size_t i = 0; i < block.ids.size(); i++)
    rays.push_back({block.ids[i], block.points[i], filter.direction});
  return rays;
}

std::shared_ptr<const RaySource> raySource(const RaySampler& filter, const FilterRun& run,
                                           const RayPlan& plan) {
  const int sources =
      (filter.lines > 0) + !filter.rays.empty() + !filter.points.empty() + filter.camera.has_value();
  if (sources != 1)
    throw Error("RaySampler: there are " + std::to_string(sources) +
                " sources of rays, expected one of `lines`, `rays`, `points` and `camera`");
  const int rank = run.ranks.rank(), ranks = run.ranks.size();
  if (filter.lines > 0)
    return std::make_shared<UniformLines>(plan.firstBox, uint64_t(filter.seed), 0, uint64_t(filter.lines),
                                          rank, ranks);
  if (filter.camera) return std::make_shared<MappedRays>(cameraRays(*filter.camera, plan.box, rank, ranks));
  if (!filter.points.empty()) return std::make_shared<GivenRays>(raysFrom(filter, run), plan.box);
  return std::make_shared<GivenRays>(rank == 0 ? filter.rays : std::vector<SampleRay>(), plan.box);
}

uint64_t raysBegun(const RaySource& source) {
  uint64_t n = 0;
  for (size_t k = 0; k < source.chunks(); k++) n += uint64_t(source.raysOf(k));
  return n;
}

}  // namespace

FilterInfo RaySampler::info() {
  return {
      "RaySampler",
      1,
      "Points where rays meet isosurfaces, planes or triangles.",
      {{"data", kVolumes | kTriangles | kParticles,
        "What operators, conditions, `values` and `points` call by this name.", FilterPort::Count::AnyName}},
      DatasetType::Particles};
}

FilterResult RaySampler::run(FilterRun& run) const {
  Sampler& sampler = run.sampler();
  std::optional<RayPlan> plan;
  std::shared_ptr<const RaySource> rays;
  agree(run.ranks, [&] {
    plan.emplace(*this, run);
    rays = raySource(*this, run, *plan);
  });
  const EnterMemory enter = [&run](const char* purpose, int64_t bytes) {
    return run.takeMemory(purpose, bytes);
  };
  int64_t items = 1;  // of progress: what SceneBuilder does, and rays
  const auto sampling = sampler.prepare(std::move(plan->source), run.ranks, enter,
                                        [&](int64_t item, int64_t of, const std::string& text) {
                                          items = of + 1;
                                          run.begin(item, items, text);
                                        });
  run.begin(items - 1, items, "sending rays");
  TakenSamples samples = sampler.sample(sampling, rays, run.ranks, enter);
  FilterResult result;
  result.dataset = sampledPoints(run, "ray points", std::move(samples), UINT64_MAX, plan->partitioning(),
                                 plan->recorded, gradient);
  result.told = {{"particles", result.dataset->geometry->primitives},
                 {"rays", sumOfCounts(run.ranks, raysBegun(*rays))}};
  if (const auto fields = toldOfPoints(*result.dataset->geometry); !fields.empty())
    result.told["fields"] = fields;
  return result;
}

}  // namespace gxy
