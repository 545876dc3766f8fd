// SPDX-License-Identifier: Apache-2.0
// Module `data`: the data space by name.
#include <map>

#include "core/comm/error.h"
#include "core/scene/state_file.h"
#include "multiserver/modules/data/export.h"
#include "multiserver/modules/data/fetch.h"
#include "multiserver/modules/data/files.h"
#include "multiserver/modules/data/histogram.h"
#include "multiserver/server/datasets.h"
#include "multiserver/server/filter_runs.h"
#include "multiserver/server/module.h"

namespace gxy {
namespace {

using nlohmann::json;

const char* nameOf(Scope scope) { return scope == Scope::Shared ? "shared" : "private"; }

json listed(const NamedDataset& d) {
  return {{"name", d.name},   {"scope", nameOf(d.scope)}, {"type", d.type},
          {"owner", d.owner}, {"read only", d.readOnly},  {"generation", d.generation}};
}

Datasets& datasetsOf(const Request& request) { return *request.session().serverRank().datasets; }

json list(Request& request, protocol::Arguments arguments) {
  const bool all = arguments.taken("all");
  arguments.expectEnd();
  json datasets = json::array();
  std::string text = "datasets:";
  for (const NamedDataset& d : datasetsOf(request).list(request.session().tenant())) {
    if (d.ofGraph && d.name.find('/') != std::string::npos && !all) continue;
    datasets.push_back(listed(d));
    text += "\n" + d.name;
  }
  return {{"datasets", datasets}, {"text", text}};
}

std::string infoText(const json& d) {
  std::string text = d["name"].get<std::string>() + ": " + d["type"].get<std::string>() + " of " +
                     d["owner"].get<std::string>() + ", " + d["scope"].get<std::string>() + ", generation " +
                     d["generation"].dump();
  for (const char* key : {"points", "mesh", "primitives", "components", "range", "box", "partitions", "bytes",
                          "file", "stream", "time"})
    if (d.contains(key)) text += "\n  " + std::string(key) + " " + d[key].dump();
  return text;
}

json info(Request& request, protocol::Arguments arguments) {
  const std::string tenant = request.session().tenant();
  const auto name = arguments.word();
  arguments.expectEnd();
  Datasets& datasets = datasetsOf(request);
  json all = json::array();
  std::string text;
  const auto add = [&](const NamedDataset& d, const json& known) {
    json one = listed(d);
    one.update(known);
    text += (text.empty() ? "" : "\n") + infoText(one);
    all.push_back(std::move(one));
  };
  if (name) {
    const auto [dataset, known] = datasets.info(tenant, *name);
    add(dataset, known);
  } else {
    for (const NamedDataset& d : datasets.list(tenant))
      if (const json known = d.ofGraph ? json() : datasets.info(d); !known.is_null()) add(d, known);
  }
  return {{"datasets", all}, {"text", text}};
}

json import(Request& request, protocol::Arguments arguments) {
  Datasets::Import what;
  if (arguments.taken("shared")) what.scope = Scope::Shared;
  if (arguments.taken("new"))
    what.newPartitioning = true;
  else if (arguments.taken("like"))
    what.like = arguments.expectWord();
  const std::string_view text = arguments.expectJson();
  StateFile file = DocumentReader(request).state(text, "import");
  if (!file.state.visualizations.empty() || !file.state.cameras.empty())
    throw Error("import: expected `Datasets` only; module viewer takes whole state documents");
  what.specs = file.state.datasets;
  for (std::string& w : request.session().serverRank().filterRuns->importAndMake(request, what))
    file.warnings.push_back(std::move(w));
  json names = json::array(), generations = json::object();
  for (const DatasetSpec& d : what.specs) {
    names.push_back(d.name);
    if (const auto now = datasetsOf(request).find(request.session().tenant(), d.name))
      generations[d.name] = now->generation;
  }
  json result{{"datasets", names}, {"generations", generations}, {"text", ""}};
  std::string warnings;
  for (const std::string& w : file.warnings) warnings += (warnings.empty() ? "warning: " : "\nwarning: ") + w;
  result["warnings"] = file.warnings;
  result["text"] = warnings;
  return result;
}

json range(Request& request, protocol::Arguments arguments) {
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  Datasets& datasets = datasetsOf(request);
  const json found = datasets.info(request.session().tenant(), name).second.at("range");
  return {{"range", found},
          {"text", found.is_null() ? "no values" : found[0].dump() + " " + found[1].dump()}};
}

json copy(Request& request, protocol::Arguments arguments) {
  const Scope scope = arguments.taken("shared") ? Scope::Shared : Scope::Private;
  const std::string name = arguments.expectWord(), newName = arguments.expectWord();
  arguments.expectEnd();
  checkDatasetName(newName);
  return datasetsOf(request).copy(request, name, newName, scope);
}

json drop(Request& request, protocol::Arguments arguments) {
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  datasetsOf(request).drop(request.session().tenant(), name);
  return nullptr;
}

json rename(Request& request, protocol::Arguments arguments) {
  const std::string name = arguments.expectWord(), newName = arguments.expectWord();
  arguments.expectEnd();
  datasetsOf(request).rename(request.session().tenant(), name, newName);
  return nullptr;
}

json publish(Request& request, protocol::Arguments arguments) {
  const std::string name = arguments.expectWord();
  const bool writable = arguments.taken("writable");
  arguments.expectEnd();
  datasetsOf(request).move(request.session().tenant(), name, Scope::Shared, !writable);
  return nullptr;
}

json unpublish(Request& request, protocol::Arguments arguments) {
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  datasetsOf(request).move(request.session().tenant(), name, Scope::Private, false);
  return nullptr;
}

json wait(Request& request, protocol::Arguments arguments) {
  const std::string name = arguments.expectWord();
  const auto generation = arguments.number(), seconds = arguments.number();
  arguments.expectEnd();
  checkDatasetName(name);
  if (generation && (*generation < 1 || *generation > 1e15 || *generation != double(uint64_t(*generation))))
    arguments.fail("a generation is an integer from 1 up");
  if (seconds && (*seconds < 0 || *seconds > 1e7)) arguments.fail("seconds are 0 to 10^7");
  const auto found = datasetsOf(request).wait(
      request, name, generation ? std::optional(Generation(*generation)) : std::nullopt,
      seconds.value_or(60));
  return {{"generation", found}, {"text", "generation " + std::to_string(found)}};
}

/// What a session observes.
struct Observed {
  std::mutex mutex;
  std::shared_ptr<void> all;                           ///< the wish for newer data of all; null: not of all
  std::map<std::string, std::shared_ptr<void>> names;  ///< with the wishes for these
  std::shared_ptr<void> subscription;                  ///< last: ends first

  bool concerns(const DatasetEvent& event) {
    const std::lock_guard lock(mutex);
    return all || names.count(event.dataset.name) ||
           (event.kind == DatasetEvent::Kind::Renamed && names.count(event.newName));
  }
};

std::shared_ptr<Observed> observedBy(Session& session) {
  return session.state<Observed>([&session]() {
    const auto observed = std::make_shared<Observed>();
    observed->subscription = session.serverRank().datasets->observe(
        [weak = std::weak_ptr(observed), who = session.weak_from_this()](const DatasetEvent& event) {
          const auto o = weak.lock();
          const auto s = who.lock();
          if (o && s && event.visibleTo(s->tenant()) && o->concerns(event)) s->outbox().event(event.json());
        });
    return observed;
  });
}

json observe(Request& request, protocol::Arguments arguments) {
  const auto name = arguments.word();
  arguments.expectEnd();
  if (name) checkDatasetName(*name);  // it is kept
  const auto observed = observedBy(request.session());
  const std::lock_guard lock(observed->mutex);
  Datasets& datasets = datasetsOf(request);
  const std::string& tenant = request.session().tenant();
  if (!name)
    observed->all = datasets.want(tenant, {});
  else if (observed->names.size() < 10000)
    observed->names[*name] = datasets.want(tenant, {*name});
  else
    throw Error("observe: 10000 names are observed, expected fewer; `observe` without a name observes all");
  return nullptr;
}

json unobserve(Request& request, protocol::Arguments arguments) {
  const auto name = arguments.word();
  arguments.expectEnd();
  const auto observed = observedBy(request.session());
  const std::lock_guard lock(observed->mutex);
  if (name)
    observed->names.erase(*name);
  else
    observed->all = nullptr, observed->names.clear();
  return nullptr;
}

using Action = json (*)(Request&, protocol::Arguments);

Verb verb(std::string name, std::string arguments, std::string help, Order order, Action action,
          Effect effect = Effect::Changes) {
  Verb v{std::move(name), std::move(arguments), std::move(help), order, {}, effect};
  v.action = [usage = v.name + (v.arguments.empty() ? "" : " " + v.arguments), action](Request& request) {
    return action(request, protocol::Arguments(request.arguments(), usage));
  };
  return v;
}

}  // namespace
}  // namespace gxy

GALAXY_MODULE(registration) {
  using namespace gxy;
  registration.verb(verb("list", "[all]", "Names the datasets; with `all` those that graphs have made, too.",
                         Order::InTurn, list, Effect::Looks));
  registration.verb(
      verb("info", "[NAME]", "What is known of a dataset, or of all.", Order::InTurn, info, Effect::Looks));
  registration.verb(verb("import", "[shared] [new | like NAME] {\"Datasets\": [...]}",
                         "Reads files; each becomes a dataset, or a new generation of one.", Order::Aside,
                         import));
  registration.verb(verb("export", "NAME FILE",
                         "Writes a dataset to a file: .vti, or .vtp, .vtu, .csv, .ply, .stl.", Order::Aside,
                         exportDataset));
  registration.verb({"fetch", "NAME", "Sends the client what a dataset holds, as arrays.", Order::Aside,
                     [fetches = addFetchWork(registration)](Request& request) {
                       return fetchDataset(*fetches, request, {request.arguments(), "fetch NAME"});
                     },
                     Effect::Looks});
  registration.verb(verb("files", "[FOLDER]", "What can be opened in the server's data folders.",
                         Order::InTurn, files, Effect::Looks));
  registration.verb(
      {"histogram", "NAME [BINS [COMPONENT]]", "How often values are in which bin.", Order::Aside,
       [histograms = std::make_shared<Histograms>()](Request& request) {
         return histogram(*histograms, request, {request.arguments(), "histogram NAME [BINS [COMPONENT]]"});
       },
       Effect::Looks});
  registration.verb(verb("copy", "[shared] NAME NEW", "Keeps what a dataset is now under another name.",
                         Order::Aside, copy));
  registration.verb(verb("drop", "NAME", "Forgets a dataset.", Order::InTurn, drop));
  registration.verb(verb("rename", "NAME NEW", "Gives a dataset another name.", Order::InTurn, rename));
  registration.verb(verb("range", "NAME", "Least and largest value.", Order::InTurn, range, Effect::Looks));
  registration.verb(
      verb("publish", "NAME [writable]", "Lets all tenants see a dataset.", Order::InTurn, publish));
  registration.verb(verb("unpublish", "NAME", "Takes a dataset back.", Order::InTurn, unpublish));
  registration.verb(verb("wait", "NAME [GENERATION [SECONDS]]", "Until there is a new generation.",
                         Order::Aside, wait, Effect::Looks));
  registration.verb(
      verb("observe", "[NAME]", "Events of a dataset, or of all.", Order::InTurn, observe, Effect::Looks));
  registration.verb(verb("unobserve", "[NAME]", "No more events.", Order::InTurn, unobserve, Effect::Looks));
}
