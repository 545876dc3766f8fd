// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/isosurface_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/analysis/made_geometry.h"
#include "core/analysis/sampled_points.h"
#include "core/comm/error.h"

namespace gxy {

namespace {

constexpr int kMostSampled = 1 << 30;
constexpr size_t kAreaGroups = 256;  // of lines, whose numbers of hits tell the error of the area
constexpr uint64_t kLinesOfRound = 4 * kAreaGroups;  // rounds have multiples of so many lines
constexpr int64_t kSamplingItems = 3;                // of progress: what SceneBuilder does, and rays

double surfaceOf(const Box& box) {
  const glm::dvec3 s = box.hi - box.lo;
  return 2 * (s.x * s.y + s.y * s.z + s.z * s.x);
}

// Which hits there were, on all ranks. Groups of lines are independent of each other, hits of one line are not.
class HitCensus {
 public:
  // Collective.
  void add(const SampleList& samples, uint64_t lines, Collectives& ranks) {
    std::array<uint64_t, kAreaGroups> mine{};
    for (const uint64_t line : samples.ray) mine[line % kAreaGroups]++;
    for (const auto& theirs : gatherValues<uint64_t>(ranks, mine))
      for (size_t g = 0; g < kAreaGroups; g++) hits_[g] += theirs[g];
    lines_ += lines;
  }

  uint64_t hits() const { return std::accumulate(hits_.begin(), hits_.end(), uint64_t(0)); }
  uint64_t lines() const { return lines_; }
  double perLine() const { return lines_ ? double(hits()) / double(lines_) : 0; }
  // The standard error of perLine().
  double error() const {
    if (!lines_) return 0;
    const double mean = double(hits()) / double(kAreaGroups);
    double squares = 0;
    for (const uint64_t n : hits_) squares += (double(n) - mean) * (double(n) - mean);
    return std::sqrt(squares / double(kAreaGroups - 1) * double(kAreaGroups)) / double(lines_);
  }

 private:
  std::array<uint64_t, kAreaGroups> hits_{};
  uint64_t lines_ = 0;
};

// The number of lines of the next round, where `count` hits are wanted of at most `most` lines; 0: there is none.
uint64_t nextRound(const HitCensus& census, uint64_t count, uint64_t most) {
  if (census.hits() >= count || census.lines() >= most) return 0;
  double lines = double(count) / 16;
  if (census.hits() > 0)
    lines = 1.05 * double(count - census.hits()) / census.perLine();
  else if (census.lines() > 0)
    lines = 8 * double(census.lines());
  // Few hits do not tell much of the rate.
  lines = std::min(lines, std::max(double(count) / 16, 16 * double(census.lines())));
  const uint64_t left = (most - census.lines() + kLinesOfRound - 1) / kLinesOfRound * kLinesOfRound;
  return std::min((uint64_t(lines) / kLinesOfRound + 1) * kLinesOfRound, left);
}

std::span<const FilterSource> isosurfaceValues(const FilterRun& run) {
  const auto found = run.inputs().find("values");
  return found == run.inputs().end() ? std::span<const FilterSource>() : found->second;
}

SamplingSource isosurfaceSource(const IsosurfaceSampler& filter, FilterRun& run,
                                const SampledVolumes& recorded) {
  const FilterSource& field = run.input("field");
  SamplingSource source;
  Vis vis;
  vis.dataset = field.name;
  vis.component = filter.component;
  vis.isovalues = {filter.isovalue};
  source.scene.visualization.operators = {vis};
  source.scene.partitioning = field.data->partitioning;
  OperatorData& shown = source.scene.data.emplace_back().data;
  shown.volume = field.data->volume;
  shown.mesh = field.data->mesh;
  source.rules = {{{}, kMostHits}};
  source.priority.tenant = run.services().turn;
  source.account = run.services().tenant;
  source.fields = recorded.sampled;
  source.recorded = int(recorded.sampled.size());
  source.gradient = filter.gradient;
  return source;
}

void checkIsosurface(const IsosurfaceSampler& filter, FilterRun& run) {
  const FilterSource& field = run.input("field");
  if (filter.component && *filter.component >= field.data->components())
    throw Error("IsosurfaceSampler: `component` is " + std::to_string(*filter.component) + ", but " +
                inQuotes(field.name) + " has " + std::to_string(field.data->components()) +
                " (counted from 0)");
  if (filter.gradient && field.data->mesh)
    throw Error("IsosurfaceSampler: `gradient` is of " + inQuotes(field.name) +
                ", an unstructured volume, expected one on a uniform grid");
  for (const FilterSource& values : isosurfaceValues(run))
    if (!(*values.data->partitioning == *field.data->partitioning))
      throw Error("IsosurfaceSampler: " + inQuotes(values.name) + " and " + inQuotes(field.name) +
                  " are cut differently, expected volumes on the same partitions");
}

}  // namespace

FilterInfo IsosurfaceSampler::info() {
  return {"IsosurfaceSampler",
          1,
          "Points on an isosurface, uniformly distributed by area. It also tells the area.",
          {{"field", kVolumes | kUnstructured, "The volume that the isosurface is of."},
           {"values", kVolumes, "The volumes whose values the points get. What is shown is the first.",
            FilterPort::Count::Any}},
          DatasetType::Particles};
}

std::vector<KeyRow<IsosurfaceSampler>> IsosurfaceSampler::properties() {
  return {
      numberKey("isovalue", &IsosurfaceSampler::isovalue, kAny, "The value on the isosurface.").require(),
      customKey<IsosurfaceSampler>(
          "component", "integer >= 0", "The component of the field, counted from 0.",
          [](const Found& found, IsosurfaceSampler& s) {
            s.component = found.integer({0, 1 << 20});
          },
          [](const IsosurfaceSampler& s) { return s.component ? OrderedJson(*s.component) : OrderedJson(); })
          .byDefault("the magnitude, if there are several"),
      flagKey(
          "gradient", &IsosurfaceSampler::gradient,
          "Whether points get the gradient of `field`, per unit of the world, as their field `gradient`. Not "
          "of unstructured volumes."),
      integerKey("count", &IsosurfaceSampler::count, {1, kMostSampled}, "The number of points."),
      integerKey("seed", &IsosurfaceSampler::seed, {0, 2147483647},
                 "Chooses the random numbers. The same seed gives the same points."),
  };
}

FilterResult IsosurfaceSampler::run(FilterRun& run) const {
  Sampler& sampler = run.sampler();
  Collectives& ranks = run.ranks;
  SampledVolumes recorded;
  agree(ranks, [&] {
    checkIsosurface(*this, run);
    recorded = sampledVolumes(isosurfaceValues(run), "IsosurfaceSampler", gradient);
  });
  const EnterMemory enter = [&run](const char* purpose, int64_t bytes) {
    return run.takeMemory(purpose, bytes);
  };
  const auto sampling = sampler.prepare(
      isosurfaceSource(*this, run, recorded), ranks, enter,
      [&run](int64_t item, int64_t, const std::string& text) { run.begin(item, kSamplingItems, text); });
  run.begin(kSamplingItems - 1, kSamplingItems, "sampling the isosurface");
  const Box box = run.input("field").data->box();
  const auto& visible = sampling->scene.compiled->visible;
  // Lines that can meet nothing need not be sent.
  const bool empty = std::all_of(visible.begin(), visible.end(), [](uint8_t v) { return v == 0; });
  const uint64_t most = empty ? 0 : 1000 * uint64_t(count) + 1'000'000;
  TakenSamples samples;
  HitCensus census;
  while (const uint64_t lines = nextRound(census, uint64_t(count), most)) {
    const auto source = std::make_shared<UniformLines>(box, uint64_t(seed), census.lines(),
                                                       census.lines() + lines, ranks.rank(), ranks.size());
    TakenSamples more = sampler.sample(sampling, source, ranks);
    census.add(more.list, lines, ranks);
    agree(ranks, [&] { samples.append(std::move(more)); });
  }
  FilterResult result;
  result.dataset = sampledPoints(run, "isosurface points", std::move(samples), uint64_t(count),
                                 run.input("field").data->partitioning, recorded, gradient);
  const uint64_t made = result.dataset->geometry->primitives;
  const double half = surfaceOf(box) / 2;
  result.told = {{"particles", made},
                 {"area", half * census.perLine()},
                 {"area error", half * census.error()},
                 {"lines", census.lines()}};
  if (const auto fields = toldOfPoints(*result.dataset->geometry); !fields.empty())
    result.told["fields"] = fields;
  if (made < uint64_t(count)) result.told.update({{"found", made}, {"count", count}});
  return result;
}

}  // namespace gxy
