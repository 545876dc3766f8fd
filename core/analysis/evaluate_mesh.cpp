// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/evaluate_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/analysis/evaluation.h"
#include "core/analysis/field_passes.h"
#include "core/analysis/field_tiles.h"
#include "core/analysis/value_rows.h"
#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/comm/parallel_for.h"
#include "core/data/mesh_blocks.h"
#include "core/data/point_averages.h"
#include "point_rows_ispc.h"

namespace gxy {
namespace {

constexpr size_t kMeshRow = 512;

bool areOnOneMesh(const Mesh& a, const Mesh& b) {
  if (a.ofCells != b.ofCells || a.blocks.size() != b.blocks.size()) return false;
  return std::equal(a.blocks.begin(), a.blocks.end(), b.blocks.begin(),
                    [](const auto& one, const auto& other) {
                      return one.first == other.first && one.second.points == other.second.points &&
                             one.second.cells.points == other.second.cells.points;
                    });
}

const std::vector<float>& valuesOf(const Mesh& mesh, const MeshBlock& block) {
  return mesh.ofCells ? block.cellValues : block.values;
}

/// A row of points or cells of one block at a time.
class MeshRow {
 public:
  MeshRow(const FieldPass& pass, std::span<const MeshInput> inputs)
      : pass_(pass), inputs_(inputs), memory_(size_t(pass.registers) * kMeshRow), floats_(kMeshRow) {}

  /// Writes results for `count` entries from `first` on, the components together.
  void run(int partition, size_t first, size_t count, bool logical, std::vector<float>& to) {
    const FieldStage& stage = pass_.stages.back();
    for (const PointStep& step : stage.steps) run(step, partition, first, count);
    const size_t n = stage.results.size();
    for (size_t c = 0; c < n; ++c) {
      double* const values = at(stage.results[c]);
      if (logical)
        for (size_t i = 0; i < count; ++i) floats_[i] = std::isnan(values[i]) ? NAN : float(values[i] == 1);
      else
        ispc::pointFloats(values, floats_.data(), int(count));
      for (size_t i = 0; i < count; ++i) to[(first + i) * n + c] = floats_[i];
    }
  }

 private:
  double* at(const PointPlace& place) { return memory_.data() + size_t(place.index) * kMeshRow; }

  void run(const PointStep& step, int partition, size_t first, size_t count) {
    double* const to = at(step.to);
    if (step.op == PointOp::Load) {
      const Mesh& mesh = *inputs_[size_t(step.source)].mesh;
      const std::vector<float>& values = valuesOf(mesh, mesh.blocks.at(partition));
      for (size_t i = 0; i < count; ++i)
        to[i] = double(values[(first + i) * size_t(mesh.components) + size_t(step.component)]);
      return ispc::pointValues(to, mesh.shift, mesh.scale, int(count));
    }
    if (step.op == PointOp::Coordinate) {
      const Mesh& mesh = *inputs_[0].mesh;
      for (size_t i = 0; i < count; ++i)
        to[i] = placeOf(mesh, mesh.blocks.at(partition), uint32_t(first + i))[step.axis];
      return;
    }
    if (step.op == PointOp::Fill) {
      std::fill_n(to, count, step.operands[0].number);
      return;
    }
    std::array<const double*, 9> operands{};
    unsigned numbers = 0;
    const int all = operandsOf(step.op);
    for (int i = 0; i < all; ++i) {
      const PointPlace& place = step.operands[size_t(i)];
      const bool isNumber = place.kind == PointPlace::Kind::Number;
      if (isNumber) numbers |= 1u << i;
      operands[size_t(i)] = isNumber ? &place.number : at(place);
    }
    computePoints(step.op, std::span(operands.data(), size_t(all)), numbers, to, int(count));
  }

  const FieldPass& pass_;
  const std::span<const MeshInput> inputs_;
  std::vector<double> memory_;
  std::vector<float> floats_;
};

/// The computation of one expression of fields on a mesh on this rank.
class MeshEvaluation final : public Evaluation {
 public:
  MeshEvaluation(const Expression& expression, std::span<const MeshInput> inputs, Collectives& ranks,
                 const DeriveOptions& options)
      : Evaluation(expression, ranks, options), inputs_(inputs) {
    agree(ranks_, [&] { prepare(); });
  }

  DerivedMesh derived() {
    DerivedMesh made{std::make_shared<Mesh>(samplesOf(root())), type()};
    Mesh& mesh = *made.mesh;
    mesh.name = options_.name;
    setRanges(mesh, made.noData);
    agree(ranks_, [&] { finish(mesh, made.noData); });
    if (mesh.ofCells) average(mesh);
    return made;
  }

 private:
  const Mesh& like() const { return *inputs_[0].mesh; }
  const Partitioning& partitioning() const { return *inputs_[0].partitioning; }

  void prepare() {
    if (inputs_.empty()) throw Error("expression: there are no inputs, expected at least one field");
    std::vector<ExpressionInput> typed;
    for (const MeshInput& input : inputs_) {
      const bool isCut =
          input.partitioning == inputs_[0].partitioning || *input.partitioning == partitioning();
      if (!isCut || !areOnOneMesh(*input.mesh, like()))
        throw Error(
            "expression: " + inQuotes(inputs_[0].name, '`') + " and " + inQuotes(input.name, '`') +
            " are on different meshes, expected values at the points of one mesh in the same partitions, or "
            "of its cells");
      typed.push_back({input.name, input.mesh->components});
    }
    setInputs(std::move(typed));
  }

  Statistics statisticsOfInput(const std::string& name, const StatisticsOptions& wanted) override {
    const auto input = std::ranges::find(inputs_, name, &MeshInput::name);
    return meshStatistics(*input->mesh, partitioning(), ranks_, wanted);
  }

  Statistics statisticsOfNode(size_t node, const StatisticsOptions& wanted) override {
    const Mesh samples = samplesOf(node);
    const Statistics found = meshStatistics(samples, partitioning(), ranks_, wanted);
    memory_(-bytesOfValues(samples));
    return found;
  }

  FieldPass passOf(size_t node) const {
    const FieldGraph graph = graphAt(node);
    for (const PointValue& value : graph.values)
      if (reachOf(value.op) > 0)
        throw Error("expression: differentials need fields on a grid, and " + inQuotes(inputs_[0].name, '`') +
                    " is an unstructured volume; Resample puts it on a grid");
    return passesOf(graph, int(inputs_.size()), 0).back();
  }

  /// Returns a mesh with what operation `node` computes, NaN where there is no data, without averages and ranges.
  Mesh samplesOf(size_t node) {
    Mesh made;
    made.ofCells = like().ofCells;
    made.box = like().box;
    made.report = like().report;
    agree(ranks_, [&] {
      const FieldPass pass = passOf(node);
      made.components = int(pass.stages.back().results.size());
      for (const auto& [partition, block] : like().blocks) {
        const size_t entries = made.ofCells ? block.cells.size() : block.points.size();
        MeshBlock& own =
            made.blocks
                .try_emplace(partition,
                             MeshBlock{block.points, {}, block.cells, block.neighbours, block.shell})
                .first->second;
        memory_(int64_t(entries * size_t(made.components) * sizeof(float)));
        std::vector<float>& to = made.ofCells ? own.cellValues : own.values;
        to.resize(entries * size_t(made.components));
        compute(pass, partition, entries, types_[node].kind == ValueType::Kind::Logical, to);
      }
    });
    return made;
  }

  void compute(const FieldPass& pass, int partition, size_t entries, bool logical,
               std::vector<float>& to) const {
    constexpr size_t kTogether = 16 * kMeshRow;
    parallelFor(size_t(0), (entries + kTogether - 1) / kTogether, [&](size_t part) {
      const PlainArithmetic plain;
      ranks_.check();
      MeshRow row(pass, inputs_);
      const size_t end = std::min(entries, (part + 1) * kTogether);
      for (size_t first = part * kTogether; first < end; first += kMeshRow)
        row.run(partition, first, std::min(kMeshRow, end - first), logical, to);
    });
  }

  static void clearNoData(Mesh& mesh) {
    for (auto& [partition, block] : mesh.blocks)
      for (float& value : mesh.ofCells ? block.cellValues : block.values)
        if (std::isnan(value)) value = 0;
  }

  void setRanges(Mesh& mesh, int64_t& noData) {
    for (int c = 0; c < mesh.components + (mesh.components > 1); ++c) {
      StatisticsOptions wanted;
      wanted.component = c;
      const Statistics found = meshStatistics(mesh, partitioning(), ranks_, wanted);
      mesh.ranges.emplace_back();
      if (found.count > 0) mesh.ranges.back() = {found.least.value, found.largest.value};
      noData = found.noData;  // of the magnitude: where any component has none
    }
  }

  void finish(Mesh& mesh, int64_t noData) const {
    const bool logical = type().kind == ValueType::Kind::Logical;
    if (logical && noData > 0) mesh.ranges[0].extend(0.);
    if (logical) clearNoData(mesh);
    MeshReport& report = mesh.report;
    report.differingPoints = report.differingCells = report.noDataPoints = report.noDataCells = 0;
    (mesh.ofCells ? report.noDataCells : report.noDataPoints) = logical ? 0 : uint64_t(noData);
    if (!mesh.ofCells) return;
    // A cell has all of its components or none.
    const auto n = size_t(mesh.components);
    for (auto& [partition, block] : mesh.blocks)
      for (size_t at = 0; at < block.cellValues.size(); at += n) {
        float* const own = block.cellValues.data() + at;
        if (std::any_of(own, own + n, [](float v) { return std::isnan(v); })) std::fill_n(own, n, float(NAN));
      }
  }

  /// Collective. Each partition is sure of the averages at the points that are nearest to it, and tells them to the others.
  void average(Mesh& mesh) {
    MeshBlockCounts counts;
    agree(ranks_, [&] {
      for (auto& [partition, block] : mesh.blocks) {
        memory_(int64_t(block.points.size() * size_t(mesh.components) * sizeof(float)));
        block.values = averagesAtPoints({block.points.data(), block.points.size()}, block.cells.view(),
                                        block.cellValues, mesh.components, [&](double) { ranks_.check(); });
        for (uint32_t p = 0; p < block.points.size() && partitioning().partitions() > 1; ++p)
          if (partitioning().nearest(block.points[p]) == partition) counts.differing[partition].push_back(p);
      }
    });
    settle(mesh.blocks, partitioning(), counts, {}, ranks_, true);
  }

  const std::span<const MeshInput> inputs_;
};

}  // namespace

DerivedMesh derive(const Expression& expression, std::span<const MeshInput> inputs, Collectives& ranks,
                   const DeriveOptions& options) {
  MeshEvaluation evaluation(expression, inputs, ranks, options);
  agree(ranks, [&] { evaluation.expectField(false); });
  evaluation.findNumbers();
  return evaluation.derived();
}

double numberOf(const Expression& expression, std::span<const MeshInput> inputs, Collectives& ranks,
                const DeriveOptions& options) {
  MeshEvaluation evaluation(expression, inputs, ranks, options);
  double number = 0;
  agree(ranks, [&] { evaluation.expectNumber(); });
  evaluation.findNumbers();
  agree(ranks, [&] { number = evaluation.number(); });
  return number;
}

}  // namespace gxy
