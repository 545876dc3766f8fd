// SPDX-License-Identifier: Apache-2.0
#include "core/io/collectives.h"

#include <cstring>
#include <string>

#include "core/comm/error.h"
#include "core/comm/error_text.h"

namespace gxy {
namespace {

template <class T>
std::vector<std::vector<T>> gather(Collectives& ranks, std::span<const T> mine) {
  Bytes bytes(mine.size_bytes());
  if (!bytes.empty()) std::memcpy(bytes.data(), mine.data(), bytes.size());
  std::vector<std::vector<T>> all;
  for (const Bytes& theirs : ranks.allGather(std::move(bytes))) {
    if (theirs.size() != mine.size_bytes())
      throw Error("collective operation: ranks disagree about its size");
    all.emplace_back(mine.size());
    if (!theirs.empty()) std::memcpy(all.back().data(), theirs.data(), theirs.size());
  }
  return all;
}

}  // namespace

void agree(Collectives& ranks, const std::function<void()>& work) {
  std::string failure;
  bool failed = false;
  try {
    work();
  } catch (const std::exception& e) {
    failed = true;
    failure = textOf(e);
  }
  // An empty message means success, so a failure is marked by a first byte.
  Bytes message(failed ? 1 + failure.size() : 0);
  if (failed && !failure.empty()) std::memcpy(message.data() + 1, failure.data(), failure.size());
  const std::vector<Bytes> all = ranks.allGather(std::move(message));
  for (size_t rank = 0; rank < all.size(); ++rank) {
    if (all[rank].empty()) continue;
    const std::string text(reinterpret_cast<const char*>(all[rank].data()) + 1, all[rank].size() - 1);
    throw Error(all.size() > 1 ? "rank " + std::to_string(rank) + ": " + text : text);
  }
}

void mergeRanges(Collectives& ranks, std::span<Range> ranges) {
  for (const auto& theirs : gather<Range>(ranks, ranges))
    for (size_t i = 0; i < theirs.size(); ++i) ranges[i].extend(theirs[i]);
}

void mergeBox(Collectives& ranks, Box& box) {
  for (const auto& theirs : gather<Box>(ranks, std::span<const Box>(&box, 1))) box.extend(theirs[0]);
}

std::vector<uint64_t> gatherCounts(Collectives& ranks, uint64_t mine) {
  std::vector<uint64_t> counts;
  for (const auto& theirs : gather<uint64_t>(ranks, std::span<const uint64_t>(&mine, 1)))
    counts.push_back(theirs[0]);
  return counts;
}

}  // namespace gxy
