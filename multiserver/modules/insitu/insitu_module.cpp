// SPDX-License-Identifier: Apache-2.0
// Module `insitu`: simulations publish their steps (docs/protocol.md, section 9.5).
#include <algorithm>

#include "core/comm/error.h"
#include "core/scene/json_text.h"
#include "insitu/plan/description.h"
#include "multiserver/insitu/streams.h"
#include "multiserver/protocol/json.h"
#include "multiserver/server/module.h"

namespace gxy {
namespace {

using nlohmann::json;

int integer(const json& object, const char* key, int least, int most) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number_integer() || found->get<int64_t>() < least ||
      found->get<int64_t>() > most)
    throw Error(std::string("insitu.join: `") + key + "`: expected an integer from " + std::to_string(least) +
                " to " + std::to_string(most));
  return found->get<int>();
}

StreamWishes wishesOf(const json& object) {
  StreamWishes wishes;
  const json scope = object.value("scope", json("private"));
  if (scope != "private" && scope != "shared")
    throw Error("insitu.join: `scope`: expected \"private\" or \"shared\"");
  wishes.scope = scope == "shared" ? Scope::Shared : Scope::Private;
  wishes.partition = object.value("partition", json("even"));
  const bool like = wishes.partition.is_object() && wishes.partition.size() == 1 &&
                    wishes.partition.contains("like") && wishes.partition["like"].is_string();
  if (wishes.partition != "even" && wishes.partition != "simulation" && !like)
    throw Error("insitu.join: `partition`: expected \"even\", \"simulation\" or {\"like\": DATASET}");
  const json steerable = object.value("steerable", json::array());
  if (!steerable.is_array() || steerable.size() > insitu::kMostSteerable)
    throw Error("insitu.join: `steerable`: expected a list, of at most 64 parameters");
  for (const json& one : steerable) {
    if (!one.is_object() || !one.value("name", json()).is_string() ||
        !one.value("least", json()).is_number() || !one.value("largest", json()).is_number())
      throw Error("insitu.join: `steerable`: expected objects with `name`, `least` and `largest`");
    wishes.steerable.push_back(
        {one["name"].get<std::string>(), one["least"].get<double>(), one["largest"].get<double>()});
    insitu::checkName(wishes.steerable.back().name, "parameter");
  }
  return wishes;
}

json join(Streams& streams, Request& request) {
  const json object = protocol::parseObject(request.arguments(), "insitu.join");
  for (const auto& [key, value] : object.items())
    if (key != "name" && key != "rank" && key != "ranks" && key != "scope" && key != "partition" &&
        key != "triggers" && key != "steerable")
      throw Error("insitu.join: unknown key " + inQuotes(key) +
                  ", expected `name`, `rank`, `ranks`, `scope`, `partition`, `triggers` and `steerable`");
  const auto name = object.find("name");
  if (name == object.end() || !name->is_string()) throw Error("insitu.join: `name`: expected a text");
  Streams::Join what{name->get<std::string>(), 0, integer(object, "ranks", 1, insitu::kMostRanks),
                     wishesOf(object)};
  what.rank = integer(object, "rank", 0, what.ranks - 1);
  insitu::checkName(what.name, "stream");
  const json triggers = object.value("triggers", json::array());
  if (!triggers.is_array()) throw Error("insitu.join: `triggers`: expected a list");
  for (const json& trigger : triggers) what.triggers.push_back(readTrigger(trigger));
  return streams.join(request.session().tenant(), what);
}

json list(Streams& streams, Request& request) {
  protocol::Arguments(request.arguments(), "streams").expectEnd();
  const json all = streams.list(request.session().tenant());
  std::string text = "streams:";
  for (const json& s : all) {
    text += "\n" + s.at("name").get<std::string>() + ": " + s.at("connected").dump() + " of " +
            s.at("ranks").dump() + " ranks, " + s.value("published", json(0)).dump() + " steps published";
    if (s.contains("step")) text += ", the newest is step " + s.at("step").dump();
    if (s.contains("problem")) text += "; " + s.at("problem").get<std::string>();
  }
  return {{"streams", all}, {"text", text}};
}

json trigger(Streams& streams, Request& request) {
  protocol::Arguments arguments(request.arguments(), "trigger STREAM JSON");
  const std::string stream = arguments.expectWord();
  Trigger trigger = readTrigger(protocol::parseObject(arguments.expectJson(), "insitu.trigger"));
  streams.withTriggers(request.session().tenant(), stream, [&](Triggers& t) { t.add(std::move(trigger)); });
  return nullptr;
}

json steer(Streams& streams, Request& request) {
  protocol::Arguments arguments(request.arguments(), "steer STREAM PARAMETER VALUE");
  const std::string stream = arguments.expectWord(), parameter = arguments.expectWord();
  const auto value = arguments.number();
  if (!value) arguments.fail("VALUE is a number");
  arguments.expectEnd();
  streams.steer(request.session().tenant(), stream, {{parameter, *value}});
  return nullptr;
}

json untrigger(Streams& streams, Request& request) {
  protocol::Arguments arguments(request.arguments(), "untrigger STREAM NAME");
  const std::string stream = arguments.expectWord(), name = arguments.expectWord();
  arguments.expectEnd();
  streams.withTriggers(request.session().tenant(), stream, [&](Triggers& t) { t.remove(name); });
  return nullptr;
}

json triggers(Streams& streams, Request& request) {
  protocol::Arguments arguments(request.arguments(), "triggers STREAM");
  const std::string stream = arguments.expectWord();
  arguments.expectEnd();
  json all;
  streams.withTriggers(request.session().tenant(), stream, [&](Triggers& t) { all = t.list(); });
  std::string text = "triggers:";
  for (const json& t : all) {
    text += "\n" + t.at("name").get<std::string>() + ": " + t.at("do").get<std::string>() + " when " +
            t.at("when").dump() + ", for " + t.at("fired").dump() + " steps, " + t.at("done").dump() +
            " done";
    if (t.contains("problem")) text += "; " + t.at("problem").get<std::string>();
  }
  return {{"triggers", all}, {"text", text}};
}

/// What a session listens to.
struct Listening {
  std::shared_ptr<void> subscription;
};

json listen(Streams& streams, Request& request) {
  protocol::Arguments(request.arguments(), "listen").expectEnd();
  Session& session = request.session();
  session.state<Listening>([&]() -> std::shared_ptr<Listening> {
    return std::make_shared<Listening>(Listening{streams.listen(session.tenant(), session.sharedOutbox())});
  });
  return nullptr;
}

json close(Streams& streams, Request& request) {
  protocol::Arguments arguments(request.arguments(), "close NAME");
  const std::string name = arguments.expectWord();
  arguments.expectEnd();
  streams.close(request.session().tenant(), name);
  return nullptr;
}

}  // namespace
}  // namespace gxy

GALAXY_MODULE(registration) {
  using namespace gxy;
  const auto streams = std::make_shared<Streams>(
      registration.serverRank(), [&](const std::string& name, Work::Action action, Work::Runs runs) {
        registration.work(name, std::move(action), runs);
      });
  registration.keep(streams);
  Streams& s = *streams;
  registration.verb({"join", "JSON", "A rank of a simulation says that it will publish steps.", Order::InTurn,
                     [&s](Request& r) { return join(s, r); }});
  registration.verb({"streams", "", "Lists the simulations that publish steps.", Order::InTurn,
                     [&s](Request& r) { return list(s, r); }, Effect::Looks});
  registration.verb({"close", "NAME", "Ends a stream; its data stay.", Order::InTurn,
                     [&s](Request& r) { return close(s, r); }});
  registration.verb({"trigger", "STREAM JSON", "Has the server do something with steps of a stream.",
                     Order::InTurn, [&s](Request& r) { return trigger(s, r); }});
  registration.verb({"steer", "STREAM PARAMETER VALUE", "Gives a parameter of a simulation another value.",
                     Order::InTurn, [&s](Request& r) { return steer(s, r); }});
  registration.verb({"untrigger", "STREAM NAME", "Removes a trigger.", Order::InTurn,
                     [&s](Request& r) { return untrigger(s, r); }});
  registration.verb({"triggers", "STREAM", "Lists the triggers of a stream.", Order::InTurn,
                     [&s](Request& r) { return triggers(s, r); }, Effect::Looks});
  registration.verb({"listen", "", "Events about streams: of triggers, and their ends.", Order::InTurn,
                     [&s](Request& r) { return listen(s, r); }, Effect::Looks});
}
