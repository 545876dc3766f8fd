// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/evaluate.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/analysis/evaluation.h"
#include "core/analysis/field_passes.h"
#include "core/analysis/field_tiles.h"
#include "core/analysis/statistics.h"
#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/data/bricks.h"
#include "core/data/complete_volume.h"
#include "core/data/extent_pieces.h"
#include "core/data/ghosts.h"

namespace gxy {
namespace {

/// Copies to the points of a block's rim that are owned what the nearest point with data of its own has.
void fillRim(VolumeBlock& block, const Extent& owned, const DataPoints& data, size_t bytesPerPoint) {
  const Bricks bricks(block.extent.points);
  const auto placeOf = [&](int64_t x, int64_t y, int64_t z) {
    return block.samples.data() +
           bricks(x - block.extent.first[0], y - block.extent.first[1], z - block.extent.first[2]) *
               bytesPerPoint;
  };
  for (int64_t z = owned.first[2]; z < owned.first[2] + owned.points[2]; ++z)
    for (int64_t y = owned.first[1]; y < owned.first[1] + owned.points[1]; ++y) {
      const bool all = !data.contain(1, y) || !data.contain(2, z);
      for (int64_t x = owned.first[0]; x < owned.first[0] + owned.points[0]; ++x) {
        if (!all && data.contain(0, x)) {
          x = std::max(x, std::min(data.last[0], owned.first[0] + owned.points[0] - 1));
          continue;
        }
        const std::byte* from = placeOf(data.nearest(0, x), data.nearest(1, y), data.nearest(2, z));
        std::copy_n(from, bytesPerPoint, placeOf(x, y, z));
      }
    }
}

/// The computation of one expression of fields on a grid on this rank.
class GridEvaluation final : public Evaluation {
 public:
  GridEvaluation(const Expression& expression, std::span<const FieldInput> inputs, Collectives& ranks,
                 const DeriveOptions& options)
      : Evaluation(expression, ranks, options), inputs_(inputs) {
    agree(ranks_, [&] { prepare(); });
  }

  DerivedField derived() {
    DerivedField made;
    made.type = type();
    FieldResults results;
    made.volume = std::make_shared<Volume>(samplesOf(root(), true, results));
    made.volume->name = options_.name;
    // Tiles tell them of floats, and not of a rim.
    if (needsStatistics(*made.volume, partitioning()) &&
        (grid().rim || made.volume->stored != ScalarType::Float32))
      agree(ranks_, [&] { results.statistics = statisticsOfOwned(*made.volume); });
    made.noData = int64_t(sumOfCounts(ranks_, uint64_t(results.noData)));
    if (!needsStatistics(*made.volume, partitioning())) results.statistics = {};
    completeBricks(*made.volume, partitioning(), ranks_, std::move(results.statistics),
                   made.volume->components);
    return made;
  }

  /// Returns a field of operation `node`. Owned points are set; with `ghosts`, all are.
  Volume samplesOf(size_t node, bool ghosts, FieldResults& results) {
    std::vector<FieldPass> passes;
    agree(ranks_, [&] { passes = passesOf(graphAt(node), int(inputs_.size()), kGhostLayers); });
    const bool logical = types_[node].kind == ValueType::Kind::Logical;
    std::vector<const Volume*> fields;
    for (const FieldInput& input : inputs_) fields.push_back(input.volume.get());
    std::vector<Volume> stored(passes.size());
    for (size_t i = 0; i < passes.size(); ++i) {
      const bool last = i + 1 == passes.size();
      const ScalarType type = !last ? ScalarType::Float64 : logical ? ScalarType::UInt8 : ScalarType::Float32;
      const double first = double(i) / double(passes.size()), end = double(i + 1) / double(passes.size());
      agree(ranks_, [&] {
        stored[i] = emptyVolume(type, int(passes[i].stages.back().results.size()));
        results = FieldTiles(passes[i], fields, stored[i], computed_, owned_, memory_)
                      .run(advanceOf(ranks_, first, end));
        finish(stored[i]);
      });
      if (!last || ghosts) exchange(stored[i]);
      fields.push_back(&stored[i]);
      for (size_t s = 0; s < i; ++s) dropUnused(stored[s], int32_t(inputs_.size() + s), passes, i);
    }
    return std::move(stored.back());
  }

 private:
  const Grid& grid() const { return inputs_[0].volume->grid; }
  const Partitioning& partitioning() const { return *inputs_[0].partitioning; }

  void prepare() {
    if (inputs_.empty()) throw Error("expression: there are no inputs, expected at least one field");
    std::vector<ExpressionInput> typed;
    for (const FieldInput& input : inputs_) {
      const std::string both = inQuotes(inputs_[0].name, '`') + " and " + inQuotes(input.name, '`');
      if (input.volume->grid != grid())
        throw Error("expression: " + both +
                    " have different grids, expected one grid; Resample puts a field on another's grid");
      if (input.partitioning != inputs_[0].partitioning && *input.partitioning != partitioning())
        throw Error("expression: " + both +
                    " are cut into different partitions, expected the same ones; import " +
                    inQuotes(input.name, '`') + " like " + inQuotes(inputs_[0].name, '`'));
      checkBlocks(input);
      typed.push_back({input.name, input.volume->components});
    }
    setInputs(std::move(typed));
    const DataPoints data(grid());
    for (const auto& entry : inputs_[0].volume->blocks) {
      const Extent owned = ownedPoints(grid(), partitioning(), entry.first);
      owned_[entry.first] = owned;
      if (owned.count() == 0) continue;
      Extent& computed = computed_[entry.first];
      for (int a = 0; a < 3; ++a) {
        const auto i = size_t(a);
        computed.first[i] = data.nearest(a, owned.first[i]);
        computed.points[i] = data.nearest(a, owned.first[i] + owned.points[i] - 1) - computed.first[i] + 1;
      }
    }
    plan_.emplace(grid(), partitioning(), kGhostLayers, ranks_.rank(), ranks_.size());
  }

  void checkBlocks(const FieldInput& input) const {
    for (const int partition : partitioning().owned(ranks_.rank())) {
      const Extent extent = extentOf(grid(), partitioning().box(partition), kGhostLayers);
      const auto block = input.volume->blocks.find(partition);
      const bool there = block != input.volume->blocks.end();
      if (there ? block->second.extent != extent : extent.count() > 0)
        throw Error("expression: " + inQuotes(input.name, '`') + ", partition " + std::to_string(partition) +
                    ": there is no block with " + std::to_string(kGhostLayers) + " ghost layers");
    }
  }

  Statistics statisticsOfInput(const std::string& name, const StatisticsOptions& wanted) override {
    const auto input = std::ranges::find(inputs_, name, &FieldInput::name);
    return fieldStatistics(*input->volume, partitioning(), ranks_, wanted);
  }

  Statistics statisticsOfNode(size_t node, const StatisticsOptions& wanted) override {
    FieldResults ignored;
    const Volume samples = samplesOf(node, false, ignored);
    const Statistics found = fieldStatistics(samples, partitioning(), ranks_, wanted);
    memory_(-bytesOf(samples));
    return found;
  }

  Volume emptyVolume(ScalarType type, int components) const {
    Volume volume;
    volume.grid = grid();
    volume.stored = type;
    volume.components = components;
    for (const auto& entry : inputs_[0].volume->blocks) {
      VolumeBlock& block = volume.blocks[entry.first];
      block.extent = entry.second.extent;
      const size_t bytes = Bricks(block.extent.points).count() * bytesOf(type) * size_t(components);
      memory_(int64_t(bytes));
      block.samples.resize(bytes);
    }
    return volume;
  }

  /// Sets what the tiles leave out: the padding, and the rim.
  void finish(Volume& volume) const {
    const size_t bytes = bytesOf(volume.stored) * size_t(volume.components);
    for (auto& [partition, block] : volume.blocks) {
      clearPadding(block.samples, block.extent.points, bytes);
      if (grid().rim) fillRim(block, owned_.at(partition), DataPoints(grid()), bytes);
    }
  }

  void exchange(Volume& volume) {
    Volume* const one = &volume;
    exchangeGhosts(std::span(&one, 1), *plan_, ranks_);
  }

  /// Gives a stored field back when no pass after `done` loads it.
  void dropUnused(Volume& field, int32_t source, std::span<const FieldPass> passes, size_t done) const {
    for (size_t i = done + 1; i < passes.size(); ++i)
      if (std::ranges::find(passes[i].sources, source) != passes[i].sources.end()) return;
    const int64_t bytes = bytesOf(field);
    field.blocks.clear();
    if (bytes > 0) memory_(-bytes);
  }

  FieldStatistics statisticsOfOwned(const Volume& volume) const {
    FieldStatistics statistics;
    Samples samples;
    const size_t bytes = bytesOf(volume.stored) * size_t(volume.components);
    for (const auto& entry : volume.blocks)
      forPieces(owned_.at(entry.first), 1 << 20, [&](const Extent& piece) {
        ranks_.check();
        samples.resize(size_t(piece.count()) * bytes);
        copyFromBricks(entry.second.samples, entry.second.extent, piece, samples, bytes);
        statistics.merge(statisticsOf(samples, volume.stored, volume.components));
      });
    return statistics;
  }

  const std::span<const FieldInput> inputs_;
  std::map<int, Extent> owned_, computed_;  ///< by partition
  std::optional<GhostPlan> plan_;
};

}  // namespace

DerivedField derive(const Expression& expression, std::span<const FieldInput> inputs, Collectives& ranks,
                    const DeriveOptions& options) {
  GridEvaluation evaluation(expression, inputs, ranks, options);
  agree(ranks, [&] { evaluation.expectField(false); });
  evaluation.findNumbers();
  return evaluation.derived();
}

std::shared_ptr<Volume> conditionOf(const Expression& expression, std::span<const FieldInput> inputs,
                                    Collectives& ranks, const DeriveOptions& options) {
  GridEvaluation evaluation(expression, inputs, ranks, options);
  agree(ranks, [&] { evaluation.expectField(true); });
  evaluation.findNumbers();
  FieldResults ignored;
  return std::make_shared<Volume>(evaluation.samplesOf(evaluation.root(), false, ignored));
}

double numberOf(const Expression& expression, std::span<const FieldInput> inputs, Collectives& ranks,
                const DeriveOptions& options) {
  GridEvaluation evaluation(expression, inputs, ranks, options);
  double number = 0;
  agree(ranks, [&] { evaluation.expectNumber(); });
  evaluation.findNumbers();
  agree(ranks, [&] { number = evaluation.number(); });
  return number;
}

}  // namespace gxy
