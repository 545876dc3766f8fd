// SPDX-License-Identifier: Apache-2.0
// Module `example`: the two examples of the Galaxy paper's section 3. docs/modules.md walks through it.
#include <algorithm>
#include <cstring>

#include "core/comm/error.h"
#include "core/data/bricks.h"
#include "core/data/complete_volume.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/module.h"

namespace {

using namespace gxy;
using nlohmann::json;

// --- 1. Global information: the data range ---------------------------------------------------------------------------

/// On each rank: the range of what it owns of a dataset.
struct RangeWork {
  static constexpr const char* name = "example.range";
  static constexpr Work::Runs runs = Work::Runs::Long;  // it looks at all samples
  uint64_t exchange = 0, key = 0, generation = 0;

  json action(ServerRank& serverRank, const Work::Call&) const {
    Exchanges::Part part = serverRank.exchanges.join(exchange);
    const Pin pin = serverRank.objects.pin(Key{key}, generation);
    const auto dataset = pin.get<Dataset>();
    Range range;
    if (dataset->geometry) range = rangeOf(dataset->geometry->block);
    if (const Volume* volume = dataset->volume.get())
      for (const auto& [partition, block] : volume->blocks) {
        part.ranks.check();  // throws when the request has been cancelled
        for (const Range& r : statisticsOf(block, volume->stored, volume->components).ranges)
          if (!r.empty())
            range.extend({volume->shift + volume->scale * r.min, volume->shift + volume->scale * r.max});
      }
    return range.empty() ? json(nullptr) : json{range.min, range.max};
  }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RangeWork, exchange, key, generation)

/// The driver: broadcasts the work, waits until the results of all ranks have come, and merges them.
json range(Request& request) {
  ServerRank& serverRank = request.session().serverRank();
  protocol::Arguments arguments(request.arguments(), "range NAME");
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  const auto exchange = serverRank.exchanges.beginLong(request);  // waits for its turn among the tenant's
  // pinned on this rank, the generation stays on all of them
  const auto [dataset, pin] = serverRank.datasets->getPinned(request.session().tenant(), name);
  Range all;
  for (const json& part : callAll(serverRank, RangeWork{*exchange, dataset.key.value, dataset.generation}))
    if (!part.is_null()) all.extend({part[0].get<double>(), part[1].get<double>()});
  if (all.empty()) return {{"range", nullptr}, {"text", "no values"}};
  return {{"range", {all.min, all.max}}, {"text", json(all.min).dump() + " " + json(all.max).dump()}};
}

// --- 2. Data parallel: a filter that makes its destination where the source is ----------------------------------------

/// On each rank: a volume of the same grid, 1 where the source lies in [least, largest], else 0.
struct ThresholdWork {
  static constexpr const char* name = "example.threshold";
  static constexpr Work::Runs runs = Work::Runs::Long;
  uint64_t exchange = 0, source = 0, generation = 0;
  json items;  ///< what is published
  double least = 0, largest = 0;
  std::string tenant, sourceName;

  json action(ServerRank& serverRank, const Work::Call&) const {
    Exchanges::Part part = serverRank.exchanges.join(exchange);
    RankCollectives& ranks = part.ranks;
    part.begin(0, 2, "threshold");
    Publication publication = serverRank.datasets->join(items, ranks);
    publication.reserve();
    const auto made = std::make_shared<Dataset>();
    const auto volume = std::make_shared<Volume>();
    agree(ranks, [&] {  // what may fail on one rank fails on all
      const Pin pin = serverRank.objects.pin(Key{source}, generation);
      const auto from = pin.get<Dataset>();
      if (!from->volume || from->volume->components != 1)
        throw Error("threshold: expected a volume with one component");
      made->partitioning = from->partitioning;
      made->origins = from->origins;
      made->time = from->time;
      made->provenance = {name,
                          1,
                          json{{"least", least}, {"largest", largest}}.dump(),
                          {{sourceName, Key{source}, generation}}};
      volume->name = "threshold";
      volume->grid = from->volume->grid;
      volume->stored = ScalarType::UInt8;
      for (const auto& [partition, block] : from->volume->blocks)
        made->bytes += int64_t(Bricks(block.extent.points).count());
      made->memory = serverRank.takeMemory(tenant, "volume", made->bytes);
      for (const auto& [partition, block] : from->volume->blocks)
        volume->blocks[partition] = thresholded(*from->volume, block, [&](double fraction) {
          ranks.check();
          ranks.done((double(volume->blocks.size()) + fraction) / double(from->volume->blocks.size()));
        });
    });
    part.begin(1, 2, "summaries", true);
    completeVolume(*volume, *made->partitioning, ranks);
    made->volume = volume;
    publication.stage(0, Payload(std::shared_ptr<const Dataset>(made)));
    serverRank.datasets->publish(publication, exchange);
    return nullptr;
  }

  VolumeBlock thresholded(const Volume& from, const VolumeBlock& block,
                          const std::function<void(double)>& done) const {
    VolumeBlock out;
    out.extent = block.extent;
    out.samples.resize(size_t(block.extent.count()));
    const Index3& n = block.extent.points;
    const Bricks bricks(n);  // where the points of a complete block lie
    size_t i = 0;            // those of a new one come x fastest
    withType(from.stored, [&](auto stored) {
      for (int64_t z = 0; z < n[2]; z++) {
        done(double(z) / double(n[2]));
        for (int64_t y = 0; y < n[1]; y++)
          for (int64_t x = 0; x < n[0]; x++) {
            std::memcpy(&stored, &block.samples[bricks(x, y, z) * sizeof stored], sizeof stored);
            const double value = from.shift + from.scale * double(stored);
            out.samples[i++] = std::byte(value >= least && value <= largest);
          }
      }
    });
    return out;
  }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ThresholdWork, exchange, source, generation, items, least, largest, tenant,
                                   sourceName)

/// The driver: takes the name of the destination, which the work publishes.
json threshold(Request& request) {
  ServerRank& serverRank = request.session().serverRank();
  const std::string& tenant = request.session().tenant();
  protocol::Arguments arguments(request.arguments(), "threshold NAME NEW LEAST LARGEST");
  const std::string from = arguments.expectWord(), name = arguments.expectWord();
  const auto least = arguments.number(), largest = arguments.number();
  if (!least || !largest) arguments.fail("LEAST and LARGEST are numbers");
  arguments.expectEnd();
  checkDatasetName(name);
  const auto exchange = serverRank.exchanges.beginLong(request);
  const auto names = serverRank.datasets->begin(request, *exchange, "threshold", Scope::Private,
                                                {{name, DatasetType::Volume}});
  // Pinned once the name is there: whoever has it may publish what the source is, which needs the room of what is pinned.
  const auto [source, pin] = serverRank.datasets->getPinned(tenant, from);
  try {
    callAll(serverRank, ThresholdWork{*exchange, source.key.value, source.generation, names->items(), *least,
                                      *largest, tenant, from});
  } catch (const Error&) {
    serverRank.datasets->check(*names);
    throw;
  }
  return nullptr;
}

}  // namespace

GALAXY_MODULE(registration) {
  registration.work<RangeWork>();
  registration.work<ThresholdWork>();
  registration.verb({"range", "NAME", "Least and largest value, found on all ranks.", Order::InTurn, range});
  registration.verb({"threshold", "NAME NEW LEAST LARGEST", "A volume that is 1 where NAME lies between.",
                     Order::Aside, threshold});
}
