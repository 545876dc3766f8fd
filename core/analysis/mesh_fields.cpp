// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/mesh_fields.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <string>
#include <utility>

#include "core/analysis/mesh_heads.h"
#include "core/analysis/mesh_walk.h"
#include "core/comm/error.h"

namespace gxy {

bool haveSameCells(const Mesh& a, const Mesh& b) {
  return a.blocks.size() == b.blocks.size() &&
         std::equal(a.blocks.begin(), a.blocks.end(), b.blocks.begin(), [](const auto& x, const auto& y) {
           return x.first == y.first && x.second.points == y.second.points &&
                  x.second.cells.points == y.second.cells.points;
         });
}

namespace {

/// Steps in meshes take longer than those on grids, so that there are fewer in a call (kCellsPerCall).
constexpr int64_t kMeshCellsPerCall = 1 << 16;

const Mesh& checkedVectors(std::span<const std::shared_ptr<const Mesh>> meshes) {
  if (meshes.empty() || meshes.size() > kMostFields)
    throw Error("lines read " + std::to_string(meshes.size()) + " volumes; expected 1 to " +
                std::to_string(kMostFields));
  const Mesh& first = *meshes.front();
  if (first.components != 3)
    throw Error("unstructured volume \"" + first.name + "\" has " + std::to_string(first.components) +
                " components; lines need vectors of 3");
  for (const auto& other : meshes)
    if (!haveSameCells(first, *other))
      throw Error("unstructured volume \"" + other->name +
                  "\" has other points or cells than the vectors \"" + first.name +
                  "\"; expected the same, of the same import");
  return first;
}

/// The result of a call in the making.
class MeshPacket {
 public:
  MeshPacket(const MeshTrace& trace, HeadList heads) : t_(trace), heads_(std::move(heads)) {
    result_.counters.headsAdvanced = uint64_t(heads_.size());
  }

  AdvanceResult advance() {
    for (int i = 0; i < heads_.size(); i++) {
      MeshHead head = MeshHead::of(heads_, i);
      if (!t_.block && !head.unplaced)
        throw Error("heads of lines came for partition " + std::to_string(t_.partition) +
                    ", which has no cells on this rank");
      MeshWalk walk(t_, head, heads_.backward(i), heads_.line(i), result_);
      const MeshWalk::Stop stop =
          walk.run(std::max<int64_t>(kMeshCellsPerCall - MeshWalk::spent(result_.counters), 0));
      if (stop == MeshWalk::Stop::Ends) {
        addEnd(i, head, walk);
        continue;
      }
      head.writeTo(heads_, i);
      leaving_[stop == MeshWalk::Stop::Leaves ? walk.next() : t_.partition].push_back(i);
    }
    for (const auto& [partition, which] : leaving_)
      result_.leaving.push_back(heads_.gather(partition, which));
    return std::move(result_);
  }

 private:
  void addEnd(int i, const MeshHead& head, const MeshWalk& walk) {
    result_.retired++;
    const bool backward = heads_.backward(i);
    LineEnd end = outsideEnd(heads_.line(i), backward, walk.world());
    end.reason = walk.reason();
    if (end.reason != EndReason::Outside) {
      end.points = head.points;
      end.length = backward ? -head.length : head.length;
      end.time = t_.options.normalised ? end.length : backward ? -head.time : head.time;
      settleAtLimit(t_.options, t_.limits, end);
    }
    result_.ends.push_back(end);
  }

  const MeshTrace& t_;
  HeadList heads_;
  AdvanceResult result_;
  std::map<int, std::vector<int>> leaving_;
};

}  // namespace

MeshFields::MeshFields(std::vector<std::shared_ptr<const Mesh>> meshes,
                       std::shared_ptr<const Partitioning> partitioning, const std::function<void()>& check)
    : meshes_(std::move(meshes)),
      partitioning_(std::move(partitioning)),
      reader_(checkedVectors(meshes_), check) {
  for (size_t m = 1; m < meshes_.size(); m++)
    for (int c = 0; c < meshes_[m]->components; c++) recorded_.push_back({int(m), c});
  const std::vector<Range>& ranges = vectors().ranges;
  leastSpeed_ = ranges.empty() || ranges.back().empty() ? 0 : 0x1p-90 * ranges.back().max;
}

double MeshFields::diagonal() const {
  return vectors().box.empty() ? 0 : glm::length(vectors().box.hi - vectors().box.lo);
}

SeedHeads MeshFields::seeds(std::span<const glm::dvec3> positions, std::span<const uint64_t> ids,
                            TraceDirection direction) const {
  return makeSeedHeads(
      positions, ids, direction, kMeshHeads,
      [&](size_t i) {
        return isInBox(vectors().box, positions[i]) ? partitioning_->nearest(positions[i]) : -1;
      },
      [&](HeadList& heads, int k, size_t i, bool backward) {
        heads.clear(k, ids[i], backward);
        MeshHead head;
        head.unplaced = true;
        head.place = positions[i];
        head.writeTo(heads, k);
      });
}

const char* MeshFields::wrongHeads(const HeadList& heads) const { return wrongInMesh(heads); }

void MeshFields::advance(int partition, HeadList heads, const TraceOptions& options, Done done) const {
  const auto start = std::chrono::steady_clock::now();
  const MeshTrace trace(*this, partition, options);
  AdvanceResult result = MeshPacket(trace, std::move(heads)).advance();
  result.counters.nsAdvance =
      uint64_t(std::chrono::nanoseconds(std::chrono::steady_clock::now() - start).count());
  done(std::move(result));
}

}  // namespace gxy
