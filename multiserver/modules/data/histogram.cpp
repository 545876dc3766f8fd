// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/data/histogram.h"

#include <algorithm>
#include <cmath>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/scene/scene.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/filter_runs.h"

namespace gxy {

using nlohmann::json;

namespace {

constexpr int kBins = 256, kMostBins = 4096, kMostComponents = 1024;
constexpr int kTries = 3;  // where new generations keep coming

std::optional<int> integerOf(protocol::Arguments& arguments, const char* what, int least, int most) {
  const auto number = arguments.number();
  if (!number) return std::nullopt;
  if (*number < least || *number > most || *number != std::floor(*number))
    arguments.fail(std::string(what) + " is an integer from " + std::to_string(least) + " to " +
                   std::to_string(most));
  return int(*number);
}

NamedDataset named(const Request& request, const std::string& name) {
  const auto found = request.session().serverRank().datasets->find(request.session().tenant(), name);
  if (!found)
    throw Error("dataset " + inQuotes(name) + ": there is none that you see; `list` names what there is");
  return *found;
}

json made(Request& request, const std::string& name, const Histograms::Of& of) {
  DatasetSpec entry;
  entry.filter = "Statistics";
  entry.inputs = {{"field", {name}}};
  json properties{{"histogram", of.bins}};
  if (of.component) properties["component"] = *of.component;
  entry.properties = properties.dump();
  const json told =
      request.session().serverRank().filterRuns->make(request, {entry}, Scope::Private).at(0).told;
  json result =
      told.contains("histogram") ? told.at("histogram") : json{{"range", nullptr}, {"counts", json::array()}};
  for (const char* key : {"count", "no data"}) result[key] = told.at(key);
  return result;
}

}  // namespace

std::optional<json> Histograms::find(const Of& of) const {
  const std::lock_guard lock(mutex_);
  for (const auto& [what, histogram] : kept_)
    if (what == of) return histogram;
  return std::nullopt;
}

void Histograms::keep(const Of& of, json histogram) {
  const std::lock_guard lock(mutex_);
  kept_.emplace_back(of, std::move(histogram));
  bins_ += of.bins;
  for (; bins_ > kMostBins; kept_.pop_front()) bins_ -= kept_.front().first.bins;
}

json histogram(Histograms& histograms, Request& request, protocol::Arguments arguments) {
  const std::string name = arguments.expectWord();
  Histograms::Of of;
  of.bins = integerOf(arguments, "BINS", 1, kMostBins).value_or(kBins);
  of.component = integerOf(arguments, "COMPONENT", 0, kMostComponents - 1);
  arguments.expectEnd();
  // The filter reads what the name means when it begins. Only if that is the same before and after is it known.
  for (int tries = 1;; tries++) {
    const NamedDataset before = named(request, name);
    of.object = before.key;
    of.generation = before.generation;
    std::optional<json> result = histograms.find(of);
    if (!result) {
      result = made(request, name, of);
      const NamedDataset after = named(request, name);
      const bool same = after.key == before.key && after.generation == before.generation;
      if (same) histograms.keep(of, *result);
      if (!same && tries < kTries) continue;
    }
    (*result)["generation"] = of.generation;
    return *result;
  }
}

}  // namespace gxy
