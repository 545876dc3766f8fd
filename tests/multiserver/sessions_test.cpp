// SPDX-License-Identifier: Apache-2.0
// Connections, requests and modules: what a client can rely on whatever it asks.
#include <gtest/gtest.h>

#include <fcntl.h>
#include <netinet/in.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <optional>
#include <sstream>
#include <thread>

#include "core/comm/error.h"
#include "multiserver/protocol/run_files.h"
#include "multiserver/server/module.h"
#include "multiserver/server/tenants.h"
#include "tests/multiserver/test_server.h"

namespace gxy::test {
namespace {

using nlohmann::json;

ServerSetup setup() {
  ServerSetup setup;
  setup.modules = GALAXY_MODULES;
  return setup;
}

/// A run directory of its own, while it lives.
class RunDirectory {
 public:
  RunDirectory() {
    if (const char* user = std::getenv("XDG_RUNTIME_DIR")) before_ = user;
    setenv("XDG_RUNTIME_DIR", folder_.path().c_str(), 1);
  }
  ~RunDirectory() {
    if (before_)
      setenv("XDG_RUNTIME_DIR", before_->c_str(), 1);
    else
      unsetenv("XDG_RUNTIME_DIR");
  }
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;

 private:
  const TemporaryFolder folder_;
  std::optional<std::string> before_;
};

TEST(Sessions, AnswerEachRequestOnceInTheirOrder) {
  TestServer server(setup());
  const auto client = server.client();
  std::vector<std::future<std::pair<int, Reply>>> replies;
  std::atomic<int> order = 0;
  for (int i = 0; i < 1000; i++) {
    auto promise = std::make_shared<std::promise<std::pair<int, Reply>>>();
    replies.push_back(promise->get_future());
    client->send("echo " + std::to_string(i), [promise, &order](const Reply& r) {
      promise->set_value({order++, r});
    });
  }
  for (int i = 0; i < 1000; i++) {
    const auto [place, reply] = replies[size_t(i)].get();
    EXPECT_EQ(place, i);
    EXPECT_EQ(reply.value.at("text"), std::to_string(i));
  }
}

TEST(Sessions, TokensSayWhoMayEnterAndWho) {
  ServerSetup s = setup();
  s.tokens = {{"good", "ann"}, {"best", "admin"}};
  TestServer server(std::move(s));
  const auto enter = [&](const std::string& token) {
    const std::string file = server.folder() / "token";
    std::ofstream(file) << token << "\n";
    Client::Options options = server.options("somebody");
    options.tokenFile = file;
    return std::make_unique<Client>(options);
  };
  const auto ann = enter("good");
  EXPECT_EQ(ann->welcome().tenant, "ann");
  EXPECT_FALSE(ann->welcome().administrator);
  for (const char* wrong : {"bad", "goo", "goodd", "best2"}) EXPECT_THROW(enter(wrong), Error) << wrong;
  EXPECT_FALSE(ann->request("quit").ok);
  EXPECT_FALSE(server.stopAsked());
  EXPECT_TRUE(enter("best")->request("quit").ok);
  EXPECT_TRUE(server.waitForStop());  // the reply comes first
}

TEST(Sessions, OnlyServersOfThisMachineAreSentTheTokenThatIsHere) {
  const RunDirectory here;
  ServerSetup s = setup();
  s.tokens = {{"good", "ann"}};
  TestServer server(std::move(s));
  Client::Options options = server.options();
  options.tokenFile.clear();
  const auto refusal = [&](const std::string& host) {
    options.host = host;
    try {
      Client client(options);
      return std::string("let in");
    } catch (const Error& e) {
      return std::string(e.what());
    }
  };
  const std::string file = protocol::tokenFile(server.port());
  EXPECT_NE(refusal("127.0.0.1").find("the token is wrong"), std::string::npos);
  EXPECT_NE(refusal("127.0.0.1").find("none was sent: " + file), std::string::npos);
  protocol::makeRunDirectory();
  const protocol::TokenFile written(file, "good");
  for (const char* host : {"127.0.0.1", "localhost"}) EXPECT_EQ(refusal(host), "let in") << host;
  for (const char* host : {"127.0.0.3", "::1"})  // nobody listens there
    EXPECT_NE(refusal(host).find("is a server running there?"), std::string::npos) << refusal(host);
  for (const char* host : {"192.0.2.1", "2001:db8::1", "0.0.0.0"})
    EXPECT_NE(refusal(host).find("is another machine"), std::string::npos) << refusal(host);
}

TEST(Sessions, TokensTakeThePlaceOfTokensAndOfNothingElse) {
  const RunDirectory here;
  protocol::makeRunDirectory();
  const std::string file = protocol::runDirectory() + "/file", link = protocol::runDirectory() + "/link";
  for (const std::string before : {"thesis\n", "abc\n12\nwords",
                                   "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef\n\n"}) {
    std::ofstream(file) << before;
    EXPECT_THROW(protocol::TokenFile(file, "new"), Error) << before;
    std::ostringstream after;
    after << std::ifstream(file).rdbuf();
    EXPECT_EQ(after.str(), before);
  }
  for (const std::string& before : {newToken() + "\n", std::string()}) {  // of a server that was killed
    std::ofstream(file) << before;
    std::filesystem::remove(link);
    std::filesystem::create_symlink("file", link);
    EXPECT_THROW(protocol::TokenFile(link, "new"), Error);
    const protocol::TokenFile written(file, "new");
    EXPECT_EQ(protocol::readToken(file), "new");
  }
  EXPECT_THROW(protocol::TokenFile(protocol::runDirectory(), "new"), Error);
}

TEST(Sessions, TokensOfServersThatWereKilledAreNeitherUsedNorKept) {
  const RunDirectory here;
  protocol::removeStaleTokens();  // where there is nothing
  protocol::makeRunDirectory();
  const std::string stale = protocol::tokenFile(1), other = protocol::tokenFile(2, "ann"),
                    empty = protocol::tokenFile(3), words = protocol::tokenFile(4);
  for (const std::string& file : {stale, other}) std::ofstream(file) << newToken() << "\n";
  std::ofstream{empty};  // of a server that begins: it is about to lock it
  std::ofstream(words) << "no token\n";
  const protocol::TokenFile live(protocol::tokenFile(5), "good");
  EXPECT_EQ(protocol::readServerToken(5), "good");
  EXPECT_EQ(protocol::readToken(stale).size(), 64u) << "a copy is locked by nobody";
  try {
    protocol::readServerToken(1);
    ADD_FAILURE() << "a stale token was read";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("a server that was killed has left this token"), std::string::npos);
  }
  protocol::removeStaleTokens();
  for (const std::string& file : {stale, other}) EXPECT_FALSE(std::filesystem::exists(file)) << file;
  for (const std::string& file : {empty, words, live.path()})
    EXPECT_TRUE(std::filesystem::exists(file)) << file;
}

TEST(Sessions, ATokensFileMayBeLookedAtWhileAServerBegins) {
  const RunDirectory here;
  protocol::makeRunDirectory();
  const std::string file = protocol::tokenFile(1);
  std::ofstream(file) << newToken() << "\n";
  const int looks = open(file.c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_EQ(flock(looks, LOCK_SH), 0);
  EXPECT_THROW(protocol::TokenFile(file, "new"), Error) << "it waits for a moment only";
  auto begins = std::async(std::launch::async, [&] { return protocol::TokenFile(file, "new"); });
  close(looks);
  const protocol::TokenFile written = begins.get();
  EXPECT_EQ(protocol::readServerToken(1), "new");
}

TEST(Sessions, AServerThatAsksForNoTokenTakesWhoeverHasNone) {
  const RunDirectory here;
  TestServer server(setup());
  Client::Options options = server.options("ann");
  options.tokenFile.clear();
  EXPECT_EQ(Client(options).welcome().tenant, "ann");
}

TEST(Sessions, LoadModulesByBareNameOnly) {
  TestServer server(setup());
  const auto client = server.client();
  for (const char* name :
       {"", "nothing", "../data", "/etc/passwd", "data.so", "galaxy_data.so", "data/../data", "libc"})
    EXPECT_FALSE(client->request(std::string("load ") + name).ok) << name;
  EXPECT_FALSE(client->request("list").ok) << "nothing was loaded";
  client->expect("load data");
  client->expect("load data");
  EXPECT_EQ(client->expect("modules").at("loaded"), json{"data"});
  EXPECT_FALSE(server.client()->request("list").ok) << "modules are a session's own";
}

TEST(Sessions, ALibraryThatIsNoModuleIsRefusedEverywhere) {
  const TemporaryFolder folder;
  std::filesystem::copy_file(std::filesystem::path(GALAXY_MODULES) / "galaxy_data.so",
                             folder / "galaxy_data.so");
  std::ofstream(folder / "galaxy_text.so") << "this is no library";
  std::filesystem::create_symlink(std::filesystem::path(GALAXY_MODULES) / "galaxy_viewer.so",
                                  folder / "galaxy_outside.so");
  ServerSetup s = setup();
  s.modules = folder.path().string();
  TestServer server(std::move(s));
  const auto client = server.client();
  EXPECT_NE(client->request("load text").error.find("cannot be loaded"), std::string::npos);
  EXPECT_EQ(client->request("load outside").error,
            "module \"outside\": there is none, expected one of: data, text")
      << "a link out of the folder";
  EXPECT_EQ(client->expect("modules").at("available"), (json{"data", "text"}));
  client->expect("load data");
  client->expect("list");
}

TEST(Sessions, FoldersOfModulesAreLookedIntoInTheirOrder) {
  const TemporaryFolder folder;
  std::filesystem::copy_file(GALAXY_FOREIGN_MODULE, folder / "galaxy_viewer.so");
  ServerSetup s = setup();
  s.modules = folder.path().string();
  s.serverRank.moduleFolders = {GALAXY_MODULES};
  TestServer server(std::move(s));
  const auto client = server.client();
  EXPECT_NE(client->request("load viewer").error.find("it was built for interface"), std::string::npos)
      << "that of the first folder: " << client->request("load viewer").error;
  client->expect("load data");
  EXPECT_EQ(client->expect("modules").at("available"),
            (json{"analysis", "data", "example", "graph", "insitu", "viewer"}));
}

TEST(Sessions, AModuleWithAWorkThatThereIsAlreadyChangesNothing) {
  const TemporaryFolder folder;
  std::filesystem::copy_file(GALAXY_CLASHING_MODULE, folder / "galaxy_clashing.so");
  ServerSetup s = setup();
  s.modules = folder.path().string();
  TestServer server(std::move(s));
  const auto client = server.client();
  for (int times = 0; times < 2; times++) {
    const Reply reply = client->request("load clashing");
    EXPECT_NE(reply.error.find("there is a work datasets.info already"), std::string::npos) << reply.error;
  }
  for (int rank = 0; rank < 2; rank++)
    EXPECT_FALSE(server.serverRank(rank).work.contains("clashing.first")) << rank;
}

TEST(Sessions, AModuleOfAnotherInterfaceIsRefusedBeforeItRuns) {
  const TemporaryFolder folder;
  std::filesystem::copy_file(GALAXY_FOREIGN_MODULE, folder / "galaxy_foreign.so");
  std::filesystem::copy_file(std::filesystem::path(GALAXY_MODULES) / "galaxy_data.so",
                             folder / "galaxy_data.so");
  ServerSetup s = setup();
  s.modules = folder.path().string();
  TestServer server(std::move(s));
  const auto client = server.client();
  for (int times = 0; times < 2; times++)
    EXPECT_EQ(client->request("load foreign").error,
              "module foreign: it was built for interface " + std::to_string(kModuleAbi + 1) + ", expected " +
                  std::to_string(kModuleAbi) + "; build it anew against this server");
  EXPECT_EQ(client->expect("modules").at("loaded"), json::array());
  for (int rank = 0; rank < 2; rank++)
    EXPECT_FALSE(server.serverRank(rank).work.contains("foreign.work")) << rank;
  client->expect("load data");
  client->expect("list");
}

TEST(Sessions, AVerbWithoutAnObjectIsAnError) {
  const TemporaryFolder folder;
  std::filesystem::copy_file(GALAXY_ODD_MODULE, folder / "galaxy_odd.so");
  ServerSetup s = setup();
  s.modules = folder.path().string();
  TestServer server(std::move(s));
  const auto client = server.client();
  client->expect("load odd");
  EXPECT_EQ(client->request("list_of_two").error,
            "list_of_two returned no object: its result is array, expected an object or nothing");
  EXPECT_NE(client->request("text").error.find("text returned no object"), std::string::npos);
  EXPECT_EQ(client->expect("object").at("a"), 1);
}

TEST(Sessions, AServerWhoseModuleFolderIsNoneDoesNotStart) {
  for (const std::string& folder : {std::string("/nonexistent"), std::string(GALAXY_FOREIGN_MODULE)}) {
    ServerSetup s = setup();
    s.modules = folder;
    try {
      TestServer server(std::move(s));
      ADD_FAILURE() << "it has started with modules in " << folder;
    } catch (const Error& e) {
      EXPECT_EQ(e.what(), folder + ": it is no folder, expected one of the server's modules");
    }
  }
}

TEST(Sessions, AFolderWithoutModulesIsToldAsOne) {
  const TemporaryFolder folder;
  ServerSetup s = setup();
  s.modules = folder.path().string();
  TestServer server(std::move(s));
  EXPECT_EQ(server.client()->request("load data").error,
            "module \"data\": there is none, nor any other in the server's module folders");
}

TEST(Sessions, VerbsAreResolvedAsTheProtocolSays) {
  TestServer server(setup());
  const auto client = server.client();
  client->expect("load data");
  const json viewer = client->expect("load viewer");
  EXPECT_EQ(viewer.at("hidden"), json::array());
  client->expect("list");
  client->expect("data.list");
  client->expect("viewer.windows");
  client->expect("server.stat");
  EXPECT_FALSE(client->request("viewer.list").ok);
  const Reply misspelt = client->request("lisst");
  EXPECT_NE(misspelt.error.find("did you mean `list`"), std::string::npos) << misspelt.error;
  EXPECT_GT(client->expect("help").at("verbs").size(), 20u);
  for (const char* one :
       {"help import", "help data.import", "help server.stat", "help stat", "server.help help"})
    EXPECT_EQ(client->expect(one).at("verbs").size(), 1u) << one;
  for (const char* none : {"help viewer.import", "help server.import", "help data.", "help import drop"})
    EXPECT_NE(client->request(none).error.find("there is no verb"), std::string::npos) << none;
}

TEST(Sessions, VerbsWithoutArgumentsRefuseThem) {
  TestServer server(setup());
  const auto client = server.client();
  client->expect("load data");
  client->expect("load viewer");
  const json verbs = client->expect("help").at("verbs");
  for (const json& verb : verbs)
    if (verb.at("arguments") == "") {
      const auto name = verb.at("verb").get<std::string>();
      EXPECT_EQ(client->request(name + " foo").error, "\"foo\" is too much, expected `" + name + "`");
    }
  EXPECT_FALSE(server.stopAsked());
}

TEST(Sessions, RequestsAreBoundedAsTheProtocolSays) {
  TestServer server(setup());
  const auto client = server.client();
  client->expect("load data");
  client->expect("load viewer");
  client->expect("window 1");
  const auto error = [&](const std::string& statement) { return client->request(statement).error; };
  EXPECT_NE(error("range {x}").find("a word is missing"), std::string::npos);
  EXPECT_NE(error("range \"{x}\"").find("{x}"), std::string::npos);
  EXPECT_NE(error(R"(render 1 {"levels": [8, 7, 6, 5, 4, 3, 2, 1]})").find("1 to 7 scales"),
            std::string::npos);
  std::string many = "1";
  for (int i = 1; i < 1'000'000; i++) many += ",1";
  EXPECT_NE(error("import {\"Datasets\": [" + many + "]}").find("more than 1000000 values"),
            std::string::npos);
  const std::string deep = std::string(64, '[') + std::string(64, ']');
  EXPECT_NE(error("import {\"Datasets\": " + deep + "}").find("nested deeper than 64"), std::string::npos);
  const std::string one = R"({"type": "Triangles", "dataset": "x"})";
  std::string operators = one;
  for (int i = 1; i <= 65535; i++) operators += "," + one;
  EXPECT_NE(
      error(R"(set 1 {"Visualization": {"operators": [)" + operators + "]}}").find("at most 65535 operators"),
      std::string::npos);
  for (int i = 0; i < 10000; i++)
    client->send("observe name" + std::to_string(i), [](const Reply& reply) { EXPECT_TRUE(reply.ok); });
  EXPECT_NE(error("observe another").find("10000 names are observed"), std::string::npos);
}

TEST(Sessions, StatCountsWhatIsThere) {
  TestServer server(setup());
  const auto client = server.client(), other = server.client();
  const json stat = client->expect("stat");
  EXPECT_EQ(stat.at("ranks").size(), 2u);
  EXPECT_EQ(stat.at("clients").size(), 2u);
  for (const json& rank : stat.at("ranks"))
    EXPECT_GT(rank.at("memory").at("resident").get<int64_t>(), 1 << 20);
}

TEST(Sessions, FiftyClientsAtOnceGetTheirOwnReplies) {
  TestServer server(setup());
  std::vector<std::unique_ptr<Client>> clients;
  for (int i = 0; i < 50; i++) clients.push_back(server.client("tenant" + std::to_string(i)));
  std::vector<std::future<Reply>> replies;
  for (auto& client : clients) {
    auto promise = std::make_shared<std::promise<Reply>>();
    replies.push_back(promise->get_future());
    client->expect("load data");
    const std::string name = "ball of " + client->welcome().tenant;
    client->send(importBall(name), [promise](const Reply& r) { promise->set_value(r); });
  }
  for (size_t i = 0; i < clients.size(); i++) {
    EXPECT_TRUE(replies[i].get().ok);
    const json list = clients[i]->expect("list").at("datasets");
    ASSERT_EQ(list.size(), 1u);
    EXPECT_EQ(list[0].at("name"), "ball of tenant" + std::to_string(i));
  }
}

// As imports do, which wait for files and other ranks.
TEST(Sessions, LongWorkOfOthersHoldsUpNobody) {
  TestServer server(setup());
  std::promise<void> release;
  const std::shared_future<void> released = release.get_future().share();
  for (int rank = 0; rank < 2; rank++)
    server.serverRank(rank).work.add(
        "test.long", [released](const Work::Call&) -> json { return released.wait(), nullptr; },
        Work::Runs::Waiting);
  std::atomic<int> ended = 0;
  constexpr int kWorks = 60;
  for (int i = 0; i < kWorks; i++)
    server.serverRank().work.broadcast("test.long", json::object(),
                                       [&](std::vector<Work::Reply>) { ended++; });
  const auto client = server.client();
  for (const std::string& statement :
       {std::string("echo"), std::string("load data"), importBall("ball"), std::string("info"),
        std::string("stat"), std::string("load viewer"), std::string("window 1 {\"size\": [20, 20]}"),
        "set 1 " + stateOf("ball"), std::string("render 1"), "batch {\"state\": " + stateOf("ball") + "}",
        std::string("drop ball")})
    client->expect(statement);
  EXPECT_EQ(ended, 0) << "they are still at it";
  release.set_value();
  server.stop();
  EXPECT_EQ(ended, kWorks);
}

TEST(Sessions, LongWorkOfATenantWaitsForItsTurnAndHoldsUpNobodyElse) {
  TestServer server(setup());
  const auto ann = server.client("ann"), bob = server.client("bob");
  for (const auto* client : {&ann, &bob}) {
    (*client)->expect("load data");
    (*client)->expect("load example");
    (*client)->expect("load analysis");
    (*client)->expect(importBall("ball"));
  }
  const std::string threshold =
      R"(make {"name": "late", "filter": "Threshold", "inputs": {"source": "ball"}, "least": 0, "largest": 1})";
  std::vector<std::shared_ptr<void>> turns;
  for (int i = 0; i < Tenants::kLong; i++)
    turns.push_back(server.serverRank().tenants.beginLong("ann", [] { FAIL() << "there is room"; }));
  std::promise<Reply> filtered, found;
  const uint32_t id = ann->send(threshold, [&](const Reply& reply) { filtered.set_value(reply); });  // aside
  ann->send("example.range ball", [&](const Reply& reply) { found.set_value(reply); });
  bob->expect(threshold);
  bob->expect("example.range ball");
  ann->expect("cancel " + std::to_string(id));
  EXPECT_EQ(filtered.get_future().get().error, "cancelled") << "though it has not begun";
  turns.pop_back();
  EXPECT_TRUE(found.get_future().get().ok);
  EXPECT_EQ(ann->expect("list").at("datasets").size(), 1u);
}

TEST(Sessions, LongWorkHasItsTurnUntilItEnds) {
  TestServer server(setup());
  ServerRank& serverRank = server.serverRank();
  const auto outbox = std::make_shared<Outbox>(
      Outbox::Limits{}, [] {}, serverRank.ledger.enter("ann", "to be sent", 0));
  Session ann(serverRank, outbox, {1, "test", "ann", false}, {});
  Request request(ann, 1, protocol::bytesOf("echo"));
  std::vector<std::shared_ptr<const uint64_t>> begun;
  for (int i = 0; i < Tenants::kLong; i++) begun.push_back(serverRank.exchanges.beginLong(request));
  const auto another = [&] { return serverRank.tenants.beginLong("ann", [] { throw Error("it waits"); }); };
  EXPECT_THROW((void)another(), Error);
  begun.pop_back();
  EXPECT_NO_THROW((void)another());
}

// As those of modules do, which cannot know how long the data are.
TEST(Sessions, LongWorkEndsOnAllRanksWhenItsRequestIsCancelled) {
  TestServer server(setup());
  ServerRank& serverRank = server.serverRank();
  std::promise<void> begun;
  std::atomic<int> ended = 0;
  for (int rank = 0; rank < 2; rank++)
    server.serverRank(rank).work.add(
        "test.long",
        [&, rank](const Work::Call& call) -> json {
          Exchanges::Part part = server.serverRank(rank).exchanges.join(call.parameters.at("exchange"));
          part.begin(0, 1, "at it");
          if (rank == 0) begun.set_value();
          try {
            for (;; std::this_thread::yield()) part.ranks.check();
          } catch (const Error&) {
            ended++;
            throw;
          }
        },
        Work::Runs::Long);
  const auto outbox = std::make_shared<Outbox>(
      Outbox::Limits{}, [] {}, serverRank.ledger.enter("ann", "to be sent", 0));
  Session ann(serverRank, outbox, {1, "test", "ann", false}, {});
  Request request(ann, 1, protocol::bytesOf("echo"));
  const auto exchange = serverRank.exchanges.beginLong(request);
  auto called = std::async(std::launch::async, [&] {
    try {
      serverRank.callAll("test.long", {{"exchange", *exchange}});
      return std::string();
    } catch (const Error& e) {
      return std::string(e.what());
    }
  });
  begun.get_future().wait();
  request.cancel();
  EXPECT_EQ(called.get(), "cancelled");
  EXPECT_EQ(ended, 2);
}

/// A reply that is to come.
std::future<Reply> sent(Client& client, const std::string& statement, uint32_t* id = nullptr) {
  const auto promise = std::make_shared<std::promise<Reply>>();
  const uint32_t number = client.send(statement, [promise](const Reply& r) { promise->set_value(r); });
  if (id) *id = number;
  return promise->get_future();
}

TEST(Sessions, ARequestThatHasNotBegunIsCancelledAtOnce) {
  TestServer server(setup());
  const auto client = server.client();
  client->expect("load data");
  std::vector<std::future<Reply>> waits;
  std::vector<uint32_t> ids(size_t(Session::kAside) + 1);
  for (uint32_t& id : ids) waits.push_back(sent(*client, "wait nothing 1 100000", &id));
  uint32_t echo = 0;
  auto queued = sent(*client, "echo", &echo), last = sent(*client, "echo last");
  const auto cancel = [&](uint32_t id) { client->expect("cancel " + std::to_string(id)); };
  cancel(echo);
  EXPECT_EQ(queued.get().error, "cancelled");
  cancel(ids.back());
  EXPECT_EQ(waits.back().get().error, "cancelled") << "it waited for one of the eight to end";
  EXPECT_EQ(last.get().value.at("text"), "last") << "and nothing waits for it";
  waits.pop_back();
  ids.pop_back();
  for (const uint32_t id : ids) cancel(id);
  for (auto& wait : waits) EXPECT_EQ(wait.get().error, "cancelled");
}

TEST(Sessions, LongRequestsAreReadInTheirTurn) {
  TestServer server(setup());
  const auto client = server.client();
  const std::string text(1 << 20, 'x');
  EXPECT_EQ(client->expect("echo " + text).at("text"), text);
  EXPECT_NE(client->request("help " + text).error.find("there is no verb"), std::string::npos);
  EXPECT_NE(client->request(text).error.find("expected a verb"), std::string::npos);
  EXPECT_NE(client->request("echo " + text + "\xFF").error.find("not UTF-8"), std::string::npos);
  client->expect("echo");
}

TEST(Sessions, LongDocumentsOfATenantAreReadOneAfterTheOther) {
  TestServer server(setup());
  ServerRank& serverRank = server.serverRank();
  const auto outbox = std::make_shared<Outbox>(
      Outbox::Limits{}, [] {}, serverRank.ledger.enter("ann", "to be sent", 0));
  Session ann(serverRank, outbox, {1, "test", "ann", false}, {}),
      bob(serverRank, outbox, {2, "test", "bob", false}, {});
  const Bytes text = protocol::bytesOf("echo");
  Request first(ann, 1, text), second(ann, 2, text), third(ann, 3, text), other(bob, 1, text);
  auto turn = serverRank.reading.take(first);
  auto waiting = std::async(std::launch::async, [&] { return serverRank.reading.take(second); });
  const auto others = serverRank.reading.take(other);
  second.cancel();
  EXPECT_THROW(waiting.get(), Error) << "it waited, and was cancelled";
  turn = nullptr;
  turn = serverRank.reading.take(third);
}

TEST(Sessions, DocumentsTakeMemoryOfTheirTenantWhileTheyAreRead) {
  ServerSetup s = setup();
  s.serverRank.tenantMemory = 8 << 20;
  TestServer server(std::move(s));
  const auto client = server.client();
  client->expect("load viewer");
  client->expect("window 1");
  const auto isovalues = [](int count) {
    std::string list = "0";
    for (int i = 1; i < count; i++) list += ",0";
    return R"({"Visualization": {"operators": [{"type": "Volume", "dataset": "x", "isovalues": [)" + list +
           "]}]}}";
  };
  const auto error = [&](const std::string& statement) { return client->request(statement).error; };
  for (const std::string& statement :
       {"set 1 " + isovalues(200000), "batch {\"state\": " + isovalues(200000) + "}",
        "render 1 {\"Camera\": {}, \"x\": [" + std::string(200000, ' ') + "0" +
            [] {
              std::string zeros;
              for (int i = 0; i < 200000; i++) zeros += ",0";
              return zeros;
            }() +
            "]}"})
    EXPECT_EQ(error(statement).find("memory: "), 0u) << error(statement);
  std::string points = "0";
  for (int i = 0; i < 200000; i++) points += ",0";
  std::ofstream(server.folder() / "map.json") << R"([{"RGBPoints": [)" << points << "]}]";
  const std::string named = error(
      R"(set 1 {"Visualization": {"operators": [{"type": "Volume", "dataset": "x", "colormap": "map.json"}]}})");
  EXPECT_NE(named.find("memory: "), std::string::npos) << "of a file that one names: " << named;
  EXPECT_NE(error("set 1 " + isovalues(20000)).find("20000 isovalues"), std::string::npos);
  for (int i = 0; i < 20; i++) client->expect("set 1 " + isovalues(200));
  client->expect("close 1");
  EXPECT_EQ(server.serverRank().ledger.total("user"), 0);
}

TEST(Sessions, MoreClientsThanAllowedAreTold) {
  ServerSetup s = setup();
  s.server.connection.limits.clients = 2;
  TestServer server(std::move(s));
  const auto first = server.client(), second = server.client();
  try {
    server.client();
    FAIL() << "a third client came in";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("no more are allowed"), std::string::npos) << e.what();
  }
}

TEST(Sessions, AClientGivesUpOnAPortThatSaysNothing) {
  const int mute = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof where;
  ASSERT_EQ(::bind(mute, reinterpret_cast<sockaddr*>(&where), size), 0);
  ASSERT_EQ(::listen(mute, 1), 0);
  ASSERT_EQ(::getsockname(mute, reinterpret_cast<sockaddr*>(&where), &size), 0);
  Client::Options options;
  options.port = ntohs(where.sin_port);
  options.tokenFile = "-";
  options.patience = std::chrono::seconds(1);
  try {
    Client client(options);
    FAIL() << "nobody has answered";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("timed out"), std::string::npos) << e.what();
  }
  ::close(mute);
}

TEST(Sessions, ATenantThatHasAllItsClientsLeavesRoomForOthers) {
  ServerSetup s = setup();
  s.server.tenantClients = 2;
  TestServer server(std::move(s));
  const auto first = server.client("ann"), second = server.client("ann");
  try {
    server.client("ann");
    FAIL() << "a third client of one tenant came in";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("tenant ann: 2 clients are connected"), std::string::npos)
        << e.what();
  }
  EXPECT_NO_THROW(server.client("bob"));
}

TEST(Sessions, AServerThatIsToStopWhenIdleStaysWhileThereAreClients) {
  ServerSetup s = setup();
  s.server.idleExit = std::chrono::seconds(2);
  TestServer server(std::move(s));
  auto client = server.client();
  std::this_thread::sleep_for(std::chrono::seconds(4));
  EXPECT_FALSE(server.stopAsked());
  client = nullptr;
  EXPECT_TRUE(server.waitForStop());
}

TEST(Sessions, EndWhenTheServerStops) {
  TestServer server(setup());
  std::promise<std::string> ended;
  auto options = server.options();
  options.onEnd = [&](const std::string& reason) { ended.set_value(reason); };
  Client client(options);
  std::promise<Reply> waiting;
  client.expect("load data");
  client.send("wait ball", [&](const Reply& r) { waiting.set_value(r); });
  client.expect("echo");
  server.stop();
  EXPECT_EQ(ended.get_future().get(), "the server stops");
  EXPECT_FALSE(waiting.get_future().get().ok);
}

}  // namespace
}  // namespace gxy::test
