// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/macrocell_densities.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/comm/error.h"
#include "core/comm/wire.h"

namespace gxy {
namespace {

Index3 quotients(const Index3& a, int64_t side) {
  Index3 q;
  for (size_t i = 0; i < 3; i++) q[i] = std::max<int64_t>((a[i] + side - 1) / side, 1);
  return q;
}

int64_t numberIn(const Index3& n, const Index3& i) { return (i[2] * n[1] + i[1]) * n[0] + i[0]; }

Index3 indexIn(const Index3& n, int64_t number) {
  return {number % n[0], number / n[0] % n[1], number / n[0] / n[1]};
}

size_t placeIn(const Index3& macrocell) {
  constexpr int64_t s = MacrocellDensities::kSide;
  return size_t((macrocell[2] % s * s + macrocell[1] % s) * s + macrocell[0] % s);
}

/// The bound of one macrocell, as a rank tells it to the one that collects its block.
struct Told {
  int64_t block;
  uint64_t place;
  double bound;
};

std::vector<Bytes> exchanged(std::vector<Writer>& messages, Collectives& ranks) {
  std::vector<Bytes> out;
  for (Writer& message : messages) out.push_back(message.take());
  return ranks.allToAll(std::move(out));
}

template <class F>
void eachMacrocell(const Index3& first, const Index3& count, F f) {
  for (int64_t z = 0; z < count[2]; z++)
    for (int64_t y = 0; y < count[1]; y++)
      for (int64_t x = 0; x < count[0]; x++)
        f(Index3{first[0] + x, first[1] + y, first[2] + z}, size_t((z * count[1] + y) * count[0] + x));
}

}  // namespace

int64_t MacrocellDensities::blockOf(const Index3& m) const {
  return numberIn(blocks_, {m[0] / kSide, m[1] / kSide, m[2] / kSide});
}

MacrocellDensities::Macrocell MacrocellDensities::macrocell(int64_t block, size_t place) const {
  const Index3 b = indexIn(blocks_, block);
  const Index3 m = indexIn({kSide, kSide, kSide}, int64_t(place));
  Macrocell out{};
  for (size_t a = 0; a < 3; a++) {
    out.firstCell[a] = (b[a] * kSide + m[a]) * kMacrocellSize;
    out.cells[a] = std::clamp<int64_t>(cells_[a] - out.firstCell[a], 0, kMacrocellSize);
  }
  return out;
}

void MacrocellDensities::sum(int64_t number, Block& block) const {
  block.sums[0] = 0;
  for (size_t i = 0; i < kCells; i++) {
    const Index3 n = macrocell(number, i).cells;
    block.sums[i + 1] = block.sums[i] + block.bounds[i] * double(n[0] * n[1] * n[2]);
  }
}

MacrocellDensities::MacrocellDensities(const Volume& volume, const FieldReader& reader, int component,
                                       const Bound& bound, Collectives& ranks)
    : cells_(volume.grid.cells()),
      macrocells_(quotients(cells_, kMacrocellSize)),
      blocks_(quotients(macrocells_, kSide)) {
  // Each block has a home: the rank that collects the bounds of its macrocells, and tells them to those who hold a part of it.
  Messages told(size_t(ranks.size())), wanted(size_t(ranks.size()));
  agree(ranks, [&] { tellBounds(volume, reader, component, bound, ranks, told, wanted); });
  const std::vector<Bytes> heard = exchanged(told, ranks), asked = exchanged(wanted, ranks);
  std::map<int64_t, Block> collected;
  Messages answers(size_t(ranks.size()));
  Writer sums;
  agree(ranks, [&] {
    collect(heard, collected, sums);
    answer(asked, collected, answers);
  });
  const std::vector<Bytes> answered = exchanged(answers, ranks);
  const std::vector<Bytes> all = ranks.allGather(sums.take());
  agree(ranks, [&] {
    take(answered);
    takeSums(all);
  });
}

void MacrocellDensities::tellBounds(const Volume& volume, const FieldReader& reader, int component,
                                    const Bound& bound, Collectives& ranks, Messages& told,
                                    Messages& wanted) const {
  const auto homeOf = [&](int64_t block) { return size_t(block) % told.size(); };
  std::set<int64_t> held;
  for (const auto& [partition, block] : volume.blocks) {
    ranks.check();
    const auto& summaries =
        block.summaries.at(component < 0 ? block.summaries.size() - 1 : size_t(component));
    eachMacrocell(block.firstMacrocell, block.macrocells, [&, owner = partition](const Index3& m, size_t i) {
      if (m[0] >= macrocells_[0] || m[1] >= macrocells_[1] || m[2] >= macrocells_[2]) return;
      held.insert(blockOf(m));
      const Index3 firstCell{m[0] * kMacrocellSize, m[1] * kMacrocellSize, m[2] * kMacrocellSize};
      if (reader.partitionOf(firstCell) != owner) return;
      const gxy::Macrocell& s = summaries[i];
      const double largest = s.min > s.max ? 0
                                           : bound(volume.shift + volume.scale * double(s.min),
                                                   volume.shift + volume.scale * double(s.max));
      if (!std::isfinite(largest))
        throw Error("DensitySampler: the density is not finite, expected a finite one");
      told[homeOf(blockOf(m))].write(Told{blockOf(m), placeIn(m), largest});
    });
  }
  for (const int64_t block : held) wanted[homeOf(block)].write(block);
}

void MacrocellDensities::collect(const std::vector<Bytes>& heard, std::map<int64_t, Block>& collected,
                                 Writer& sums) const {
  for (const Bytes& message : heard) {
    Reader in(message, "bounds of macrocells");
    while (!in.rest().empty()) {
      const Told t = in.read<Told>();
      collected.try_emplace(t.block).first->second.bounds.at(t.place) = t.bound;
    }
  }
  for (auto& [number, block] : collected) {
    sum(number, block);
    sums.write(number).write(block.sums[kCells]);
  }
}

void MacrocellDensities::answer(const std::vector<Bytes>& asked, const std::map<int64_t, Block>& collected,
                                Messages& answers) const {
  for (size_t r = 0; r < asked.size(); r++) {
    Reader in(asked[r], "blocks of macrocells");
    while (!in.rest().empty()) {
      const auto number = in.read<int64_t>();
      answers[r].write(number).write(collected.at(number).bounds);
    }
  }
}

void MacrocellDensities::take(const std::vector<Bytes>& answered) {
  for (const Bytes& message : answered) {
    Reader in(message, "bounds of macrocells");
    while (!in.rest().empty()) {
      const auto number = in.read<int64_t>();
      Block& block = held_[number];
      block.bounds = in.read<std::array<double, kCells>>();
      sum(number, block);
    }
  }
}

void MacrocellDensities::takeSums(const std::vector<Bytes>& all) {
  std::vector<double> each(size_t(blocks_[0] * blocks_[1] * blocks_[2]), 0.0);
  for (const Bytes& message : all) {
    Reader in(message, "sums of blocks");
    while (!in.rest().empty()) {
      const auto number = size_t(in.read<int64_t>());
      each.at(number) = in.read<double>();
    }
  }
  sums_.assign(1, 0.0);
  for (const double s : each) sums_.push_back(sums_.back() + s);
  if (!std::isfinite(total()))
    throw Error("DensitySampler: the sum of the density is not finite, expected smaller densities");
}

std::optional<MacrocellDensities::Macrocell> MacrocellDensities::at(double place) const {
  // The last of those that begin at or before the place is not empty, but where rounding reaches the end.
  const auto find = [](const auto& sums, double x) {
    auto next = size_t(std::upper_bound(sums.begin(), sums.end(), x) - sums.begin());
    next = std::min(next, sums.size() - 1);
    while (next > 1 && sums[next] == sums[next - 1]) next--;
    return next - 1;
  };
  const auto block = int64_t(find(sums_, place));
  const auto found = held_.find(block);
  if (found == held_.end()) return std::nullopt;
  const size_t cell = find(found->second.sums, place - sums_[size_t(block)]);
  Macrocell out = macrocell(block, cell);
  out.bound = found->second.bounds[cell];
  return out;
}

}  // namespace gxy
