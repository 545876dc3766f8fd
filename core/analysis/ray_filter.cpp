// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/ray_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "core/analysis/field_values.h"
#include "core/analysis/made_geometry.h"
#include "core/analysis/next_rays.h"
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
    throw Error("RaySampler: " + of + " is of " + inQuotes(source.name) +
                ", expected a volume on a uniform grid");
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
    recorded = sampledVolumes(values, "RaySampler", filter.gradient);
    source.fields = recorded.sampled;
    source.recorded = int(recorded.sampled.size());
    source.gradient = filter.gradient;
    for (const RaySampler::Target& target : filter.operators) add(target);
    source.met = following() > 0;
    source.scene.partitioning = partitioning_;
    source.priority.tenant = run.services().turn;
    source.account = run.services().tenant;
  }

  /// The most rays that follow a hit.
  int following() const { return filter_.depth > 0 ? mostChildren(next) : 0; }

  SamplingSource source;
  SampledVolumes recorded;
  std::vector<NextRule> next;  ///< by operator
  Box box;                     ///< of all that can be met
  Box firstBox;                ///< of the first operator's dataset
  std::shared_ptr<const Partitioning> partitioning() const { return partitioning_; }

 private:
  void take(const FilterSource& from) {
    if (!partitioning_) partitioning_ = from.data->partitioning;
    if ((from.data->volume || from.data->mesh) && !(*from.data->partitioning == *partitioning_))
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
    if (data.volume || data.mesh) {
      if (target.isovalues.empty() && target.planes.empty() && target.every == 0)
        throw Error("RaySampler: the operator of " + inQuotes(from.name) +
                    " has nothing to meet, expected `isovalues`, `planes` or `every`");
      vis.isovalues = target.isovalues;
      vis.every = target.every;
      vis.slices = target.planes;
      operand.data.volume = data.volume;
      operand.data.mesh = data.mesh;
    } else {
      if (data.geometry->kind != GeometryKind::Triangles)
        throw Error("RaySampler: an operator is of " + inQuotes(from.name) +
                    ", expected a volume or triangles");
      if (target.every > 0)
        throw Error("RaySampler: `every` is of " + inQuotes(from.name) + ", expected a volume");
      vis.type = VisType::Triangles;
      operand.geometry = GeometrySource{
          "sampled " + std::to_string(from.key.value) + " " + std::to_string(from.generation), data.geometry};
    }
    next.push_back(nextOf(target, from));
    // With rays that follow, a ray ends at its first hit, unless `hits` says another.
    const bool passes = target.next.goesOn || (target.every > 0 && next.back().way == NextRule::Way::Stop);
    HitRule rule{{}, target.hits.value_or(passes ? kMostHits : 1)};
    for (const RaySampler::Condition& c : target.conditions)
      rule.conditions.push_back({fieldOf(c.field, "a condition"), c.least, c.largest});
    if (source.rules.empty()) firstBox = data.box();
    box.extend(data.box());
    source.scene.visualization.operators.push_back(std::move(vis));
    source.scene.data.push_back(std::move(operand));
    source.rules.push_back(std::move(rule));
  }

  NextRule nextOf(const RaySampler::Target& target, const FilterSource& of) {
    using Way = NextRule::Way;
    const RaySampler::Next& asked = target.next;
    NextRule rule;
    rule.way = wayOf(asked);
    rule.n1 = asked.n1, rule.n2 = asked.n2;
    rule.direction = asked.direction;
    rule.rays = std::max(1, asked.spawn);
    rule.sphere = asked.sphere, rule.uniform = asked.uniform;
    if (rule.needsNormal() && target.every > 0)
      throw Error("RaySampler: what follows hits of " + inQuotes(of.name) +
                  " needs the normals of surfaces, expected no `every` there");
    const bool gradient = rule.way == Way::AlongGradient || rule.way == Way::AgainstGradient;
    if (!gradient && rule.way != Way::AlongField) return rule;
    const std::string what = gradient ? "a gradient" : "a vector field";
    const bool own = asked.field.empty();
    const FilterSource& from = rayVolume(run_, own ? target.dataset : asked.field, what);
    take(from);
    rule.field = {from.data->volume, own ? target.component.value_or(-1) : -1};
    if (!gradient && from.data->volume->components != 3)
      throw Error("RaySampler: rays are to follow " + inQuotes(from.name) + ", which has " +
                  std::to_string(from.data->volume->components) + " components, expected 3");
    return rule;
  }

  static NextRule::Way wayOf(const RaySampler::Next& next) {
    using Way = NextRule::Way;
    if (next.spawn > 0 || next.redirect == "random") return Way::Spawn;
    if (next.redirect == "gradient") return Way::AlongGradient;
    if (next.redirect == "against gradient") return Way::AgainstGradient;
    if (next.redirect == "field") return Way::AlongField;
    if (next.redirect == "mirror") return Way::Mirror;
    if (next.redirect == "refract") return Way::Refract;
    return next.redirect == "direction" ? Way::Fixed : Way::Stop;
  }

  const RaySampler& filter_;
  const FilterRun& run_;
  std::shared_ptr<const Partitioning> partitioning_;
};

const GeometryBlock& pointsOf(const RaySampler& filter, const FilterRun& run) {
  const FilterSource& from = rayInput(run, filter.points, "`points`");
  if (!from.data->geometry || from.data->geometry->kind != GeometryKind::Particles)
    throw Error("RaySampler: `points` is " + inQuotes(from.name) + ", expected particles");
  return from.data->geometry->block;
}

// Collective. The directions of the rays from this rank's points; 0 where the field has no data.
std::vector<glm::dvec3> directionsOf(const RaySampler& filter, FilterRun& run) {
  const FilterSource* field = nullptr;
  const GeometryBlock* block = nullptr;
  std::vector<glm::dvec3> directions;
  if (filter.points.empty()) return directions;
  agree(run.ranks, [&] {
    block = &pointsOf(filter, run);
    directions.assign(block->points.size(), filter.direction);
    if (filter.directionField.empty()) return;
    field = &rayVolume(run, filter.directionField, "`direction`");
    if (field->data->volume->components != 3)
      throw Error("RaySampler: `direction` is " + inQuotes(field->name) + ", which has " +
                  std::to_string(field->data->volume->components) + " components, expected 3");
  });
  if (!field) return directions;
  const FieldValues found = ValueReader(run, *field).at(std::array{0, 1, 2}, block->points, run.ranks);
  for (size_t i = 0; i < directions.size(); i++) {
    const float* v = &found.values[3 * i];
    const glm::dvec3 d(v[0], v[1], v[2]);
    directions[i] = std::isfinite(d.x + d.y + d.z) ? d : glm::dvec3(0);
  }
  return directions;
}

// The rays from this rank's points that have a direction.
std::vector<SampleRay> raysFrom(const RaySampler& filter, const FilterRun& run,
                                const std::vector<glm::dvec3>& directions) {
  const GeometryBlock& block = pointsOf(filter, run);
  std::vector<SampleRay> rays;
  rays.reserve(block.ids.size());
  for (size_t i = 0; i < block.ids.size(); i++)
    if (directions[i] != glm::dvec3(0)) rays.push_back({block.ids[i], block.points[i], directions[i]});
  return rays;
}

std::shared_ptr<const RaySource> raySource(const RaySampler& filter, const FilterRun& run,
                                           const RayPlan& plan, const std::vector<glm::dvec3>& directions) {
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
  if (!filter.points.empty()) return std::make_shared<GivenRays>(raysFrom(filter, run, directions), plan.box);
  return std::make_shared<GivenRays>(rank == 0 ? filter.rays : std::vector<SampleRay>(), plan.box);
}

uint64_t raysBegun(const RaySource& source) {
  uint64_t n = 0;
  for (size_t k = 0; k < source.chunks(); k++) n += uint64_t(source.raysOf(k));
  return n;
}

// All numbers of rays that this rank begins are below this.
uint64_t numbersOf(const RaySampler& filter, const FilterRun& run) {
  if (filter.lines > 0) return uint64_t(filter.lines);
  if (filter.camera) return uint64_t(filter.camera->dimensions.x) * uint64_t(filter.camera->dimensions.y);
  if (filter.points.empty()) return filter.rays.size();
  uint64_t largest = 0;
  for (const uint64_t id : pointsOf(filter, run).ids) largest = std::max(largest, id);
  return largest == UINT64_MAX ? largest : largest + 1;
}

/// Samples, and how many rays have followed others.
struct Generations {
  TakenSamples samples;
  uint64_t following = 0;
};

// Collective. Sends rays, and those that follow them.
Generations sendAll(FilterRun& run, const RaySampler& filter, const RayPlan& plan,
                    const std::shared_ptr<const Sampling>& sampling, std::shared_ptr<const RaySource> rays) {
  Generations all;
  LedgerEntry memory;  // of `rays`
  for (int generation = 0;; generation++) {
    TakenSamples samples = run.sampler().sample(sampling, rays, run.ranks);
    std::shared_ptr<const NextRays> next;
    if (generation < filter.depth && plan.following() > 0)
      agree(run.ranks, [&] {
        LedgerEntry room = run.takeMemory("sampling rays", NextRays::mostBytes(samples.list.size()));
        next = std::make_shared<const NextRays>(*sampling->compiled, samples.list, plan.next,
                                                uint32_t(filter.seed), [&] { run.ranks.check(); });
        memory = std::move(room);
      });
    samples.list.met = {};
    all.samples.append(std::move(samples));
    const uint64_t following = next ? sumOfCounts(run.ranks, next->size()) : 0;
    if (following == 0) return all;
    all.following += following;
    rays = std::move(next);
  }
}

}  // namespace

FilterInfo RaySampler::info() {
  return {"RaySampler",
          1,
          "Points where rays meet isosurfaces, planes or triangles, or at equal distances along rays. Other "
          "rays may begin there.",
          {{"data", kVolumes | kUnstructured | kTriangles | kParticles,
            "What operators, conditions, `values`, `points` and `direction` call by this name.",
            FilterPort::Count::AnyName}},
          DatasetType::Particles};
}

FilterResult RaySampler::run(FilterRun& run) const {
  Sampler& sampler = run.sampler();
  std::optional<RayPlan> plan;
  std::shared_ptr<const RaySource> rays;
  uint64_t numbers = 0;
  agree(run.ranks, [&] {
    plan.emplace(*this, run);
    if (!directionField.empty() && points.empty())
      throw Error("RaySampler: `direction` is " + inQuotes(directionField) +
                  ", a field, but no rays begin at `points`");
  });
  const std::vector<glm::dvec3> directions = directionsOf(*this, run);
  agree(run.ranks, [&] {
    rays = raySource(*this, run, *plan, directions);
    numbers = numbersOf(*this, run);
  });
  const uint64_t begun = sumOfCounts(run.ranks, raysBegun(*rays));
  const std::vector<uint64_t> allNumbers = gatherCounts(run.ranks, numbers);
  if (plan->following() > 0)
    checkedFollowingRays(begun, *std::max_element(allNumbers.begin(), allNumbers.end()), plan->following(),
                         depth);
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
  Generations all = sendAll(run, *this, *plan, sampling, std::move(rays));
  FilterResult result;
  result.dataset = sampledPoints(run, "ray points", std::move(all.samples), UINT64_MAX, plan->partitioning(),
                                 plan->recorded, gradient);
  result.told = {{"particles", result.dataset->geometry->primitives}, {"rays", begun}};
  if (plan->following() > 0) result.told["following rays"] = all.following;
  if (const auto fields = toldOfPoints(*result.dataset->geometry); !fields.empty())
    result.told["fields"] = fields;
  return result;
}

}  // namespace gxy
