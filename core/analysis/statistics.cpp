// SPDX-License-Identifier: Apache-2.0
// Three passes over the values. The first finds extremes, and so the units of sums; the second adds the values, the third the
// squares of their distances to the mean. Quantiles are found by three digits of the values' ordered bits, one in each pass from
// the second on, so they take a fourth.
#include "core/analysis/statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>

#include "core/analysis/field_tiles.h"
#include "core/analysis/fixed_sum.h"
#include "core/analysis/value_rows.h"
#include "core/comm/error.h"
#include "core/comm/parallel_for.h"

namespace gxy {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Bits that ascend with the value.
uint32_t orderedBits(float value) {
  const auto bits = std::bit_cast<uint32_t>(value);
  return bits >> 31 ? ~bits : bits | 0x80000000u;
}
float valueOfOrderedBits(uint32_t ordered) {
  return std::bit_cast<float>(ordered >> 31 ? ordered & 0x7fffffffu : ~ordered);
}

/// An extreme and where it is. The better one is the smaller one of `sign` times the value, or that with the lower key.
struct Candidate {
  float stored = 0;
  bool exists = false;
  ValueKey key;
  glm::dvec3 position{0};

  void improve(const Candidate& other, float sign) {
    if (!other.exists) return;
    const float mine = sign * stored, theirs = sign * other.stored;
    if (!exists || theirs < mine || (theirs == mine && other.isBefore(*this))) *this = other;
  }

 private:
  /// Several points of a mesh may be at one place along the curve.
  bool isBefore(const Candidate& other) const {
    const auto placeOf = [](const Candidate& c) {
      return std::tuple(c.key, c.position.x, c.position.y, c.position.z);
    };
    return placeOf(*this) < placeOf(other);
  }
};

/// What the first pass finds.
struct Extremes {
  int64_t count = 0, noData = 0;
  Candidate least, largest;

  void add(const ValueRow& row) {
    float lo = std::numeric_limits<float>::infinity(), hi = -lo;
    for (size_t i = 0; i < row.stored.size(); ++i) {
      if (row.where && !row.where[i]) continue;
      const float v = row.stored[i];
      const bool there = v == v;
      (there ? count : noData) += 1;
      lo = v < lo ? v : lo;
      hi = v > hi ? v : hi;
    }
    if (!(lo <= hi)) return;
    offer(least, lo, row, 1);
    offer(largest, hi, row, -1);
  }

  void add(const Extremes& other) {
    count += other.count;
    noData += other.noData;
    least.improve(other.least, 1);
    largest.improve(other.largest, -1);
  }

 private:
  static void offer(Candidate& best, float value, const ValueRow& row, float sign) {
    if (best.exists && sign * value > sign * best.stored) return;
    Candidate mine;
    for (size_t i = 0; i < row.stored.size(); ++i) {
      if (row.stored[i] != value || (row.where && !row.where[i])) continue;
      if (mine.exists && mine.key < row.key(i)) continue;
      mine.improve({value, true, row.key(i), row.position(i)}, sign);
      if (!row.keys) break;
    }
    best.improve(mine, sign);
  }
};

/// The digits of the bits of values, from the highest: 11, 11 and 10 bits.
constexpr int kDigits = 3;
constexpr int kShift[kDigits] = {21, 10, 0};
constexpr uint32_t kDigitValues[kDigits] = {2048, 2048, 1024};

/// Finds the values at some ranks in the order of all values.
class OrderStatistics {
 public:
  explicit OrderStatistics(std::vector<int64_t> ranks) {
    for (const int64_t rank : ranks) wanted_.push_back({rank, 0});
  }

  using Counts = std::map<uint32_t, std::vector<int64_t>>;  ///< of the next digit, by the digits before it

  Counts noCounts() const {
    Counts counts;
    for (const Wanted& w : wanted_) counts[w.prefix].resize(kDigitValues[digit_]);
    return counts;
  }

  void add(Counts& counts, float value) const {
    const uint32_t ordered = orderedBits(value);
    const uint32_t prefix = digit_ == 0 ? 0 : ordered >> kShift[digit_ - 1];
    const auto found = counts.find(prefix);
    if (found != counts.end()) ++found->second[(ordered >> kShift[digit_]) & (kDigitValues[digit_] - 1)];
  }

  /// Takes the counts of all ranks, and goes on to the next digit.
  void next(const Counts& counts) {
    for (Wanted& w : wanted_) {
      const std::vector<int64_t>& digits = counts.at(w.prefix);
      uint32_t d = 0;
      while (d + 1 < digits.size() && w.rank >= digits[d]) w.rank -= digits[d++];
      w.prefix = w.prefix * kDigitValues[digit_] + d;
    }
    ++digit_;
  }

  bool done() const { return wanted_.empty() || digit_ == kDigits; }
  float value(size_t i) const { return valueOfOrderedBits(wanted_[i].prefix); }

 private:
  struct Wanted {
    int64_t rank;     ///< among the values with the prefix
    uint32_t prefix;  ///< the digits found so far
  };
  std::vector<Wanted> wanted_;
  int digit_ = 0;
};

class Measurement {
 public:
  Measurement(const ValueRows& rows, Collectives& ranks, const StatisticsOptions& options)
      : rows_(rows), ranks_(ranks), options_(options) {}

  Statistics statistics(double cell) {
    findExtremes();
    if (found_.count > 0) {
      OrderStatistics order(wantedRanks());
      addValues(order, cell);
      addSquares(order);
      while (!order.done()) countDigits(order);
      setQuantiles(order);
    } else {
      found_.mean = found_.variance = kNan;
      found_.histogram.assign(size_t(options_.bins), 0);
      found_.binRange = options_.binRange.value_or(Range{0, 0});
      found_.quantiles.assign(options_.quantiles.size(), kNan);
    }
    return std::move(found_);
  }

 private:
  double valueOf(float stored) const { return rows_.offset + rows_.scale * double(stored); }

  /// Calls use(made, row) for all rows on several threads, each with a `made` of its own, and merge(made) for each of these.
  template <class Make, class Use, class Merge>
  void pass(Make make, Use use, Merge merge) {
    std::mutex mutex;
    agree(ranks_, [&] {
      parallelFor(size_t(0), rows_.parts(), [&](size_t part) {
        const PlainArithmetic plain;
        ranks_.check();
        auto made = make();
        rows_.visit(part, [&](const ValueRow& row) { use(made, row); });
        const std::lock_guard lock(mutex);
        merge(made);
      });
    });
  }

  /// Calls use(stored, i) for the values of a row that count.
  template <class Use>
  static void forValues(const ValueRow& row, Use use) {
    for (size_t i = 0; i < row.stored.size(); ++i)
      if (row.stored[i] == row.stored[i] && !(row.where && !row.where[i])) use(row.stored[i], i);
  }

  /// Replaces a plain value by that of all ranks together.
  template <class T>
  void mergeRanks(T& mine) {
    T all{};
    bool isFirst = true;
    for (const std::vector<T>& theirs : gatherValues<T>(ranks_, std::span<const T>(&mine, 1))) {
      if (isFirst)
        all = theirs[0];
      else
        all.add(theirs[0]);
      isFirst = false;
    }
    mine = all;
  }

  void mergeCounts(std::vector<int64_t>& mine) {
    const auto all = gatherValues<int64_t>(ranks_, mine);
    std::ranges::fill(mine, 0);
    for (const auto& theirs : all)
      for (size_t i = 0; i < mine.size(); ++i) mine[i] += theirs[i];
  }

  void mergeCounts(OrderStatistics::Counts& mine) {
    std::vector<int64_t> flat;
    for (const auto& [prefix, counts] : mine) flat.insert(flat.end(), counts.begin(), counts.end());
    mergeCounts(flat);
    size_t next = 0;
    for (auto& [prefix, counts] : mine)
      for (int64_t& count : counts) count = flat[next++];
  }

  static void addCounts(OrderStatistics::Counts& to, const OrderStatistics::Counts& from) {
    for (auto& [prefix, counts] : to)
      for (size_t i = 0; i < counts.size(); ++i) counts[i] += from.at(prefix)[i];
  }

  void findExtremes() {
    Extremes all;
    pass([] { return Extremes{}; }, [](Extremes& made, const ValueRow& row) { made.add(row); },
         [&](const Extremes& made) { all.add(made); });
    mergeRanks(all);
    found_.count = all.count;
    found_.noData = all.noData;
    if (all.count == 0) return;
    found_.least = {valueOf(all.least.stored), int64_t(all.least.key.id), all.least.position};
    found_.largest = {valueOf(all.largest.stored), int64_t(all.largest.key.id), all.largest.position};
    found_.binRange = options_.binRange.value_or(Range{found_.least.value, found_.largest.value});
  }

  /// The ranks in the order of all values that quantiles need: two of each.
  std::vector<int64_t> wantedRanks() const {
    std::vector<int64_t> wanted;
    for (const double fraction : options_.quantiles) {
      const auto lower = int64_t(std::floor(fraction * double(found_.count - 1)));
      wanted.push_back(lower);
      wanted.push_back(std::min(lower + 1, found_.count - 1));
    }
    return wanted;
  }

  void setQuantiles(const OrderStatistics& order) {
    for (size_t q = 0; q < options_.quantiles.size(); ++q) {
      const double at = options_.quantiles[q] * double(found_.count - 1);
      const double lower = valueOf(order.value(2 * q)), upper = valueOf(order.value(2 * q + 1));
      const double fraction = at - std::floor(at);
      found_.quantiles.push_back(fraction > 0 ? lower + fraction * (upper - lower) : lower);
    }
  }

  void addValues(OrderStatistics& order, double cell) {
    struct Sums {
      FixedSum plain, weighted;
      std::vector<int64_t> bins;
      OrderStatistics::Counts counts;
    };
    const double largest = std::max(std::abs(found_.least.value), std::abs(found_.largest.value));
    const auto make = [&] {
      return Sums{FixedSum(largest), FixedSum(largest), std::vector<int64_t>(size_t(options_.bins)),
                  order.noCounts()};
    };
    const Range& range = found_.binRange;
    const double perBin = range.max > range.min ? double(options_.bins) / (range.max - range.min) : 0;
    Sums all = make();
    pass(
        make,
        [&](Sums& made, const ValueRow& row) {
          FixedSum sum(largest);
          forValues(row, [&](float stored, size_t i) {
            const double v = valueOf(stored);
            sum.add(v);
            if ((row.halfFirst && i == 0) || (row.halfLast && i + 1 == row.stored.size()))
              made.weighted.add(v, -row.weight / 2);
            if (options_.bins > 0 && v >= range.min && v <= range.max)
              ++made.bins[size_t(std::min<int64_t>(int64_t((v - range.min) * perBin), options_.bins - 1))];
            if (!order.done()) order.add(made.counts, stored);
          });
          made.plain.add(sum);
          made.weighted.add(sum, row.weight);
        },
        [&](const Sums& made) {
          all.plain.add(made.plain);
          all.weighted.add(made.weighted);
          for (size_t i = 0; i < all.bins.size(); ++i) all.bins[i] += made.bins[i];
          addCounts(all.counts, made.counts);
        });
    mergeRanks(all.plain);
    mergeRanks(all.weighted);
    found_.sum = all.plain.over(1);
    found_.mean = all.plain.over(double(found_.count));
    found_.integral = all.weighted.over(8) * cell;
    mergeCounts(all.bins);
    found_.histogram = std::move(all.bins);
    nextDigit(order, all.counts);
  }

  void addSquares(OrderStatistics& order) {
    struct Sums {
      FixedSum squares;
      OrderStatistics::Counts counts;
    };
    const double mean = found_.mean;
    const double furthest =
        std::max(std::abs(found_.least.value - mean), std::abs(found_.largest.value - mean));
    // Distances are scaled below 1, which is exact, so that no square overflows or vanishes.
    int exponent = 0;
    std::frexp(furthest, &exponent);
    const double scale = std::ldexp(1, -exponent);
    const auto make = [&] {
      return Sums{FixedSum(1), order.done() ? OrderStatistics::Counts{} : order.noCounts()};
    };
    Sums all = make();
    pass(
        make,
        [&](Sums& made, const ValueRow& row) {
          forValues(row, [&](float stored, size_t) {
            const double d = (valueOf(stored) - mean) * scale;
            made.squares.add(d * d);
            if (!order.done()) order.add(made.counts, stored);
          });
        },
        [&](const Sums& made) {
          all.squares.add(made.squares);
          addCounts(all.counts, made.counts);
        });
    mergeRanks(all.squares);
    found_.variance = std::ldexp(all.squares.over(double(found_.count)), 2 * exponent);
    nextDigit(order, all.counts);
  }

  void countDigits(OrderStatistics& order) {
    using Counts = OrderStatistics::Counts;
    Counts all = order.noCounts();
    pass([&] { return order.noCounts(); },
         [&](Counts& made, const ValueRow& row) {
           forValues(row, [&](float stored, size_t) { order.add(made, stored); });
         },
         [&](const Counts& made) { addCounts(all, made); });
    nextDigit(order, all);
  }

  void nextDigit(OrderStatistics& order, OrderStatistics::Counts& counts) {
    if (order.done()) return;
    mergeCounts(counts);
    order.next(counts);
  }

  const ValueRows& rows_;
  Collectives& ranks_;
  const StatisticsOptions& options_;
  Statistics found_;
};

void check(const StatisticsOptions& options) {
  if (options.bins < 0 || options.bins > StatisticsOptions::kMostBins)
    throw Error("statistics: " + std::to_string(options.bins) + " bins, expected 0 to " +
                std::to_string(StatisticsOptions::kMostBins));
  if (const auto& range = options.binRange;
      range && !(range->min < range->max && std::isfinite(range->max - range->min)))
    throw Error("statistics: bins from " + std::to_string(range->min) + " to " + std::to_string(range->max) +
                ", expected a lower and a higher number");
  for (const double q : options.quantiles)
    if (!(q >= 0 && q <= 1))
      throw Error("statistics: quantile at " + std::to_string(q) + ", expected a number from 0 to 1");
}

/// The sizes of segments: their lengths, and their integrals of the value.
struct LineSizes {
  FixedSum length, integral;
  double longest = 0, largest = 0;

  void add(const LineSizes& other) {
    length.add(other.length);
    integral.add(other.integral);
    longest = std::max(longest, other.longest);
    largest = std::max(largest, other.largest);
  }
};

/// Adds up the segments in the units of `units`; without units it finds the largest sizes only.
LineSizes sizesOf(const GeometryBlock& block, const LineSizes* units, Collectives& ranks) {
  LineSizes sizes = units ? *units : LineSizes{};
  for (size_t s = 0; s < block.segments.size(); ++s) {
    if (s % 8192 == 0) ranks.check();
    const auto [a, b] = block.segments[s];
    const glm::dvec3 d = block.points[b] - block.points[a];
    const double length = std::sqrt((d.x * d.x + d.y * d.y) + d.z * d.z);
    const double mean = block.values.empty() ? 0 : (double(block.values[a]) + double(block.values[b])) * 0.5;
    const double integral = std::isfinite(length * mean) ? length * mean : 0;
    sizes.longest = std::max(sizes.longest, length);
    sizes.largest = std::max(sizes.largest, std::abs(integral));
    if (!units) continue;
    sizes.length.add(length);
    sizes.integral.add(integral);
  }
  return sizes;
}

/// Collective.
template <class T>
T merged(Collectives& ranks, const T& mine) {
  const auto all = gatherValues<T>(ranks, std::span<const T>(&mine, 1));
  T sum = all[0][0];
  for (size_t r = 1; r < all.size(); ++r) sum.add(all[r][0]);
  return sum;
}

}  // namespace

Statistics meshStatistics(const Mesh& mesh, const Partitioning& partitioning, Collectives& ranks,
                          const StatisticsOptions& options) {
  std::optional<MeshRows> rows;
  agree(ranks, [&] {
    check(options);
    const int c = options.component;
    if (c < 0 || c > mesh.components)
      throw Error("statistics: component " + std::to_string(c) + " of a field of " +
                  std::to_string(mesh.components) + ", expected 0 to " + std::to_string(mesh.components));
    rows.emplace(mesh, partitioning, c);
  });
  Statistics all = Measurement(*rows, ranks, options).statistics(0);
  for (ExtremeValue* extreme : {&all.least, &all.largest})
    extreme->index = std::min<int64_t>(extreme->index, 0);
  return all;
}

Statistics fieldStatistics(const Volume& volume, const Partitioning& partitioning, Collectives& ranks,
                           const StatisticsOptions& options, const Volume* where) {
  std::optional<VolumeRows> rows;
  agree(ranks, [&] {
    check(options);
    const int most = volume.components > 1 ? volume.components : 0;
    if (options.component < 0 || options.component > most)
      throw Error("statistics: component " + std::to_string(options.component) + " of a field of " +
                  std::to_string(volume.components) + ", expected 0 to " + std::to_string(most));
    if (where && (where->grid != volume.grid || where->stored != ScalarType::UInt8 || where->components != 1))
      throw Error("statistics: the condition is no field of logical values on the field's grid");
    for (const auto& [partition, block] : volume.blocks)
      if (where && (!where->blocks.contains(partition) || where->blocks.at(partition).extent != block.extent))
        throw Error("statistics: the condition and the field are cut into different partitions");
    rows.emplace(volume, partitioning, options.component, where);
  });
  const glm::dvec3& h = volume.grid.spacing;
  return Measurement(*rows, ranks, options).statistics((h.x * h.y) * h.z);
}

Statistics geometryStatistics(const GeometryBlock& block, GeometryKind kind, Collectives& ranks,
                              const StatisticsOptions& options) {
  LineSizes sizes;
  const bool lines = kind == GeometryKind::PathLines;
  agree(ranks, [&] {
    check(options);
    if (kind == GeometryKind::Triangles)
      throw Error("statistics: of triangles, expected particles or path lines");
    validate(block, kind);
    if (lines) sizes = sizesOf(block, nullptr, ranks);
  });
  Statistics found = Measurement(GeometryRows(block, kind), ranks, options).statistics(0);
  if (!lines) return found;
  sizes = merged(ranks, sizes);
  const LineSizes units{FixedSum(sizes.longest), FixedSum(sizes.largest), 0, 0};
  agree(ranks, [&] { sizes = sizesOf(block, &units, ranks); });
  sizes = merged(ranks, sizes);
  found.length = sizes.length.over(1);
  found.integral = sizes.integral.over(1);
  return found;
}

}  // namespace gxy
