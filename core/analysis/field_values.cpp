// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/field_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/comm/parallel_for.h"
#include "core/comm/wire.h"

namespace gxy {
namespace {

constexpr size_t kPointsOfRound = size_t(1) << 18;  // points that a rank sends at once

/// The points of one round of a rank, by the ranks that own them.
struct Round {
  std::vector<std::vector<GridPlace>> places;
  std::vector<std::vector<size_t>> origins;  ///< numbers of the points
};

template <class T>
Bytes bytesOf(const std::vector<T>& values) {
  const auto* first = reinterpret_cast<const std::byte*>(values.data());
  return Bytes(first, first + values.size() * sizeof(T));
}

}  // namespace

FieldValues valuesAt(const Volume& volume, const Partitioning& partitioning, std::span<const int> components,
                     std::span<const glm::dvec3> points, Collectives& ranks) {
  const auto read = [components](const FieldReader& reader, int partition, const GridPlace& place,
                                 float* values) {
    for (const int c : components) *values++ = float(reader.value(partition, place, c));
  };
  return readAt(volume, partitioning, components.size(), read, points, ranks);
}

FieldValues readAt(const Volume& volume, const Partitioning& partitioning, size_t count,
                   const ReadPlace& read, std::span<const glm::dvec3> points, Collectives& ranks) {
  const FieldReader reader(volume, partitioning);
  const size_t n = count, size = size_t(ranks.size());
  const std::vector<uint64_t> counts = gatherCounts(ranks, points.size());
  const uint64_t most = *std::max_element(counts.begin(), counts.end());
  FieldValues result;
  uint64_t outside = 0, noData = 0;
  agree(ranks, [&] { result.values.assign(points.size() * n, std::numeric_limits<float>::quiet_NaN()); });
  for (size_t begin = 0; begin < most; begin += kPointsOfRound) {
    Round round;
    std::vector<Bytes> asked(size);
    agree(ranks, [&] {
      ranks.check();
      ranks.done(double(begin) / double(most));
      round.places.resize(size);
      round.origins.resize(size);
      for (size_t i = std::min(begin, points.size()); i < std::min(begin + kPointsOfRound, points.size());
           i++) {
        const auto place = reader.place(points[i]);
        if (!place) {
          outside++;
          continue;
        }
        const auto owner = size_t(partitioning.owner(reader.partitionOf(place->cell)));
        round.places[owner].push_back(*place);
        round.origins[owner].push_back(i);
      }
      for (size_t r = 0; r < size; r++) asked[r] = bytesOf(round.places[r]);
    });
    const std::vector<Bytes> heard = ranks.allToAll(std::move(asked));
    std::vector<Bytes> answers(size);
    agree(ranks, [&] {
      for (size_t r = 0; r < size; r++) {
        std::vector<GridPlace> places(heard[r].size() / sizeof(GridPlace));
        std::copy(heard[r].begin(), heard[r].end(), reinterpret_cast<std::byte*>(places.data()));
        std::vector<float> values(places.size() * n);
        parallelFor(
            size_t(0), places.size(),
            [&](size_t i) {
              const int partition = reader.partitionOf(places[i].cell);
              read(reader, partition, places[i], &values[i * n]);
            },
            [&](double) { ranks.check(); });
        answers[r] = bytesOf(values);
      }
    });
    const std::vector<Bytes> answered = ranks.allToAll(std::move(answers));
    for (size_t r = 0; r < size; r++) {
      const auto* values = reinterpret_cast<const float*>(answered[r].data());
      for (size_t i = 0; i < round.origins[r].size(); i++) {
        std::copy_n(values + i * n, n, &result.values[round.origins[r][i] * n]);
        noData += std::isnan(values[i * n]);
      }
    }
  }
  result.outside = sumOfCounts(ranks, outside);
  result.noData = sumOfCounts(ranks, noData);
  return result;
}

}  // namespace gxy
