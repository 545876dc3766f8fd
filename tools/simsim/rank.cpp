// SPDX-License-Identifier: Apache-2.0
#include "tools/simsim/rank.h"

#include "core/comm/error.h"

namespace gxy::simsim {
namespace {

constexpr const char* kMesh = "grid";

}  // namespace

Rank::Rank(const Inputs& inputs, const std::string& name, int rank, int ranks, const std::string& options)
    : rank_(rank), owned_(blockOf(inputs.grid.points, rank, ranks)) {
  arrays_.reserve(inputs.arrays.size());
  for (const Inputs::Pair& pair : inputs.arrays) arrays_.emplace_back(pair.array, owned_);
  sim_.reset(gxy_open(name.c_str(), rank, ranks, options.c_str()));
  int64_t size[3], first[3], count[3];
  double origin[3], spacing[3];
  for (int a = 0; a < 3; ++a) {
    size[a] = inputs.grid.points[size_t(a)];
    first[a] = owned_.first[size_t(a)];
    count[a] = owned_.points[size_t(a)];
    origin[a] = inputs.grid.origin[a];
    spacing[a] = inputs.grid.spacing[a];
  }
  expectRight(gxy_grid(sim_.get(), kMesh, 0, GXY_OF_POINTS, size, first, count, origin, spacing));
  for (size_t i = 0; i < arrays_.size(); ++i)
    expectRight(gxy_field(sim_.get(), kMesh, 0, inputs.arrays[i].array.name.c_str(), GXY_OF_POINTS,
                          arrays_[i].view()));
}

void Rank::expectRight(int result) const {
  if (result < 0) throw Error("rank " + std::to_string(rank_) + ": " + message());
}

ReadTarget Rank::target(size_t index, bool second) {
  BlockArray& array = arrays_.at(index);
  return {owned_, second ? array.second() : array.first()};
}

void Rank::compute(double weight) {
  for (BlockArray& array : arrays_) array.compute(weight);
}

void Rank::write(const VolumeWriter& writer) const {
  for (size_t i = 0; i < arrays_.size(); ++i) writer.write(i, owned_, arrays_[i].copyOfOwned());
}

int Rank::publish(int64_t step) {
  const int result = gxy_publish(sim_.get(), step, double(step));
  expectRight(result);
  return result;
}

void readBlocks(const Inputs& inputs, std::span<Rank> ranks, const std::function<void()>& check) {
  for (size_t i = 0; i < inputs.arrays.size(); ++i)
    for (const bool second : {false, true}) {
      std::vector<ReadTarget> targets;
      for (Rank& rank : ranks) targets.push_back(rank.target(i, second));
      readVolume(second ? inputs.arrays[i].second : inputs.arrays[i].first, targets,
                 [&check](int64_t) { check(); });
    }
}

}  // namespace gxy::simsim
