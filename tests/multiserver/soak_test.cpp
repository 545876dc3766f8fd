// SPDX-License-Identifier: Apache-2.0
// Clients that die at any time, fall silent, read slowly, or come all at once: of none is anything left. --cycles=1000
// --clients=200 for the long form, in which the memory of the process is looked at, too.
#include <gtest/gtest.h>

#include <malloc.h>

#include <cstdio>
#include <cstdlib>
#include <deque>
#include <memory>
#include <random>
#include <thread>

#include "core/comm/thread_pool.h"
#include "core/space/ledger.h"
#include "multiserver/protocol/statement.h"
#include "tests/multiserver/bystander.h"
#include "tests/multiserver/raw_client.h"

namespace gxy::test {
namespace {

using nlohmann::json;
using protocol::MessageChannel;
using protocol::WireMessage;

constexpr int kRanks = 2;
constexpr const char* kVictims[] = {"victim", "another"};  // tenants

/// What the server holds, by its own count and the system's.
struct Counts {
  int files = 0, threads = 0;
  int64_t ledger = 0;    ///< of all ranks
  int64_t heap = 0;      ///< bytes that the process has allocated and not freed
  int64_t resident = 0;  ///< what of its memory is in place, freed pieces between others included
};

// As malloc_info() has it at its end, of all arenas: taken from the system, less what is free in it, and large pieces.
int64_t heapInUse() {
  char* text = nullptr;
  size_t size = 0;
  std::FILE* stream = open_memstream(&text, &size);
  malloc_info(0, stream);
  std::fclose(stream);
  const std::string all(text, size);
  std::free(text);
  const std::string totals = all.substr(all.rfind("</heap>"));
  const auto bytes = [&](const std::string& element) {
    const size_t at = totals.find("size=\"", totals.find(element)) + 6;
    return std::stoll(totals.substr(at));
  };
  return bytes("<system type=\"current\"") - bytes("<total type=\"fast\"") - bytes("<total type=\"rest\"") +
         bytes("<total type=\"mmap\"");
}

class Soak {
 public:
  Soak() : server_(setup()), bystander_(server_) {}

  /// One client, whose fate the seed decides.
  void cycle(uint32_t seed) {
    std::mt19937 random(seed);
    auto raw = std::make_unique<RawClient>(server_.port(), 4096);
    const auto part = [&](std::span<const std::byte> all) { raw->send(all.first(random() % all.size())); };
    const uint32_t fate = random() % 10;
    if (fate == 0) part(protocol::preamble());
    if (fate == 1) {
      raw->send(protocol::preamble());
      part(protocol::headerOf(protocol::textMessage(MessageChannel::Control, 0, "hello {}")));
    }
    if (fate >= 2) converse(*raw, random);
    if (fate == 8) {  // half open: it says nothing any more, and does not close
      silent_.push_back(std::move(raw));
    } else if (fate == 9) {
      slow_.push_back(std::move(raw));
      if (slow_.size() > 3) slow_.pop_front();
    } else if (random() % 2) {
      raw->reset();
    }
    if (silent_.size() > 10) silent_.pop_front();
    readSlowly();
  }

  /// So many clients ask for data and a picture, all at once, and get them; half of them die before.
  void crowd(int clients) {
    std::deque<RawClient> all;
    std::deque<std::jthread> readers;  // each client answers its pings, however long the others take
    for (int i = 0; i < clients; i++) {
      RawClient& raw = all.emplace_back(server_.port());
      uint32_t id = 1;
      raw.greet(
          kVictims[size_t(i / 2 % 2)]);  // of one tenant fewer long requests may run than there are here
      for (const std::string& statement : statements(" of " + std::to_string(i)))
        raw.request(id++, statement);
      if (i % 2 == 0)
        readers.emplace_back(
            [&raw, i] { EXPECT_EQ(raw.repliesAndEnds(statements("").size(), 1), "") << "client " << i; });
    }
    for (size_t i = 1; i < all.size(); i += 2) all[i].reset();
  }

  /// All of them are gone: what is left?
  Counts left() {
    slow_.clear();
    silent_.clear();
    waitForClients(server_, 1);
    std::unique_ptr<Client> cleaner;
    for (const char* victim : kVictims) {
      cleaner = server_.client(victim);
      cleaner->expect("load data");
      const json list = cleaner->expect("list");
      for (const json& d : list.at("datasets"))
        cleaner->expect("drop " + protocol::asWord(d.at("name").get<std::string>()));
    }
    bystander_.expectTheSamePicture();
    Counts counts;
    for (int rank = 0; rank < kRanks; rank++) {
      ServerRank& serverRank = server_.serverRank(rank);
      // the bystander has its picture before its frame has let go of what it was made of
      for (int i = 0; i < 1000 && (serverRank.renderer.kept().frames > 0 || bytesOfVictims(serverRank) > 0 ||
                                   bytesOfFrames(serverRank.ledger) > 0);
           i++)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      EXPECT_EQ(serverRank.renderer.kept().frames, 0u) << "rank " << rank;
      EXPECT_EQ(serverRank.renderer.kept().credits, 0) << "rank " << rank;
      EXPECT_EQ(bytesOfVictims(serverRank), 0) << "rank " << rank;
      EXPECT_EQ(bytesOfFrames(serverRank.ledger), 0) << "rank " << rank;
      counts.ledger += serverRank.ledger.total();
    }
    const json stat = cleaner->expect("stat");
    for (const json& c : stat.at("clients")) {
      EXPECT_EQ(c.at("queued bytes"), 0) << c;
      EXPECT_LE(c.at("requests"), 1) << "the question itself";
    }
    counts.files = openFiles();
    counts.threads = runningThreads();
    malloc_trim(0);  // so that what has been freed is not counted
    counts.heap = heapInUse();
    counts.resident = processBytes().resident;
    return counts;
  }

 private:
  static int64_t bytesOfVictims(const ServerRank& serverRank) {
    int64_t bytes = 0;
    for (const char* victim : kVictims) bytes += serverRank.ledger.total(victim);
    return bytes;
  }
  static int64_t bytesOfFrames(const Ledger& ledger) {
    int64_t bytes = 0;
    for (const Ledger::Line& line : ledger.snapshot())
      for (const char* purpose : {"framebuffer", "picture", "passes", "rays", "tiles"})
        if (line.purpose == purpose) bytes += line.bytes;
    return bytes;
  }

  static ServerSetup setup() {
    ServerSetup setup;
    setup.ranks = kRanks;
    setup.serverRank.tenantFrames = 1000;
    setup.modules = GALAXY_MODULES;
    setup.server.connection.patience = {std::chrono::milliseconds(5000), std::chrono::milliseconds(500),
                                        std::chrono::milliseconds(30000)};
    return setup;
  }

  static std::vector<std::string> statements(const std::string& whose) {
    json state = json::parse(stateOf("ball" + whose));
    state["Datasets"] = {{{"name", "ball" + whose}, {"filename", "ball.vol"}, {"type", "Volume"}}};
    return {"load data",
            "load viewer",
            importBall("ball" + whose),
            "window 1 {\"size\": [300, 200]}",
            "set 1 " + state.dump(),
            "render 1 {\"levels\": [1]}"};
  }

  // Up to a point that is drawn: between two statements, or within one.
  void converse(RawClient& raw, std::mt19937& random) {
    raw.greet("victim");
    uint32_t id = 1;
    for (const std::string& statement : statements("")) {
      const WireMessage frame = protocol::textMessage(MessageChannel::Request, id++, statement);
      if (random() % 12 == 0) {
        raw.send(protocol::headerOf(frame));
        raw.send(std::span(frame.payload).first(frame.payload.size() / 2));
        return;
      }
      raw.send(frame);
    }
    raw.request(id, "render 1 {\"passes\": 50}");
    std::array<std::byte, 4096> some;
    for (int n = int(random() % 4); n > 0; n--) raw.receive(some, int(random() % 20));
  }

  // 10 kB/s of each of them.
  void readSlowly() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - std::exchange(lastRead_, now)).count();
    std::vector<std::byte> some(std::clamp(size_t(seconds * 10000), size_t(1), size_t(10000)));
    for (const auto& raw : slow_) raw->receive(some, 0);
  }

  TestServer server_;
  Bystander bystander_;
  std::deque<std::unique_ptr<RawClient>> silent_, slow_;
  std::chrono::steady_clock::time_point lastRead_ = std::chrono::steady_clock::now();
};

TEST(Soak, NothingIsLeftOfClientsThatDieFallSilentOrReadSlowly) {
  const int cycles = argument("--cycles=", 50), clients = argument("--clients=", 50);
  Soak soak;
  const auto warm = uint32_t(cycles * 3 / 10);
  uint32_t seed = 0;
  for (int i = 0; i < 2; i++) soak.crowd(clients);
  while (seed < warm) soak.cycle(++seed);
  const Counts before = soak.left();
  while (seed < uint32_t(cycles)) soak.cycle(++seed);
  const Counts after = soak.left();
  EXPECT_EQ(after.files, before.files);
  EXPECT_EQ(after.ledger, before.ledger) << "bytes";
  EXPECT_LE(after.threads, before.threads + 3 * int(ThreadPool::kKept)) << "idle ones of the three pools";
  RecordProperty("threads", std::to_string(before.threads) + ", " + std::to_string(after.threads));
  RecordProperty("resident bytes", std::to_string(before.resident) + ", " + std::to_string(after.resident));
  RecordProperty("heap bytes", std::to_string(before.heap) + ", " + std::to_string(after.heap));
  if (cycles >= 1000) {
    EXPECT_LE(double(after.heap), 1.01 * double(before.heap)) << "bytes";
    EXPECT_LE(double(after.resident), 1.1 * double(before.resident)) << "bytes";
  }
}

}  // namespace
}  // namespace gxy::test
