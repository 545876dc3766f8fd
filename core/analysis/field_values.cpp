// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/field_values.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>

#include "core/comm/parallel_for.h"
#include "core/comm/wire.h"

namespace gxy {
namespace {

constexpr size_t kPointsOfRound = size_t(1) << 18;  // points that a rank sends at once

template <class T>
Bytes bytesOf(const std::vector<T>& values) {
  const auto* first = reinterpret_cast<const std::byte*>(values.data());
  return Bytes(first, first + values.size() * sizeof(T));
}

/// What is asked for at a point, and the rank that can tell.
template <class Place>
struct Addressed {
  size_t rank;
  Place place;
};

/// The points of one round of a rank, by the ranks that are asked.
template <class Place>
struct Round {
  std::vector<std::vector<Place>> places;
  std::vector<std::vector<size_t>> origins;  ///< numbers of the points
};

/// Collective. Returns `count` numbers for each point. `address` says which rank is asked for what, or nothing for a point outside;
/// `answer` writes the numbers on that rank, and returns whether the point is inside.
template <class Place, class Address, class Answer>
FieldValues ask(size_t count, std::span<const glm::dvec3> points, Collectives& ranks, const Address& address,
                const Answer& answer) {
  const size_t size = size_t(ranks.size());
  const std::vector<uint64_t> counts = gatherCounts(ranks, points.size());
  const uint64_t most = *std::max_element(counts.begin(), counts.end());
  FieldValues result;
  uint64_t outside = 0, without = 0;
  std::atomic<uint64_t> outsideHere = 0;
  agree(ranks, [&] { result.values.assign(points.size() * count, std::numeric_limits<float>::quiet_NaN()); });
  for (size_t begin = 0; begin < most; begin += kPointsOfRound) {
    Round<Place> round;
    std::vector<Bytes> asked(size);
    agree(ranks, [&] {
      ranks.check();
      ranks.done(double(begin) / double(most));
      round.places.resize(size);
      round.origins.resize(size);
      for (size_t i = std::min(begin, points.size()); i < std::min(begin + kPointsOfRound, points.size());
           i++) {
        const std::optional<Addressed<Place>> to = address(points[i]);
        if (!to) {
          outside++;
          continue;
        }
        round.places[to->rank].push_back(to->place);
        round.origins[to->rank].push_back(i);
      }
      for (size_t r = 0; r < size; r++) asked[r] = bytesOf(round.places[r]);
    });
    const std::vector<Bytes> heard = ranks.allToAll(std::move(asked));
    std::vector<Bytes> answers(size);
    agree(ranks, [&] {
      for (size_t r = 0; r < size; r++) {
        std::vector<Place> places(heard[r].size() / sizeof(Place));
        std::copy(heard[r].begin(), heard[r].end(), reinterpret_cast<std::byte*>(places.data()));
        std::vector<float> values(places.size() * count, std::numeric_limits<float>::quiet_NaN());
        parallelFor(
            size_t(0), places.size(),
            [&](size_t i) {
              if (!answer(places[i], &values[i * count])) outsideHere++;
            },
            [&](double) { ranks.check(); });
        answers[r] = bytesOf(values);
      }
    });
    const std::vector<Bytes> answered = ranks.allToAll(std::move(answers));
    for (size_t r = 0; r < size; r++) {
      const auto* values = reinterpret_cast<const float*>(answered[r].data());
      for (size_t i = 0; i < round.origins[r].size(); i++) {
        std::copy_n(values + i * count, count, &result.values[round.origins[r][i] * count]);
        without += std::isnan(values[i * count]);
      }
    }
  }
  const uint64_t inNoCell = sumOfCounts(ranks, outsideHere);
  result.outside = sumOfCounts(ranks, outside) + inNoCell;
  result.noData = sumOfCounts(ranks, without) - inNoCell;
  return result;
}

}  // namespace

FieldValues readAt(const Volume& volume, const Partitioning& partitioning, size_t count,
                   const ReadPlace& read, std::span<const glm::dvec3> points, Collectives& ranks) {
  const FieldReader reader(volume, partitioning);
  return ask<GridPlace>(
      count, points, ranks,
      [&](glm::dvec3 point) -> std::optional<Addressed<GridPlace>> {
        const std::optional<GridPlace> place = reader.place(point);
        if (!place) return std::nullopt;
        return Addressed<GridPlace>{size_t(partitioning.owner(reader.partitionOf(place->cell))), *place};
      },
      [&](const GridPlace& place, float* values) {
        read(reader, reader.partitionOf(place.cell), place, values);
        return true;
      });
}

ValueReader::ValueReader(FilterRun& run, const FilterSource& field) : field_(field.data) {
  if (!field_->mesh) return;
  agree(run.ranks, [&] {
    memory_ = run.takeMemory("search tree", MeshReader::bytesFor(*field_->mesh));
    mesh_ = std::make_unique<const MeshReader>(*field_->mesh, [&] { run.ranks.check(); });
  });
}

ValueReader::~ValueReader() = default;

FieldValues ValueReader::at(std::span<const int> components, std::span<const glm::dvec3> points,
                            Collectives& ranks) const {
  const Partitioning& partitioning = *field_->partitioning;
  if (!mesh_)
    return readAt(
        *field_->volume, partitioning, components.size(),
        [components](const FieldReader& reader, int partition, const GridPlace& place, float* values) {
          for (const int c : components) *values++ = float(reader.value(partition, place, c));
        },
        points, ranks);
  return inCellsAt(
      components.size(),
      [components](const Mesh& mesh, const MeshPlace& place, float* values) {
        for (const int c : components) *values++ = float(valueAt(mesh, place, c));
      },
      points, ranks);
}

FieldValues ValueReader::inCellsAt(size_t count, const ReadMeshPlace& read,
                                   std::span<const glm::dvec3> points, Collectives& ranks) const {
  const Partitioning& partitioning = *field_->partitioning;
  return ask<glm::dvec3>(
      count, points, ranks,
      [&](glm::dvec3 point) -> std::optional<Addressed<glm::dvec3>> {
        if (!isInBox(field_->mesh->box, point)) return std::nullopt;
        return Addressed<glm::dvec3>{size_t(partitioning.owner(partitioning.nearest(point))), point};
      },
      [&](const glm::dvec3& point, float* values) {
        const std::optional<MeshPlace> place = mesh_->place(partitioning.nearest(point), point);
        if (!place) return false;
        read(*field_->mesh, *place, values);
        return true;
      });
}

}  // namespace gxy
