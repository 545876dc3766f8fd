// SPDX-License-Identifier: Apache-2.0
#include "core/comm/collectives.h"

#include <functional>
#include <string>

#include "core/comm/error_text.h"

namespace gxy {

Bytes Collectives::allReduce(Bytes mine, const Collective::Fold& fold) {
  std::vector<Bytes> all = allGather(std::move(mine));
  for (size_t rank = 1; rank < all.size(); ++rank) fold(all[0], all[rank]);
  return std::move(all[0]);
}

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

std::vector<uint64_t> gatherCounts(Collectives& ranks, uint64_t mine) {
  std::vector<uint64_t> counts;
  for (const auto& theirs : gatherValues(ranks, std::span<const uint64_t>(&mine, 1)))
    counts.push_back(theirs[0]);
  return counts;
}

uint64_t sumOfCounts(Collectives& ranks, uint64_t mine) {
  reduceValues(ranks, std::span(&mine, 1), std::plus<>());
  return mine;
}

}  // namespace gxy
