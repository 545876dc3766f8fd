// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/density_filter.h"

#include <algorithm>
#include <cmath>

#include "core/analysis/macrocell_densities.h"
#include "core/analysis/made_geometry.h"
#include "core/analysis/random_numbers.h"
#include "core/analysis/recorded_fields.h"
#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/comm/wire.h"

namespace gxy {
namespace {

constexpr int kMostSamples = 1 << 28;

/// A candidate that has been accepted.
struct Accepted {
  uint64_t candidate;
  glm::dvec3 point;
  float value;
};

/// The van der Corput number of k in base 2 plus a shift, modulo 1.
double spread(uint64_t k, uint64_t shift) {
  uint64_t reversed = 0;
  for (int i = 0; i < 64; i++) reversed |= (k >> i & 1) << (63 - i);
  return double((reversed + shift) >> 11) * 0x1p-53;
}

/// Draws candidates, of which each rank looks at those in its partitions.
class Candidates {
 public:
  Candidates(const DensitySampler& filter, const Volume& volume, const Partitioning& partitioning,
             int component, Collectives& ranks)
      : filter_(filter),
        partitioning_(partitioning),
        component_(component),
        rank_(ranks.rank()),
        reader_(volume, partitioning),
        densities_(
            volume, reader_, component,
            [&filter](double least, double largest) { return filter.largestDensity(least, largest); },
            ranks) {
    const auto words = randomWords(uint32_t(filter.seed), uint32_t(Draw::DensityShift), 0);
    shift_ = uint64_t(words[0]) << 32 | words[1];
  }

  double total() const { return densities_.total(); }

  /// Those of candidates [first, end) that are this rank's and are accepted, in order.
  std::vector<Accepted> accepted(uint64_t first, uint64_t end, Collectives& ranks) const {
    constexpr uint64_t kChunk = 1024;
    std::vector<std::vector<Accepted>> chunks(size_t((end - first + kChunk - 1) / kChunk));
    parallelFor(size_t(0), chunks.size(), [&](size_t c) {
      ranks.check();
      const uint64_t begin = first + c * kChunk;
      for (uint64_t k = begin; k < std::min(begin + kChunk, end); k++) look(k, chunks[c]);
    });
    std::vector<Accepted> all;
    for (const auto& chunk : chunks) all.insert(all.end(), chunk.begin(), chunk.end());
    return all;
  }

 private:
  void look(uint64_t k, std::vector<Accepted>& out) const {
    const auto macrocell = densities_.at(spread(k, shift_) * densities_.total());
    if (!macrocell) return;
    const auto words = randomWords(uint32_t(filter_.seed), uint32_t(Draw::Density), k);
    GridPlace place;
    for (int a = 0; a < 3; a++) {
      const double at = unitOf(words[size_t(a)]) * double(macrocell->cells[size_t(a)]);
      const double cell = std::floor(at);
      place.cell[size_t(a)] = macrocell->firstCell[size_t(a)] + int64_t(cell);
      place.fraction[a] = at - cell;
    }
    const int partition = reader_.partitionOf(place.cell);
    if (partitioning_.owner(partition) != rank_) return;
    const double value = reader_.value(partition, place, component_);
    if (unitOf(words[3]) * macrocell->bound < filter_.densityAt(value))
      out.push_back({k, reader_.worldOf(place), float(value)});
  }

  const DensitySampler& filter_;
  const Partitioning& partitioning_;
  const int component_, rank_;
  const FieldReader reader_;
  const MacrocellDensities densities_;
  uint64_t shift_ = 0;
};

/// The numbers of the accepted candidates of all ranks, ascending.
std::vector<uint64_t> gatheredNumbers(const std::vector<Accepted>& mine, Collectives& ranks) {
  Writer writer;
  for (const Accepted& a : mine) writer.write(a.candidate);
  std::vector<uint64_t> all;
  for (const Bytes& message : ranks.allGather(writer.take())) {
    Reader in(message, "accepted candidates");
    while (!in.rest().empty()) all.push_back(in.read<uint64_t>());
  }
  std::sort(all.begin(), all.end());
  return all;
}

void readMap(const Found& found, DensitySampler& filter) { filter.map = readOpacityMap(found, true).points; }

}  // namespace

FilterInfo DensitySampler::info() {
  return {"DensitySampler",
          1,
          "Points at random, whose density in space is proportional to a field or to a map of it. The first "
          "n of them are the points "
          "for a smaller `count`.",
          {{"field", kVolumes, "The field."},
           {"values", kVolumes | kUnstructured, "Further volumes whose values the points get.",
            FilterPort::Count::Any}},
          DatasetType::Particles};
}

std::vector<KeyRow<DensitySampler>> DensitySampler::properties() {
  using D = DensitySampler;
  return {
      integerKey("count", &D::count, {1, kMostSamples}, "The number of points."),
      integerKey("seed", &D::seed, {0, 2147483647}, "Other numbers make other points."),
      customKey<D>(
          "component", "integer >= 0", "The component of a field that has several.",
          [](const Found& f, D& d) {
            d.component = f.integer({0, 1023});
          },
          [](const D& d) { return d.component ? OrderedJson(*d.component) : OrderedJson(); })
          .byDefault("the magnitude"),
      customKey<D>(
          "map", "list of [value, density >= 0]",
          "The density by value, linear between these points, as an `extinctionmap` is. Only ratios count.",
          readMap,
          [](const D& d) {
            return d.map.empty() ? OrderedJson() : toJson(OpacityMap{true, d.map});
          })
          .byDefault("the value, and 0 where it is below 0"),
      flagKey(
          "gradient", &D::gradient,
          "Whether points get the gradient of `field`, per unit of the world, as their field `gradient`."),
  };
}

double DensitySampler::densityAt(double value) const {
  if (std::isnan(value)) return 0;
  if (map.empty()) return std::max(value, 0.0);
  const auto above = std::upper_bound(map.begin(), map.end(), value,
                                      [](double v, const OpacityPoint& p) { return v < p.value; });
  if (above == map.begin()) return map.front().opacity;
  if (above == map.end()) return map.back().opacity;
  const OpacityPoint &a = above[-1], &b = *above;
  return a.opacity + (value - a.value) / (b.value - a.value) * (b.opacity - a.opacity);
}

double DensitySampler::largestDensity(double least, double largest) const {
  double most = std::max(densityAt(least), densityAt(largest));
  for (const OpacityPoint& p : map)
    if (p.value >= least && p.value <= largest) most = std::max(most, p.opacity);
  return most;
}

FilterResult DensitySampler::run(FilterRun& run) const {
  const FilterSource& source = run.input("field");
  const Dataset& field = *source.data;
  Collectives& ranks = run.ranks;
  int number = 0;
  const auto values = run.inputs().find("values");
  const std::span<const FilterSource> further =
      values == run.inputs().end() ? std::span<const FilterSource>() : values->second;
  agree(ranks, [&] {
    number = componentOf(field.components(), source.name, component);
    checkNames(further, "DensitySampler", gradient);
  });
  run.begin(0, 2, "bounds of the density");
  const Candidates candidates(*this, *field.volume, *field.partitioning, number, ranks);
  if (candidates.total() == 0)
    throw Error("DensitySampler: the density of " + inQuotes(source.name) +
                " is 0 everywhere, expected some value that the map gives a density > 0");
  run.begin(1, 2, "points");
  GeometryBlock block;
  constexpr int64_t kPointBytes = sizeof(glm::dvec3) + sizeof(float) + sizeof(uint64_t);
  std::vector<LedgerEntry> memory;  // of each round
  const uint64_t most = 10000 * uint64_t(count) + 1000000;
  uint64_t found = 0, tried = 0, size = 4096;
  while (found < uint64_t(count) && tried < most) {
    const uint64_t end = std::min(tried + size, most);
    std::vector<Accepted> mine;
    agree(ranks, [&] { mine = candidates.accepted(tried, end, ranks); });
    const std::vector<uint64_t> all = gatheredNumbers(mine, ranks);
    agree(ranks, [&] {
      memory.push_back(run.takeMemory("geometry", int64_t(mine.size()) * kPointBytes));
      size_t place = 0;
      for (const Accepted& a : mine) {
        while (all[place] != a.candidate) place++;
        if (found + place >= uint64_t(count)) break;
        block.points.push_back(a.point);
        block.values.push_back(a.value);
        block.ids.push_back(found + place);
      }
      ranks.done(double(found) / double(count));
    });
    found = std::min(found + all.size(), uint64_t(count));
    tried = end;
    size = std::min<uint64_t>(2 * size, uint64_t(1) << 20);
  }
  LedgerEntry whole;
  agree(ranks, [&] {
    memory.clear();
    whole = run.takeMemory("geometry", int64_t(block.points.size()) * kPointBytes);
  });
  recordFields(run, further, block, memory);
  if (gradient) recordGradient(run, field, number, block, memory);
  FilterResult result;
  result.dataset =
      madeGeometry(run, "density samples", GeometryKind::Particles, std::move(block), field.partitioning,
                   std::move(whole), nameOfComponent(source.name, field.volume->components, number));
  result.told = {{"particles", found}, {"candidates", tried}};
  result.told["fields"] = toldOfPoints(*result.dataset->geometry);
  if (found < uint64_t(count)) result.told.update({{"found", found}, {"count", count}});
  return result;
}

}  // namespace gxy
