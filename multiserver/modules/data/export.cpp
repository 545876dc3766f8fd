// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/data/export.h"

#include <filesystem>
#include <string>

#include "core/comm/error.h"
#include "core/io/write_dataset.h"
#include "multiserver/server/data_export.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/exchanges.h"

namespace gxy {
namespace {

/// `pinned`: null before the dataset's turn.
void checkFile(const std::string& file, const NamedDataset& dataset, const Dataset* pinned) {
  const std::string what = "dataset " + inQuotes(dataset.name);
  try {
    if (pinned)
      checkFileFor(*pinned, file, what);
    else
      checkFileFor(geometryKindOf(*datasetTypeNamed(dataset.type)), file, what);
  } catch (const Error& e) {
    throw Error(std::string("export: ") + e.what());
  }
}

}  // namespace

nlohmann::json exportDataset(Request& request, protocol::Arguments arguments) {
  const std::string name = arguments.expectWord(), file = arguments.expectWord();
  arguments.expectEnd();
  ServerRank& serverRank = request.session().serverRank();
  const std::string& tenant = request.session().tenant();
  checkFile(file, serverRank.datasets->get(tenant, name), nullptr);
  const std::string path = serverRank.folders.toWrite(file);
  const auto exchange = serverRank.exchanges.beginLong(request);
  // Pinned once it is its turn: until then a publisher may need the room.
  const auto [dataset, pin] = serverRank.datasets->getPinned(tenant, name);
  checkFile(file, dataset, pin.get<Dataset>().get());
  exportData(serverRank, *exchange, tenant, {dataset.key, dataset.generation}, path);
  return {{"file", path},
          {"generation", dataset.generation},
          {"bytes", std::filesystem::file_size(path)},
          {"text", path}};
}

}  // namespace gxy
