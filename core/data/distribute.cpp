// SPDX-License-Identifier: Apache-2.0
#include "core/data/distribute.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/comm/wire.h"
#include "core/data/block_arrays.h"
#include "core/data/geometry_bytes.h"
#include "core/data/joined.h"

namespace gxy {
namespace {

/// Primitives of a rank that are under way at a time.
constexpr size_t kAtOnce = size_t(1) << 18;

/// The primitives of a block for one rank after the other, so many at a time as may be under way. The portions of a rank,
/// joined with Indices::OfAll, are subset() of its primitives.
class Portions {
 public:
  /// `homes`: the primitives of each rank.
  Portions(const GeometryBlock& block, GeometryKind kind, std::vector<std::vector<uint32_t>> homes)
      : block_(block), kind_(kind), homes_(std::move(homes)) {}

  /// The next portion of each rank that has one, as messages to all ranks.
  std::vector<Bytes> next() {
    std::vector<Bytes> messages(homes_.size());
    for (size_t room = kAtOnce; room > 0 && rank_ < homes_.size();) {
      if (first_ == 0) ofRank_ = subset(block_, kind_, homes_[rank_]);
      const size_t last = std::min(first_ + room, ofRank_.ids.size());
      room -= last - first_;
      Writer writer;
      if (last > 0) write(writer, portion(last));
      messages[rank_] = writer.take();
      if (last < ofRank_.ids.size()) break;
      first_ = points_ = 0, rank_++;
    }
    return messages;
  }

 private:
  /// Primitives up to number `last`, with the points up to the last that they need. The last portion of a rank has all others.
  GeometryBlock portion(size_t last) {
    size_t points = points_;
    for (size_t p = first_; p < last; p++)
      for (const uint32_t i : primitivePoints(ofRank_, kind_, p)) points = std::max(points, size_t(i) + 1);
    if (last == ofRank_.ids.size()) points = ofRank_.points.size();
    GeometryBlock part;
    part.fields = emptyLike(ofRank_.fields);
    const auto copy = [&](auto of, size_t begin, size_t end) {
      const auto& from = of(std::as_const(ofRank_));
      if (!from.empty())
        of(part).assign(from.begin() + std::ptrdiff_t(begin), from.begin() + std::ptrdiff_t(end));
    };
    forPointArrays(part.fields, [&](auto of, size_t each) { copy(of, points_ * each, points * each); });
    forPrimitiveArrays([&](auto of) { copy(of, first_, last); });
    first_ = last, points_ = points;
    return part;
  }

  const GeometryBlock& block_;
  const GeometryKind kind_;
  const std::vector<std::vector<uint32_t>> homes_;
  GeometryBlock ofRank_;
  size_t rank_ = 0, first_ = 0, points_ = 0;  ///< what comes next; numbers in ofRank_
};

size_t roundsFor(uint64_t primitives) { return size_t((primitives + kAtOnce - 1) / kAtOnce); }

}  // namespace

GeometryBlock keepHome(const GeometryBlock& all, GeometryKind kind, const Partitioning& partitioning,
                       Collectives& ranks) {
  std::optional<Portions> portions;
  agree(ranks, [&] {
    if (ranks.rank() == 0)
      portions.emplace(all, kind, homesOf(all, kind, partitioning, ranks.size(), advanceOf(ranks, 0, 0.2)));
  });
  const size_t rounds = roundsFor(sumOfCounts(ranks, all.ids.size()));
  std::vector<GeometryBlock> parts;
  for (size_t round = 0; round < rounds; round++) {
    std::vector<Bytes> messages(static_cast<size_t>(ranks.size()));
    agree(ranks, [&] {
      ranks.check();
      ranks.done(0.2 + 0.8 * double(round) / double(rounds));
      if (portions) messages = portions->next();
    });
    const std::vector<Bytes> received = ranks.allToAll(std::move(messages));
    agree(ranks, [&] {
      Reader reader(received.at(0), "primitives of a file");
      if (!reader.rest().empty()) parts.push_back(readBlock(reader));
    });
  }
  GeometryBlock mine;
  agree(ranks, [&] {
    mine = joined(kind, std::move(parts), Indices::OfAll);
    if (mine.points.empty()) mine.fields = emptyLike(all.fields);
    validate(mine, kind);
  });
  return mine;
}

std::shared_ptr<Geometry> distribute(const OwnedGeometry& owned, const Partitioning& partitioning,
                                     const RadiusOf& radius, Collectives& ranks) {
  auto geometry = std::make_shared<Geometry>();
  geometry->name = owned.name;
  geometry->kind = owned.kind;
  geometry->box = owned.box;
  geometry->range = owned.range;
  geometry->radiusRange = owned.radiusRange;
  geometry->colored = owned.colored;
  geometry->primitives = owned.primitives;
  geometry->droppedPrimitives = owned.droppedPrimitives;
  ReceivedBlocks received(owned.kind, partitioning, ranks.rank());
  const std::vector<uint64_t> counts = gatherCounts(ranks, owned.block.ids.size());
  const size_t rounds = std::max<size_t>(roundsFor(*std::max_element(counts.begin(), counts.end())), 1);
  for (size_t round = 0; round < rounds; round++) {
    const double part = 0.5 / double(rounds), begin = double(round) * part;
    std::vector<Bytes> messages;
    agree(ranks, [&] {
      messages =
          packForOwners(owned.block, owned.kind, partitioning, radius, ranks.size(),
                        advanceOf(ranks, begin, begin + part), {round * kAtOnce, (round + 1) * kAtOnce});
    });
    messages = ranks.allToAll(std::move(messages));
    agree(ranks, [&] { received.take(messages); });
  }
  agree(ranks, [&] { geometry->blocks = received.merged(advanceOf(ranks, 0.5)); });
  return geometry;
}

}  // namespace gxy
