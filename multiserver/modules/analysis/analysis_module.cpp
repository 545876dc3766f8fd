// SPDX-License-Identifier: Apache-2.0
// Module `analysis`: data made of data.
#include "core/comm/error.h"
#include "core/scene/filter_schema.h"
#include "multiserver/modules/analysis/watches.h"
#include "multiserver/server/filter_runs.h"
#include "multiserver/server/module.h"

namespace {

using namespace gxy;
using nlohmann::json;

// What a filter told, for people: a line for each dataset or each filter without one.
std::string textOf(const DatasetSpec& entry, const json& told) {
  std::string text = entry.name.empty() ? entry.filter : entry.name;
  for (const auto& [key, value] : told.items())
    if (key != "name")
      text += ", " + key + " " + (value.is_string() ? value.get<std::string>() : value.dump());
  return text;
}

json make(Request& request) {
  protocol::Arguments arguments(request.arguments(), "make [shared] ENTRY");
  const Scope scope = arguments.taken("shared") ? Scope::Shared : Scope::Private;
  StateFile file = DocumentReader(request).datasets(arguments.expectJsonOrList(), "make");
  const std::vector<DatasetSpec>& entries = file.state.datasets;
  for (const DatasetSpec& entry : entries)
    if (entry.filter.empty())
      throw Error("make: dataset " + inQuotes(entry.name) +
                  " has no `filter`; expected entries with filters, `import` reads files");
  json results = json::array();
  std::string text;
  for (const auto& made : request.session().serverRank().filterRuns->make(request, entries, scope)) {
    text += (text.empty() ? "" : "\n") + textOf(entries[made.entry], made.told);
    results.push_back(made.told);
  }
  for (const std::string& w : file.warnings) text += "\nwarning: " + w;
  return {{"results", results}, {"warnings", file.warnings}, {"text", text}};
}

json filters(Request& request) {
  protocol::Arguments(request.arguments(), "filters").expectEnd();
  return described(request.session().serverRank().filters);
}

std::shared_ptr<Watches> watchesOf(Session& session) {
  return session.state<Watches>([&] { return std::make_shared<Watches>(session); });
}

json watch(Request& request) {
  protocol::Arguments arguments(request.arguments(), "watch {\"expression\": TEXT}");
  const json wanted = DocumentReader(request).object(arguments.expectJson(), "watch");
  arguments.expectEnd();
  return watchesOf(request.session())->add(request, WatchedCondition::read(wanted));
}

json unwatch(Request& request) {
  protocol::Arguments arguments(request.arguments(), "unwatch NAME");
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  watchesOf(request.session())->remove(name);
  return nullptr;
}

}  // namespace

GALAXY_MODULE(registration) {
  registration.verb({"make", "[shared] ENTRY",
                     "Makes datasets of datasets, or tells numbers: entries of a state file with a `filter`.",
                     Order::Aside, make});
  registration.verb({"filters", "", "What filters there are, with their inputs and properties.",
                     Order::InTurn, filters, Effect::Looks});
  registration.verb({"watch", "{\"expression\": TEXT}",
                     "Tells when a condition on whole fields begins to hold, such as max(p) > 3.",
                     Order::Aside, watch});
  registration.verb({"unwatch", "NAME", "Ends a watch.", Order::InTurn, unwatch});
}
