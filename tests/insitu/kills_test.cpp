// SPDX-License-Identifier: Apache-2.0
// Processes that are killed or stopped at moments that a seed draws: nobody else is harmed, and nothing is left of them.
#include <spawn.h>
#include <sys/wait.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/comm/random.h"
#include "core/comm/thread_pool.h"
#include "tests/insitu/killed_simulation.h"
#include "tests/insitu/published.h"

extern char** environ;  // NOLINT(readability-redundant-declaration)

namespace gxy::test {
namespace {

using Clock = std::chrono::steady_clock;
using nlohmann::json;

/// A process, which is killed at the end of its life here.
class Process {
 public:
  explicit Process(std::vector<std::string> arguments) {
    std::vector<char*> argv;
    for (std::string& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    if (posix_spawn(&pid_, argv[0], nullptr, nullptr, argv.data(), environ) != 0)
      throw std::runtime_error("cannot start " + arguments[0]);
  }
  ~Process() { kill(); }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void signal(int number) const { ::kill(pid_, number); }
  void kill() {
    if (pid_ == 0) return;
    ::kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }
  bool runs() const { return waitpid(pid_, nullptr, WNOHANG) == 0; }
  /// Waits for its end.
  void wait() {
    waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }
  /// The processes that it has started, by name.
  std::vector<pid_t> children(const std::string& name) const {
    std::vector<pid_t> found;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      std::ifstream stat(entry.path() / "stat");
      pid_t pid = 0, parent = 0;
      std::string comm;
      char state = 0;
      if (stat >> pid >> comm >> state >> parent && parent == pid_ && comm == "(" + name + ")")
        found.push_back(pid);
    }
    return found;
  }

 private:
  pid_t pid_ = 0;
};

std::ptrdiff_t entries(const char* folder) {
  const std::filesystem::directory_iterator all(folder);
  return std::distance(begin(all), end(all));
}

/// What this process has open, and threads.
std::pair<std::ptrdiff_t, std::ptrdiff_t> held() {
  return {entries("/proc/self/fd"), entries("/proc/self/task")};
}

/// A number that was given to the test as --NAME=N.
uint64_t given(const std::string& name, uint64_t otherwise) {
  const std::string begin = "--" + name + "=";
  for (const std::string& a : testing::internal::GetArgvs())
    if (a.starts_with(begin)) return std::stoull(a.substr(begin.size()));
  return otherwise;
}

Clock::time_point end() { return Clock::now() + std::chrono::seconds(given("seconds", 5)); }

void pause(Random& random, uint64_t mostMilliseconds) {
  std::this_thread::sleep_for(std::chrono::microseconds(random.below(1000 * mostMilliseconds + 1)));
}

TEST(Kills, OfASimulationHarmNeitherTheServerNorItsData) {
  Random random(given("seed", KILLS_SEED));
  ServerSetup setup;
  setup.ranks = 3;
  setup.modules = GALAXY_MODULES;
  TestServer server(std::move(setup));
  Events events("heat.a");
  const auto client = events.client(server);
  client->expect("load data");
  client->expect("load insitu");
  client->expect("observe");
  const auto streams = [&] { return client->expect("insitu.streams").at("streams").size(); };
  const auto memory = [&] {
    int64_t bytes = 0;
    for (int r = 0; r < 3; r++) bytes += server.serverRank(r).ledger.total();
    return bytes;
  };
  const int64_t memoryBefore = memory();
  std::pair<std::ptrdiff_t, std::ptrdiff_t> heldBefore;
  int rounds = 0, kills = 0, stops = 0;
  for (const auto until_ = end(); rounds < 3 || Clock::now() < until_; rounds++) {
    const uint64_t seed = random.below(uint64_t(1) << 40);
    SCOPED_TRACE("round " + std::to_string(rounds) + ", seed " + std::to_string(seed));
    const int ranks = 1 + int(random.below(4));
    const std::string options = json{
        {"to", "127.0.0.1:" + std::to_string(server.port())},
        {"token-file", "-"},
        {"reconnect", 0.02}}.dump();
    std::vector<std::unique_ptr<Process>> simulation;
    const std::string start =
        std::to_string(std::chrono::nanoseconds(Clock::now().time_since_epoch()).count());
    for (int r = 0; r < ranks; r++)
      simulation.push_back(std::make_unique<Process>(
          std::vector<std::string>{KILLED_SIMULATION, options, std::to_string(r), std::to_string(ranks),
                                   std::to_string(seed), start}));
    const auto steps = [&] { return events.count("added") + events.count("updated"); };
    const auto more = [&](size_t than) { until([&] { return steps() > than; }, "a step"); };
    more(steps() + 1);
    for (uint64_t i = random.below(3); i > 0; i--, stops++) {
      const Process& rank = *simulation[random.below(simulation.size())];
      rank.signal(SIGSTOP);
      pause(random, 20);
      rank.signal(SIGCONT);
      more(steps());
    }
    pause(random, 20);
    while (!simulation.empty()) {
      const size_t victim = random.below(simulation.size());
      if (random.oneIn(4)) simulation[victim]->signal(SIGSTOP);
      simulation.erase(simulation.begin() + std::ptrdiff_t(victim));
      kills++;
      pause(random, 10);
      for (const auto& other : simulation) EXPECT_TRUE(other->runs());
    }
    until([&] { return streams() == 0; }, "the end of the stream");
    expectEqualsImport(server, *client, killedGrid(), GXY_OF_POINTS, killedFields());
    for (const char* name : {"heat.a", "heat.b", "file"}) client->expect(std::string("drop ") + name);
    until([&] { return memory() == memoryBefore; }, "the memory");
    if (rounds == 0)
      heldBefore = held();  // Modules have been loaded, and threads have begun to work.
    else
      until([&] { return held().first == heldBefore.first; }, "descriptors");
    // The pool of each rank keeps some threads that have had work.
    const auto pools = std::ptrdiff_t(3 * ThreadPool::kKept);
    until([&] { return held().second <= heldBefore.second + pools; }, "threads");
    if (testing::Test::HasFailure()) return;
  }
  std::cout << rounds << " simulations, " << kills << " kills, " << stops << " stops\n";
}

TEST(Kills, OfTheServerDoNotHarmTheSimulation) {
  Random random(given("seed", KILLS_SEED));
  const TemporaryFolder folder;
  const auto place = folder.path() / "port";
  std::string port = "0";
  const auto start = [&] {
    auto server = std::make_unique<Process>(std::vector<std::string>{
        GXYSERVER, "--no-token", "--port", port, "--port-file", place.string(), "--log-level", "off"});
    until([&] { return std::filesystem::exists(place); }, "the server");
    std::ifstream(place) >> port;
    std::filesystem::remove(place);
    return server;
  };
  auto server = start();
  const auto heldBefore = held();
  int kills = 0;
  {
    MiniSimulation simulation(
        "heat", killedGrid(), killedBlocks(1, 2), 2, killedFields(), Layout::Backwards,
        json{{"to", "127.0.0.1:" + port}, {"token-file", "-"}, {"reconnect", 0.02}}.dump());
    for (const auto until_ = end(); kills < 2 || Clock::now() < until_; kills++) {
      const int64_t before = simulation.published();
      until(
          [&] {
            simulation.publish();
            return simulation.published() > before;
          },
          "a step");
      for (uint64_t i = random.below(30); i > 0; i--) simulation.publish();
      if (random.oneIn(2)) {
        server->signal(SIGSTOP);
        for (int i = 0; i < 100; i++) simulation.publish();  // It does not wait for the server.
        if (random.oneIn(2)) server->signal(SIGCONT);
      }
      pause(random, 20);
      server->kill();
      until(
          [&] {
            simulation.publish();
            return *gxy_message(simulation.rank(0)) != 0;
          },
          "the loss");
      server = start();
    }
  }
  until([&] { return held() == heldBefore; }, "descriptors and threads");
  std::cout << kills << " kills\n";
}

TEST(Kills, OfOneRankOfAServerDoNotHarmTheSimulation) {
  Random random(given("seed", KILLS_SEED));
  const TemporaryFolder folder;
  const auto place = folder.path() / "port";
  std::string port = "0";
  setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
  setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
  constexpr size_t kRanks = 3;
  const auto start = [&] {
    std::vector<std::string> command;
    std::istringstream words(MPIEXEC);
    for (std::string word; words >> word;) command.push_back(word);
    for (const std::string& word :
         {std::string("-n"), std::to_string(kRanks), std::string(GXYSERVER), std::string("--no-token"),
          std::string("--port"), port, std::string("--port-file"), place.string(), std::string("--log-level"),
          std::string("off")})
      command.push_back(word);
    auto job = std::make_unique<Process>(command);
    until([&] { return std::filesystem::exists(place); }, "the server");
    std::ifstream(place) >> port;
    std::filesystem::remove(place);
    return job;
  };
  auto job = start();
  const auto heldBefore = held();
  int kills = 0;
  {
    MiniSimulation simulation(
        "heat", killedGrid(), killedBlocks(1, 3), 3, killedFields(), Layout::Ghosts,
        json{{"to", "127.0.0.1:" + port}, {"token-file", "-"}, {"reconnect", 0.05}}.dump());
    for (const auto until_ = end(); kills < 1 || Clock::now() < until_; kills++) {
      const int64_t before = simulation.published();
      until(
          [&] {
            simulation.publish();
            return simulation.published() > before;
          },
          "a step");
      for (uint64_t i = random.below(30); i > 0; i--) simulation.publish();
      const std::vector<pid_t> ranks = job->children("gxyserver");
      ASSERT_EQ(ranks.size(), kRanks);
      const pid_t victim = ranks[random.below(kRanks)];
      const bool stops = random.oneIn(3);
      if (stops) ::kill(victim, SIGSTOP);
      for (uint64_t i = random.below(50); i > 0; i--) simulation.publish();  // It does not wait for the rank.
      pause(random, 20);
      ::kill(victim, SIGKILL);
      until(
          [&] {
            simulation.publish();
            return *gxy_message(simulation.rank(0)) != 0;
          },
          "the loss");
      job->wait();  // The launcher ends the other ranks.
      job = start();
    }
    const int64_t before = simulation.published();
    until(
        [&] {
          simulation.publish();
          return simulation.published() > before;
        },
        "a step for the last server");
  }
  until([&] { return held() == heldBefore; }, "descriptors and threads");
  std::cout << kills << " kills of one rank\n";
}

}  // namespace
}  // namespace gxy::test
