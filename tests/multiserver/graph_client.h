// SPDX-License-Identifier: Apache-2.0
// Clients of module graph, a filter that runs as long as a test wants, and a simulation without a simulation.
#pragma once
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/analysis/filter.h"
#include "multiserver/server/datasets.h"
#include "tests/multiserver/viewer_client.h"

namespace gxy::test {

/// The filter Held gives its input back, and runs as long as the gate is shut, on all ranks.
struct Held {
  struct Gate {
    std::atomic<bool> shut = false;
    std::atomic<int> begun = 0, ended = 0;  ///< evaluations, of all ranks
  };
  static Gate& gate() {
    static Gate gate;
    return gate;
  }

  int number = 0;
  static FilterInfo info() {
    return {"Held", 1, "Its input.", {{"field", kVolumes, "The field."}}, DatasetType::Volume};
  }
  static std::vector<KeyRow<Held>> properties() {
    return {integerKey("number", &Held::number, {0, 1000}, "Makes another key. 13 fails.")};
  }
  FilterResult run(FilterRun& run) const {
    gate().begun++;
    const std::shared_ptr<void> end(nullptr, [](void*) { gate().ended++; });
    run.begin(0, 2, "held");
    for (bool open = false; !open;) {
      agree(run.ranks, [&] {
        run.ranks.check();
        if (number == 13 && run.ranks.rank() == run.ranks.size() - 1) throw Error("13 is no good number");
      });
      open = sumOfCounts(run.ranks, gate().shut ? 0 : 1) == uint64_t(run.ranks.size());
      if (!open) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const Dataset& from = *run.input("field").data;
    LedgerEntry memory;
    agree(run.ranks, [&] { memory = run.takeMemory("volume", from.bytes); });
    return {run.made(from.volume, from.partitioning, std::move(memory)), {{"number", number}}};
  }
};

inline std::unique_ptr<TestServer> serveGraphs(int ranks = 2, ServerRankOptions options = {}) {
  ServerSetup setup;
  setup.ranks = ranks;
  setup.modules = GALAXY_MODULES;
  setup.serverRank = std::move(options);
  auto server = std::make_unique<TestServer>(std::move(setup));
  for (int r = 0; r < ranks; r++) server->serverRank(r).filters.add<Held>();
  Held::gate().shut = false;
  Held::gate().begun = Held::gate().ended = 0;
  return server;
}

/// A client of modules data, graph and viewer, and the events that it is told.
struct GraphClient {
  explicit GraphClient(const TestServer& server, const std::string& tenant = "user") {
    auto options = server.options(tenant);
    options.onPixels = [this](const auto& header, auto data) { screen.take(header, data); };
    options.onEvent = [this](const nlohmann::json& event) {
      const std::lock_guard lock(mutex);
      events.push_back(event);
    };
    client = std::make_unique<Client>(options);
    for (const char* module : {"data", "graph", "viewer", "analysis"})
      client->expect(std::string("load ") + module);
  }
  nlohmann::json say(const std::string& statement) { return client->expect(statement); }
  Reply request(const std::string& statement) { return client->request(statement); }
  std::string error(const std::string& statement) { return client->request(statement).error; }
  nlohmann::json edit(const nlohmann::json& edits, bool live = false) {
    return say("graph.edit g " + nlohmann::json{{"edits", edits}, {"live", live}}.dump());
  }
  nlohmann::json node(const std::string& name, const std::string& kind = "dataset") {
    const nlohmann::json graph = say("graph.get g");
    for (const nlohmann::json& node : graph.at("nodes"))
      if (node.at("node") == name && node.at("kind") == kind) return node;
    return nullptr;
  }
  std::string state(const std::string& name, const std::string& kind = "dataset") {
    return node(name, kind).at("state");
  }
  void untilState(const std::string& name, const std::string& expected, const std::string& kind = "dataset") {
    until([&] { return state(name, kind) == expected; }, (name + " is " + expected).c_str());
  }
  /// Whether the ledger of a rank has memory for this purpose.
  bool hasMemory(int rank, const std::string& purpose) {
    const nlohmann::json stat = say("stat");
    for (const nlohmann::json& line : stat.at("ranks").at(size_t(rank)).at("memory").at("by purpose"))
      if (line.at("purpose") == purpose) return true;
    return false;
  }
  /// Waits for an event that `wanted` accepts, and returns it.
  template <class F>
  nlohmann::json untilEvent(const F& wanted) {
    nlohmann::json found;
    until(
        [&] {
          const std::lock_guard lock(mutex);
          for (const nlohmann::json& event : events)
            if (wanted(event)) found = event;
          return !found.is_null();
        },
        "the event");
    return found;
  }

  Screen screen;
  std::mutex mutex;
  std::vector<nlohmann::json> events;
  std::unique_ptr<Client> client;  // after what it uses, so that it goes first
};

/// Publishes steps of two fields, `p` and `t`, together, as a simulation does. Their values are those of datasets of this server.
class TwoFields {
 public:
  explicit TwoFields(TestServer& server) : server_(server) {
    for (int r = 0; r < server.serverRank().ranks(); r++) {
      ServerRank& serverRank = server.serverRank(r);
      serverRank.work.add(
          "test.publish",
          [&serverRank](const Work::Call& call) { return publishHere(serverRank, call.parameters); },
          Work::Runs::Waiting);
    }
  }
  /// The next step; its values are those of `like`. Throws Error where there is no room after a second.
  void publish(const std::string& like) {
    ServerRank& root = server_.serverRank();
    const auto exchange = root.exchanges.begin(Asker{});
    const auto names = root.datasets->beginNow("user", *exchange, "publish", Scope::Private,
                                               {{"p", DatasetType::Volume}, {"t", DatasetType::Volume}});
    const NamedDataset from = root.datasets->get("user", like);
    root.callAll("test.publish", {{"exchange", *exchange},
                                  {"items", names->items()},
                                  {"key", from.key.value},
                                  {"generation", from.generation},
                                  {"step", step_ + 1}});
    step_++;
  }
  int64_t step() const { return step_; }

 private:
  static nlohmann::json publishHere(ServerRank& serverRank, const nlohmann::json& p) {
    Exchanges::Part part = serverRank.exchanges.join(p.at("exchange").get<uint64_t>());
    Publication publication = serverRank.datasets->join(p.at("items"), part.ranks);
    publication.reserve();
    for (size_t i = 0; i < 2; i++) {
      const auto from =
          serverRank.objects.pin(Key{p.at("key").get<uint64_t>()}, p.at("generation").get<Generation>())
              .get<Dataset>();
      auto dataset = std::make_shared<Dataset>();
      dataset->volume = from->volume;
      dataset->partitioning = from->partitioning;
      dataset->origins = {{7, p.at("step").get<int64_t>()}};
      dataset->bytes = from->bytes;
      dataset->memory = serverRank.takeMemory("user", "volume", from->bytes);
      publication.stage(i, Payload(std::shared_ptr<const Dataset>(std::move(dataset))));
    }
    serverRank.datasets->publish(publication, p.at("exchange").get<uint64_t>());
    return nullptr;
  }

  TestServer& server_;
  int64_t step_ = 0;
};

/// A live volume, an entry of a filter, and a view of a volume, as documents have them.
inline nlohmann::json liveVolume(const std::string& name) { return {{"name", name}, {"type", "Volume"}}; }
inline nlohmann::json madeBy(const std::string& filter, const std::string& name, const nlohmann::json& inputs,
                             nlohmann::json properties = nlohmann::json::object()) {
  properties.update({{"name", name}, {"filter", filter}, {"inputs", inputs}});
  return properties;
}
/// A node of filter Held.
inline nlohmann::json copyOf(const std::string& name, const std::string& of, int number = 0) {
  return madeBy("Held", name, {{"field", of}}, {{"number", number}});
}
/// The request for a graph `g`.
inline std::string newGraph(const nlohmann::json& datasets,
                            const nlohmann::json& views = nlohmann::json::array()) {
  return "graph.new g " + nlohmann::json{{"Datasets", datasets}, {"Visualizations", views}}.dump();
}
inline nlohmann::json viewOf(const std::string& name, const std::vector<std::string>& volumes) {
  nlohmann::json view = nlohmann::json::parse(stateOf("ball")).at("Visualization");
  const nlohmann::json look = view.at("operators").at(0);
  view["name"] = name;
  view["operators"] = nlohmann::json::array();
  for (const std::string& volume : volumes) {
    view["operators"].push_back(look);
    view["operators"].back()["dataset"] = volume;
  }
  view["camera"] = nlohmann::json::parse(stateOf("ball")).at("Camera");
  view["size"] = {96, 80};
  return view;
}

}  // namespace gxy::test
