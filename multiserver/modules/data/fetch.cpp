// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/data/fetch.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <numeric>
#include <span>
#include <string>

#include "core/comm/error.h"
#include "core/data/gather.h"
#include "core/data/gather_mesh.h"
#include "core/io/write_dataset.h"
#include "multiserver/protocol/file_record.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/exchanges.h"

namespace gxy {

using FetchedJson = nlohmann::json;

/// Sends a part of an array to the client: its header, and its values.
using SendPart = std::function<void(const FetchedJson& header, std::span<const std::byte> values)>;

class Fetches {
 public:
  /// Keeps `send` for as long as the result lives, under the number of an exchange.
  std::shared_ptr<void> add(uint64_t exchange, SendPart send) {
    const std::lock_guard lock(mutex_);
    sends_[exchange] = std::move(send);
    return {nullptr, [this, exchange](void*) {
              const std::lock_guard lock(mutex_);
              sends_.erase(exchange);
            }};
  }
  SendPart find(uint64_t exchange) const {
    const std::lock_guard lock(mutex_);
    return sends_.at(exchange);
  }

 private:
  mutable std::mutex mutex_;
  std::map<uint64_t, SendPart> sends_;
};

namespace {

/// An array as its header tells it.
struct SentArray {
  FetchedJson header;  ///< `structure` or `field`, `type` and `components`
  int64_t tuples = 0, tupleBytes = 0;
};

void sendPart(const SentArray& array, int64_t first, std::span<const std::byte> values,
              const SendPart& send) {
  FetchedJson header = array.header;
  header["first"] = first;
  header["count"] = int64_t(values.size()) / array.tupleBytes;
  header["of"] = array.tuples;
  send(header, values);
}

/// Sends a whole array in parts.
void sendAll(const SentArray& array, std::span<const std::byte> values, const SendPart& send) {
  const auto tuple = size_t(array.tupleBytes);
  const size_t atOnce = std::max<size_t>(size_t(kSlabBytes) / tuple, 1) * tuple;
  if (values.empty()) return sendPart(array, 0, {}, send);
  for (size_t first = 0; first < values.size(); first += atOnce)
    sendPart(array, int64_t(first / tuple), values.subspan(first, std::min(atOnce, values.size() - first)),
             send);
}

template <class T>
void sendArray(FetchedJson header, const std::vector<T>& values, const SendPart& send) {
  sendAll({std::move(header), int64_t(values.size()), sizeof(T)}, std::as_bytes(std::span(values)), send);
}

FetchedJson structure(const char* name, const char* type, int components) {
  return {{"structure", name}, {"type", type}, {"components", components}};
}
FetchedJson field(const std::string& name, const char* type, int components) {
  return {{"field", name}, {"type", type}, {"components", components}};
}

/// A field of points. Its values stand together by points.
void sendField(const PointField& of, const SendPart& send) {
  const auto n = size_t(of.components);
  if (of.values.empty()) return;
  sendAll(
      {field(of.name, "float32", of.components), int64_t(of.values.size() / n), int64_t(n * sizeof(float))},
      std::as_bytes(std::span(of.values)), send);
}

/// On each rank.
struct FetchWork {
  uint64_t exchange = 0, key = 0, generation = 0;
  std::string tenant;

  void run(ServerRank& serverRank, const Fetches& fetches) const {
    Exchanges::Part part = serverRank.exchanges.join(exchange);
    Pin pin;
    std::shared_ptr<const Dataset> dataset;
    LedgerEntry memory;
    SendPart send;
    part.begin(0, 1, "fetch");
    agree(part.ranks, [&] {
      pin = serverRank.objects.pin(Key{key}, generation);
      dataset = pin.get<Dataset>();
      memory = serverRank.takeMemory(tenant, "fetch", gatheringBytes(*dataset, serverRank.rank() == 0));
      if (serverRank.rank() == 0) send = fetches.find(exchange);
    });
    if (dataset->volume)
      sendVolume(*dataset, part.ranks, send);
    else if (dataset->mesh)
      sendMesh(*dataset, part.ranks, send);
    else
      sendGeometry(*dataset, part.ranks, send);
  }

  static void sendVolume(const Dataset& d, Collectives& ranks, const SendPart& send) {
    const Volume& volume = *d.volume;
    const Index3 n = gatheredPoints(volume.grid);
    const ScalarType type = gatheredType(volume);
    const SentArray array{field(arrayName(d), nameOf(type), volume.components), n[0] * n[1] * n[2],
                          int64_t(volume.components) * int64_t(bytesOf(type))};
    gatherSlices(volume, *d.partitioning, ranks, kSlabBytes,
                 [&](int64_t slice, std::span<const std::byte> values) {
                   sendPart(array, slice * n[0] * n[1], values, send);
                 });
  }

  static void sendMesh(const Dataset& d, Collectives& ranks, const SendPart& send) {
    const Mesh& mesh = *d.mesh;
    const GatheredMesh all = gatherMesh(mesh, *d.partitioning, ranks);
    agree(ranks, [&] {
      if (!send) return;
      sendArray(structure("points", "float64", 3), all.points, send);
      sendArray(structure("types", "uint8", 1), all.types, send);
      sendArray(structure("offsets", "uint64", 1), all.offsets, send);
      sendArray(structure("connectivity", "uint32", 1), all.connectivity, send);
      const ScalarType type = gatheredType(mesh);
      const int64_t tuple = int64_t(mesh.components) * int64_t(bytesOf(type));
      sendAll({field(arrayName(d), nameOf(type), mesh.components), int64_t(all.values.size()) / tuple, tuple},
              all.values, send);
    });
  }

  static void sendGeometry(const Dataset& d, Collectives& ranks, const SendPart& send) {
    const GeometryBlock all = gatherGeometry(*d.geometry, ranks);
    agree(ranks, [&] {
      if (!send) return;
      const GeometryKind kind = d.geometry->kind;
      sendArray(structure("points", "float64", 3), all.points, send);
      sendArray(structure("ids", "uint64", 1), all.ids, send);
      if (!all.normals.empty()) sendArray(structure("normals", "float32", 3), all.normals, send);
      if (kind == GeometryKind::PathLines) sendArray(structure("segments", "uint32", 2), all.segments, send);
      if (kind == GeometryKind::Triangles)
        sendArray(structure("triangles", "uint32", 3), all.triangles, send);
      const std::string array = arrayName(d);
      if (!all.values.empty()) sendArray(field(array, "float32", 1), all.values, send);
      for (const PointField& f : all.fields)
        if (!repeatsValues(all, f, array)) sendField(f, send);
      if (!all.colors.empty())
        sendArray(field(d.array.empty() ? "colors" : d.array, "float32", 3), all.colors, send);
      if (!d.radiusArray.empty() && !all.radiusValues.empty())
        sendArray(field(d.radiusArray, "float32", 1), all.radiusValues, send);
    });
  }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FetchWork, exchange, key, generation, tenant)

constexpr const char* kFetchWork = "data.fetch";

}  // namespace

std::shared_ptr<Fetches> addFetchWork(Registration& registration) {
  auto fetches = std::make_shared<Fetches>();
  ServerRank& serverRank = registration.serverRank();
  registration.work(
      kFetchWork,
      [&serverRank, fetches](const Work::Call& call) -> FetchedJson {
        call.parameters.get<FetchWork>().run(serverRank, *fetches);
        return nullptr;
      },
      Work::Runs::Long);
  return fetches;
}

FetchedJson fetchDataset(Fetches& fetches, Request& request, protocol::Arguments arguments) {
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  ServerRank& serverRank = request.session().serverRank();
  const std::string& tenant = request.session().tenant();
  serverRank.datasets->get(tenant, name);  // before it waits for its turn
  const auto exchange = serverRank.exchanges.beginLong(request);
  // Pinned once it is its turn: until then a publisher may need the room.
  const auto [named, pin] = serverRank.datasets->getPinned(tenant, name);
  int64_t sent = 0;
  const auto kept = fetches.add(*exchange, [&](const FetchedJson& header, std::span<const std::byte> values) {
    if (!request.session().outbox().file(request.id(), protocol::fileRecord(header, values),
                                         [&] { return request.cancelled(); }))
      throw Error("cancelled");
    sent += int64_t(values.size());
  });
  FetchedJson parameters;
  to_json(parameters, FetchWork{*exchange, named.key.value, named.generation, tenant});
  serverRank.callAll(kFetchWork, parameters);

  const std::shared_ptr<const Dataset> dataset = pin.get<Dataset>();
  FetchedJson reply{{"type", named.type}, {"generation", named.generation}, {"bytes", sent}};
  if (dataset->volume) {
    const Grid& grid = dataset->volume->grid;
    const Index3 n = gatheredPoints(grid);
    const glm::dvec3 origin = grid.origin + grid.spacing * (grid.rim ? 1.0 : 0.0);
    reply["dimensions"] = n;
    reply["origin"] = {origin.x, origin.y, origin.z};
    reply["spacing"] = {grid.spacing.x, grid.spacing.y, grid.spacing.z};
    reply["centers of cells"] = grid.rim;
  } else if (dataset->mesh) {
    const MeshReport& report = dataset->mesh->report;
    reply["points"] = report.points;
    reply["cells"] = std::accumulate(report.cells.begin(), report.cells.end(), uint64_t(0));
    reply["values"] = dataset->mesh->ofCells ? "cells" : "points";
  } else {
    reply["primitives"] = dataset->geometry->primitives;
  }
  if (std::isfinite(dataset->time)) reply["time"] = dataset->time;
  reply["text"] = name + ": " + std::to_string(sent) + " bytes";
  return reply;
}

}  // namespace gxy
