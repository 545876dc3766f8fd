// SPDX-License-Identifier: Apache-2.0
// Module `graph`: documents that the server keeps evaluated (docs/graph.md).
#include <set>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/scene/state_file.h"
#include "multiserver/graph/document_edits.h"
#include "multiserver/graph/graphs.h"

namespace gxy::graph {
namespace {

using nlohmann::json;
using protocol::Arguments;

Graph::Client clientOf(const Session& session) {
  return {session.identity().number, session.identity().client};
}

StateReader readerOf(Request& request) {
  return stateReaderOf(request.session().serverRank(), request.session().tenant());
}

/// The graph that a request changes.
std::shared_ptr<Graph> changed(const Graphs& graphs, Request& request, const std::string& name) {
  return graphs.get(request.session().tenant(), name, Graphs::Access::Change);
}

std::string warningsText(const std::vector<std::string>& warnings) {
  std::string text;
  for (const std::string& w : warnings) text += "\nwarning: " + w;
  return text;
}

std::string nodeText(const json& node) {
  std::string text = node.at("kind").get<std::string>() + " " + node.at("node").get<std::string>() + ": " +
                     node.at("state").get<std::string>();
  if (node.contains("done")) text += " " + node["done"].dump() + " of " + node["of"].dump();
  if (node.contains("generation")) text += ", generation " + node["generation"].dump();
  if (node.contains("by")) text += " by " + node["by"].get<std::string>();
  if (node.contains("text")) text += ", " + node["text"].get<std::string>();
  return text;
}

json list(Graphs& graphs, Request& request, Arguments arguments) {
  arguments.expectEnd();
  json all = json::array();
  std::string text = "graphs:";
  for (const auto& [graph, shared] : graphs.list(request.session().tenant())) {
    all.push_back(graph->summary());
    json& g = all.back();
    g["owner"] = graph->tenant();
    g["scope"] = shared ? "shared" : "private";
    if (shared) g["read only"] = *shared == Graphs::Access::Look;
    text += "\n" + graph->name() + ": revision " + g["revision"].dump() + ", " + g["nodes"].dump() +
            " nodes" + (g["paused"].get<bool>() ? ", paused" : "");
  }
  return {{"graphs", all}, {"text", text}};
}

json make(Graphs& graphs, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord();
  const auto text = arguments.json();
  DocumentReader reader(request);
  const json document = text ? reader.object(*text, "new") : json::object();
  const auto [graph, warnings] = graphs.make(request.session().tenant(), name, document, readerOf(request));
  const json revision = graph->summary().at("revision");
  return {{"graph", name},
          {"revision", revision},
          {"warnings", warnings},
          {"text", "revision " + revision.dump() + warningsText(warnings)}};
}

json get(Graphs& graphs, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  json result = graphs.get(request.session().tenant(), name)->describe();
  std::string text =
      "revision " + result["revision"].dump() + (result["paused"].get<bool>() ? ", paused" : "");
  for (const json& node : result["nodes"]) text += "\n" + nodeText(node);
  result["text"] = text;
  return result;
}

json numbers(Graphs& graphs, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord(), node = arguments.expectWord();
  const auto from = arguments.number();
  arguments.expectEnd();
  if (from && (*from < 1 || *from > 1e15 || *from != double(uint64_t(*from))))
    arguments.fail("a generation is an integer from 1 up");
  const json numbers =
      graphs.get(request.session().tenant(), name)->numbers(node, Generation(from.value_or(1)));
  std::string text;
  for (const json& entry : numbers) text += (text.empty() ? "" : "\n") + entry.dump();
  return {{"numbers", numbers}, {"text", text}};
}

/// `once` of an edit: who has made it, and its number among theirs.
std::optional<EditMark> markIn(const json& what) {
  const auto once = what.find("once");
  if (once == what.end()) return {};
  const bool isPair =
      once->is_array() && once->size() == 2 && once->at(0).is_string() && once->at(1).is_number_unsigned();
  const std::string who = isPair ? once->at(0).get<std::string>() : "";
  if (who.empty() || who.size() > EditMark::kLongest)
    throw Error("edit: `once`: expected [text of 1 to " + std::to_string(EditMark::kLongest) +
                " bytes, integer >= 0], found " + inQuotes(once->dump()));
  return EditMark{who, once->at(1).get<uint64_t>()};
}

json edit(Graphs& graphs, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord();
  const auto graph = changed(graphs, request, name);
  DocumentReader reader(request);
  const json what = reader.object(arguments.expectJson(), "edit");
  for (const auto& [key, value] : what.items())
    if (key != "edits" && key != "live" && key != "once")
      throw Error("edit: unknown key " + inQuotes(key, '`') + ", expected `edits`, `live` and `once`");
  const json live = what.value("live", json(false));
  if (!live.is_boolean()) throw Error("edit: `live`: expected true or false, found " + inQuotes(live.dump()));
  json result = graph->edit(what.value("edits", json()), live.get<bool>(), markIn(what),
                            clientOf(request.session()), readerOf(request));
  result["text"] = "revision " + result["revision"].dump() +
                   warningsText(result["warnings"].get<std::vector<std::string>>());
  return result;
}

/// The graphs that a session watches. Its end ends that.
struct Watched {
  explicit Watched(uint64_t number) : session(number) {}
  ~Watched() {
    for (const auto& [name, watched] : graphs)
      if (const auto graph = watched.lock()) graph->unwatch(session);
  }
  const uint64_t session;
  std::mutex mutex;
  std::map<std::string, std::weak_ptr<Graph>> graphs;
};

std::shared_ptr<Watched> watchedBy(Session& session) {
  return session.state<Watched>([&] { return std::make_shared<Watched>(session.identity().number); });
}

json watch(Graphs& graphs, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  Session& session = request.session();
  const auto graph = graphs.get(session.tenant(), name);
  const auto watched = watchedBy(session);
  const std::lock_guard lock(watched->mutex);
  graph->watch(clientOf(session), session.sharedOutbox());
  std::erase_if(watched->graphs, [](const auto& item) { return item.second.expired(); });
  watched->graphs[name] = graph;
  return {{"revision", graph->summary().at("revision")}, {"text", ""}};
}

json unwatch(Graphs&, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  const auto watched = watchedBy(request.session());
  const std::lock_guard lock(watched->mutex);
  const auto found = watched->graphs.find(name);
  if (found == watched->graphs.end()) return nullptr;
  if (const auto graph = found->second.lock()) graph->unwatch(watched->session);
  watched->graphs.erase(found);
  return nullptr;
}

json run(Graphs& graphs, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord();
  const auto node = arguments.word();
  arguments.expectEnd();
  changed(graphs, request, name)->run(node);
  return nullptr;
}

json cancel(Graphs& graphs, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord();
  const auto node = arguments.word();
  arguments.expectEnd();
  changed(graphs, request, name)->cancel(node);
  return nullptr;
}

json pause(Graphs& graphs, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  changed(graphs, request, name)->pause();
  return nullptr;
}

json resume(Graphs& graphs, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  changed(graphs, request, name)->resume();
  return nullptr;
}

json wait(Graphs& graphs, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord();
  const auto seconds = arguments.number();
  arguments.expectEnd();
  if (seconds && (*seconds < 0 || *seconds > 1e7)) arguments.fail("seconds are 0 to 10^7");
  const auto graph = graphs.get(request.session().tenant(), name);
  if (!graph->waitUntilIdle(std::chrono::duration<double>(seconds.value_or(60)), [&] { request.check(); }))
    throw Error("wait: graph " + inQuotes(name) + " is still being evaluated");
  return get(graphs, request, Arguments(protocol::asWord(name), "get NAME"));
}

json check(Graphs& graphs, Request& request, Arguments arguments) {
  (void)graphs;
  DocumentReader reader(request);
  const json document = reader.object(arguments.expectJson(), "check");
  std::vector<DocumentProblem> problems;
  const Filters& filters = request.session().serverRank().filters;
  const GraphDocument read = readGraphDocument("graph", document, filters, readerOf(request), &problems);
  if (problems.empty()) try {
      const flow::CompiledDocument compiled(read.flow, filters);
    } catch (const Error& e) {
      problems.push_back(problemOf(e.what()));
    }
  json errors = json::array();
  std::string text = problems.empty() ? "nothing is wrong" : "";
  for (const DocumentProblem& p : problems) {
    errors.push_back({{"path", p.path}, {"text", p.text}});
    text += (text.empty() ? "" : "\n") + p.path + ": " + p.text;
  }
  return {{"errors", errors}, {"warnings", read.warnings}, {"text", text + warningsText(read.warnings)}};
}

json types(Graphs&, Request& request, Arguments arguments) {
  arguments.expectEnd();
  json result = described(request.session().serverRank().filters);
  result["sections"] = json::parse(stateTables());
  return result;
}

json drop(Graphs& graphs, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  graphs.drop(request.session().tenant(), name);
  return nullptr;
}

json publish(Graphs& graphs, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord();
  const bool writable = arguments.taken("writable");
  arguments.expectEnd();
  graphs.publish(request.session().tenant(), name, writable ? Graphs::Access::Change : Graphs::Access::Look);
  return nullptr;
}

json unpublish(Graphs& graphs, Request& request, Arguments arguments) {
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  graphs.unpublish(request.session().tenant(), name);
  return nullptr;
}

}  // namespace
}  // namespace gxy::graph

GALAXY_MODULE(registration) {
  using namespace gxy;
  const auto graphs = graphsOf(registration);
  registration.keep(graphs);
  using Action = nlohmann::json (*)(Graphs&, Request&, protocol::Arguments);
  const auto add = [&](std::string name, std::string arguments, std::string help, Order order, Action action,
                       Effect effect = Effect::Changes) {
    Verb verb{std::move(name), std::move(arguments), std::move(help), order, {}, effect};
    verb.action = [usage = verb.name + (verb.arguments.empty() ? "" : " " + verb.arguments), &g = *graphs,
                   action](Request& request) {
      return action(g, request, protocol::Arguments(request.arguments(), usage));
    };
    registration.verb(std::move(verb));
  };
  add("list", "", "Names the graphs.", Order::InTurn, graph::list, Effect::Looks);
  add("new", "NAME [JSON]", "Makes a graph, of a document or empty.", Order::InTurn, graph::make);
  add("get", "NAME", "The document of a graph, and the states of its nodes.", Order::InTurn, graph::get,
      Effect::Looks);
  add("numbers", "NAME NODE [GENERATION]", "What a node has told of its generations, from one on.",
      Order::InTurn, graph::numbers, Effect::Looks);
  add("edit", "NAME {\"edits\": [...]}", "Changes the document, all or nothing.", Order::InTurn, graph::edit);
  add("watch", "NAME", "Events of a graph: edits, states, who watches.", Order::InTurn, graph::watch,
      Effect::Looks);
  add("unwatch", "NAME", "No more of these events.", Order::InTurn, graph::unwatch, Effect::Looks);
  add("run", "NAME [NODE]", "Evaluates all nodes, or one with what it needs.", Order::InTurn, graph::run);
  add("pause", "NAME", "Evaluates nothing more by itself.", Order::InTurn, graph::pause);
  add("resume", "NAME", "Evaluates by itself again.", Order::InTurn, graph::resume);
  add("cancel", "NAME [NODE]", "Ends what is being evaluated.", Order::InTurn, graph::cancel);
  add("wait", "NAME [SECONDS]", "Until nothing is being evaluated.", Order::Aside, graph::wait,
      Effect::Looks);
  add("check", "JSON", "What is wrong with a document.", Order::InTurn, graph::check, Effect::Looks);
  add("types", "", "What filters there are, with their inputs and properties.", Order::InTurn, graph::types,
      Effect::Looks);
  add("publish", "NAME [writable]", "Lets all tenants look at a graph, or also change it.", Order::InTurn,
      graph::publish);
  add("unpublish", "NAME", "Takes a graph back.", Order::InTurn, graph::unpublish);
  add("drop", "NAME", "Ends a graph, and forgets what it has made.", Order::Aside, graph::drop);
}
