// SPDX-License-Identifier: Apache-2.0
// Samplings on ranks that are threads of the test.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "core/analysis/sample_order.h"
#include "core/analysis/sampler.h"
#include "core/comm/error.h"
#include "core/comm/in_process.h"
#include "tests/support/backends.h"
#include "tests/support/data_sets.h"
#include "tests/support/partitionings.h"
#include "tests/support/thread_ranks.h"

namespace gxy::test {

inline Box unitCube() { return {glm::dvec3(0), glm::dvec3(1)}; }

/// A grid of `points` points a side on the unit cube.
inline Grid unitGrid(int64_t points) {
  return {glm::dvec3(0), glm::dvec3(1.0 / double(points - 1)), {points, points, points}};
}

/// The squared distance from the middle of the unit cube: its isosurfaces are spheres up to the grid's resolution.
inline double squaredDistance(glm::dvec3 p) {
  const glm::dvec3 q = p - 0.5;
  return q.x * q.x + q.y * q.y + q.z * q.z;
}

/// Whole volumes and what is sampled in them.
struct SamplingCase {
  std::vector<WholeVolume> volumes;
  std::vector<Vis> operators;
  std::vector<size_t> shown;  ///< by operator: its volume; not looked at for geometry
  std::map<size_t, std::shared_ptr<const WholeGeometry>>
      geometry;                                ///< by operator of another type than VisType::Volume
  std::vector<std::pair<size_t, int>> fields;  ///< volume and component
  int recorded = 0;
  bool gradient = false, met = false;
  std::vector<HitRule> rules;
};

/// One isosurface of one volume, of which all hits are taken.
inline SamplingCase isosurfaceOf(WholeVolume whole, double isovalue) {
  SamplingCase c;
  c.volumes.push_back(std::move(whole));
  Vis vis;
  vis.isovalues = {isovalue};
  c.operators = {vis};
  c.shown = {0};
  c.rules = {{{}, kMostHits}};
  return c;
}

inline LedgerEntry freeMemory(const char*, int64_t) { return {}; }

/// A Sampler on every rank of a world with threads.
class SamplingRanks {
 public:
  struct Run {
    uint64_t seed = 1;
    int workers = 2;
    Sampler::Options options{};
    const Backend* backend = nullptr;  ///< null: Embree
    EnterMemory enter = freeMemory;
  };
  SamplingRanks(const Cut& cut, const Run& run)
      : cut_(cut), enter_(run.enter), world_(cut.ranks, run.seed, {true, run.workers, {}}) {
    for (int r = 0; r < cut.ranks; r++)
      samplers_.push_back(
          std::make_unique<Sampler>(world_.rank(r), run.backend ? *run.backend : embree(), run.options));
  }

  Sampler& sampler(int rank) { return *samplers_[size_t(rank)]; }
  const Cut& cut() const { return cut_; }

  /// What is sampled, on one rank.
  static SamplingSource sourceOf(
      const SamplingCase& c, const std::vector<std::vector<std::shared_ptr<const Volume>>>& parts,
      const std::map<size_t, std::vector<std::shared_ptr<const Geometry>>>& geometry,
      std::shared_ptr<const Partitioning> partitioning, int rank) {
    SamplingSource s;
    s.scene.visualization.operators = c.operators;
    s.scene.partitioning = std::move(partitioning);
    for (size_t i = 0; i < c.shown.size(); i++) {
      OperatorSource& source = s.scene.data.emplace_back();
      const auto found = geometry.find(i);
      if (found == geometry.end())
        source.data.volume = parts[c.shown[i]][size_t(rank)];
      else
        source.data.geometry = found->second[size_t(rank)];
    }
    for (const auto& [v, component] : c.fields) s.fields.push_back({parts[v][size_t(rank)], component});
    s.recorded = c.recorded;
    s.gradient = c.gradient;
    s.met = c.met;
    s.rules = c.rules;
    return s;
  }

  /// Runs work(rank, sampler, sampling, ranks) on all ranks; returns their errors.
  template <class Work>
  std::vector<std::string> run(const SamplingCase& c, Work work) {
    const auto partitioning = std::make_shared<const Partitioning>(cut_.partitioning);
    std::vector<std::vector<std::shared_ptr<const Volume>>> parts;
    for (const WholeVolume& whole : c.volumes) parts.push_back(test::cut(whole, *partitioning, cut_.ranks));
    std::map<size_t, std::vector<std::shared_ptr<const Geometry>>> geometry;
    for (const auto& [i, g] : c.geometry) {
      const bool flat = g->kind == GeometryKind::Triangles;
      geometry[i] = distributed(
          *g, *partitioning,
          [&, index = i](double value) { return flat ? 0 : radiusOf(c.operators[index], value); },
          cut_.ranks);
    }
    return ThreadRanks(cut_.ranks).run([&](Collectives& ranks) {
      Sampler& mine = sampler(ranks.rank());
      const auto sampling =
          mine.prepare(sourceOf(c, parts, geometry, partitioning, ranks.rank()), ranks, enter_);
      work(ranks.rank(), mine, sampling, ranks);
    });
  }

  /// Samples with `lines` uniform lines. Returns the samples of all ranks in their order.
  SampleList lines(const SamplingCase& c, uint64_t seed, uint64_t lines) {
    return all(c, [&](int rank) -> std::shared_ptr<const RaySource> {
      const Box box = c.volumes.front().grid.box();
      return std::make_shared<UniformLines>(box, seed, 0, lines, rank, cut_.ranks);
    });
  }

  SampleList all(const SamplingCase& c,
                 const std::function<std::shared_ptr<const RaySource>(int)>& sourceOfRank) {
    std::vector<SampleList> lists(static_cast<size_t>(cut_.ranks));
    for (const std::string& error : run(c, [&](int rank, Sampler&sampler, auto sampling, Collectives&ranks) {
           lists[size_t(rank)] = sampler.sample(sampling, sourceOfRank(rank), ranks).list;
         }))
      if (!error.empty()) throw Error(error);
    SampleList merged;
    for (SampleList& list : lists) merged.append(std::move(list));
    sort(merged);
    return merged;
  }

  static void sort(SampleList& list) {
    std::vector<uint32_t> order(list.size());
    for (size_t i = 0; i < order.size(); i++) order[i] = uint32_t(i);
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
      return SampleKey{list.ray[a], list.depth[a], list.hit[a]} <
             SampleKey{list.ray[b], list.depth[b], list.hit[b]};
    });
    list.select(order);
  }

 private:
  const Cut cut_;
  const EnterMemory enter_;
  InProcessWorld world_;
  std::vector<std::unique_ptr<Sampler>> samplers_;
};

/// 1024 rays with 1250 places each are one packet, whose samples are 70 MiB. They are entered in the ledger as they are recorded:
/// all of them before the packet ends, and none after a step was refused.
inline void expectSamplesEnteredWhileTheyAreRecorded(const Backend& backend) {
  SamplingCase c = isosurfaceOf(sampled(unitGrid(5), squaredDistance), 0);
  c.operators[0].isovalues = {};
  c.operators[0].every = 8e-4;
  const auto sent = [&](int most) {
    std::atomic<int> entered = 0;
    SamplingRanks::Run run;
    run.backend = &backend;
    run.enter = [&](const char* purpose, int64_t) -> LedgerEntry {
      if (std::string(purpose) == "samples" && ++entered > most) throw Error("no room");
      return {};
    };
    SamplingRanks ranks(whole(unitCube()), run);
    SampleList samples;
    std::string error;
    try {
      samples = ranks.all(c, [](int) {
        std::vector<SampleRay> rays;
        for (uint64_t i = 0; i < 1024; i++)
          rays.push_back({i, {-1, 0.5, 0.01 + 9e-4 * double(i)}, {1, 0, 0}});
        return std::make_shared<GivenRays>(std::move(rays), unitCube());
      });
    } catch (const Error& e) {
      error = e.what();
    }
    return std::tuple(samples.size(), int(entered), ranks.sampler(0).traced().raysTraced, error);
  };
  const auto [size, steps, traced, none] = sent(1000);
  EXPECT_EQ(none, "");
  EXPECT_GT(size, 1024u * 1248u);
  EXPECT_EQ(steps, int((int64_t(size) * SampleList::bytesPerSample(0, false) + (1 << 20) - 1) >> 20));
  const auto [kept, refusedAt, begun, error] = sent(3);
  EXPECT_EQ(kept, 0u);
  EXPECT_EQ(refusedAt, 4);
  EXPECT_NE(error.find("no room"), std::string::npos) << error;
  EXPECT_LT(begun, traced / 10);
}

}  // namespace gxy::test
