// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/viewer/documents.h"

#include <algorithm>
#include <utility>

#include "multiserver/rendering/cost.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/filter_runs.h"

namespace gxy::viewer {

namespace {
constexpr int64_t kShort = 64 << 10;  // Less is not worth an entry.
}

std::vector<std::string> importMissing(Request& request, const std::vector<DatasetSpec>& specs) {
  Datasets::Import what;
  what.specs = specs;
  what.onlyMissing = true;
  if (specs.empty()) return {};
  return request.session().serverRank().filterRuns->importAndMake(request, what);
}

std::string linesOf(const std::vector<std::string>& warnings) {
  std::string text;
  for (const std::string& w : warnings) text += (text.empty() ? "warning: " : "\nwarning: ") + w;
  return text;
}

LedgerEntry roomFor(const State& state, Session& session) {
  const int64_t bytes = bytesOf(state);
  return bytes > kShort ? session.serverRank().takeMemory(session.tenant(), "documents", bytes)
                        : LedgerEntry();
}

void KeptRoom::take() {
  if (pending_ <= kShort) return;
  taken_.push_back(session_.serverRank().takeMemory(session_.tenant(), "documents", pending_));
  bytes_ += std::exchange(pending_, 0);
}

void KeptRoom::atLeast(int64_t bytes) {
  add(std::max<int64_t>(bytes - bytes_ - pending_, 0));
  take();
}

}  // namespace gxy::viewer
