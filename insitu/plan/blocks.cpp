// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/blocks.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "core/comm/error.h"

namespace gxy::insitu {

namespace {

int64_t endOf(const Extent& e, size_t axis) { return e.first[axis] + e.points[axis]; }

std::string text(const Extent& e) {
  const auto index = [](const Index3& i) {
    return "(" + std::to_string(i[0]) + ", " + std::to_string(i[1]) + ", " + std::to_string(i[2]) + ")";
  };
  return index(e.first) + " to " + index({endOf(e, 0) - 1, endOf(e, 1) - 1, endOf(e, 2) - 1});
}

std::string text(const Block& b) {
  return "block " + std::to_string(b.index) + " of rank " + std::to_string(b.rank) + ", points " +
         text(b.extent);
}

void checkDisjoint(const BlockSearch& search) {
  for (size_t i = 0; i < search.blocks().size(); i++)
    search.overlapping(search.blocks()[i].extent, [&](size_t other, const Extent& common) {
      if (other == i) return true;
      throw Error("the blocks of the simulation overlap in points " + text(common) + ": " +
                  text(search.blocks()[other]) + ", and " + text(search.blocks()[i]) +
                  "; expected that each point is owned once");
    });
}

// The parts of a box beside a box inside it.
void addRest(const Extent& box, const Extent& inside, std::vector<Extent>& parts) {
  Extent rest = box;
  for (size_t a = 0; a < 3; a++) {
    for (const bool below : {true, false}) {
      Extent side = rest;
      side.first[a] = below ? rest.first[a] : endOf(inside, a);
      side.points[a] = below ? inside.first[a] - rest.first[a] : endOf(rest, a) - endOf(inside, a);
      if (side.points[a] > 0) parts.push_back(side);
    }
    rest.first[a] = inside.first[a];
    rest.points[a] = inside.points[a];
  }
}

// Returns a box without points of any block; nothing if it is hard to find.
std::optional<Extent> holeIn(const BlockSearch& search, const Extent& whole) {
  constexpr int kMost = 1000000;  // parts that are looked at: about a second
  std::vector<Extent> parts{whole};
  for (int i = 0; i < kMost && !parts.empty(); i++) {
    const Extent part = parts.back();
    parts.pop_back();
    Extent met;
    const bool isFree = search.overlapping(part, [&](size_t, const Extent& common) {
      met = common;
      return false;
    });
    if (isFree) return part;
    addRest(part, met, parts);
  }
  return std::nullopt;
}

Extent around(const Extent& a, const Extent& b) {
  Extent both;
  for (size_t axis = 0; axis < 3; axis++) {
    both.first[axis] = std::min(a.first[axis], b.first[axis]);
    both.points[axis] = std::max(endOf(a, axis), endOf(b, axis)) - both.first[axis];
  }
  return both;
}

}  // namespace

BlockSearch::BlockSearch(std::vector<Block> blocks) : blocks_(std::move(blocks)) {
  if (!blocks_.empty()) build(0, blocks_.size());
}

void BlockSearch::build(size_t first, size_t last) {
  const size_t node = nodes_.size();
  Extent bounds = blocks_[first].extent;
  for (size_t i = first; i < last; i++) bounds = around(bounds, blocks_[i].extent);
  nodes_.push_back({bounds, first, last, 0});
  if (last - first <= kLeaf) return;
  const auto axis =
      size_t(std::max_element(bounds.points.begin(), bounds.points.end()) - bounds.points.begin());
  const auto at = [this](size_t i) { return blocks_.begin() + std::ptrdiff_t(i); };
  const size_t middle = first + (last - first) / 2;
  std::nth_element(at(first), at(middle), at(last), [axis](const Block& a, const Block& b) {
    return 2 * a.extent.first[axis] + a.extent.points[axis] <
           2 * b.extent.first[axis] + b.extent.points[axis];
  });
  build(first, middle);
  nodes_[node].right = nodes_.size();
  build(middle, last);
}

void checkCover(const BlockSearch& search, const Index3& points) {
  checkDisjoint(search);
  int64_t owned = 0;
  for (const Block& b : search.blocks()) owned += b.extent.count();
  const Extent whole{{0, 0, 0}, points};
  if (owned == whole.count()) return;
  if (const auto hole = holeIn(search, whole))
    throw Error("the blocks of the simulation leave a hole of " + std::to_string(hole->points[0]) + " x " +
                std::to_string(hole->points[1]) + " x " + std::to_string(hole->points[2]) + " points, " +
                text(*hole) + "; expected that each point is owned once");
  throw Error("the blocks of the simulation have " + std::to_string(owned) + " of " +
              std::to_string(whole.count()) + " points, expected that each point is owned once");
}

}  // namespace gxy::insitu
