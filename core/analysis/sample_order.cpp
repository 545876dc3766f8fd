// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/sample_order.h"

#include <algorithm>
#include <cstring>

#include "core/comm/error.h"

namespace gxy {

namespace {

constexpr size_t kProbes = 32;  // keys that each rank tells to choose the parts by

template <class T>
Bytes packed(std::span<const T> values) {
  const auto bytes = std::as_bytes(values);
  return {bytes.begin(), bytes.end()};
}

template <class T>
std::vector<T> unpacked(const Bytes& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

// The first keys of the parts of all ranks but rank 0.
std::vector<SampleKey> splitters(std::span<const SampleKey> mine, Collectives& ranks) {
  std::vector<SampleKey> probes;
  const size_t n = std::min(kProbes, mine.size());
  for (size_t i = 0; i < n; i++) probes.push_back(mine[(2 * i + 1) * mine.size() / (2 * n)]);
  std::vector<SampleKey> all;
  for (const Bytes& theirs : ranks.allGather(packed<SampleKey>(probes)))
    for (const SampleKey& key : unpacked<SampleKey>(theirs)) all.push_back(key);
  std::sort(all.begin(), all.end());
  std::vector<SampleKey> first;
  for (int r = 1; r < ranks.size() && !all.empty(); r++)
    first.push_back(all[all.size() * size_t(r) / size_t(ranks.size())]);
  return first;
}

// Gives each rank its part of this rank's keys.
std::vector<Bytes> partsOf(std::span<const SampleKey> mine, std::span<const SampleKey> first, int ranks) {
  std::vector<Bytes> parts;
  auto from = mine.begin();
  for (int r = 0; r < ranks; r++) {
    const auto to =
        size_t(r) < first.size() ? std::lower_bound(from, mine.end(), first[size_t(r)]) : mine.end();
    parts.push_back(packed<SampleKey>({from, to}));
    from = to;
  }
  return parts;
}

}  // namespace

std::vector<uint64_t> placesAmong(std::span<const SampleKey> mine, Collectives& ranks) {
  const std::vector<SampleKey> first = splitters(mine, ranks);
  const std::vector<Bytes> parts = ranks.allToAll(partsOf(mine, first, ranks.size()));
  struct From {
    SampleKey key;
    uint32_t rank;
    uint32_t index;
  };
  std::vector<From> all;
  std::vector<std::vector<uint64_t>> places(parts.size());
  for (size_t r = 0; r < parts.size(); r++) {
    const std::vector<SampleKey> keys = unpacked<SampleKey>(parts[r]);
    for (size_t i = 0; i < keys.size(); i++) all.push_back({keys[i], uint32_t(r), uint32_t(i)});
    places[r].resize(keys.size());
  }
  std::sort(all.begin(), all.end(), [](const From& a, const From& b) { return a.key < b.key; });
  uint64_t place = 0;
  const std::vector<uint64_t> counts = gatherCounts(ranks, all.size());
  for (int r = 0; r < ranks.rank(); r++) place += counts[size_t(r)];
  for (const From& one : all) places[one.rank][one.index] = place++;
  std::vector<Bytes> answers;
  for (const auto& theirs : places) answers.push_back(packed<uint64_t>(theirs));
  std::vector<uint64_t> result;
  for (const Bytes& answer : ranks.allToAll(std::move(answers)))
    for (const uint64_t p : unpacked<uint64_t>(answer)) result.push_back(p);
  return result;
}

}  // namespace gxy
