// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/data/export.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/comm/error.h"
#include "core/data/gather.h"
#include "core/io/write_geometry.h"
#include "core/io/write_volume.h"
#include "core/scene/dataset_type.h"
#include "multiserver/modules/data/gathering.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/exchanges.h"

namespace gxy {
namespace {

using nlohmann::json;

/// On each rank.
struct ExportWork {
  static constexpr const char* name = "data.export";
  static constexpr Work::Runs runs = Work::Runs::Long;
  uint64_t exchange = 0, key = 0, generation = 0;
  std::string tenant, path;

  json action(ServerRank& serverRank, const Work::Call&) const {
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
    if (dataset->volume)
      writeVolume(*dataset, part.ranks, file);
    else
      writeGeometryOf(*dataset, part.ranks, file);
    agree(part.ranks, [&] {
      if (file) file->finish();
    });
    return nullptr;
  }

  static void writeVolume(const Dataset& d, Collectives& ranks,
                          const std::optional<DataFolders::NewFile>& file) {
    const Volume& volume = *d.volume;
    std::optional<VolumeWriter> writer;
    agree(ranks, [&] {
      if (!file) return;
      ArrayInfo array{arrayName(d), gatheredType(volume), volume.components, {}, volume.grid.rim};
      writer.emplace(file->partial(), volume.grid, std::vector{std::move(array)});
    });
    gatherSlices(volume, *d.partitioning, ranks, kSlabBytes,
                 [&](int64_t first, std::span<const std::byte> values) { writer->write(0, first, values); });
  }

  static void writeGeometryOf(const Dataset& d, Collectives& ranks,
                              const std::optional<DataFolders::NewFile>& file) {
    const GeometryBlock all = gatherGeometry(*d.geometry, ranks);
    agree(ranks, [&] {
      if (file) writeGeometry(file->partial(), all, d.geometry->kind, arrayName(d));
    });
  }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ExportWork, exchange, key, generation, tenant, path)

/// The extensions of files that hold a type.
std::vector<std::string> extensionsFor(DatasetType type) {
  switch (type) {
    case DatasetType::Volume:
      return {".vti"};
    case DatasetType::Particles:
      return {".vtp", ".vtu", ".csv"};
    case DatasetType::PathLines:
      return {".vtp", ".vtu"};
    case DatasetType::Triangles:
      break;
  }
  return {".vtp", ".vtu", ".ply", ".stl"};
}

void checkExtension(const std::string& file, const NamedDataset& dataset) {
  const std::vector<std::string> known = extensionsFor(*datasetTypeNamed(dataset.type));
  std::string list;
  for (const std::string& extension : known) {
    if (file.size() > extension.size() && file.ends_with(extension)) return;
    list += (list.empty() ? "" : ", ") + extension;
  }
  throw Error("export: file " + inQuotes(file) + " for dataset " + inQuotes(dataset.name) + ", which is " +
              dataset.type + ": expected a name that ends with one of " + list);
}

}  // namespace

void addExportWork(Registration& registration) { registration.work<ExportWork>(); }

json exportDataset(Request& request, protocol::Arguments arguments) {
  const std::string name = arguments.expectWord(), file = arguments.expectWord();
  arguments.expectEnd();
  ServerRank& serverRank = request.session().serverRank();
  const std::string& tenant = request.session().tenant();
  checkExtension(file, serverRank.datasets->get(tenant, name));
  const std::string path = serverRank.folders.toWrite(file);
  const auto exchange = serverRank.exchanges.beginLong(request);
  // Pinned once it is its turn: until then a publisher may need the room.
  const auto [dataset, pin] = serverRank.datasets->getPinned(tenant, name);
  checkExtension(file, dataset);
  callAll(serverRank, ExportWork{*exchange, dataset.key.value, dataset.generation, tenant, path});
  return {{"file", path},
          {"generation", dataset.generation},
          {"bytes", std::filesystem::file_size(path)},
          {"text", path}};
}

}  // namespace gxy
