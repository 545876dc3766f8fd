// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/viewer/documents.h"

#include "multiserver/rendering/cost.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/filter_runs.h"

namespace gxy::viewer {

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

LedgerEntry roomFor(const State& state, Session& session, int64_t copies) {
  constexpr int64_t kShort = 64 << 10;
  const int64_t bytes = bytesOf(state) * copies;
  return bytes > kShort ? session.serverRank().takeMemory(session.tenant(), "documents", bytes)
                        : LedgerEntry();
}

}  // namespace gxy::viewer
