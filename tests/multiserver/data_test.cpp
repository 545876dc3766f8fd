// SPDX-License-Identifier: Apache-2.0
// Module data: what several clients see of one data space.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <future>
#include <set>
#include <thread>

#include "core/comm/error.h"
#include "multiserver/protocol/json.h"
#include "multiserver/server/datasets.h"
#include "tests/multiserver/test_server.h"
#include "tests/support/seeds.h"

namespace gxy::test {
namespace {

using nlohmann::json;

std::unique_ptr<TestServer> serve(int ranks = 2) {
  ServerSetup setup;
  setup.ranks = ranks;
  setup.modules = GALAXY_MODULES;
  return std::make_unique<TestServer>(std::move(setup));
}

std::unique_ptr<Client> dataClient(const TestServer& server, const std::string& tenant = "user") {
  auto client = server.client(tenant);
  client->expect("load data");
  return client;
}

std::vector<std::string> names(Client& client) {
  std::vector<std::string> names;
  const json list = client.expect("list");
  for (const json& d : list.at("datasets")) names.push_back(d.at("name"));
  return names;
}

using Names = std::vector<std::string>;

TEST(Data, TheTranscriptsOfThePaperWork) {
  const auto server = serve();
  const auto first = dataClient(*server), second = dataClient(*server);
  EXPECT_EQ(first->expect("list;").at("text"), "datasets:");
  EXPECT_EQ(second
                ->expect("import { \"Datasets\": [\n  {\n    \"name\": \"eightBalls\",\n    \"filename\": "
                         "\"ball.vol\",\n    \"type\": \"Volume\" } ]};")
                .at("text"),
            "");
  EXPECT_EQ(first->expect("list;").at("text"), "datasets:\neightBalls");
  EXPECT_EQ(second->expect("list;").at("text"), "datasets:\neightBalls");
}

TEST(Data, InfoSaysWhatIsInAFileOnAnyNumberOfRanks) {
  for (const int ranks : {1, 3}) {
    const auto server = serve(ranks);
    const auto client = dataClient(*server);
    client->expect(importBall("ball"));
    const json info = client->expect("info ball").at("datasets").at(0);
    EXPECT_EQ(info.at("points"), (json{16, 16, 16}));
    EXPECT_EQ(info.at("generation"), 1);
    EXPECT_EQ(info.at("partitions"), ranks);
    const json range = client->expect("range ball").at("range");
    EXPECT_NEAR(range.at(0).get<double>(), std::sqrt(3.0) / 15, 1e-6);
    EXPECT_NEAR(range.at(1).get<double>(), std::sqrt(3.0), 1e-6);
  }
}

TEST(Data, NamesAreDroppedAndRenamed) {
  const auto server = serve();
  const auto client = dataClient(*server);
  client->expect(importBall("a name; with \\\"quotes\\\""));
  client->expect("rename \"a name; with \\\"quotes\\\"\" ball");
  EXPECT_EQ(names(*client), Names{"ball"});
  client->expect("drop ball");
  EXPECT_EQ(names(*client), Names{});
  EXPECT_FALSE(client->request("drop ball").ok);
  for (int rank = 0; rank < 2; rank++) EXPECT_EQ(server->serverRank(rank).ledger.total("user"), 0) << rank;
}

TEST(Data, TenantsSeeOnlyWhatIsShared) {
  const auto server = serve();
  const auto ann = dataClient(*server, "ann"), bob = dataClient(*server, "bob");
  ann->expect(importBall("ball"));
  EXPECT_EQ(names(*bob), Names{});
  EXPECT_FALSE(bob->request("info ball").ok);
  ann->expect("publish ball");
  EXPECT_EQ(names(*bob), Names{"ball"});
  EXPECT_EQ(bob->expect("list").at("datasets").at(0).at("owner"), "ann");
  EXPECT_FALSE(bob->request("drop ball").ok);
  EXPECT_FALSE(bob->request("rename ball mine").ok);
  EXPECT_FALSE(bob->request("unpublish ball").ok);
  ann->expect("unpublish ball");
  EXPECT_EQ(names(*bob), Names{});
  EXPECT_EQ(names(*ann), Names{"ball"});
}

TEST(Data, ARenameToANameInUseChangesNothing) {
  const auto server = serve();
  const auto ann = dataClient(*server, "ann"), bob = dataClient(*server, "bob");
  bob->expect(importBall("shared"));
  bob->expect("publish shared");
  ann->expect(importBall("first"));
  ann->expect(importBall("second"));
  for (const char* name : {"second", "shared", "first"})
    EXPECT_EQ(ann->request(std::string("rename first ") + name).error,
              "rename: the name \"" + std::string(name) + "\" is in use, expected a free one");
  EXPECT_EQ(names(*ann), (Names{"first", "second", "shared"}));
}

TEST(Data, ListSaysWhatOnlyItsOwnerMayWrite) {
  const auto server = serve();
  const auto ann = dataClient(*server, "ann"), bob = dataClient(*server, "bob");
  const auto readOnly = [](Client& client) {
    return client.expect("list").at("datasets").at(0).at("read only");
  };
  ann->expect(importBall("ball"));
  EXPECT_EQ(readOnly(*ann), false);
  ann->expect("publish ball");
  EXPECT_EQ(readOnly(*bob), true);
  EXPECT_EQ(bob->expect("info ball").at("datasets").at(0).at("scope"), "shared");
  ann->expect("unpublish ball");
  ann->expect("publish ball writable");
  EXPECT_EQ(readOnly(*bob), false);
}

TEST(Data, WhatIsPublishedForAllToWriteStaysItsOwners) {
  const auto server = serve();
  writeBall(server->folder().path().string(), "twice", 16, 2);
  const auto ann = dataClient(*server, "ann"), bob = dataClient(*server, "bob"),
             cid = dataClient(*server, "cid");
  ann->expect(importBall("ball"));
  ann->expect("publish ball writable");
  Generation generation = 1;
  for (Client* writer : {bob.get(), cid.get(), ann.get()}) {
    writer->expect("import shared " + importBall("ball", "twice.vol").substr(sizeof "import"));
    const json d = ann->expect("list").at("datasets").at(0);
    EXPECT_EQ(d.at("owner"), "ann");
    EXPECT_EQ(d.at("generation"), ++generation);
  }
  EXPECT_FALSE(bob->request("rename ball mine").ok);
  EXPECT_FALSE(bob->request("unpublish ball").ok);
  ann->expect(importBall("ball"));  // a private one, by which it is hidden
  ann->expect("rename ball other");
  ann->expect(importBall("ball"));
  const Reply taken = ann->request("unpublish ball");
  EXPECT_NE(taken.error.find("is in use there"), std::string::npos) << taken.error;
  ann->expect("drop ball");
  ann->expect("unpublish ball");
  EXPECT_EQ(names(*bob), Names{});
  ann->expect("publish ball writable");
  bob->expect("drop ball");
  EXPECT_EQ(names(*ann), Names{"other"});
}

TEST(Data, AnImportUnderANameInUseIsANewGeneration) {
  const auto server = serve();
  writeBall(server->folder().path().string(), "twice", 16, 2);
  const auto client = dataClient(*server);
  client->expect(importBall("ball"));
  const double before = client->expect("range ball").at("range").at(1);
  client->expect(importBall("ball", "twice.vol"));
  const json info = client->expect("info ball").at("datasets").at(0);
  EXPECT_EQ(info.at("generation"), 2);
  EXPECT_NEAR(info.at("range").at(1).get<double>(), 2 * before, 1e-5);
}

TEST(Data, ACopyKeepsWhatADatasetWas) {
  const auto server = serve();
  writeBall(server->folder().path().string(), "twice", 16, 2);
  const auto client = dataClient(*server);
  client->expect(importBall("ball"));
  const json before = client->expect("info ball").at("datasets").at(0);
  EXPECT_EQ(client->expect("copy ball kept").at("generation"), 1);
  client->expect(importBall("ball", "twice.vol"));
  const json kept = client->expect("info kept").at("datasets").at(0);
  for (const char* same : {"type", "range", "box", "points", "bytes", "partitions", "file"})
    EXPECT_EQ(kept.at(same), before.at(same)) << same;
  EXPECT_NE(client->expect("range ball").at("range"), kept.at("range"));
  EXPECT_NE(kept.at("origins"), before.at("origins"));
  EXPECT_EQ(client->expect("copy ball kept").at("generation"), 2);
  EXPECT_EQ(client->expect("range ball").at("range"), client->expect("range kept").at("range"));
  client->expect("drop ball");
  const json histogram = client->expect("histogram kept 4");
  uint64_t samples = 0;
  for (const json& count : histogram.at("counts")) samples += count.get<uint64_t>();
  EXPECT_EQ(samples, 16u * 16 * 16);
  client->expect("drop kept");
  for (int rank = 0; rank < 2; rank++) EXPECT_EQ(server->serverRank(rank).ledger.total("user"), 0) << rank;
}

TEST(Data, ACopyOfAnothersDataBelongsToWhoMadeIt) {
  const auto server = serve();
  const auto ann = dataClient(*server, "ann"), bob = dataClient(*server, "bob");
  ann->expect(importBall("ball"));
  EXPECT_NE(bob->request("copy ball mine").error.find("there is none that you see"), std::string::npos);
  ann->expect("publish ball");
  bob->expect("copy ball mine");
  ann->expect("drop ball");
  EXPECT_EQ(names(*bob), Names{"mine"});
  EXPECT_EQ(names(*ann), Names{});
  for (int rank = 0; rank < 2; rank++) {
    EXPECT_EQ(server->serverRank(rank).ledger.total("ann"), 0) << rank;
    EXPECT_GT(server->serverRank(rank).ledger.total("bob"), 0) << rank;
  }
}

TEST(Data, ACopyOfWhatAFilterMadeIsNotMadeAgain) {
  const auto server = serve();
  const auto client = dataClient(*server);
  client->expect("load analysis");
  client->expect(importBall("ball"));
  client->expect(
      R"(make {"Datasets": [{"name": "double", "filter": "Derive", "inputs": {"f": "ball"}, "expression": "2 * f"}]})");
  client->expect("copy double kept");
  EXPECT_TRUE(client->expect("info double").at("datasets").at(0).contains("provenance"));
  EXPECT_FALSE(client->expect("info kept").at("datasets").at(0).contains("provenance"));
  EXPECT_EQ(client->expect("range kept").at("range"), client->expect("range double").at("range"));
}

TEST(Data, ACopyThatCannotBeMadeChangesNothing) {
  ServerSetup setup;
  setup.ranks = 2;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.tenantMemory = 40'000;
  const TestServer server(std::move(setup));
  const auto client = dataClient(server);
  client->expect(importBall("ball"));
  EXPECT_NE(client->request("copy ball ball").error.find("both names are"), std::string::npos);
  EXPECT_NE(client->request("copy nothing kept").error.find("there is none that you see"), std::string::npos);
  int copies = 0;
  while (copies < 10 && client->request("copy ball kept" + std::to_string(copies)).ok) copies++;
  EXPECT_GT(copies, 0);
  EXPECT_LT(copies, 10);
  EXPECT_EQ(names(*client).size(), size_t(copies) + 1);
  client->expect("drop kept0");
  client->expect("copy ball kept0");
}

TEST(Data, ObserversAreToldInOrder) {
  const auto server = serve();
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::string> events;
  auto options = server->options();
  options.onEvent = [&](const json& event) {
    if (event.at("event") == "progress") return;
    const std::lock_guard lock(mutex);
    events.push_back(event.at("event").get<std::string>() + " " + event.at("scope").get<std::string>() + " " +
                     event.at("name").get<std::string>() + " " + event.at("generation").dump());
    changed.notify_all();
  };
  Client watcher(options);
  watcher.expect("load data");
  watcher.expect("observe ball");
  const auto client = dataClient(*server);
  client->expect(importBall("other"));
  client->expect(importBall("ball"));
  client->expect(importBall("ball"));
  for (const char* statement : {"publish ball", "unpublish ball", "drop ball"}) client->expect(statement);
  std::unique_lock lock(mutex);
  EXPECT_TRUE(changed.wait_for(lock, std::chrono::minutes(1), [&] { return events.size() == 7; }));
  EXPECT_EQ(events, (Names{"added private ball 1", "updated private ball 2", "dropped private ball 2",
                           "added shared ball 2", "dropped shared ball 2", "added private ball 2",
                           "dropped private ball 2"}));
}

TEST(Data, WaitEndsWithTheNextGenerationAndCanBeCancelled) {
  const auto server = serve();
  const auto client = dataClient(*server), other = dataClient(*server);
  std::promise<Reply> waited;
  client->send("wait ball 1", [&](const Reply& reply) { waited.set_value(reply); });
  other->expect(importBall("ball"));
  const Reply reply = waited.get_future().get();
  EXPECT_EQ(reply.value.at("generation"), 1) << reply.error;
  std::promise<Reply> cancelled;
  const uint32_t id = client->send("wait ball 7", [&](const Reply& r) { cancelled.set_value(r); });
  EXPECT_EQ(client->expect("list").at("datasets").size(), 1u) << "a waiting request holds up no other";
  client->expect("cancel " + std::to_string(id));
  EXPECT_EQ(cancelled.get_future().get().error, "cancelled");
  EXPECT_FALSE(client->request("wait ball 9 0.01").ok);
}

TEST(Data, WaitEndsWithAnotherObjectOfTheName) {
  const auto server = serve();
  const auto client = dataClient(*server), other = dataClient(*server);
  other->expect(importBall("ball"));
  other->expect(importBall("ball"));
  other->expect(importBall("new"));
  std::promise<Reply> waited;
  client->send("wait ball", [&](const Reply& reply) { waited.set_value(reply); });
  client->expect("list");  // answered after the wait has begun
  other->expect("drop ball");
  other->expect("rename new ball");
  const Reply reply = waited.get_future().get();
  EXPECT_EQ(reply.value.at("generation"), 1) << reply.error;
}

TEST(Data, WhatIsNoNameIsNeitherObservedNorWaitedFor) {
  const auto server = serve();
  const auto client = dataClient(*server);
  for (const std::string& name : {std::string(256, 'n'), std::string(1 << 20, 'n'), std::string("\"a\\tb\"")})
    for (const std::string verb : {"observe ", "wait "}) {
      const Reply reply = client->request(verb + name + (verb == "wait " ? " 1 0" : ""));
      EXPECT_NE(reply.error.find("expected 1 to 255 bytes"), std::string::npos) << reply.error.substr(0, 200);
      EXPECT_LT(reply.error.size(), 200u);
    }
  client->expect("observe " + std::string(255, 'n'));
  for (const std::string control : {"\x1B", "\x7F", "\xC2\x9B", "\xC2\x80"})
    EXPECT_NE(client->request("observe a" + control + "b").error.find("without control characters"),
              std::string::npos);
  client->expect("observe a\xC2\xA0\xC3\xA9");
}

TEST(Data, AFailedImportChangesNothing) {
  const auto server = serve();
  std::ofstream(server->folder() / "broken.vol") << "float\n0 0 0\n4 4 4\n1 1 1\nmissing.raw\n";
  const auto client = dataClient(*server);
  for (const std::string& statement :
       {std::string(R"(import {"Datasets": [{"name": "good", "filename": "ball.vol", "type": "Volume"},
                                {"name": "bad", "filename": "broken.vol", "type": "Volume"}]})"),
        importBall("bad", "nowhere.vol"), std::string("import {\"Datasets\": []}"), std::string("import {"),
        std::string(R"(import {"Datasets": {"name": "b", "filename": "ball.vol", "type": "Ball"}})")}) {
    const Reply reply = client->request(statement);
    EXPECT_FALSE(reply.ok) << statement;
    EXPECT_NE(reply.error.find("expected"), std::string::npos) << reply.error;
  }
  EXPECT_EQ(names(*client), Names{});
  for (int rank = 0; rank < 2; rank++) EXPECT_EQ(server->serverRank(rank).ledger.total("user"), 0) << rank;
  client->expect(importBall("ball"));  // all still work
}

std::string importShared(const std::vector<std::string>& names) {
  json state;
  for (const std::string& name : names)
    state["Datasets"].push_back({{"name", name}, {"filename", "ball.vol"}, {"type", "Volume"}});
  return "import shared " + state.dump();
}

TEST(Data, AnImportLooksForItsNamesInItsOwnDirectory) {
  const auto server = serve();
  const auto ann = dataClient(*server, "ann"), bob = dataClient(*server, "bob");
  bob->expect(importShared({"b"}));
  ann->expect(importBall("b"));  // hides the shared one
  const Reply reply = ann->request(importShared({"a", "b"}));
  EXPECT_NE(reply.error.find("\"b\" belongs to bob and is read-only"), std::string::npos) << reply.error;
  EXPECT_EQ(names(*ann), (Names{"b", "b"})) << "all or none";

  ann->expect(importBall("c"));
  ann->expect(importShared({"c"}));
  ann->expect(importShared({"c"}));
  const json list = bob->expect("list").at("datasets");
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list.at(1).at("name"), "c");
  EXPECT_EQ(list.at(1).at("generation"), 2) << "of the shared one, though a private one hides it";
}

/// An import of 200 datasets; what is done meanwhile begins when its client is told that it goes on.
struct LongImport {
  LongImport(const TestServer& server, const std::string& tenant) {
    auto options = server.options(tenant);
    options.onEvent = [this](const json& event) {
      if (event.at("event") == "progress") std::call_once(once, [this] { begun.set_value(); });
    };
    client = std::make_unique<Client>(options);
    client->expect("load data");
  }
  Reply run(const std::string& how, const std::vector<std::string>& more,
            const std::function<void()>& meanwhile) {
    json state;
    for (int i = 0; i < 200; i++)
      state["Datasets"].push_back(
          {{"name", "ball " + std::to_string(i)}, {"filename", "ball.vol"}, {"type", "Volume"}});
    for (const std::string& name : more)
      state["Datasets"].push_back({{"name", name}, {"filename", "ball.vol"}, {"type", "Volume"}});
    client->send("import " + how + state.dump(), [this](const Reply& r) { imported.set_value(r); });
    begun.get_future().wait();
    meanwhile();
    return imported.get_future().get();
  }

  std::once_flag once;
  std::promise<void> begun;
  std::promise<Reply> imported;
  std::unique_ptr<Client> client;  // after what it sets, so that it goes first
};

TEST(Data, AnImportLikeADatasetThatIsDroppedMeanwhileIsCutAsItWas) {
  for (const std::string how : {"like model ", ""}) {
    const auto server = serve();
    LongImport import(*server, "user");
    dataClient(*server)->expect(importBall("model"));
    const Reply reply = import.run(how, {}, [&] { dataClient(*server)->expect("drop model"); });
    EXPECT_TRUE(reply.ok) << reply.error;
    const auto client = dataClient(*server);
    EXPECT_EQ(names(*client).size(), 200u);
    const Reply late = client->request(
        R"(import like model {"Datasets": [{"name": "late", "filename": "ball.vol", "type": "Volume"}]})");
    EXPECT_NE(late.error.find("dataset \"model\""), std::string::npos) << late.error;
  }
}

TEST(Data, AnImportThatLosesANameMeanwhileNamesNothing) {
  const auto server = serve();
  LongImport import(*server, "ann");
  const auto bob = dataClient(*server, "bob");
  bob->expect(importBall("last"));
  Reply published;
  const Reply reply = import.run("shared ", {"last"}, [&] { published = bob->request("publish last"); });
  EXPECT_NE(published.ok, reply.ok) << reply.error;
  EXPECT_EQ(names(*import.client).size(), reply.ok ? 201u : 1u) << "all or none";
  if (reply.ok) return;
  for (int rank = 0; rank < 2; rank++) EXPECT_EQ(server->serverRank(rank).ledger.total("ann"), 0) << rank;
}

/// What is done while rank 1 has stored the first of an import's two datasets, before any is named.
Reply importWhile(TestServer& server, Client& client, const std::string& second,
                  const std::function<void()>& meanwhile) {
  std::promise<void> stored, goOn;
  std::once_flag once;
  const auto subscription = server.serverRank(1).observers.subscribe({}, [&](const ObjectEvent& event) {
    if (event.kind != ObjectEvent::Kind::Added) return;
    std::call_once(once, [&] {
      stored.set_value();
      goOn.get_future().wait();
    });
  });
  std::promise<Reply> imported;
  client.send(importShared({"first", second}), [&](const Reply& r) { imported.set_value(r); });
  stored.get_future().wait();
  meanwhile();
  goOn.set_value();
  return imported.get_future().get();
}

TEST(Data, AnImportThatIsToBeSharedGoesOnWhateverOthersDrop) {
  const auto server = serve();
  const auto ann = dataClient(*server, "ann"), bob = dataClient(*server, "bob");
  const Reply reply =
      importWhile(*server, *ann, "second", [&] { EXPECT_FALSE(bob->request("drop second").ok); });
  EXPECT_TRUE(reply.ok) << reply.error;
  EXPECT_EQ(names(*bob), (Names{"first", "second"}));
}

TEST(Data, AnImportWhoseDatasetIsDroppedAtTheLastMomentNamesNothing) {
  const auto server = serve();
  const auto ann = dataClient(*server, "ann"), other = dataClient(*server, "ann");
  const Reply reply = importWhile(*server, *ann, "second", [&] { other->expect("drop second"); });
  EXPECT_EQ(reply.error, "cancelled: a dataset of this import was dropped");
  EXPECT_EQ(names(*ann), Names{});
  for (int rank = 0; rank < 2; rank++) EXPECT_EQ(server->serverRank(rank).ledger.total("ann"), 0) << rank;
}

TEST(Data, WhatOneImportGivesIsSeenTogetherOnAllRanks) {
  const auto server = serve();
  const auto ann = dataClient(*server, "ann");
  const std::vector<std::string> both{"first", "second"};
  const std::string import = importShared({"first", "second"});
  ann->expect(import);
  std::atomic<bool> done = false;
  std::atomic<int> looks = 0;
  std::set<Generation> shown;
  std::thread reader([&] {
    while (!done) {
      const auto seen = server->serverRank(0).datasets->getPinned("ann", both);
      EXPECT_EQ(seen[0].first.generation, seen[1].first.generation);
      std::vector<ObjectGeneration> generations;
      for (const auto& [dataset, pin] : seen) generations.push_back({dataset.key, dataset.generation});
      EXPECT_NO_THROW(server->serverRank(1).objects.pin(generations)) << "while they are pinned on rank 0";
      shown.insert(seen[0].first.generation);
      looks++;
    }
  });
  for (int n = 0; n < 20; n++) {
    ann->expect(import);
    for (const int before = looks; looks <= before + 1;) std::this_thread::yield();
  }
  done = true;
  reader.join();
  EXPECT_GE(shown.size(), 20u) << "the reader has seen each import, but perhaps the first state";
}

TEST(Data, AnImportThatFailsOnItsFilesTakesNoRoomFromWhatIsShown) {
  const auto server = serve();
  const auto ann = dataClient(*server, "ann");
  ann->expect(importShared({"ball"}));
  const Key key = server->serverRank(0).datasets->get("ann", "ball").key;
  const Pin shown = server->serverRank(0).objects.pin(key);
  ann->expect(importShared({"ball"}));
  for (const std::string file : {"missing.vol", "broken.vti"}) {
    std::ofstream(server->folder().path() / "broken.vti") << "no XML";
    const Reply reply = ann->request(
        "import shared {\"Datasets\": [{\"type\": \"Volume\", \"name\": \"ball\", \"filename\": \"" + file +
        "\"}]}");
    EXPECT_NE(reply.error.find(file), std::string::npos) << reply.error;
    EXPECT_EQ(reply.error.find("in use"), std::string::npos) << reply.error;
  }
  EXPECT_NO_THROW(server->serverRank(0).objects.pin(key, shown.generation())) << "it is still there";
}

TEST(Data, AnImportThatWaitsForItsNameIsCancelledAtOnce) {
  const auto server = serve();
  const auto ann = dataClient(*server, "ann"), other = dataClient(*server, "ann");
  std::promise<Reply> second;
  auto ended = second.get_future();
  const Reply first = importWhile(*server, *ann, "second", [&] {
    const uint32_t id =
        other->send(importShared({"second"}), [&](const Reply& reply) { second.set_value(reply); });
    EXPECT_EQ(ended.wait_for(std::chrono::milliseconds(100)), std::future_status::timeout) << "it waits";
    other->expect("cancel " + std::to_string(id));
    EXPECT_EQ(ended.wait_for(std::chrono::minutes(1)), std::future_status::ready);
  });
  EXPECT_TRUE(first.ok) << first.error;
  EXPECT_EQ(ended.get().error, "cancelled");
}

TEST(Data, AnImportChangesNothingThatItMayNoLongerChange) {
  const auto server = serve();
  const auto ann = dataClient(*server, "ann"), bob = dataClient(*server, "bob");
  const auto refused = [&](const Reply& reply) {
    EXPECT_EQ(reply.error.find("import: \"ball\" was dropped, renamed or taken back meanwhile"), 0u)
        << reply.error;
    const Names left = names(*ann);
    EXPECT_EQ(std::count(left.begin(), left.end(), "first"), 0) << "all or none";
  };
  bob->expect(importBall("ball"));
  bob->expect("publish ball writable");
  refused(importWhile(*server, *ann, "ball", [&] { bob->expect("unpublish ball"); }));
  EXPECT_EQ(bob->expect("info ball").at("datasets").at(0).at("generation"), 1) << "it is bob's own again";
  bob->expect("publish ball writable");
  refused(importWhile(*server, *ann, "ball", [&] { bob->expect("rename ball other"); }));
  EXPECT_EQ(bob->expect("info other").at("datasets").at(0).at("generation"), 1);
  bob->expect("rename other ball");
  std::promise<Reply> dropped;  // rank 1 is not asked before the import goes on
  refused(importWhile(*server, *ann, "ball", [&] {
    bob->send("drop ball", [&](const Reply& r) { dropped.set_value(r); });
    while (server->serverRank().datasets->find("bob", "ball"))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }));
  EXPECT_TRUE(dropped.get_future().get().ok);
  EXPECT_EQ(names(*bob), Names{});
  for (int rank = 0; rank < 2; rank++)
    for (const char* tenant : {"ann", "bob"})
      EXPECT_EQ(server->serverRank(rank).ledger.total(tenant), 0) << tenant << " on " << rank;
  ann->expect(importShared({"first", "ball"}));
  bob->expect(importBall("ball"));
}

TEST(Data, KeysOfAVolumeThatMeanNothingAreToldOnceToWhoImportsIt) {
  const auto server = serve();
  const auto client = dataClient(*server);
  json volume{{"type", "float"},    {"origin", {-1, -1, -1}}, {"counts", {16, 16, 16}},
              {"delta", {1, 1, 1}}, {"rawdata", "ball.raw"},  {"conts\x1B[31m", 1}};
  const auto warnings = [&] {
    std::ofstream(server->folder() / "odd.json") << volume.dump();
    return client->expect(importBall("odd", "odd.json")).at("warnings");
  };
  const json one = warnings();
  ASSERT_EQ(one.size(), 1u);
  EXPECT_NE(one.at(0).get<std::string>().find("odd.json: unknown key \"conts?[31m\" is ignored"),
            std::string::npos)
      << one;
  for (int i = 0; i < 30; i++) volume["more" + std::to_string(i)] = i;
  const json many = warnings();
  ASSERT_EQ(many.size(), 11u);
  EXPECT_NE(many.at(10).get<std::string>().find("and 21 more unknown keys"), std::string::npos) << many;
}

TEST(Data, FlawsOfAMeshAreToldToWhoImportsIt) {
  const auto server = serve();
  const auto client = dataClient(*server);
  std::ofstream(server->folder() / "flawed.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2\nf 3\n";
  const json warnings =
      client->expect(R"(import {"Datasets": {"name": "m", "filename": "flawed.obj", "type": "Triangles"}})")
          .at("warnings");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings.at(0).get<std::string>().find(
                "flawed.obj: line 5: a face of fewer than 3 corners is left out (2 of these)"),
            std::string::npos)
      << warnings;
}

TEST(Data, AnImportHasAtMostTenThousandDatasets) {
  const auto server = serve(1);
  const auto client = dataClient(*server);
  std::vector<std::string> many;
  for (int i = 0; i <= 10000; i++) many.push_back(std::to_string(i));
  EXPECT_EQ(client->request(importShared(many)).error,
            "import: there are 10001 datasets, expected at most 10000 in one request");
}

TEST(Data, InfoLeavesOutWhatIsDroppedMeanwhile) {
  const auto server = serve();
  const auto client = dataClient(*server);
  client->expect(importBall("ball"));
  client->expect(importBall("gone"));
  Datasets& datasets = *server->serverRank().datasets;
  const NamedDataset gone = datasets.get("user", "gone");
  server->serverRank(1).objects.drop(
      gone.key);  // as while it is dropped: it has its name, but not all of its parts
  const json all = client->expect("info").at("datasets");
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all.at(0).at("name"), "ball");
  EXPECT_FALSE(client->request("info gone").ok);
  client->expect("drop gone");
  EXPECT_TRUE(datasets.info(gone).is_null());
  for (const char* verb : {"info", "range"})
    EXPECT_EQ(client->request(std::string(verb) + " gone")
                  .error.find("dataset \"gone\": there is none that you see"),
              0u);
}

TEST(Data, MessagesAboutBinaryFilesAreTextForPeople) {
  const auto server = serve();
  const auto client = dataClient(*server);
  for (const char* name : {"b.json", "b.part", "b.vol", "b.obj"}) {
    const bool mesh = std::string(name) == "b.obj";
    std::ofstream(server->folder() / name)
        << (mesh ? "v 0 0 0\nf " : "{\"") << "\xA0\x1B[31m\xC2\x9B\xFF 2 3\n";
    const std::string type = mesh ? "Triangles" : "Volume";
    const Reply reply = client->request(R"(import {"Datasets": {"name": "b", "filename": ")" +
                                        std::string(name) + R"(", "type": ")" + type + R"("}})");
    EXPECT_FALSE(reply.ok) << name;
    EXPECT_EQ(reply.error, protocol::printable(reply.error)) << name;
  }
}

TEST(Data, TheProgressOfAnImportIsToldToItsClientOnly) {
  const auto server = serve();
  Progress progress, others;
  auto options = server->options();
  options.onEvent = [&](const json& event) { others.take(event); };
  Client other(options);
  options.onEvent = [&](const json& event) { progress.take(event); };
  Client client(options);
  client.expect("load data");
  std::promise<Reply> imported;
  const uint32_t id = client.send(importBall("ball"), [&](const Reply& reply) { imported.set_value(reply); });
  EXPECT_TRUE(imported.get_future().get().ok);
  const std::vector<json> events = progress.waitFor(id);
  EXPECT_EQ(events.front().at("text"), "opening ball");
  EXPECT_EQ(events.front().at("done"), 0);
  EXPECT_TRUE(std::any_of(events.begin(), events.end(), [](const json& event) {
    return event.at("text") == "importing ball";
  })) << "however soon after";
  for (size_t i = 0; i < events.size(); i++) {
    EXPECT_EQ(events[i].at("of"), Exchanges::kUnits) << "of one dataset";
    EXPECT_LE(events[i == 0 ? 0 : i - 1].at("done"), events[i].at("done"));
  }
  EXPECT_EQ(events.back().at("text"), "done");
  other.expect("echo");
  EXPECT_TRUE(others.none());
}

TEST(Data, ImportsOfOneNameAtOnceBecomeOneGenerationEach) {
  const auto server = serve();
  std::vector<std::unique_ptr<Client>> clients;
  std::vector<std::future<Reply>> replies;
  for (int i = 0; i < 6; i++) clients.push_back(dataClient(*server));
  for (auto& client : clients) {
    auto promise = std::make_shared<std::promise<Reply>>();
    replies.push_back(promise->get_future());
    client->send(importBall("ball"), [promise](const Reply& r) { promise->set_value(r); });
  }
  for (auto& reply : replies) {
    const Reply r = reply.get();
    EXPECT_TRUE(r.ok) << r.error;
  }
  EXPECT_EQ(clients[0]->expect("list").at("datasets").at(0).at("generation"), 6);
  EXPECT_FALSE(clients[0]
                   ->request(R"(import {"Datasets": [{"name": "b", "filename": "ball.vol", "type": "Volume"},
                              {"name": "b", "filename": "ball.vol", "type": "Volume"}]})")
                   .ok)
      << "one name twice";
}

TEST(Data, AnImportThatIsCancelledEndsBetweenItsFilesAndLeavesNothing) {
  const auto server = serve();
  const auto client = dataClient(*server);
  json state;
  for (int i = 0; i < 500; i++)
    state["Datasets"].push_back(
        {{"name", "ball " + std::to_string(i)}, {"filename", "ball.vol"}, {"type", "Volume"}});
  std::promise<Reply> ended;
  const uint32_t id = client->send("import " + state.dump(), [&](const Reply& r) { ended.set_value(r); });
  client->expect("cancel " + std::to_string(id));
  EXPECT_EQ(ended.get_future().get().error, "cancelled");
  EXPECT_EQ(names(*client), Names{});
  for (int rank = 0; rank < 2; rank++) EXPECT_EQ(server->serverRank(rank).ledger.total("user"), 0) << rank;
  client->expect(importBall("ball"));
}

/// A server with a volume that takes seconds to import, 4 GiB of zeros, none of which the disk holds.
constexpr int64_t kLargeBytes = int64_t(1024) * 1024 * sweep(4096);

std::unique_ptr<TestServer> serveLarge() {
  auto server = serve();
  std::ofstream(server->folder() / "large.vol")
      << "uchar\n0 0 0\n1024 1024 " << kLargeBytes / (1024 * 1024) << "\n1 1 1\nlarge.raw\n";
  std::ofstream(server->folder() / "large.raw").put('\0');
  std::filesystem::resize_file(server->folder() / "large.raw", uint64_t(kLargeBytes));
  return server;
}
constexpr const char* kImportLarge =
    R"(import {"Datasets": [{"name": "large", "filename": "large.vol", "type": "Volume"}]})";

int64_t memoryOf(TestServer& server) {
  return server.serverRank(0).ledger.total("user") + server.serverRank(1).ledger.total("user");
}

// The import would be done some seconds later, and keep its memory.
TEST(Data, AnImportWithinOneFileEndsByCancelAndByDropAndWithItsClient) {
  const auto server = serveLarge();
  const auto other = dataClient(*server);
  for (const std::string way : {"cancel", "drop", "leave"}) {
    auto client = dataClient(*server);
    std::promise<Reply> ended;
    const uint32_t id = client->send(kImportLarge, [&](const Reply& r) { ended.set_value(r); });
    while (memoryOf(*server) < kLargeBytes) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (way == "cancel") {
      client->expect("cancel " + std::to_string(id));
      EXPECT_EQ(ended.get_future().get().error, "cancelled");
    } else if (way == "drop") {
      other->expect("drop large");
      EXPECT_EQ(ended.get_future().get().error, "cancelled: a dataset of this import was dropped");
      EXPECT_FALSE(other->request("drop large").ok) << "neither a dataset nor an import";
    }
    client.reset();
    while (memoryOf(*server) > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(names(*other), Names{});
  }
}

TEST(Data, AnUpdateEndsWhenItsDatasetIsDropped) {
  const auto server = serveLarge();
  const auto client = dataClient(*server), other = dataClient(*server);
  client->expect(importBall("large"));
  std::promise<Reply> ended;
  client->send(kImportLarge, [&](const Reply& r) { ended.set_value(r); });
  while (memoryOf(*server) < kLargeBytes) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  other->expect("drop large");
  EXPECT_FALSE(ended.get_future().get().ok);
  EXPECT_EQ(names(*other), Names{});
  while (memoryOf(*server) > 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

TEST(Data, QuotasOfMemoryHoldBeforeAnythingIsRead) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.tenantMemory = 20000;  // a half of 16^3 floats with its ghosts is 12288 bytes or less
  TestServer server(std::move(setup));
  const auto client = dataClient(server);
  client->expect(importBall("ball"));
  const Reply second = client->request(importBall("second"));
  EXPECT_FALSE(second.ok);
  EXPECT_NE(second.error.find("memory"), std::string::npos) << second.error;
  // a mesh that no reader would take: it is not asked
  std::ofstream(server.folder() / "large.stl") << std::string(20001, 'x');
  const Reply mesh = client->request(
      R"(import {"Datasets": [{"name": "mesh", "filename": "large.stl", "type": "Triangles"}]})");
  EXPECT_FALSE(mesh.ok);
  EXPECT_NE(mesh.error.find("20001 bytes are needed"), std::string::npos) << mesh.error;
  // points that take more than their text
  std::string numbers;
  for (int i = 0; i < 3000; i++) numbers += "0 ";
  std::ofstream(server.folder() / "small.vtp")
      << R"(<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian"><PolyData>
            <Piece NumberOfPoints="1000"><Points>
            <DataArray type="Float32" Name="Points" NumberOfComponents="3" format="ascii">)"
      << numbers << "</DataArray></Points></Piece></PolyData></VTKFile>";
  const Reply points = client->request(
      R"(import {"Datasets": [{"name": "points", "filename": "small.vtp", "type": "Particles"}]})");
  EXPECT_FALSE(points.ok);
  EXPECT_NE(points.error.find("12000 bytes are needed"), std::string::npos) << points.error;
  const auto other = dataClient(server, "other");
  other->expect(importBall("ball"));
}

TEST(Data, OfAllTenantsTakeNoMoreThanTheRankMayHave) {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  setup.serverRank.memory = 20000;  // a half of 16^3 floats with its ghosts is 9216 bytes or more
  TestServer server(std::move(setup));
  const auto ann = dataClient(server, "ann"), bob = dataClient(server, "bob");
  ann->expect(importBall("ball"));
  EXPECT_NE(bob->request(importBall("ball")).error.find("of this rank's 20000 bytes"), std::string::npos);
  ann->expect("drop ball");
  bob->expect(importBall("ball"));
}

}  // namespace
}  // namespace gxy::test
