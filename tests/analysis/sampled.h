// SPDX-License-Identifier: Apache-2.0
// Evaluates filters that send rays, on ranks that are threads of the test.
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/analysis/filter.h"
#include "tests/analysis/sampling.h"
#include "tests/support/meshes.h"

namespace gxy::test {

/// Particles by id, with their values, and what rank 0 has told.
struct SampledPoints {
  std::map<uint64_t, std::pair<glm::dvec3, float>> points;
  std::map<uint64_t, std::vector<float>> fields;  ///< all components of all further fields
  std::vector<std::string> names;                 ///< of the values and the fields
  nlohmann::json told;
  bool operator==(const SampledPoints&) const = default;
};

/// What else may be said of an evaluation.
struct Evaluation {
  SamplingRanks::Run run{};
  std::map<std::string, std::vector<const WholeVolume*>> inputs;
  std::map<std::string, WholeGeometry> geometry = {};   ///< inputs, too; ranks have its primitives in turn
  std::map<std::string, const WholeMesh*> meshes = {};  ///< inputs, too
  /// Replaces the ranks' check() and memory, by rank; null: nothing fails.
  std::function<void(int rank)> check = nullptr;
  std::function<LedgerEntry(int rank, const std::string& purpose)> memory = nullptr;
};

/// Ranks with another check().
class CheckedRanks final : public Collectives {
 public:
  CheckedRanks(Collectives& to, std::function<void(int)> check) : to_(to), check_(std::move(check)) {}
  int rank() const override { return to_.rank(); }
  int size() const override { return to_.size(); }
  std::vector<Bytes> allGather(Bytes mine) override { return to_.allGather(std::move(mine)); }
  std::vector<Bytes> allToAll(std::vector<Bytes> perRank) override {
    return to_.allToAll(std::move(perRank));
  }
  void check() const override {
    if (check_) check_(rank());
  }

 private:
  Collectives& to_;
  const std::function<void(int)> check_;
};

/// What a rank has of a geometry whose primitives ranks have in turn.
inline std::shared_ptr<const OwnedGeometry> ownedOf(const WholeGeometry& whole, int rank, int ranks) {
  auto owned = std::make_shared<OwnedGeometry>();
  owned->kind = whole.kind;
  std::vector<uint32_t> mine;
  for (size_t i = size_t(rank); i < whole.block.ids.size(); i += size_t(ranks)) mine.push_back(uint32_t(i));
  owned->block = subset(whole.block, whole.kind, mine);
  for (const glm::dvec3& p : whole.block.points) owned->box.extend(Box{p, p});
  owned->middle = owned->box;
  owned->primitives = whole.block.ids.size();
  return owned;
}

/// Evaluates a filter on all ranks of a cut. Returns the ranks' errors; `result` gets the particles. Throws Error if something of
/// the flights is left over.
template <class Filter>
std::vector<std::string> evaluateOn(const Cut& cut, const Evaluation& evaluation,
                                    const std::string& properties, SampledPoints& result) {
  const auto partitioning = std::make_shared<const Partitioning>(cut.partitioning);
  std::map<std::string, std::vector<std::vector<std::shared_ptr<const Volume>>>> parts;
  for (const auto& [name, list] : evaluation.inputs)
    for (const WholeVolume* whole : list) parts[name].push_back(test::cut(*whole, *partitioning, cut.ranks));
  SamplingRanks world(cut, evaluation.run);
  std::mutex mutex;
  const std::vector<std::string> errors = ThreadRanks(cut.ranks).run([&](Collectives& all) {
    const int rank = all.rank();
    CheckedRanks ranks(all, evaluation.check);
    FilterRun::Inputs inputs;
    for (const auto& [name, list] : parts)
      for (size_t i = 0; i < list.size(); i++) {
        const auto& ofRanks = list[i];
        auto dataset = std::make_shared<Dataset>();
        dataset->partitioning = partitioning;
        dataset->volume = ofRanks[size_t(rank)];
        inputs[name].push_back(
            {i == 0 ? name : name + " " + std::to_string(i + 1), {}, 1, std::move(dataset)});
      }
    for (const auto& [name, whole] : evaluation.geometry) {
      auto dataset = std::make_shared<Dataset>();
      dataset->partitioning = partitioning;
      dataset->geometry = ownedOf(whole, rank, cut.ranks);
      inputs[name].push_back({name, {}, 1, std::move(dataset)});
    }
    for (const auto& [name, whole] : evaluation.meshes) {
      auto dataset = std::make_shared<Dataset>();
      dataset->partitioning = partitioning;
      dataset->mesh = test::cut(*whole, *partitioning, cut.ranks)[size_t(rank)];
      inputs[name].push_back({name, {}, 1, std::move(dataset)});
    }
    FilterServices services;
    services.sampler = &world.sampler(rank);
    services.takeMemory = [&](const std::string& purpose, int64_t) {
      return evaluation.memory ? evaluation.memory(rank, purpose) : LedgerEntry();
    };
    FilterRun run(ranks, std::move(inputs), std::move(services));
    const FilterResult made = evaluate(*makeFilter<Filter>(), run, properties);
    const GeometryBlock& block = made.dataset->geometry->block;
    const std::lock_guard lock(mutex);
    if (rank == 0) {
      result.told = made.told;
      result.names = {made.dataset->geometry->array};
      for (const PointFieldInfo& f : made.dataset->geometry->fields) result.names.push_back(f.name);
    }
    for (size_t i = 0; i < block.ids.size(); i++)
      for (const PointField& f : block.fields)
        for (int c = 0; c < f.components; c++) result.fields[block.ids[i]].push_back(fieldValue(f, c, i));
    for (size_t i = 0; i < block.ids.size(); i++)
      if (!result.points
               .emplace(block.ids[i],
                        std::pair(block.points[i], block.values.empty() ? 0.0f : block.values[i]))
               .second)
        throw Error("two particles have one id");
  });
  for (int r = 0; r < cut.ranks; r++) {
    const FlightControl::Kept kept = world.sampler(r).kept();
    if (kept.flights || kept.parkedMessages || kept.announced || kept.completionSets || kept.tasks ||
        kept.credits)
      throw Error("something is left over on rank " + std::to_string(r));
  }
  return errors;
}

template <class Filter>
SampledPoints evaluateOn(const Cut& cut, const Evaluation& evaluation, const std::string& properties) {
  SampledPoints result;
  for (const std::string& error : evaluateOn<Filter>(cut, evaluation, properties, result))
    if (!error.empty()) throw Error(error);
  return result;
}

}  // namespace gxy::test
