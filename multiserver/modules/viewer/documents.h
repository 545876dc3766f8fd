// SPDX-License-Identifier: Apache-2.0
// State documents that requests bring with them.
#pragma once
#include <string>
#include <vector>

#include "core/scene/scene.h"
#include "core/space/ledger.h"
#include "multiserver/server/session.h"

namespace gxy::viewer {

/// Reads and makes what a document has and the request's tenant has not. Returns what of the files is not used. Waits. Throws Error.
std::vector<std::string> importMissing(Request& request, const std::vector<DatasetSpec>& specs);

/// Returns a text for people, with a line for each.
std::string linesOf(const std::vector<std::string>& warnings);

/// What is kept of a long document while its data are imported and rendered. Throws Error if there is no memory for it.
LedgerEntry roomFor(const State& state, Session& session);

/// Memory of a tenant for what a request keeps, and learns of piece by piece. It is given back with this object. For one thread.
class KeptRoom {
 public:
  explicit KeptRoom(Session& session) : session_(session) {}
  /// So many bytes more are to be taken.
  void add(int64_t bytes) { pending_ += bytes; }
  /// Takes what has been added, once this is long. Throws NoRoom if there is no memory for it.
  void take();
  /// Adds and takes what is missing for `bytes` in all.
  void atLeast(int64_t bytes);

 private:
  Session& session_;
  std::vector<LedgerEntry> taken_;
  int64_t bytes_ = 0;  ///< sum of taken_
  int64_t pending_ = 0;
};

}  // namespace gxy::viewer
