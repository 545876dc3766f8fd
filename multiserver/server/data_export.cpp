// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/data_export.h"

#include <optional>

#include "core/io/write_dataset.h"
#include "multiserver/server/exchanges.h"
#include "multiserver/server/module.h"

namespace gxy {
namespace {

/// On each rank.
struct ExportWork {
  static constexpr const char* name = "data.export";
  static constexpr Work::Runs runs = Work::Runs::Long;
  uint64_t exchange = 0, key = 0, generation = 0;
  std::string tenant, path;

  nlohmann::json action(ServerRank& serverRank, const Work::Call&) const {
    Exchanges::Part part = serverRank.exchanges.join(exchange);
    Pin pin;
    std::shared_ptr<const Dataset> dataset;
    LedgerEntry memory;
    std::optional<DataFolders::NewFile> file;
    part.begin(0, 1, "export");
    agree(part.ranks, [&] {
      pin = serverRank.objects.pin(Key{key}, generation);
      dataset = pin.get<Dataset>();
      memory = serverRank.takeMemory(tenant, "export", gatheringBytes(*dataset, serverRank.rank() == 0));
      if (serverRank.rank() == 0) file.emplace(serverRank.folders, path);
    });
    writeDataset(*dataset, part.ranks, file ? file->partial() : std::string());
    agree(part.ranks, [&] {
      if (file) file->finish();
    });
    return nullptr;
  }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ExportWork, exchange, key, generation, tenant, path)

}  // namespace

void addExportWork(ServerRank& serverRank) {
  serverRank.work.add(
      ExportWork::name,
      [&serverRank](const Work::Call& call) -> nlohmann::json {
        return call.parameters.get<ExportWork>().action(serverRank, call);
      },
      ExportWork::runs);
}

void exportData(ServerRank& serverRank, uint64_t exchange, const std::string& tenant,
                const ObjectGeneration& data, const std::string& path) {
  callAll(serverRank, ExportWork{exchange, data.key.value, data.generation, tenant, path});
}

}  // namespace gxy
