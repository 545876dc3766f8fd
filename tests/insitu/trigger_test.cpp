// SPDX-License-Identifier: Apache-2.0
// Which steps triggers are for, and what they do with them.
#include "multiserver/insitu/trigger.h"

#include <filesystem>
#include <fstream>

#include "core/comm/error.h"
#include "core/scene/check_cinema.h"
#include "tests/insitu/published.h"

namespace gxy::test {
namespace {

using nlohmann::json;

json every(int64_t k) { return {{"name", "t"}, {"when", {{"every", k}}}, {"do", "event"}}; }

std::string errorOf(const json& document) {
  try {
    readTrigger(document);
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

TEST(Trigger, DocumentsAreReadAsWritten) {
  const json document{
      {"name", "hot"},
      {"when",
       {{"every", 10}, {"above", {{"t", 350.5}}}, {"below", {{"p", -1.0}}}, {"nodata", {{"t", 0.0}}}}},
      {"do", "batch"},
      {"batch", {{"state", json::object()}, {"prefix", "hot-{step}"}}},
      {"exact", true}};
  EXPECT_EQ(written(readTrigger(document)), document);
  const json steers{{"name", "slow"},
                    {"when", {{"every", 3}}},
                    {"do", "steer"},
                    {"steer", {{"dt", 0.5}}},
                    {"exact", false}};
  EXPECT_EQ(written(readTrigger(steers)), steers);
  json shorter = document;
  shorter["batch"].erase("prefix");
  EXPECT_EQ(readTrigger(shorter).document.at("prefix"), "picture-{step}");
}

TEST(Trigger, WrongDocumentsSayWhatWasExpected) {
  const auto expect = [](const char* key, const json& value, const std::string& why) {
    json document = every(5);
    document[key] = value;
    EXPECT_NE(errorOf(document).find(why), std::string::npos) << errorOf(document);
  };
  EXPECT_NE(errorOf(json::array()), "");
  expect("names", 1, "unknown key");
  expect("name", 5, "`name`: expected a text");
  expect("name", "", "0 bytes");
  expect("when", json::object(), "expected an object with `every`");
  expect("when", {{"always", true}}, "unknown key");
  expect("when", {{"every", 0}}, "an integer from 1 up");
  expect("when", {{"above", 5}}, "a number for each field");
  expect("when", {{"above", {{"t", "hot"}}}}, "a number for field");
  expect("do", "export", "\"batch\", \"cinema\", \"event\" or \"steer\"");
  expect("do", "steer", "`steer`: expected");
  expect("steer", {{"dt", 1}}, "`steer`: expected");
  expect("do", "batch", "`batch`: expected");
  expect("batch", json::object(), "`batch`: expected");
  expect("exact", 1, "true or false");
  json batch = every(5);
  batch["do"] = "batch";
  batch["batch"] = {{"prefix", "same"}};
  EXPECT_NE(errorOf(batch).find("{step}"), std::string::npos);
  batch["batch"] = {{"to", "client"}};
  EXPECT_NE(errorOf(batch).find("there is no client"), std::string::npos);
}

TEST(Trigger, DatabasesGrowByTimeOrAreOnesOfTheirStep) {
  json document = every(5);
  document["do"] = "cinema";
  EXPECT_NE(errorOf(document).find("`cinema`: expected"), std::string::npos) << errorOf(document);
  document["cinema"] = {{"state", json::object()}, {"sweep", {{"axes", {{{"axis", "time"}}}}}}};
  EXPECT_NE(errorOf(document).find("`to`: expected a text"), std::string::npos) << errorOf(document);
  document["cinema"]["to"] = "a.cdb";
  EXPECT_EQ(errorOf(document), "");
  document["exact"] = false;
  EXPECT_EQ(written(readTrigger(document)), document);
  EXPECT_EQ(statementOf(readTrigger(document), 7), "viewer.cinema " + document["cinema"].dump());
  document["cinema"]["steps"] = 2;
  EXPECT_NE(errorOf(document).find("`steps`: expected none"), std::string::npos) << errorOf(document);
  document["cinema"].erase("steps");
  document["cinema"]["sweep"]["axes"][0]["axis"] = "phi";
  EXPECT_NE(errorOf(document).find("`sweep`: expected an axis \"time\""), std::string::npos)
      << errorOf(document);
  document["cinema"]["to"] = "a-{step}.cdb";
  EXPECT_NE(statementOf(readTrigger(document), 7).find("a-00000007.cdb"), std::string::npos);
  document["batch"] = json::object();
  EXPECT_NE(errorOf(document).find("`batch`: expected"), std::string::npos) << errorOf(document);
}

/// The steps of 1 to `last`, every `stride`, that a condition holds for.
std::vector<int64_t> heldFor(const json& when, const std::function<double(int64_t)>& value, int64_t last = 12,
                             int64_t stride = 1) {
  TriggerCondition condition(readTrigger({{"name", "t"}, {"when", when}, {"do", "event"}}));
  std::vector<int64_t> steps;
  for (int64_t step = 1; step <= last; step += stride) {
    const double v = value(step);
    if (condition.holds(step, [&](const std::string&) { return StepValues{v - 1, v, step % 2}; }))
      steps.push_back(step);
  }
  return steps;
}

TEST(Trigger, HoldsEverySoManySteps) {
  const auto any = [](int64_t) { return 0.0; };
  EXPECT_EQ(heldFor({{"every", 1}}, any, 3), (std::vector<int64_t>{1, 2, 3}));
  EXPECT_EQ(heldFor({{"every", 5}}, any), (std::vector<int64_t>{1, 6, 11}));
  EXPECT_EQ(heldFor({{"every", 5}}, any, 20, 3), (std::vector<int64_t>{1, 7, 13, 19}))
      << "where steps are left out";
}

TEST(Trigger, HoldsOnceWhereAThresholdIsCrossed) {
  const auto wave = [](int64_t step) { return step % 6 < 3 ? 0.0 : 10.0; };  // 10 at 3 to 5 and 9 to 11
  EXPECT_EQ(heldFor({{"above", {{"t", 5}}}}, wave), (std::vector<int64_t>{3, 9}));
  EXPECT_EQ(heldFor({{"below", {{"t", 5}}}}, wave), (std::vector<int64_t>{1, 6, 12}));
  EXPECT_EQ(heldFor({{"above", {{"t", 10}}}}, wave), std::vector<int64_t>{}) << "above, not at it";
  EXPECT_EQ(heldFor({{"nodata", {{"t", 0}}}}, wave, 6), (std::vector<int64_t>{1, 3, 5}));
  EXPECT_EQ(heldFor({{"above", {{"t", 5}}}, {"nodata", {{"t", 0}}}}, wave),
            (std::vector<int64_t>{3, 5, 9, 11}))
      << "both";
  EXPECT_EQ(heldFor({{"above", {{"t", 5}}}, {"every", 2}}, wave), (std::vector<int64_t>{3, 5, 9, 11}))
      << "and again while it holds";
}

TEST(Trigger, SaysWhichStepMayBeTheNext) {
  TriggerCondition some(readTrigger(every(10)));
  EXPECT_EQ(some.next(), std::nullopt);
  some.holds(3, {});
  EXPECT_EQ(some.next(), 13);
  json document = every(10);
  document["when"]["above"]["t"] = 5;
  TriggerCondition hot(readTrigger(document));
  hot.holds(3, [](const std::string&) { return StepValues{0, 10, 0}; });
  EXPECT_EQ(hot.next(), std::nullopt) << "each step is looked at";
}

TEST(Trigger, PrefixesHaveTheStep) {
  EXPECT_EQ(nameAtStep("a-{step}", 42), "a-00000042");
  EXPECT_EQ(nameAtStep("{step}/{step}", 123456789), "123456789/123456789");
}

/// A heat stream of two ranks, whose values at step s are those of MiniSimulation.
struct Heat {
  explicit Heat(const TestServer& server, const json& more = json::object())
      : simulation("heat", grid, blocks(), 2, {{"t"}}, Layout::Together, options(server, more)) {}
  static std::string options(const TestServer& server, const json& more) {
    json all = json::parse(to(server));
    all.update(more);
    return all.dump();
  }
  static std::vector<insitu::Block> blocks() {
    return {{0, 0, {{0, 0, 0}, {16, 16, 8}}}, {1, 0, {{0, 0, 8}, {16, 16, 8}}}};
  }
  Grid grid = gridOf({16, 16, 16});
  MiniSimulation simulation;
};

/// What a client is told of streams.
class StreamEvents {
 public:
  explicit StreamEvents(const TestServer& server) {
    auto options = server.options();
    options.onEvent = [this](const json& event) {
      if (!event.contains("stream")) return;
      const std::lock_guard lock(mutex_);
      events_.push_back(event);
    };
    client = std::make_unique<Client>(options);
    client->expect("load insitu");
    client->expect("insitu.listen");
  }
  std::vector<json> all(const std::string& kind) const {
    std::vector<json> some;
    const std::lock_guard lock(mutex_);
    for (const json& e : events_)
      if (e.at("event") == kind) some.push_back(e);
    return some;
  }
  json triggers() { return client->expect("insitu.triggers heat").at("triggers"); }

 private:
  mutable std::mutex mutex_;
  std::vector<json> events_;

 public:
  std::unique_ptr<Client> client;  // after what it uses, so that it goes first
};

std::vector<std::string> picturesIn(const TestServer& server) {
  std::vector<std::string> names;
  for (const auto& file : std::filesystem::directory_iterator(server.folder().path()))
    if (file.path().extension() == ".png") names.push_back(file.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

json batchOf(const std::string& prefix = "heat-{step}") {
  json state = json::parse(stateOf("heat.t"));
  state["Camera"] = {{"fit", true}, {"dimensions", {48, 40}}};
  return {{"state", state}, {"prefix", prefix}};
}

TEST(Triggers, WritePicturesEverySoManyStepsWithoutAnyClient) {
  const auto server = serve();
  json trigger{
      {"name", "movie"}, {"when", {{"every", 7}}}, {"do", "batch"}, {"batch", batchOf()}, {"exact", true}};
  std::ofstream(server->folder().path() / "triggers.json") << json::array({trigger});
  {
    Heat heat(*server, {{"triggers", (server->folder().path() / "triggers.json").string()},
                        {"policy", "wait"},
                        {"time-out", nullptr}});
    for (int i = 0; i < 22; i++)
      EXPECT_EQ(heat.simulation.publishTogether(), 2) << gxy_message(heat.simulation.rank(0));
    until([&] { return heat.simulation.published() == 22; }, "the last step");
  }
  until([&] { return server->serverRank().streaming.list().empty(); }, "the end of the stream");
  EXPECT_EQ(picturesIn(*server),
            (std::vector<std::string>{"heat-00000001_00000.png", "heat-00000008_00000.png",
                                      "heat-00000015_00000.png", "heat-00000022_00000.png"}));
}

TEST(Triggers, MakeADatabaseThatIsValidAfterEachStep) {
  const auto server = serve();
  const std::filesystem::path folder = server->folder().path();
  json cinema{{"state", batchOf()["state"]},
              {"sweep", {{"axes", {{{"axis", "time"}}, {{"axis", "phi"}, {"values", {0, 90}}}}}}},
              {"to", "heat"}};
  const json trigger{
      {"name", "cinema"}, {"when", {{"every", 2}}}, {"do", "cinema"}, {"cinema", cinema}, {"exact", true}};
  {
    Heat heat(*server, {{"triggers", json::array({trigger})}, {"policy", "wait"}, {"time-out", nullptr}});
    size_t rows = 0;
    for (int i = 0; i < 5; i++) {
      EXPECT_EQ(heat.simulation.publishTogether(), 2) << gxy_message(heat.simulation.rank(0));
      if (!std::filesystem::exists(folder / "heat.cdb/data.csv")) continue;
      const CinemaCheck check = checkCinema(folder / "heat.cdb");
      EXPECT_TRUE(check.problems.empty()) << check.problems.front();
      EXPECT_GE(check.rows, rows);
      EXPECT_EQ(check.rows % 2, 0u) << "whole steps";
      rows = check.rows;
    }
    until([&] { return heat.simulation.published() == 5; }, "the last step");
  }
  until([&] { return server->serverRank().streaming.list().empty(); }, "the end of the stream");
  EXPECT_TRUE(checkCinema(folder / "heat.cdb").problems.empty());
  std::ifstream in(folder / "heat.cdb/data.csv", std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  EXPECT_EQ(text,
            "time,phi,FILE\r\n0.5,0.0,time=0.5/0.0.png\r\n0.5,90.0,time=0.5/90.0.png\r\n"
            "1.5,0.0,time=1.5/0.0.png\r\n1.5,90.0,time=1.5/90.0.png\r\n"
            "2.5,0.0,time=2.5/0.0.png\r\n2.5,90.0,time=2.5/90.0.png\r\n");
}

TEST(Triggers, LeaveTheStepsBetweenUntakenUnlessSomebodyWantsThem) {
  const auto server = serve();
  StreamEvents events(*server);
  Heat heat(*server);
  run(heat.simulation, [&] { return heat.simulation.published() >= 1; });
  events.client->expect("insitu.trigger heat " + every(60).dump());
  run(heat.simulation, [&] { return events.all("trigger").size() >= 5; });
  const int64_t taken = heat.simulation.published(), steps = heat.simulation.step();
  EXPECT_LT(taken, 5 + 6) << "one for each, and some to find out how far apart steps are, of " << steps;
  std::vector<int64_t> fired;
  for (const json& e : events.all("trigger")) fired.push_back(e.at("step"));
  for (size_t i = 1; i < fired.size(); i++) EXPECT_GE(fired[i] - fired[i - 1], 60);
  events.client->expect("load data");
  events.client->expect("observe");
  const int64_t before = heat.simulation.step();
  run(heat.simulation, [&] { return heat.simulation.published() >= taken + 3; });
  EXPECT_LT(heat.simulation.step() - before, 120) << "a client wants the steps between";
}

TEST(Triggers, DoNotHoldUpClientsThatWantStepsSooner) {
  const auto server = serve();
  StreamEvents events(*server);
  Heat heat(*server);
  run(heat.simulation, [&] { return heat.simulation.published() >= 1; });
  events.client->expect("insitu.trigger heat " + every(1000000).dump());
  run(heat.simulation, [&] { return events.all("trigger").size() == 1; });
  for (int i = 0; i < 50; i++) heat.simulation.publish();
  const int64_t before = heat.simulation.published();
  events.client->expect("load data");
  events.client->expect("data.observe");
  run(heat.simulation, [&] { return heat.simulation.published() >= before + 3; });
  events.client->expect("data.unobserve");
  events.client->expect(R"(insitu.trigger heat {"name": "t", "when": {"every": 1}, "do": "event"})");
  run(heat.simulation, [&] { return events.all("trigger").size() >= 4; });
}

TEST(Triggers, TellOfThresholdsWithTheValues) {
  const auto server = serve();
  StreamEvents events(*server);
  Heat heat(*server);
  run(heat.simulation, [&] { return heat.simulation.published() >= 1; });
  events.client->expect(
      R"(insitu.trigger heat {"name": "hot", "when": {"above": {"t": 105}}, "do": "event"})");
  events.client->expect(
      R"(insitu.trigger heat {"name": "none", "when": {"nodata": {"t": 0}}, "do": "event"})");
  run(heat.simulation, [&] { return events.all("trigger").size() >= 3; });
  for (const json& e : events.all("trigger")) {
    EXPECT_EQ(e.at("stream"), "heat");
    EXPECT_EQ(e.at("trigger"), "hot");
    EXPECT_EQ(e.at("time"), 0.5 * e.at("step").get<double>());
    EXPECT_GT(e.at("values").at("t").at("range").at(1), 105);
    double most = 0;
    for (int64_t k = 0; k < 16; k++)
      for (int64_t j = 0; j < 16; j++)
        for (int64_t i = 0; i < 16; i++)
          most = std::max(most, double(float(valueAt(heat.grid, {i, j, k}, e.at("step"), 0, 0))));
    EXPECT_EQ(e.at("values").at("t").at("range").at(1), most);
  }
  events.client->expect("insitu.untrigger heat hot");
  EXPECT_FALSE(events.client->request("insitu.untrigger heat hot").ok);
  EXPECT_EQ(events.triggers().size(), 1u);
}

TEST(Triggers, ThatFailAreToldAndTheStreamGoesOn) {
  const auto server = serve();
  StreamEvents events(*server);
  Heat heat(*server);
  run(heat.simulation, [&] { return heat.simulation.published() >= 1; });
  json batch = batchOf();
  batch["state"] = json::parse(stateOf("nothing"));
  events.client->expect(
      "insitu.trigger heat " +
      json{{"name", "bad"}, {"when", {{"every", 1}}}, {"do", "batch"}, {"batch", batch}}.dump());
  events.client->expect(R"(insitu.trigger heat {"name": "odd", "when": {"above": {"u": 1}}, "do": "event"})");
  run(heat.simulation, [&] { return events.all("trigger failed").size() >= 2; });
  EXPECT_NE(events.all("trigger failed")[0].at("error").get<std::string>().find("nothing"),
            std::string::npos);
  const json list = events.triggers();
  EXPECT_NE(list.at(0).at("problem").get<std::string>().find("nothing"), std::string::npos) << list;
  EXPECT_NE(list.at(1).at("problem").get<std::string>().find("heat.u"), std::string::npos) << list;
  EXPECT_TRUE(picturesIn(*server).empty());
  EXPECT_FALSE(events.client->request("insitu.trigger nothing " + every(1).dump()).ok);
  EXPECT_FALSE(events.client->request("insitu.trigger heat {}").ok);
}

TEST(Triggers, EndWithTheirStreamAndTheServer) {
  for (const bool stop : {false, true}) {
    auto server = serve();
    StreamEvents events(*server);
    {
      Heat heat(*server);
      run(heat.simulation, [&] { return heat.simulation.published() >= 1; });
      events.client->expect(
          "insitu.trigger heat " +
          json{{"name", "movie"}, {"when", {{"every", 1}}}, {"do", "batch"}, {"batch", batchOf()}}.dump());
      run(heat.simulation, [&] { return !picturesIn(*server).empty(); });
      if (stop) server->stop();
    }
    if (stop) continue;
    until([&] { return events.all("stream ended").size() == 1; }, "the end of the stream");
    EXPECT_EQ(events.all("stream ended")[0].at("stream"), "heat");
    EXPECT_NE(events.all("stream ended")[0].at("reason"), "");
    EXPECT_FALSE(events.client->request("insitu.triggers heat").ok);
  }
}

}  // namespace
}  // namespace gxy::test
