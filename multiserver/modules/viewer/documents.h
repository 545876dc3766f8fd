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

/// What is kept of a long document while its data are imported and rendered, `copies` times. Throws Error if there is no memory for it.
LedgerEntry roomFor(const State& state, Session& session, int64_t copies = 1);

}  // namespace gxy::viewer
