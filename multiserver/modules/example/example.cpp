// SPDX-License-Identifier: Apache-2.0
// Module `example`: the two examples of the Galaxy paper's section 3. docs/modules.md walks through it.
#include "core/analysis/pointwise.h"
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
    if (dataset->mesh) range = dataset->range();
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

/// A volume of the same grid, 1 where the source lies in [least, largest], else 0.
struct Threshold {
  double least = 0, largest = 0;

  static FilterInfo info() {
    return {"Threshold",
            1,
            "1 where the source lies between two values, else 0.",
            {{"source", kVolumes, "One component."}},
            DatasetType::Volume};
  }
  static std::vector<KeyRow<Threshold>> properties() {
    return {numberKey("least", &Threshold::least, kAny, "The least value that becomes 1.").require(),
            numberKey("largest", &Threshold::largest, kAny, "The largest value that becomes 1.").require()};
  }
  FilterResult run(FilterRun& run) const {
    return pointwise(run, run.input("source"), "threshold",
                     [this](double value) { return value >= least && value <= largest; });
  }
};

}  // namespace

GALAXY_MODULE(registration) {
  registration.work<RangeWork>();
  registration.filter<Threshold>();
  registration.verb(
      {"range", "NAME", "Least and largest value, found on all ranks.", Order::InTurn, range, Effect::Looks});
}
