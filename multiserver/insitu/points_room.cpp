// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/points_room.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/comm/error.h"
#include "core/data/merge_ranges.h"
#include "core/io/import_geometry.h"

namespace gxy {

namespace {

// Of places, of numbers while they are compared, and of the datasets that points become.
uint64_t bytesToMake(const insitu::Mesh& mesh, size_t place) {
  const size_t fields = mesh.fields.size();
  return place + (mesh.ids ? 2 * sizeof(uint64_t) : 0) +
         (sizeof(glm::dvec3) + sizeof(uint64_t)) * std::max<size_t>(fields, 1) + sizeof(glm::vec3) * fields;
}

}  // namespace

PointsRoom::PointsRoom(const insitu::Mesh& mesh, TakeStepMemory take)
    : mesh_(mesh), sent_(mesh, std::move(take), bytesToMake(mesh, sizeof(Place))) {}

glm::dvec3 PointsRoom::position(const Place& place) const {
  return sent_.position(sent_.sources()[size_t(place.rank)], place.index);
}

// The particles of this rank that can be drawn, by ascending number.
std::vector<PointsRoom::Place> PointsRoom::places(const std::map<int, uint64_t>& firstIds) const {
  uint64_t count = 0;
  for (const SentArrays::Source& source : sent_.sources()) count += source.points();
  if (count > insitu::kMostParticles)
    throw Error("points \"" + mesh_.name +
                "\": one rank would hold more than 2^32 - 2 points; use more ranks");
  std::vector<Place> places;
  places.reserve(count);
  for (size_t r = 0; r < sent_.sources().size(); r++) {
    const SentArrays::Source& source = sent_.sources()[r];
    for (uint64_t i = 0; i < source.points(); i++) {
      const auto id = mesh_.ids ? valueAt<uint64_t>(source.data(1), i) : firstIds.at(int(r)) + i;
      const Place place{id, int(r), uint32_t(i)};
      const glm::dvec3 p = position(place);
      if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) places.push_back(place);
    }
  }
  if (mesh_.ids)
    std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.id < b.id; });
  if (!places.empty() && places.back().id > uint64_t(INT64_MAX))
    throw Error("points \"" + mesh_.name + "\": the number " + std::to_string(int64_t(places.back().id)) +
                " of a point is negative, or above 2^63 - 1, expected one from 0 up");
  return places;
}

// Each rank looks at a share of the numbers, so that none has to know all of them.
void PointsRoom::checkDistinct(const std::vector<Place>& places, Collectives& ranks) const {
  std::vector<Bytes> shares(size_t(ranks.size()));
  agree(ranks, [&] {
    for (const Place& place : places) {
      Bytes& share = shares[place.id % size_t(ranks.size())];
      const auto* bytes = reinterpret_cast<const std::byte*>(&place.id);
      share.insert(share.end(), bytes, bytes + sizeof place.id);
    }
  });
  const std::vector<Bytes> received = ranks.allToAll(std::move(shares));
  agree(ranks, [&] {
    std::vector<uint64_t> ids;
    for (const Bytes& theirs : received)
      for (size_t i = 0; i < theirs.size() / sizeof(uint64_t); i++)
        ids.push_back(valueAt<uint64_t>(theirs.data(), i));
    std::sort(ids.begin(), ids.end());
    const auto twice = std::adjacent_find(ids.begin(), ids.end());
    if (twice != ids.end())
      throw Error("points \"" + mesh_.name + "\": two of them have the number " + std::to_string(*twice) +
                  ", expected a number of its own for each");
  });
}

void PointsRoom::giveLook(size_t field, const std::vector<Place>& places, GeometryBlock& block) const {
  const LookOf look(mesh_.fields[field]);
  const size_t array = sent_.arrayOf(field);
  for (const Place& place : places)
    look.append(sent_.sources()[size_t(place.rank)].data(array), place.index, block);
}

std::vector<std::shared_ptr<Dataset>> PointsRoom::complete(Collectives& ranks) {
  std::vector<uint64_t> counts;
  agree(ranks, [&] {
    for (const SentArrays::Source& source : sent_.sources()) counts.push_back(source.points());
  });
  const std::map<int, uint64_t> first = firstNumbers(ranks, counts);
  std::vector<Place> places;
  LoadedGeometry loaded;
  OwnedGeometry& points = loaded.geometry;
  points.kind = GeometryKind::Particles;
  agree(ranks, [&] {
    places = this->places(first);
    points.block.points.reserve(places.size());
    points.block.ids.reserve(places.size());
    for (const Place& place : places) {
      points.block.points.push_back(position(place));
      points.block.ids.push_back(place.id);
    }
  });
  if (mesh_.ids) checkDistinct(places, ranks);
  points.primitives = sumOfCounts(ranks, places.size());
  points.droppedPrimitives =
      sumOfCounts(ranks, std::accumulate(counts.begin(), counts.end(), uint64_t(0)) - places.size());
  measureGeometry(loaded, ranks);

  std::vector<OwnedGeometry> all;
  std::vector<Range> ranges(mesh_.fields.size());
  agree(ranks, [&] {
    for (size_t f = 1; f < mesh_.fields.size(); f++) all.push_back(points);
    all.push_back(std::move(points));
    for (size_t f = 0; f < mesh_.fields.size(); f++) {
      giveLook(f, places, all[f].block);
      all[f].colored = all[f].primitives > 0 && LookOf(mesh_.fields[f]).colored();
      ranges[f] = rangeOf(all[f].block);
    }
  });
  mergeRanges(ranks, ranges);

  std::vector<std::shared_ptr<Dataset>> datasets;
  agree(ranks, [&] {
    const LedgerEntry memory = sent_.take(0);
    for (size_t i = 0; i < all.size(); i++) {
      const bool hasField = i < mesh_.fields.size();
      if (hasField) all[i].range = ranges[i];
      datasets.push_back(datasetOf(mesh_, hasField ? &mesh_.fields[i] : nullptr, std::move(all[i]), memory));
    }
    sent_.clear();
  });
  return datasets;
}

}  // namespace gxy
