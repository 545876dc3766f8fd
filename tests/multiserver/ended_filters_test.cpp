// SPDX-License-Identifier: Apache-2.0
// Filters that a server ends before they are done, because somebody cancels them or the tenant has no room: nothing is left of them, nobody
// else notices, and the next one works.
#include <gtest/gtest.h>

#include <future>
#include <mutex>

#include "tests/multiserver/bystander.h"
#include "tests/multiserver/viewer_client.h"

namespace gxy::test {
namespace {

using nlohmann::json;

constexpr int kRanks = 3;

/// A filter whose entry can be made to take long, to need much memory, or neither.
struct EndedCase {
  std::string filter;
  json inputs;
  json small;  ///< properties of an entry that is made at once
  json slow;   ///< that takes long; its progress says `text`
  std::string text;
  json large;  ///< that needs more than kTenantMemory on each rank, but not at its beginning
};

constexpr int64_t kTenantMemory = 4 << 20;

std::string entryOf(const EndedCase& c, const json& inputs, json properties) {
  properties.update({{"name", "made"}, {"filter", c.filter}, {"inputs", inputs}});
  return "make " + properties.dump();
}

/// Fields of three components, by names v0, v1, ...
json vectors(int count) {
  json names = json::array();
  for (int i = 0; i < count; i++) names.push_back("v" + std::to_string(i));
  return names;
}
constexpr int kVectors = 10;

std::vector<EndedCase> endedCases() {
  const json shell{{"dataset", "f"}, {"isovalues", {0.5}}, {"hits", 9}};
  json nowhere = shell, spawning = shell;
  nowhere["conditions"] = {{{"field", "f"}, {"range", {7, 8}}}};
  spawning["hits"] = 1;
  spawning["next"] = {{"spawn", 64}, {"over", "sphere"}};
  return {
      {"RaySampler",
       {{"f", "ball"}},
       {{"operators", {shell}}, {"lines", 100}},
       {{"operators", {nowhere}}, {"lines", 1 << 30}},
       "sending rays",
       {{"operators", {spawning}}, {"lines", 5000}, {"depth", 2}}},
      // Of 10^5 candidates it takes less than one.
      {"DensitySampler",
       {{"field", "ball"}},
       {{"count", 100}},
       {{"count", 1 << 28}, {"map", {{0.5, 0}, {0.500001, 1}, {0.500002, 0}}}},
       "points",
       {{"count", 1000000}}},
      {"Interpolate",
       {{"points", "many"}, {"fields", vectors(kVectors)}},
       {{"component", 1}},
       json::object(),
       "values at points",
       json::object()},
      {"Resample",
       {{"field", "ball"}},
       {{"dimensions", {9, 9, 9}}},
       {{"dimensions", {320, 256, 256}}},
       "values",
       {{"dimensions", {160, 128, 128}}}},
  };
}

/// A server with the data of the cases, a client of it and somebody else.
class EndedFilters {
 public:
  EndedFilters(int64_t tenantMemory, int64_t points) {
    ServerSetup setup;
    setup.ranks = kRanks;
    setup.modules = GALAXY_MODULES;
    if (tenantMemory > 0) setup.serverRank.tenantMemory = tenantMemory;
    server = std::make_unique<TestServer>(std::move(setup));
    bystander = std::make_unique<Bystander>(*server);
    auto options = server->options();
    options.onEvent = [this](const json& event) {
      const std::lock_guard lock(mutex_);
      if (onProgress_ && event.at("event") == "progress") onProgress_(event.at("text"));
    };
    client = std::make_unique<Client>(options);
    for (const char* module : {"data", "analysis"}) client->expect(std::string("load ") + module);
    client->expect(importBall("ball"));
    for (const json& name : vectors(kVectors))
      client->expect("make " + json{{"filter", "Derive"},
                                    {"name", name},
                                    {"inputs", {{"f", "ball"}}},
                                    {"expression", "[f, x * f, 2 - f]"}}
                                   .dump());
    for (const auto& [name, count] : {std::pair("some", int64_t(1000)), std::pair("many", points)})
      client->expect("make " + json{{"filter", "Seeds"},
                                    {"name", name},
                                    {"inputs", {{"domain", "ball"}}},
                                    {"shape", "box"},
                                    {"count", count}}
                                   .dump());
    for (int r = 0; r < kRanks; r++) before_.push_back(total(r));
    datasets_ = client->expect("list").at("datasets");
  }

  /// The error of a request that is cancelled once its progress says `text`.
  std::string cancelled(const std::string& request, const std::string& text) {
    std::promise<void> begun;
    std::once_flag once;
    {
      const std::lock_guard lock(mutex_);
      onProgress_ = [&](const std::string& said) {
        if (said == text) std::call_once(once, [&] { begun.set_value(); });
      };
    }
    std::promise<Reply> made;
    const uint32_t id = client->send(request, [&](const Reply& reply) { made.set_value(reply); });
    begun.get_future().get();
    client->expect("cancel " + std::to_string(id));
    bystander->expectTheSamePicture();
    const Reply reply = made.get_future().get();
    const std::lock_guard lock(mutex_);
    onProgress_ = nullptr;
    return reply.ok ? "it was made" : reply.error;
  }
  /// Nothing is there that was not there before, and nobody has noticed.
  void expectNothingLeft(const std::string& what) {
    // A thread that has ended the last ray may still let go of the scene.
    for (int r = 0; r < kRanks; r++)
      until([&] { return total(r) == before_[size_t(r)]; }, (what + ": nothing is kept").c_str());
    EXPECT_EQ(client->expect("list").at("datasets"), datasets_) << what;
    bystander->expectTheSamePicture();
  }
  void expectItWorks(const EndedCase& c) {
    json inputs = c.inputs;
    if (inputs.contains("points")) inputs = {{"points", "some"}, {"fields", "v0"}};
    const json told = client->expect(entryOf(c, inputs, c.small)).at("results").at(0);
    EXPECT_EQ(told.at("generation"), 1) << c.filter;
    client->expect("drop made");
    expectNothingLeft(c.filter);
  }

  std::unique_ptr<TestServer> server;
  std::unique_ptr<Bystander> bystander;
  std::unique_ptr<Client> client;

 private:
  int64_t total(int rank) { return server->serverRank(rank).ledger.total("user"); }

  std::mutex mutex_;
  std::function<void(const std::string& text)> onProgress_;
  std::vector<int64_t> before_;
  json datasets_;
};

TEST(EndedFilters, ThatAreCancelledLeaveNothingOnAnyRank) {
  EndedFilters filters(0, 500'000);
  for (const EndedCase& c : endedCases()) {
    EXPECT_EQ(filters.cancelled(entryOf(c, c.inputs, c.slow), c.text), "cancelled") << c.filter;
    filters.expectNothingLeft(c.filter);
    filters.expectItWorks(c);
  }
}

TEST(EndedFilters, ThatReachTheQuotaLeaveNothingOnAnyRank) {
  EndedFilters filters(kTenantMemory, 90000);
  for (const EndedCase& c : endedCases()) {
    const Reply reply = filters.client->request(entryOf(c, c.inputs, c.large));
    EXPECT_FALSE(reply.ok) << c.filter;
    EXPECT_NE(reply.error.find("memory"), std::string::npos) << c.filter << ": " << reply.error;
    filters.expectNothingLeft(c.filter);
    filters.expectItWorks(c);
  }
}

}  // namespace
}  // namespace gxy::test
