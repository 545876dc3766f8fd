// SPDX-License-Identifier: Apache-2.0
// Module graph: documents, their evaluation on the ranks, and what clients are told.
#include "multiserver/graph/marked_edits.h"
#include "tests/multiserver/graph_client.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using nlohmann::json;

const json kTwelve = madeBy("Seeds", "seeds", {{"domain", "ball"}}, {{"shape", "line"}, {"count", 12}});

// A session of text verbs alone, as msclient says them.
TEST(Graph, RunsWhatItsDocumentSaysOnAnyNumberOfRanks) {
  for (const int ranks : {1, 3}) {
    const auto server = serveGraphs(ranks);
    GraphClient c(*server);
    c.say(importBall("ball"));
    const int64_t before = server->serverRank(0).ledger.total("user");
    EXPECT_EQ(c.say(newGraph({liveVolume("ball"), kTwelve})).at("revision"), 1);
    EXPECT_EQ(c.state("ball"), "done");
    EXPECT_EQ(c.state("seeds"), "waiting") << "nothing needs it";
    c.say("graph.run g");
    c.say("graph.wait g");
    const json seeds = c.node("seeds");
    EXPECT_EQ(seeds.at("state"), "done") << seeds;
    EXPECT_EQ(seeds.at("generation"), 1);
    EXPECT_GT(seeds.at("bytes"), 0);
    EXPECT_EQ(c.say("data.list").at("datasets").size(), 1u) << "without what graphs have made";
    EXPECT_EQ(c.say("data.list all").at("datasets").size(), 2u);
    const json info = c.say("info g/seeds").at("datasets").at(0);
    EXPECT_EQ(info.at("type"), "Particles");
    EXPECT_EQ(info.at("primitives"), 12);
    EXPECT_EQ(info.at("provenance").at("filter"), "Seeds");
    EXPECT_TRUE(c.hasMemory(0, "graph g/seeds"));
    for (const char* refused : {"drop g/seeds", "rename g/seeds x", "publish g/seeds"})
      EXPECT_NE(c.error(refused).find("is a node of a graph"), std::string::npos) << refused;
    EXPECT_EQ(c.say("graph.list").at("graphs").at(0).at("nodes"), 2);
    c.say("graph.drop g");
    EXPECT_EQ(c.say("data.list all").at("datasets").size(), 1u);
    EXPECT_NE(c.error("graph.get g").find("there is none"), std::string::npos);
    EXPECT_EQ(server->serverRank(0).ledger.total("user"), before);
  }
}

TEST(Graph, NumbersOfAFilterAreToldWithItsState) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  c.say(newGraph({liveVolume("ball"), madeBy("Statistics", "numbers", {{"field", "ball"}})}));
  c.say("graph.run g numbers");
  c.say("graph.wait g");
  EXPECT_EQ(c.node("numbers").at("told").at("count"), 16 * 16 * 16) << c.node("numbers");
}

TEST(Graph, FilesAreReadWhenTheyAreNeeded) {
  const auto server = serveGraphs(2);
  writeBall(server->folder().path().string(), "twice", 16, 2);
  GraphClient c(*server);
  c.say(newGraph({{{"name", "file"}, {"type", "Volume"}, {"filename", "ball.vol"}},
                  {{"name", "missing"}, {"type", "Volume"}, {"filename", "none.vol"}},
                  madeBy("Statistics", "numbers", {{"field", "file"}}),
                  madeBy("Held", "copy", {{"field", "missing"}})}));
  EXPECT_EQ(c.say("data.list all").at("datasets").size(), 0u);
  c.say("graph.run g numbers");
  c.say("graph.wait g");
  const double least = c.node("numbers").at("told").at("largest").at("value");
  c.edit({{{"set", {"Datasets", "file", "filename"}}, {"to", "twice.vol"}}});
  c.say("graph.run g numbers");
  c.say("graph.wait g");
  EXPECT_DOUBLE_EQ(c.node("numbers").at("told").at("largest").at("value").get<double>(), 2 * least);
  c.say("graph.run g copy");
  c.say("graph.wait g");
  EXPECT_EQ(c.state("missing"), "failed");
  EXPECT_EQ(c.state("copy"), "blocked");
  c.say("graph.drop g");
  EXPECT_EQ(c.say("data.list all").at("datasets").size(), 0u);
  EXPECT_EQ(server->serverRank(1).ledger.total("user"), 0);
}

TEST(Graph, WhatAFileHasBecomeGoesWithItsNodeOrTheGraph) {
  const auto server = serveGraphs(2);
  writeBall(server->folder().path().string(), "twice", 16, 2);
  GraphClient c(*server);
  for (const char* end : {"node", "graph"}) {
    c.say(newGraph({{{"name", "file"}, {"type", "Volume"}, {"filename", "ball.vol"}},
                    madeBy("Statistics", "numbers", {{"field", "file"}})}));
    c.say("graph.run g numbers");
    c.say("graph.wait g");
    EXPECT_EQ(c.say("data.list all").at("datasets").size(), 1u);
    c.edit({{{"set", {"Datasets", "file", "filename"}}, {"to", "twice.vol"}}});  // which nothing reads
    if (end == std::string("node")) {
      c.edit({{{"set", {"Datasets"}}, {"to", json::array()}}});
      until([&] { return c.say("data.list all").at("datasets").empty(); }, "it is dropped");
    }
    c.say("graph.drop g");
    EXPECT_EQ(c.say("data.list all").at("datasets").size(), 0u) << end;
    for (int r = 0; r < 2; r++) EXPECT_EQ(server->serverRank(r).ledger.total("user"), 0) << end;
  }
}

TEST(Graph, ANodeMayBecomeAFilterAndAFileAgain) {
  const auto server = serveGraphs(2);
  GraphClient c(*server);
  c.say(importBall("ball"));
  const json file{{"name", "node"}, {"type", "Volume"}, {"filename", "ball.vol"}};
  const json reads = madeBy("Statistics", "numbers", {{"field", "node"}});
  c.say(newGraph({liveVolume("ball"), file, reads}));
  for (int i = 0; i < sweep(10); i++) {
    c.say("graph.run g numbers");
    if (i % 2) c.say("graph.wait g");
    c.edit({{{"set", {"Datasets", "node"}}, {"to", copyOf("node", "ball")}}});
    if (i % 3) c.say("graph.run g numbers");
    c.edit({{{"set", {"Datasets", "node"}}, {"to", file}}});
    c.say("graph.run g numbers");
    c.say("graph.wait g");
    ASSERT_EQ(c.state("numbers"), "done") << i << ": " << c.node("node");
    ASSERT_TRUE(c.say("info g/node").at("datasets").at(0).contains("file")) << i;
  }
  c.say("graph.drop g");
  EXPECT_EQ(c.say("data.list all").at("datasets").size(), 1u);
  c.say("drop ball");
  EXPECT_EQ(server->serverRank(1).ledger.total("user"), 0);
}

TEST(Graph, ADatasetOfTheUserKeepsItsNameAndItsData) {
  const auto server = serveGraphs(2);
  writeBall(server->folder().path().string(), "twice", 16, 2);
  GraphClient c(*server);
  c.say(importBall("g/file"));
  c.say(newGraph({{{"name", "file"}, {"type", "Volume"}, {"filename", "twice.vol"}},
                  madeBy("Statistics", "numbers", {{"field", "file"}})}));
  c.say("graph.run g");
  c.say("graph.wait g");
  EXPECT_EQ(c.node("file").at("text"),
            "dataset \"g/file\" is not of the graph, expected another name for it or for the graph's node");
  c.say("graph.drop g");
  const json info = c.say("info g/file").at("datasets").at(0);
  EXPECT_EQ(info.at("generation"), 1);
  EXPECT_NE(info.at("file").get<std::string>().find("ball.vol"), std::string::npos);
}

TEST(Graph, ANameWhoseObjectHasGoneIsNotThere) {
  const auto server = serveGraphs(1);
  GraphClient c(*server);
  ServerRank& root = server->serverRank();
  root.directory.bind("ghost", Scope::Private, {root.keys.next(), "Volume", "user"});
  c.say(newGraph({liveVolume("ghost")}));
  EXPECT_EQ(c.state("ghost"), "waiting");
}

TEST(Graph, AnEditAndItsInverseGiveTheDocumentBack) {
  const auto server = serveGraphs(1);
  GraphClient c(*server);
  c.say(newGraph({liveVolume("ball"), kTwelve, madeBy("Held", "copy", {{"field", "ball"}})},
                 json::array({viewOf("v", {"copy"})})));
  const json before = c.say("graph.get g").at("document");
  const std::vector<json> all{
      {{{"set", {"Datasets", "seeds", "count"}}, {"to", 7}}, {{"set", {"Datasets", 1, "note"}}, {"to", "x"}}},
      {{{"remove", {"Datasets", "copy"}}}},
      {{{"add", {"Datasets"}}, {"to", madeBy("Held", "more", {{"field", "copy"}})}, {"at", 0}}},
      {{{"add", {"GUI", "notes"}}, {"to", 1}}},
      {{{"rename", {"Datasets", "copy"}}, {"to", "clone"}},
       {{"rename", {"Visualizations", "v"}}, {"to", "w"}}},
      {{{"remove", {"Datasets", "seeds"}}}, {{"rename", {"Datasets", "copy"}}, {"to", "seeds"}}},
      {{{"set", json::array()}, {"to", {{"Datasets", json::array()}}}}}};
  c.edit({{{"set", {"GUI"}}, {"to", json::object()}}});
  const json start = c.say("graph.get g").at("document");
  uint64_t revision = 2;
  for (const json& edits : all) {
    const json reply = c.edit(edits);
    EXPECT_EQ(reply.at("revision"), ++revision);
    EXPECT_NE(c.say("graph.get g").at("document"), start) << edits;
    c.edit(reply.at("inverse"));
    revision++;
    EXPECT_EQ(c.say("graph.get g").at("document"), start) << edits;
  }
  EXPECT_NE(before, start);
}

TEST(Graph, AnEditThatIsSentTwiceCountsOnce) {
  const auto server = serveGraphs(1);
  GraphClient ann(*server), bob(*server);
  ann.say(newGraph(json::array()));
  const auto send = [](GraphClient& client, const std::string& who, int number, const char* to) {
    return client.say(
        "graph.edit g " +
        json{{"edits", {{{"add", json::array({"notes"})}, {"to", to}}}}, {"once", {who, number}}}.dump());
  };
  EXPECT_EQ(send(ann, "ann", 0, "a0").at("revision"), 2);
  EXPECT_EQ(send(bob, "bob", 0, "b0").at("revision"), 3);
  // The reply was lost: the client comes with another session, and sends it again.
  const json again = send(bob, "ann", 0, "a0");
  EXPECT_EQ(again.at("revision"), 2);
  EXPECT_EQ(again.at("repeated"), true);
  EXPECT_FALSE(again.contains("inverse"));
  EXPECT_EQ(send(ann, "ann", 7, "a7").at("revision"), 4);
  EXPECT_EQ(send(ann, "ann", 3, "a3").at("repeated"), true);
  EXPECT_EQ(ann.say("graph.get g").at("document").at("notes"), json({"a0", "b0", "a7"}));
  // One that was refused has not been made.
  const auto wrong = [](const json& once) {
    return "graph.edit g " + json{{"edits", {{{"remove", json::array({"nothing"})}}}}, {"once", once}}.dump();
  };
  EXPECT_NE(ann.error(wrong({"ann", 8})).find("there is none"), std::string::npos);
  EXPECT_EQ(send(ann, "ann", 8, "a8").at("revision"), 5);
  const std::string expected = "`once`: expected [text of 1 to 100 bytes, integer >= 0], found";
  for (const json& once : {json(1), json::array(), json({"ann"}), json({"ann", -1}), json({"", 1}),
                           json({std::string(101, 'a'), 1}), json({"ann", 1, 2}), json({1, 1})})
    EXPECT_NE(ann.error(wrong(once)).find(expected), std::string::npos) << once;
}

TEST(Graph, TheClientsThatHaveEditedLastAreRemembered) {
  MarkedEdits edits;
  EXPECT_EQ(edits.revisionOf({"first", 1}), std::nullopt);
  edits.add({"first", 1}, 1);
  for (uint64_t i = 1; i < MarkedEdits::kMost; i++) edits.add({std::to_string(i), 5}, 1 + i);
  EXPECT_EQ(edits.revisionOf({"first", 1}), 1);
  edits.add({"first", 2}, 5000);
  edits.add({"another", 1}, 5001);
  EXPECT_EQ(edits.revisionOf({"first", 2}), 5000);
  EXPECT_EQ(edits.revisionOf({"1", 5}), std::nullopt);
  EXPECT_EQ(edits.revisionOf({"2", 5}), 3);
  EXPECT_EQ(edits.revisionOf({"2", 6}), std::nullopt);
}

TEST(Graph, ARenameTakesItsReferencesAlong) {
  const auto server = serveGraphs(1);
  GraphClient c(*server);
  c.say(newGraph({liveVolume("ball"), madeBy("Held", "copy", {{"field", "ball"}})},
                 json::array({viewOf("v", {"ball", "copy"})})));
  c.edit({{{"rename", {"Datasets", "ball"}}, {"to", "bowl"}}});
  const json document = c.say("graph.get g").at("document");
  EXPECT_EQ(document.at("Datasets").at(1).at("inputs").at("field"), "bowl");
  EXPECT_EQ(document.at("Visualizations").at(0).at("operators").at(0).at("dataset"), "bowl");
}

TEST(Graph, AnEditThatIsWrongChangesNothingAndSaysWhere) {
  const auto server = serveGraphs(1);
  GraphClient c(*server);
  c.say(newGraph({liveVolume("ball"), kTwelve, madeBy("Held", "copy", {{"field", "ball"}})},
                 json::array({viewOf("v", {"copy"})})));
  const json before = c.say("graph.get g");
  const auto refused = [&](const json& edits, const std::string& expected) {
    const std::string error = c.error("graph.edit g " + json{{"edits", edits}}.dump());
    EXPECT_NE(error.find(expected), std::string::npos) << error << " for " << edits;
  };
  const json good{{"set", {"Datasets", "seeds", "count"}}, {"to", 5}};
  refused({good, {{"set", {"Datasets", "none", "count"}}, {"to", 5}}},
          "`edits`[1]: Datasets[\"none\"]: there is no such element");
  refused({good, {{"set", {"Datasets", "seeds", "count"}}, {"to", "many"}}},
          "Datasets[\"seeds\"]: `count`: expected an integer");
  refused({{{"set", {"Datasets", "copy", "inputs", "field"}}, {"to", "copy"}}}, "no cycle");
  refused({{{"set", {"Datasets", "copy", "inputs", "field"}}, {"to", "seeds"}}},
          "expected Volume, found \"seeds\"");
  refused({{{"set", {"Datasets", "copy", "inputs", "fields"}}, {"to", "ball"}}},
          "there is no input `fields`");
  refused({{{"set", {"Visualizations", "v", "operators", 0, "opacity"}}, {"to", "thin"}}},
          "Visualizations[\"v\"]: `opacity`: expected");
  refused({{{"set", {"Visualizations", "v", "operators", 0, "dataset"}}, {"to", "seeds"}}},
          "dataset of type Volume");
  refused({{{"add", {"Datasets"}}, {"to", liveVolume("ball")}}}, "two datasets named \"ball\"");
  refused({{{"set", {"version"}}, {"to", 2}}}, "`version`: expected 1, found \"2\"");
  refused({{{"drop", {"version"}}}}, "expected `set`, `add`, `remove` or `rename`");
  refused(json::array(), "expected a list of edits");
  EXPECT_EQ(c.say("graph.get g"), before);
  json many = json::array();
  for (int i = 0; i < 1001; i++) many.push_back(liveVolume("d" + std::to_string(i)));
  refused({{{"set", {"Datasets"}}, {"to", many}}}, "`Datasets`: expected at most 1000, found 1001");
  json deep = 1;
  for (int i = 0; i < 40; i++) deep = json::array({deep});
  refused({{{"set", {"GUI"}}, {"to", deep}}}, "at most 32 deep");
  EXPECT_NE(c.error("graph.new g").find("there is one"), std::string::npos);
  EXPECT_NE(c.error("graph.new a/b").find("expected a name"), std::string::npos);
}

TEST(Graph, WhatIsMissingIsAState) {
  const auto server = serveGraphs(1);
  GraphClient c(*server);
  json view = viewOf("v", {"copy"});
  view["operators"].push_back("look");
  c.say(newGraph({madeBy("Held", "copy", json::object()), madeBy("Held", "next", {{"field", "copy"}}),
                  madeBy("Unknown", "odd", {{"x", "copy"}}), liveVolume("ball")},
                 json::array({view})));
  EXPECT_EQ(c.state("copy"), "incomplete");
  EXPECT_EQ(c.node("next").at("by"), "copy");
  EXPECT_EQ(c.state("odd"), "blocked");
  EXPECT_EQ(c.state("ball"), "waiting");
  EXPECT_EQ(c.node("v", "view").at("text"), "there is no operator \"look\"");
  json look = view["operators"][0];
  look["name"] = "look";
  c.edit({{{"add", {"Operators"}}, {"to", look}}});
  EXPECT_EQ(c.node("v", "view").at("text"), "no window shows it");
}

TEST(Graph, OperatorsByNameAreLimitedBeforeTheyAreCopied) {
  const auto server = serveGraphs(1);
  GraphClient c(*server);
  json view = viewOf("v", {"ball"});
  json look = view["operators"][0];
  look["name"] = "o";
  look["colormap"] = "Viridis";  // a short text for many points
  view.erase("camera");
  json document{{"Datasets", {liveVolume("ball")}}, {"Operators", json::array({look})}};
  const auto errorOf = [&](size_t views, size_t operators) {
    view["operators"] = std::vector<std::string>(operators, "o");
    document["Visualizations"] = json::array();
    for (size_t i = 0; i < views; i++) {
      view["name"] = "v" + std::to_string(i);
      document["Visualizations"].push_back(view);
    }
    return c.error("graph.new g " + document.dump());
  };
  EXPECT_NE(errorOf(1, 65).find("rendering: 65 operators, expected at most 64"), std::string::npos);
  EXPECT_NE(errorOf(1000, 64).find("bytes of them, expected at most 67108864"), std::string::npos);
  EXPECT_EQ(errorOf(1, 64), "");
}

TEST(Graph, CheckTellsAllThatIsWrong) {
  const auto server = serveGraphs(1);
  GraphClient c(*server);
  json view = viewOf("v", {"ball"});
  view["size"] = 3;
  const json reply = c.say("graph.check " + json{{"Datasets", {liveVolume("ball"), {{"name", "x"}}, 3}},
                                                 {"Visualizations", json::array({view})}}
                                                .dump());
  std::vector<std::string> paths;
  for (const json& error : reply.at("errors")) paths.push_back(error.at("path"));
  EXPECT_EQ(paths, (std::vector<std::string>{"Datasets[\"x\"]", "Datasets[2]", "Visualizations[\"v\"]"}));
  EXPECT_EQ(c.say("graph.check {}").at("errors").size(), 0u);
  json many = json::array();
  for (int i = 0; i < 1000; i++) many.push_back(3);
  EXPECT_EQ(c.say("graph.check " + json{{"Datasets", many}}.dump()).at("errors").size(), 100u);
  many.push_back(3);
  EXPECT_EQ(c.say("graph.check " + json{{"Datasets", many}}.dump()).at("errors").size(), 1u)
      << "and nothing of them is read";
  EXPECT_EQ(c.say("graph.list").at("graphs").size(), 0u);
  bool hasSeeds = false;
  const json types = c.say("graph.types");
  for (const json& type : types.at("filters")) hasSeeds = hasSeeds || type.at("name") == "Seeds";
  EXPECT_TRUE(hasSeeds);
  std::map<std::string, json> keys;  // of operators
  for (const json& section : types.at("sections"))
    if (section.at("section") == "operator")
      for (const json& key : section.at("keys")) keys[key.at("key")] = key;
  EXPECT_EQ(keys.at("slices").at("types"), json({"Volume"}));
  EXPECT_EQ(keys.at("opacity").at("type"), "number 0 to 1");
  EXPECT_EQ(keys.at("opacity").at("default"), "`1.0`");
  EXPECT_FALSE(keys.at("opacity").contains("types"));
  EXPECT_EQ(keys.at("opacitymap").at("needs"), "volume rendering");
  EXPECT_EQ(keys.at("dataset").at("required"), true);
  EXPECT_EQ(keys.at("two sided").at("advanced"), true);
}

TEST(Graph, WatchersAreToldOfEditsAndStates) {
  const auto server = serveGraphs(2);
  GraphClient ann(*server), bob(*server);
  ann.say(importBall("ball"));
  ann.say(newGraph({liveVolume("ball"), kTwelve}));
  bob.say("graph.watch g");
  ann.say("graph.watch g");
  bob.untilEvent([](const json& e) { return e.at("event") == "present" && e.at("clients").size() == 2; });
  ann.edit({{{"set", {"Datasets", "seeds", "count"}}, {"to", 5}}});
  const json edit = bob.untilEvent([](const json& e) { return e.at("event") == "graph"; });
  EXPECT_EQ(edit.at("revision"), 2);
  EXPECT_EQ(edit.at("by").at("client"), "test");
  EXPECT_EQ(edit.at("edits").at(0).at("to"), 5);
  bob.say("graph.run g");
  const json done = ann.untilEvent([](const json& e) {
    return e.at("event") == "node" && e.at("node") == "seeds" && e.at("state") == "done";
  });
  EXPECT_EQ(done.at("graph"), "g");
  EXPECT_EQ(done.at("generation"), 1);
  ann.client.reset();
  bob.untilEvent([](const json& e) { return e.at("event") == "present" && e.at("clients").size() == 1; });
  bob.say("graph.unwatch g");
  bob.say("graph.watch g");
  bob.say("graph.drop g");
  bob.untilEvent([](const json& e) { return e.at("event") == "graph" && e.value("dropped", false); });
}

TEST(Graph, TenantsSeeTheirOwn) {
  const auto server = serveGraphs(1);
  GraphClient ann(*server, "ann"), bob(*server, "bob");
  ann.say("graph.new g");
  EXPECT_EQ(bob.say("graph.list").at("graphs").size(), 0u);
  for (const char* verb : {"get", "run", "pause", "resume", "cancel", "drop", "watch"})
    EXPECT_NE(bob.error(std::string("graph.") + verb + " g").find("there is none"), std::string::npos)
        << verb;
  EXPECT_NE(bob.error("viewer.show 1 {\"graph\": \"g\", \"view\": \"v\"}").find("there is none"),
            std::string::npos);
  bob.say("graph.new g");
}

}  // namespace
}  // namespace gxy::test
