// SPDX-License-Identifier: Apache-2.0
// What a tenant hears and sees of the data of others: of what is private to them nothing, whatever its name.
#include "tests/multiserver/viewer_client.h"

namespace gxy::test {
namespace {

using nlohmann::json;

/// A client that observes all, and what it is told of datasets.
class Observer {
 public:
  Observer(const TestServer& server, const std::string& tenant) {
    auto options = server.options(tenant);
    options.onEvent = [this](const json& event) {
      if (event.at("event") == "progress") return;
      const std::lock_guard lock(mutex_);
      told_.push_back(event.at("event").get<std::string>() + " " + event.at("scope").get<std::string>() +
                      " " + event.at("name").get<std::string>());
    };
    client_ = std::make_unique<Client>(options);
    client_->expect("load data");
    client_->expect("observe");
  }
  void say(const std::string& statement) { client_->expect(statement); }
  /// All so far; events come before the reply of a later request.
  std::vector<std::string> told() {
    client_->expect("echo");
    const std::lock_guard lock(mutex_);
    return told_;
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> told_;
  std::unique_ptr<Client> client_;  // after what it uses
};

using Told = std::vector<std::string>;

TEST(DataOfOthers, ArePrivateToThemInEventsToo) {
  const auto server = serve();
  Observer ann(*server, "ann"), bob(*server, "bob");
  for (int i = 0; i < 2; i++) ann.say(importBall("ball"));
  ann.say("rename ball secret");
  EXPECT_EQ(ann.told(), (Told{"added private ball", "updated private ball", "renamed private ball"}));
  EXPECT_EQ(bob.told(), Told{});
  ann.say("publish secret");
  EXPECT_EQ(bob.told(), Told{"added shared secret"}) << "what it leaves the private directory as is not told";
  ann.say("unpublish secret");
  ann.say("drop secret");
  EXPECT_EQ(bob.told(), (Told{"added shared secret", "dropped shared secret"}));
}

TEST(DataOfOthers, AreToldOfWithEachGenerationOnceTheyArePublished) {
  const auto server = serve();
  Observer ann(*server, "ann"), bob(*server, "bob");
  ann.say(importBall("ball"));
  ann.say("publish ball");
  ann.say("import shared " + importBall("ball").substr(7));
  EXPECT_EQ(bob.told(), (Told{"added shared ball", "updated shared ball"}));
}

TEST(Observers, AreToldOfTheNamesThatTheyObserveUntilTheyNoLongerDo) {
  const auto server = serve();
  Observer user(*server, "user");
  const auto other = server->client("user");
  other->expect("load data");
  user.say("unobserve");
  user.say("observe ball");
  user.say("observe second");
  other->expect(importBall("first"));
  EXPECT_EQ(user.told(), Told{});
  other->expect("rename first ball");
  EXPECT_EQ(user.told(), Told{"renamed private first"}) << "to a name that is observed";
  user.say("unobserve ball");
  other->expect("drop ball");
  other->expect(importBall("second"));
  EXPECT_EQ(user.told(), (Told{"renamed private first", "added private second"}));
  user.say("unobserve");
  other->expect("drop second");
  EXPECT_EQ(user.told().size(), 2u);
}

TEST(DataOfOthers, DoNotWakeWindowsThatShowDatasetsOfTheSameName) {
  const auto server = serve();
  Viewer viewer(*server, "bob");
  viewer.client->expect("window 1 {\"follow\": true}");
  viewer.frame();
  const auto ann = server->client("ann");
  ann->expect("load data");
  for (int round = 0; round < 4; round++) {
    ann->expect(importBall("ball"));  // new, then another generation
    ann->expect(importBall("ball"));
    ann->expect("drop ball");
    // A window that is between an edit and its picture has no scene by which to know its data.
    viewer.client->expect("set 1 " + stateOf("ball"));
  }
  ann->expect("import shared " + importBall("ball").substr(7));  // hidden by its own
  ann->expect("import shared " + importBall("ball").substr(7));
  viewer.client->expect(importBall("ball"));
  EXPECT_EQ(viewer.screen.waitFor(1, 2).json.at("generations"), (json{{"ball", 2}}));
  EXPECT_EQ(viewer.newestFrame(1), 2) << "its own update is the one that counts";
}

}  // namespace
}  // namespace gxy::test
