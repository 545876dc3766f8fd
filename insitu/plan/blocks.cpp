// SPDX-License-Identifier: Apache-2.0
#include "insitu/plan/blocks.h"

#include <algorithm>
#include <optional>
#include <string>
#include <tuple>
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
      if (other < i)
        throw Error("the blocks of the simulation overlap in points " + text(common) + ": " +
                    text(search.blocks()[other]) + ", and " + text(search.blocks()[i]) +
                    "; expected that each point is owned once");
    });
}

// Returns a box of `extent` without points of any block, if there is one. Cuts the extent along the faces of a block that it
// meets, until a part is free.
std::optional<Extent> holeIn(const BlockSearch& search, const Extent& extent) {
  std::optional<Extent> met;
  search.overlapping(extent, [&](size_t, const Extent& common) {
    if (!met || common.count() > met->count()) met = common;
  });
  if (!met) return extent;
  Extent rest = extent;
  for (size_t a = 0; a < 3; a++) {
    for (const bool below : {true, false}) {
      Extent side = rest;
      side.first[a] = below ? rest.first[a] : endOf(*met, a);
      side.points[a] = below ? met->first[a] - rest.first[a] : endOf(rest, a) - endOf(*met, a);
      if (side.points[a] == 0) continue;
      if (const auto hole = holeIn(search, side)) return hole;
    }
    rest.first[a] = met->first[a];
    rest.points[a] = met->points[a];
  }
  return std::nullopt;
}

}  // namespace

BlockSearch::BlockSearch(std::vector<Block> blocks) : blocks_(std::move(blocks)) {
  size_t most = 0;
  for (size_t axis = 0; axis < 3; axis++) {
    std::vector<int64_t> firsts;
    for (const Block& b : blocks_) firsts.push_back(b.extent.first[axis]);
    std::sort(firsts.begin(), firsts.end());
    const auto different = size_t(std::unique(firsts.begin(), firsts.end()) - firsts.begin());
    if (different > most) axis_ = axis;
    most = std::max(most, different);
  }
  std::sort(blocks_.begin(), blocks_.end(), [this](const Block& a, const Block& b) {
    return std::tuple(a.extent.first[axis_], a.rank, a.index) <
           std::tuple(b.extent.first[axis_], b.rank, b.index);
  });
  for (const Block& b : blocks_)
    furthest_.push_back(std::max(furthest_.empty() ? 0 : furthest_.back(), endOf(b.extent, axis_)));
}

std::pair<size_t, size_t> BlockSearch::candidates(const Extent& extent) const {
  const auto first = std::upper_bound(furthest_.begin(), furthest_.end(), extent.first[axis_]);
  const auto last =
      std::lower_bound(blocks_.begin(), blocks_.end(), endOf(extent, axis_),
                       [this](const Block& b, int64_t end) { return b.extent.first[axis_] < end; });
  return {size_t(first - furthest_.begin()), size_t(last - blocks_.begin())};
}

void checkCover(const BlockSearch& search, const Index3& points) {
  checkDisjoint(search);
  int64_t owned = 0;
  for (const Block& b : search.blocks()) owned += b.extent.count();
  const Extent whole{{0, 0, 0}, points};
  if (owned == whole.count()) return;
  const auto hole = holeIn(search, whole);
  if (hole)
    throw Error("the blocks of the simulation leave a hole of " + std::to_string(hole->points[0]) + " x " +
                std::to_string(hole->points[1]) + " x " + std::to_string(hole->points[2]) + " points, " +
                text(*hole) + "; expected that each point is owned once");
}

}  // namespace gxy::insitu
