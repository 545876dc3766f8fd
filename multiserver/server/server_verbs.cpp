// SPDX-License-Identifier: Apache-2.0
#include "multiserver/server/server_verbs.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <vector>

#include "core/comm/error.h"
#include "core/scene/read_context.h"
#include "multiserver/protocol/statement.h"
#include "multiserver/server/modules.h"

namespace gxy {

namespace {

using nlohmann::json;

struct Offered {
  std::string name;  ///< the name to type
  std::string full;  ///< the name with its module, which is always unambiguous
  const Verb* verb;
};

const std::vector<Verb>& serverVerbs();

// Returns all verbs of a session. Verbs that others hide have their full names.
std::vector<Offered> offeredTo(const Session& session) {
  std::vector<Offered> offered;
  for (const Verb& verb : serverVerbs()) offered.push_back({verb.name, "server." + verb.name, &verb});
  for (const auto& module : session.modules())
    for (const Verb& verb : module->verbs()) {
      const bool hidden =
          std::any_of(offered.begin(), offered.end(), [&](const Offered& o) { return o.name == verb.name; });
      const std::string full = module->name() + "." + verb.name;
      offered.push_back({hidden ? full : verb.name, full, &verb});
    }
  return offered;
}

json help(Request& request) {
  const std::string& wanted = request.arguments();
  json verbs = json::array();
  std::string text;
  for (const auto& [name, full, verb] : offeredTo(request.session())) {
    if (!wanted.empty() && wanted != full && wanted != verb->name) continue;
    verbs.push_back({{"verb", name}, {"arguments", verb->arguments}, {"help", verb->help}});
    text += (text.empty() ? "" : "\n") + name + (verb->arguments.empty() ? "" : " " + verb->arguments) +
            ";\n    " + verb->help;
  }
  if (verbs.empty()) throw Error("help: there is no verb " + inQuotes(wanted) + "; `help` lists them");
  return {{"verbs", verbs}, {"text", text}};
}

json load(Request& request) {
  Session& session = request.session();
  const auto module = session.serverRank().modules->load(request.arguments());
  json verbs = json::array(), hidden = json::array();
  for (const Verb& verb : module->verbs()) {
    verbs.push_back(verb.name);
    bool taken = serverVerb(verb.name) != nullptr;
    for (const auto& other : session.modules()) {
      if (other == module) break;
      taken = taken || other->find(verb.name);
    }
    if (taken) hidden.push_back(verb.name);
  }
  session.addModule(module);
  return {{"module", module->name()}, {"verbs", verbs}, {"hidden", hidden}};
}

json modules(Request& request) {
  json loaded = json::array();
  std::string text = "loaded:";
  for (const auto& module : request.session().modules()) {
    loaded.push_back(module->name());
    text += " " + module->name();
  }
  const json available = request.session().serverRank().modules->available();
  text += "\navailable:";
  for (const auto& name : available) text += " " + name.get<std::string>();
  return {{"loaded", loaded}, {"available", available}, {"text", text}};
}

json statisticsOfRank(const ServerRank& serverRank) {
  const Renderer::Counters c = serverRank.renderer.counters();
  const Renderer::ResourceCounts kept = serverRank.renderer.kept();
  const Transport::Counters t = serverRank.transport.counters();
  json lines = json::array();
  for (const Ledger::Line& line : serverRank.ledger.snapshot())
    if (line.bytes != 0)
      lines.push_back({{"tenant", line.tenant}, {"purpose", line.purpose}, {"bytes", line.bytes}});
  json byTenant = json::array();  // Here tenants are numbers; rank 0 replaces them by names.
  for (const auto& [tenant, rays] : kept.tenantCredits)
    byTenant.push_back({{"tenant", tenant}, {"in flight", rays}});
  return {{"rank", serverRank.rank()},
          {"memory",
           {{"ledger", serverRank.ledger.total()},
            {"peak", serverRank.ledger.peak()},
            {"resident", processBytes().resident},
            {"limit", serverRank.options.memory},
            {"by purpose", lines}}},
          {"rays",
           {{"traced", c.trace.raysTraced},
            {"forwarded", c.raysForwarded},
            {"retired", c.trace.raysRetired},
            {"in flight", kept.credits},
            {"by tenant", byTenant},
            {"messages", c.rayMessages},
            {"bytes", c.rayBytes}}},
          {"contributions", {{"messages", c.contributionMessages}, {"bytes", c.contributionBytes}}},
          {"frames", kept.frames},
          {"tasks waiting", kept.tasks},
          {"messages", t.messagesSent},
          {"bytes", t.bytesSent},
          {"packets", t.packetsSent},
          {"bytes waiting", t.bytesWaiting},
          {"most bytes waiting", t.mostBytesWaiting}};
}

// Returns a size with three digits and a unit.
std::string sizeText(const json& bytes) {
  constexpr const char* units[] = {" B", " KiB", " MiB", " GiB", " TiB"};
  double size = bytes.get<double>();
  size_t unit = 0;
  for (; size >= 999.5 && unit + 1 < std::size(units); unit++) size /= 1024;
  char text[32];
  std::snprintf(text, sizeof text, "%.*f%s", unit == 0 || size >= 99.95 ? 0 : 1, size, units[unit]);
  return text;
}

json stat(Request& request) {
  ServerRank& serverRank = request.session().serverRank();
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - serverRank.begin).count();
  ServerRank::RollCall call = serverRank.callThoseThere("server.stat", json::object());
  json missing = json::array();
  for (const Presence::Missing& m : call.missing)
    missing.push_back({{"rank", m.rank}, {"died", m.died}, {"seconds", m.since.count()}});
  json result{{"ranks", std::move(call.results)},       {"missing", std::move(missing)},
              {"clients", serverRank.clients()},        {"tenants", serverRank.tenants.statistics()},
              {"streams", serverRank.streaming.list()}, {"seconds", seconds}};
  for (json& rank : result["ranks"])
    for (json& line : rank["rays"]["by tenant"])
      line["tenant"] = serverRank.tenants.name(line["tenant"].get<uint32_t>());
  std::string text = "up " + std::to_string(int64_t(seconds)) + " s, " + std::to_string(serverRank.ranks()) +
                     " ranks, " + std::to_string(result["clients"].size()) + " clients";
  for (const Presence::Missing& m : call.missing) text += "\n" + textOf({m});
  for (const json& rank : result["ranks"]) {
    text += "\nrank " + rank["rank"].dump() + ": " + sizeText(rank["memory"]["ledger"]) +
            " in the ledger (of " + sizeText(rank["memory"]["limit"]) + "), " +
            sizeText(rank["memory"]["resident"]) + " resident, " + rank["frames"].dump() + " frames, " +
            rank["rays"]["in flight"].dump() + " rays in flight, " + rank["tasks waiting"].dump() +
            " tasks and " + sizeText(rank["bytes waiting"]) + " waiting, " + rank["messages"].dump() +
            " messages of " + sizeText(rank["bytes"]) + " sent";
    for (const json& line : rank["memory"]["by purpose"])
      text += "\n  " + line["tenant"].get<std::string>() + ", " + line["purpose"].get<std::string>() + ": " +
              sizeText(line["bytes"]);
  }
  for (const json& tenant : result["tenants"]) {
    const json& name = tenant["tenant"];
    int64_t rays = 0;
    for (const json& rank : result["ranks"])
      for (const json& line : rank["rays"]["by tenant"])
        if (line["tenant"] == name) rays += line["in flight"].get<int64_t>();
    const auto frames = tenant["frames"].get<double>();
    text += "\ntenant " + name.get<std::string>() + ": " + tenant["frames in flight"].dump() +
            " frames and " + std::to_string(rays) + " rays in flight, " + tenant["frames"].dump() +
            " frames made";
    if (frames > 0)
      text += " in " + numberText(std::round(tenant["frame seconds"].get<double>() / frames * 1e4) / 1e4) +
              " s on average";
  }
  for (const json& s : result["streams"])
    text += "\nstream " + s["name"].get<std::string>() + " of " + s["tenant"].get<std::string>() + ": " +
            s["connected"].dump() + " of " + s["ranks"].dump() + " ranks, " +
            s.value("published", json(0)).dump() + " steps published";
  for (const json& c : result["clients"])
    text += "\nclient " + c["session"].dump() + ": " + c["client"].get<std::string>() + " of " +
            c["tenant"].get<std::string>() + ", " + sizeText(c["queued bytes"]) + " queued, " +
            sizeText(c["sent bytes"]) + " sent";
  result["text"] = text;
  return result;
}

json cancel(Request& request) {
  const std::string& text = request.arguments();
  uint32_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (error != std::errc() || end != text.data() + text.size())
    throw Error("cancel: " + inQuotes(text) + " is no request's id, expected `cancel ID`");
  request.session().cancel(id);
  return nullptr;
}

json ticket(Request& request) {
  ServerRank& serverRank = request.session().serverRank();
  const Session::Identity& who = request.session().identity();
  if (serverRank.tenants.admitsAll()) return {{"ticket", ""}, {"seconds", 0}, {"text", "none is needed"}};
  const std::string token = serverRank.tenants.tokenOf({who.tenant, who.administrator, who.viewOnly});
  const std::string made = serverRank.tickets.issue(token, Tickets::kShort);
  return {{"ticket", made}, {"seconds", Tickets::kShort.count()}, {"text", made}};
}

json echo(Request& request) { return {{"text", request.arguments()}}; }

json quit(Request& request) {
  if (!request.session().identity().administrator)
    throw Error("quit: only an administrator may stop the server; `exit` leaves the client");
  request.onAnswered([&serverRank = request.session().serverRank()] { serverRank.stop(); });
  return nullptr;
}

// Makes a verb without arguments.
Verb alone(std::string name, std::string help, Order order, json (*action)(Request&),
           Effect effect = Effect::Looks) {
  Verb verb{std::move(name), "", std::move(help), order, {}, effect};
  verb.action = [usage = verb.name, action](Request& request) {
    protocol::Arguments(request.arguments(), usage).expectEnd();
    return action(request);
  };
  return verb;
}

const std::vector<Verb>& serverVerbs() {
  static const std::vector<Verb> verbs{
      {"help", "[VERB]", "Lists what can be asked.", Order::AtOnce, help, Effect::Looks},
      {"load", "MODULE", "Loads a module for this session.", Order::InTurn, load, Effect::Looks},
      alone("modules", "Lists the session's modules, and those there are.", Order::InTurn, modules),
      alone("stat", "What the server uses and does, by rank, tenant and client.", Order::Aside, stat),
      {"cancel", "ID", "Ends a request of this session.", Order::AtOnce, cancel, Effect::Looks},
      {"echo", "[TEXT]", "Answers with the same text.", Order::InTurn, echo, Effect::Looks},
      alone("ticket", "A ticket, with which a browser gets in once, within a minute.", Order::InTurn, ticket),
      alone("quit", "Stops the server (administrators).", Order::InTurn, quit, Effect::Changes)};
  return verbs;
}

}  // namespace

const Verb* serverVerb(const std::string& name) {
  const std::string own = name.starts_with("server.") ? name.substr(7) : name;
  for (const Verb& verb : serverVerbs())
    if (verb.name == own) return &verb;
  return nullptr;
}

const Verb& resolveVerb(Session& session, const std::string& name) {
  if (const Verb* own = serverVerb(name)) return *own;
  const size_t dot = name.find('.');
  const std::string module = dot == std::string::npos ? "" : name.substr(0, dot);
  const std::string verb = dot == std::string::npos ? name : name.substr(dot + 1);
  for (const auto& m : session.modules())
    if (module.empty() || m->name() == module)
      if (const Verb* found = m->find(verb)) return *found;
  std::vector<std::string> names;
  for (const auto& o : offeredTo(session)) names.push_back(o.name);
  throw Error("verb " + inQuotes(name) + ": there is none in the session's modules" +
              suggestion(name, names) + "; `help` lists them, `load MODULE` adds some");
}

void addServerWorks(ServerRank& serverRank) {
  serverRank.work.add("server.trace", [&serverRank](const Work::Call&) -> json {
    return serverRank.options.trace ? serverRank.options.trace->events(serverRank.rank()) : std::string();
  });
  serverRank.work.add("server.stat",
                      [&serverRank](const Work::Call&) { return statisticsOfRank(serverRank); });
}

}  // namespace gxy
