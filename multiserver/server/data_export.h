// SPDX-License-Identifier: Apache-2.0
// Writes datasets of the data space to files in data folders.
#pragma once
#include <cstdint>
#include <string>

#include "core/space/objects.h"
#include "multiserver/server/server_rank.h"

namespace gxy {

/// Registers the work of exportData() on a rank.
void addExportWork(ServerRank& serverRank);

/// Rank 0: writes one generation of a dataset, which the caller keeps pinned, to a file at `path`, which DataFolders::toWrite() has
/// returned and checkFileFor() has accepted. Rank 0 gathers it, in memory of the tenant. The file is complete, or what was there before
/// stays. `exchange` is one of Exchanges::beginLong(). Waits for all ranks. Throws Error, also when the exchange is cancelled.
void exportData(ServerRank& serverRank, uint64_t exchange, const std::string& tenant,
                const ObjectGeneration& data, const std::string& path);

}  // namespace gxy
