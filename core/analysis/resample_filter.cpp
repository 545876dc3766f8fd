// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/resample_filter.h"

#include <algorithm>
#include <numeric>

#include "core/analysis/field_values.h"
#include "core/comm/error.h"
#include "core/data/bricks.h"
#include "core/data/complete_volume.h"
#include "core/data/ghosts.h"

namespace gxy {
namespace {

constexpr int64_t kMostGridPoints = int64_t(1) << 36;
constexpr int64_t kPointsAtOnce = int64_t(1) << 18;  // points of a rank whose values are asked for at once

/// Walks through the points that the partitions of a rank own, in pieces.
class OwnedPoints {
 public:
  OwnedPoints(const Grid& grid, const Partitioning& partitioning, const GhostPlan& plan) : grid_(grid) {
    for (const auto& [partition, extent] : plan.blocks())
      if (const Extent owned = ownedPoints(grid, partitioning, partition); owned.count() > 0)
        owned_.push_back({partition, owned});
  }

  int64_t count() const {
    int64_t all = 0;
    for (const auto& [partition, extent] : owned_) all += extent.count();
    return all;
  }

  /// The next points of one partition, at most `most`; none at the end.
  struct Piece {
    int partition = 0;
    Extent box;         ///< what the partition owns
    int64_t first = 0;  ///< number of the first point in the box, x fastest
    std::vector<glm::dvec3> points;
  };
  Piece next(int64_t most) {
    while (at_ < owned_.size() && first_ == owned_[at_].second.count()) at_++, first_ = 0;
    if (at_ == owned_.size()) return {};
    const auto& [partition, box] = owned_[at_];
    Piece piece{partition, box, first_, {}};
    const int64_t end = std::min(first_ + most, box.count());
    piece.points.reserve(size_t(end - first_));
    for (; first_ < end; first_++) {
      const Index3& n = box.points;
      const Index3 at{box.first[0] + first_ % n[0], box.first[1] + first_ / n[0] % n[1],
                      box.first[2] + first_ / n[0] / n[1]};
      piece.points.push_back(grid_.origin +
                             grid_.spacing * glm::dvec3(double(at[0]), double(at[1]), double(at[2])));
    }
    return piece;
  }

 private:
  const Grid grid_;
  std::vector<std::pair<int, Extent>> owned_;
  size_t at_ = 0;
  int64_t first_ = 0;
};

void checkInside(const Grid& grid, const Partitioning& partitioning, const std::string& name) {
  const Box box = grid.box(), &domain = partitioning.domain();
  for (int a = 0; a < 3; a++)
    if (const double margin = 1e-9 * grid.spacing[a];
        box.lo[a] < domain.lo[a] - margin || box.hi[a] > domain.hi[a] + margin)
      throw Error("Resample: the box reaches beyond the domain of the partitioning of " + inQuotes(name) +
                  ", expected a box inside it");
}

}  // namespace

Box readBox(const Found& found) {
  const std::vector<double> b = found.numbers(6, 6, "[x0, x1, y0, y1, z0, z1]");
  for (size_t a = 0; a < 3; a++)
    if (!(b[2 * a] <= b[2 * a + 1]))
      found.fail("[x0, x1, y0, y1, z0, z1] with x0 <= x1, y0 <= y1 and z0 <= z1");
  return {{b[0], b[2], b[4]}, {b[1], b[3], b[5]}};
}

OrderedJson toJson(const Box& b) { return {b.lo.x, b.hi.x, b.lo.y, b.hi.y, b.lo.z, b.hi.z}; }

std::array<int, 3> readDimensions(const Found& found, int least) {
  const auto list = found.list("three whole numbers");
  if (list.size() != 3) found.fail("three whole numbers");
  std::array<int, 3> dimensions{};
  for (size_t a = 0; a < 3; a++) dimensions[a] = list[a].integer({double(least), 1 << 20});
  return dimensions;
}

FilterInfo Resample::info() {
  return {"Resample",
          1,
          "All components of a field at the points of another regular grid. Points outside the field, and in "
          "its cells without data, have no "
          "data (NaN), and are counted.",
          {{"field", kVolumes | kUnstructured, "The field."},
           {"like", kVolumes,
            "A volume whose grid and partitioning are taken, in place of `box` and `dimensions`.",
            FilterPort::Count::Optional}},
          DatasetType::Volume};
}

std::vector<KeyRow<Resample>> Resample::properties() {
  using R = Resample;
  return {customKey<R>(
              "box", "[x0, x1, y0, y1, z0, z1]", "Where the grid is; its outermost points are on the box.",
              [](const Found& f, R& r) {
                r.box = readBox(f);
                for (int a = 0; a < 3; a++)
                  if (r.box->lo[a] == r.box->hi[a]) f.fail("a box with a volume");
              },
              [](const R& r) { return r.box ? toJson(*r.box) : OrderedJson(); })
              .byDefault("the box of `field`"),
          customKey<R>(
              "dimensions", "[i, j, k], whole numbers >= 2", "The number of points along each axis.",
              [](const Found& f, R& r) {
                r.dimensions = readDimensions(f, 2);
                if (int64_t(r.dimensions[0]) * r.dimensions[1] > kMostGridPoints / r.dimensions[2])
                  f.fail("at most 2^36 points");
              },
              [](const R& r) { return OrderedJson(r.dimensions); })};
}

FilterResult Resample::run(FilterRun& run) const {
  Collectives& ranks = run.ranks;
  const Dataset& field = *run.input("field").data;
  const FilterSource* like = run.optional("like");
  const Dataset& place = like ? *like->data : field;
  const Partitioning& partitioning = *place.partitioning;
  const auto volume = std::make_shared<Volume>();
  std::optional<GhostPlan> plan;
  LedgerEntry memory;
  run.begin(0, 2, "values");
  agree(ranks, [&] {
    const Box all = box.value_or(field.box());
    for (int a = 0; a < 3 && !like; a++)
      if (!(all.hi[a] > all.lo[a]))
        throw Error("Resample: " + inQuotes(run.input("field").name) +
                    " has no cells or is flat, expected a `box` with a volume or a volume `like`");
    volume->name = field.mesh ? field.mesh->name : field.volume->name;
    volume->components = field.components();
    if (like) {
      volume->grid = place.volume->grid;
    } else {
      volume->grid.origin = all.lo;
      for (int a = 0; a < 3; a++) {
        volume->grid.points[size_t(a)] = dimensions[size_t(a)];
        volume->grid.spacing[a] = (all.hi[a] - all.lo[a]) / double(dimensions[size_t(a)] - 1);
      }
      checkInside(volume->grid, partitioning, run.input("field").name);
    }
    plan.emplace(volume->grid, partitioning, kGhostLayers, ranks.rank(), ranks.size());
    int64_t bytes = 0;
    const int64_t each = int64_t(sizeof(float)) * volume->components;
    for (const auto& [partition, extent] : plan->blocks())
      bytes += int64_t(Bricks(extent.points).count()) * each;
    memory = run.takeMemory("volume", bytes);
    for (const auto& [partition, extent] : plan->blocks()) {
      VolumeBlock& block = volume->blocks[partition];
      block.extent = extent;
      block.samples.resize(Bricks(extent.points).count() * size_t(each));
      clearPadding(block.samples, extent.points, size_t(each));
    }
  });
  std::vector<int> components(size_t(volume->components));
  std::iota(components.begin(), components.end(), 0);
  OwnedPoints points(volume->grid, partitioning, *plan);
  const ValueReader reader(run, run.input("field"));
  const size_t pieces = std::max<size_t>(plan->blocks().size(), 1);
  // Ranks make as many rounds as the one with most needs; a piece is of one partition.
  const std::vector<uint64_t> rounds = gatherCounts(ranks, uint64_t(points.count() / kPointsAtOnce) + pieces);
  const uint64_t most = *std::max_element(rounds.begin(), rounds.end());
  uint64_t outside = 0, noData = 0;
  FieldStatistics statistics;
  for (uint64_t r = 0; r < most; r++) {
    OwnedPoints::Piece piece;
    agree(ranks, [&] { piece = points.next(kPointsAtOnce); });
    const FieldValues found = reader.at(components, piece.points, ranks);
    outside += found.outside;
    noData += found.noData;
    agree(ranks, [&] {
      ranks.check();
      ranks.done(double(r + 1) / double(most));
      if (piece.points.empty()) return;
      const auto values = std::as_bytes(std::span(found.values));
      VolumeBlock& block = volume->blocks.at(piece.partition);
      storeInBricks(block.samples, block.extent, piece.box, piece.first, values,
                    sizeof(float) * components.size());
      statistics.merge(statisticsOf(values, ScalarType::Float32, volume->components));
    });
  }
  run.begin(1, 2, "summaries");
  Volume* const one = volume.get();
  exchangeGhosts(std::span(&one, 1), *plan, ranks);
  if (!needsStatistics(*volume, partitioning)) statistics = {};
  completeBricks(*volume, partitioning, ranks, std::move(statistics), volume->components);
  FilterResult result;
  result.dataset = run.made(volume, place.partitioning, std::move(memory));
  result.told = {{"outside", outside}, {"no data", noData}};
  return result;
}

}  // namespace gxy
