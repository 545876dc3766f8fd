// SPDX-License-Identifier: Apache-2.0
#include "gxy/io/import_geometry.h"

#include <spdlog/spdlog.h>

#include <filesystem>
#include <numeric>

#include "gxy/comm/error.h"

namespace gxy {
namespace {

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

template <size_t N>
void append(std::vector<std::array<uint32_t, N>>& to, std::vector<std::array<uint32_t, N>> from,
            uint32_t shift) {
  for (auto& indices : from)
    for (uint32_t& index : indices) index += shift;
  append(to, from);
}

/// What has been read so far on this rank. An attribute that one non-empty piece lacks is lost for all.
struct Reading {
  GeometryBlock block;
  bool values = true, normals = true;
  uint64_t unusedCells = 0;
  LeftOut leftOut;

  void add(GeometryContent piece) {
    GeometryBlock& from = piece.block;
    unusedCells += piece.unusedCells;
    leftOut += piece.leftOut;
    if (from.points.empty()) return;
    if (block.points.size() + from.points.size() >= std::numeric_limits<uint32_t>::max())
      throw Error("one rank would hold more than 2^32 - 2 points; use more ranks");
    const uint32_t shift = uint32_t(block.points.size());
    values = values && !from.values.empty();
    normals = normals && !from.normals.empty();
    if (block.points.empty()) {  // one file is not held twice
      block = std::move(from);
      return;
    }
    append(block.points, from.points);
    append(block.values, from.values);
    append(block.normals, from.normals);
    append(block.segments, from.segments, shift);
    append(block.neighbours, from.neighbours, shift);
    append(block.triangles, from.triangles, shift);
    block.ids.resize(block.ids.size() + from.ids.size());
  }
};

uint64_t sumOf(const std::vector<uint64_t>& counts) {
  return std::accumulate(counts.begin(), counts.end(), uint64_t(0));
}

const char* plural(GeometryKind kind) {
  return kind == GeometryKind::Particles ? "points" : kind == GeometryKind::PathLines ? "lines" : "triangles";
}

}  // namespace

LoadedGeometry loadGeometry(const std::string& path, GeometryKind kind, const std::string& array,
                            Collectives& ranks, const TakeMemory& toTake) {
  LoadedGeometry loaded;
  loaded.name = std::filesystem::path(path).stem().string();
  loaded.kind = kind;
  Reading reading;
  const size_t rank = size_t(ranks.rank()), size = size_t(ranks.size());
  agree(ranks, [&] {
    const std::vector<std::string> pieces = geometryPieces(path);
    loaded.everywhere = pieces.size() == 1;
    const size_t first = loaded.everywhere ? 0 : pieces.size() * rank / size;
    const size_t last = loaded.everywhere ? 1 : pieces.size() * (rank + 1) / size;
    for (size_t i = first; i < last; ++i) {
      ranks.check();
      reading.add(readGeometry(pieces[i], kind, array, toTake));
      ranks.done(double(i + 1 - first) / double(last - first));
    }
  });

  const bool values = sumOf(gatherCounts(ranks, !reading.values)) == 0;
  const bool normals = sumOf(gatherCounts(ranks, !reading.normals)) == 0;
  if (!values) reading.block.values.clear();
  if (!normals) reading.block.normals.clear();

  // Pieces are numbered one after the other, those of lower ranks first.
  const std::vector<uint64_t> counts = gatherCounts(ranks, reading.block.ids.size());
  const uint64_t before = std::accumulate(counts.begin(), counts.begin() + ranks.rank(), uint64_t(0));
  std::iota(reading.block.ids.begin(), reading.block.ids.end(), loaded.everywhere ? uint64_t(0) : before);
  uint64_t dropped = 0;
  agree(ranks, [&] { dropped = uint64_t(dropUnusable(reading.block, kind)); });
  loaded.block = std::move(reading.block);
  loaded.leftOut = reading.leftOut;
  loaded.dropped = loaded.everywhere ? dropped : sumOf(gatherCounts(ranks, dropped));
  loaded.primitives = (loaded.everywhere ? counts[0] : sumOf(counts)) - loaded.dropped;
  const uint64_t unused = sumOf(gatherCounts(ranks, reading.unusedCells));
  if (loaded.primitives + loaded.dropped == 0 && unused > 0)
    throw Error(path + ": the file has no " + plural(kind) + ", only other kinds of cells");
  if (loaded.dropped > 0 && rank == 0)
    spdlog::warn("{}: {} {} dropped: not finite, without area, or repeated", path, loaded.dropped,
                 plural(kind));

  // Points that no primitive uses do not count.
  agree(ranks, [&] {
    const Advance go = [&](double) { ranks.check(); };
    for (size_t p = 0; p < loaded.block.ids.size(); ++p) {
      tell(go, p, loaded.block.ids.size());
      for (uint32_t point : cornersOf(loaded.block, kind, p)) {
        loaded.box.extend(loaded.block.points[point]);
        if (!loaded.block.values.empty()) loaded.range.extend(double(loaded.block.values[point]));
      }
    }
  });
  mergeBox(ranks, loaded.box);
  mergeRanges(ranks, std::span(&loaded.range, 1));
  return loaded;
}

std::shared_ptr<Geometry> distribute(const LoadedGeometry& loaded, const Partitioning& partitioning,
                                     const RadiusOf& radius, Collectives& ranks) {
  auto geometry = std::make_shared<Geometry>();
  geometry->name = loaded.name;
  geometry->kind = loaded.kind;
  geometry->box = loaded.box;
  geometry->range = loaded.range;
  geometry->primitives = loaded.primitives;
  geometry->droppedPrimitives = loaded.dropped;
  std::vector<Bytes> messages;
  agree(ranks, [&] {
    GeometryBlock home;
    const bool some = loaded.everywhere && ranks.size() > 1;
    if (some)
      home = keepHome(loaded.block, loaded.kind, partitioning, ranks.rank(), advanceOf(ranks, 0, 0.25));
    messages = packForOwners(some ? home : loaded.block, loaded.kind, partitioning, radius, ranks.size(),
                             advanceOf(ranks, 0.25, 0.5));
  });
  const std::vector<Bytes> received = ranks.allToAll(std::move(messages));
  agree(ranks, [&] {
    geometry->blocks =
        unpackReceived(loaded.kind, partitioning, ranks.rank(), received, advanceOf(ranks, 0.5));
  });
  return geometry;
}

}  // namespace gxy
