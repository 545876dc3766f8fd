// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/points_room.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/comm/error.h"
#include "core/data/geometry_bytes.h"
#include "core/data/merge_ranges.h"
#include "core/io/import_geometry.h"

namespace gxy {

namespace {

template <class T>
T valueAt(const std::byte* values, size_t i) {
  T value;
  std::memcpy(&value, values + i * sizeof value, sizeof value);
  return value;
}

// The magnitude of the components of a point: of one component, the value itself.
template <class T>
float magnitude(const std::byte* values, size_t point, int components) {
  if (components == 1) return float(double(valueAt<T>(values, point)));
  double sum = 0;
  for (int c = 0; c < components; c++) {
    const auto value = double(valueAt<T>(values, point * size_t(components) + size_t(c)));
    sum += value * value;
  }
  return float(std::sqrt(sum));
}

}  // namespace

PointsRoom::PointsRoom(const insitu::Mesh& mesh, TakeStepMemory take)
    : mesh_(mesh), arrays_(arraysOf(mesh)), take_(std::move(take)) {}

// Of what is sent, of the places, and of the datasets that it becomes.
uint64_t PointsRoom::bytesPerPoint() const {
  uint64_t bytes = sizeof(Place);
  for (const insitu::Field& array : arrays_) bytes += array.bytesPerPoint();
  if (mesh_.ids) bytes += 2 * sizeof(uint64_t);  // while numbers are compared
  const size_t fields = mesh_.fields.size();
  return bytes + (sizeof(glm::dvec3) + sizeof(uint64_t)) * std::max<size_t>(fields, 1) +
         sizeof(float) * fields;
}

void PointsRoom::store(const insitu::Piece& piece, size_t array, const insitu::PieceHeader& header,
                       std::span<const std::byte> samples) {
  if (sources_.size() <= size_t(piece.rank)) sources_.resize(size_t(piece.rank) + 1);
  Source& source = sources_[size_t(piece.rank)];
  if (header.offset == 0) {
    if (array == 0) {
      source = {};
      source.memory = take_("geometry", int64_t(header.points * bytesPerPoint()));
      source.count = header.points;
      source.arrays.resize(arrays_.size());
    }
    source.arrays[array].resize(header.points * arrays_[array].bytesPerPoint());
  }
  if (!samples.empty())
    std::memcpy(source.arrays[array].data() + header.offset, samples.data(), samples.size());
}

glm::dvec3 PointsRoom::position(const Place& place) const {
  const std::byte* positions = sources_[size_t(place.rank)].arrays[0].data();
  glm::dvec3 p;
  for (int a = 0; a < 3; a++) {
    const size_t at = 3 * size_t(place.index) + size_t(a);
    p[a] = mesh_.positions == ScalarType::Float32 ? double(valueAt<float>(positions, at))
                                                  : valueAt<double>(positions, at);
  }
  return p;
}

// The number of the first particle of each rank of the simulation.
std::map<int, uint64_t> PointsRoom::firstIds(Collectives& ranks) const {
  struct Count {
    int64_t rank;
    uint64_t count;
  };
  Bytes mine;
  for (size_t r = 0; r < sources_.size(); r++) {
    const Count count{int64_t(r), sources_[r].count};
    if (count.count == 0) continue;
    const auto* bytes = reinterpret_cast<const std::byte*>(&count);
    mine.insert(mine.end(), bytes, bytes + sizeof count);
  }
  std::map<int, uint64_t> counts;
  for (const Bytes& theirs : ranks.allGather(std::move(mine)))
    for (size_t i = 0; i < theirs.size() / sizeof(Count); i++) {
      const auto count = valueAt<Count>(theirs.data(), i);
      counts[int(count.rank)] = count.count;
    }
  uint64_t next = 0;
  for (auto& [rank, count] : counts) next += std::exchange(count, next);
  return counts;
}

// The particles of this rank that can be drawn, by ascending number.
std::vector<PointsRoom::Place> PointsRoom::places(const std::map<int, uint64_t>& firstIds) const {
  uint64_t count = 0;
  for (const Source& source : sources_) count += source.count;
  if (count > insitu::kMostParticles)
    throw Error("points \"" + mesh_.name +
                "\": one rank would hold more than 2^32 - 2 points; use more ranks");
  std::vector<Place> places;
  places.reserve(count);
  for (size_t r = 0; r < sources_.size(); r++)
    for (uint64_t i = 0; i < sources_[r].count; i++) {
      const auto id =
          mesh_.ids ? valueAt<uint64_t>(sources_[r].arrays[1].data(), i) : firstIds.at(int(r)) + i;
      const Place place{id, int(r), uint32_t(i)};
      const glm::dvec3 p = position(place);
      if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) places.push_back(place);
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

std::vector<float> PointsRoom::values(size_t field, const std::vector<Place>& places) const {
  const size_t array = arrays_.size() - mesh_.fields.size() + field;
  std::vector<float> values;
  values.reserve(places.size());
  withType(arrays_[array].type, [&](auto type) {
    for (const Place& place : places)
      values.push_back(magnitude<decltype(type)>(sources_[size_t(place.rank)].arrays[array].data(),
                                                 place.index, arrays_[array].components));
  });
  return values;
}

std::vector<std::shared_ptr<Dataset>> PointsRoom::complete(Collectives& ranks) {
  const std::map<int, uint64_t> first = firstIds(ranks);
  std::vector<Place> places;
  uint64_t count = 0;
  LoadedGeometry loaded;
  OwnedGeometry& points = loaded.geometry;
  points.kind = GeometryKind::Particles;
  agree(ranks, [&] {
    places = this->places(first);
    for (const Source& source : sources_) count += source.count;
    points.block.points.reserve(places.size());
    points.block.ids.reserve(places.size());
    for (const Place& place : places) {
      points.block.points.push_back(position(place));
      points.block.ids.push_back(place.id);
    }
  });
  if (mesh_.ids) checkDistinct(places, ranks);
  points.primitives = sumOfCounts(ranks, places.size());
  points.droppedPrimitives = sumOfCounts(ranks, count - places.size());
  measureGeometry(loaded, ranks);

  std::vector<std::shared_ptr<OwnedGeometry>> all;
  std::vector<Range> ranges(mesh_.fields.size());
  agree(ranks, [&] {
    for (size_t f = 1; f < mesh_.fields.size(); f++) all.push_back(std::make_shared<OwnedGeometry>(points));
    all.push_back(std::make_shared<OwnedGeometry>(std::move(points)));
    for (size_t f = 0; f < mesh_.fields.size(); f++) {
      all[f]->block.values = values(f, places);
      ranges[f] = rangeOf(all[f]->block);
    }
  });
  mergeRanges(ranks, ranges);

  std::vector<std::shared_ptr<Dataset>> datasets;
  agree(ranks, [&] {
    LedgerEntry memory = take_("geometry", 0);
    for (size_t i = 0; i < all.size(); i++) {
      datasets.push_back(std::make_shared<Dataset>());
      Dataset& d = *datasets.back();
      if (i < mesh_.fields.size()) {
        d.array = mesh_.fields[i].name;
        all[i]->range = ranges[i];
      }
      all[i]->name = d.array.empty() ? mesh_.name : d.array;
      d.bytes = bytesOf(all[i]->block);
      d.memory = memory.another(d.bytes);
      d.geometry = std::move(all[i]);
    }
    sources_.clear();  // which gives their memory back
  });
  return datasets;
}

}  // namespace gxy
