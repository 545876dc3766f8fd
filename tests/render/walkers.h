// SPDX-License-Identifier: Apache-2.0
// Walkers: items of a flight that are no rays. They hop from partition to partition as their numbers say, and
// some have children.
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/in_process.h"
#include "core/comm/random.h"
#include "core/comm/wire.h"
#include "core/render/flights.h"

namespace gxy::test {

/// One walker. Children are of a kind of their own, which has no hops to count.
struct Walker {
  uint64_t number;
  uint32_t hops;
};

/// Walkers in one partition: the ItemList.
struct Walkers {
  int partition = 0;
  bool children = false;
  std::vector<Walker> all;

  uint32_t kind() const { return children; }
  int size() const { return int(all.size()); }
  int64_t bytes() const { return int64_t(all.size() * sizeof(Walker)); }
  std::vector<Walkers> split(int most) const {
    std::vector<Walkers> parts;
    for (size_t i = 0; i < all.size(); i += size_t(most)) {
      const auto begin = all.begin() + int64_t(i),
                 end = all.begin() + int64_t(std::min(all.size(), i + size_t(most)));
      parts.push_back({partition, children, {begin, end}});
    }
    return parts;
  }
  static int wireBytes(uint32_t kind) { return kind == 0 ? 12 : kind == 1 ? 8 : 0; }
  void write(Bytes& out) const {
    Writer w;
    for (const Walker& walker : all) {
      w.write(walker.number);
      if (!children) w.write(walker.hops);
    }
    const Bytes written = w.take();
    out.insert(out.end(), written.begin(), written.end());
  }
};

/// What a packet of walkers gives: the ItemResult.
struct Walked {
  std::vector<Walkers> leaving;
  uint64_t retired = 0, created = 0;
  std::string error;
  std::vector<uint64_t> ended;  ///< the numbers of walkers at their end
};

/// What goes wrong on one rank.
enum class Failure : int32_t { None, Prepare, Spawn, Advance, Result, Read };

/// The parameters of a flight of walkers, the same on all ranks.
struct Walk {
  uint64_t salt = 1;                               ///< stands for the generation of data that the flight pins
  int32_t walkers = 5, chunk = 2, partitions = 7;  ///< walkers: made on each rank, at most so many in a chunk
  int32_t children = 1;                            ///< 0: they have none
  int32_t sends = 1;  ///< 1: half of the numbers at the end are sent to other ranks
  /// 1: they end only when the flight is cancelled; 2: nor do they leave the partition where they begin.
  int32_t endless = 0;
  uint32_t tenant = 0;
  Failure failure = Failure::None;
  int32_t failingRank = 0;
};

/// A Transport that tells what is sent.
class ToldTransport final : public Transport {
 public:
  using Tell = std::function<void(Channel)>;
  ToldTransport(Transport& to, Tell tell) : to_(to), tell_(std::move(tell)) {}
  int rank() const override { return to_.rank(); }
  int size() const override { return to_.size(); }
  void send(int destination, Channel channel, Bytes message) override {
    tell_(channel);
    to_.send(destination, channel, std::move(message));
  }
  void onMessage(Channel channel, Handler handler) override { to_.onMessage(channel, std::move(handler)); }
  void post(Task task) override { to_.post(std::move(task)); }
  void postWaiting(Task task) override { to_.postWaiting(std::move(task)); }
  std::shared_ptr<void> expectPost() override { return to_.expectPost(); }
  Counters counters() const override { return to_.counters(); }

 private:
  Transport& to_;
  const Tell tell_;
};

/// Flights of walkers on all ranks of a seeded world.
///
/// While an act runs, other messages and tasks go on, as they do with threads: the world takes steps within
/// the acts' functions. Some acts give their results later.
class Walks {
 public:
  /// Free numbers. The world delays those that are equal modulo 64 together, so they differ from Completion's.
  static constexpr Channel kControl = Channel(70), kItems = Channel(71), kCredits = Channel(72);

  struct Options {
    int ranks = 3;
    int64_t credits = 1 << 20;
    int packet = 3;  ///< most walkers that are advanced together
    int runners = 1024;
  };
  /// What was seen of a flight.
  struct Outcome {
    int complete = 0;
    FlightEnding ending;
    uint64_t sum = 0, count = 0;  ///< of the walkers that had ended when it was complete, on all ranks
    std::vector<int> ends;        ///< by rank: calls of FlightBase::end()
    int counted = 0;              ///< those that said that the flight counts
    int reports = 0;              ///< that rank 0 got
    uint64_t reported = 0;        ///< the sum of what they say
  };

  Walks(uint64_t seed, Options options)
      : options_(options), random_(seed * 31 + 7), ledgers_(size_t(options.ranks)) {
    InProcessWorld::Options world;
    world.onError = [this](int, const std::string& error) { errors_.push_back(error); };
    world_ = std::make_unique<InProcessWorld>(options.ranks, seed, std::move(world));
    for (int r = 0; r < options.ranks; r++) {
      transports_.push_back(std::make_unique<ToldTransport>(
          world_->rank(r), [this, r](Channel channel) { countSent(r, channel); }));
      items_.push_back(ledgers_[size_t(r)].enter("test", "items", 0));
      ranks_.push_back(std::make_unique<Flights<Walked>>(
          *transports_.back(), optionsOf(r),
          [this, r](FlightId id, Reader& in) { return make(id, r, in.read<Walk>()); },
          [this](FlightId id, Reader& in) {
            outcomes_[id].reports++;
            outcomes_[id].reported += in.read<uint64_t>();
            in.expectEnd();
          }));
      transports_.back()->onMessage(Channel::Test, [this, r](int, Bytes m) { receiveSum(r, std::move(m)); });
    }
  }

  ~Walks() {
    ending_ = true;
    while (late_ > 0 && step()) {  // Flights wait for their devices
    }
    for (auto& transport : transports_) transport->onMessage(Channel::Test, {});
    ranks_.clear();
    for (int i = 0; i < 300 && world_->step(); i++) {  // messages and tasks outlive them
    }
  }

  FlightId announce() { return ranks_[0]->announce(); }
  void begin(FlightId id, const Walk& walk) {
    ranks_[0]->begin(make(id, 0, walk), Writer().write(walk).take(), [this, id](const FlightEnding& ending) {
      Outcome& outcome = outcomes_[id];
      outcome.complete++;
      outcome.ending = ending;
      for (const auto& [rank, flight] : flights_[id]) {
        outcome.sum += flight->sum;
        outcome.count += flight->count;
      }
    });
  }
  FlightId start(const Walk& walk) {
    const FlightId id = announce();
    begin(id, walk);
    return id;
  }
  bool step() {
    for (auto& rank : ranks_) mostParked_ = std::max(mostParked_, rank->kept().parkedMessages);
    return world_->step();
  }
  /// Takes as many steps as it needs, at most `most`. Returns whether there is nothing left to do.
  bool run(int most = 300'000) {
    for (int i = 0; i < most; i++)
      if (!step()) return true;
    return false;
  }
  InProcessWorld& world() { return *world_; }
  Flights<Walked>& rank(int r) { return *ranks_[size_t(r)]; }
  const Outcome& outcome(FlightId id) {
    outcomes_[id].ends.resize(ranks_.size());
    return outcomes_[id];
  }
  const std::vector<std::string>& errors() const { return errors_; }
  uint64_t completionMessages() const { return completionMessages_; }
  /// How often a rank has answered a wave while tasks of flights waited there.
  uint64_t answersWhileTasksWaited() const { return answersWhileTasksWaited_; }
  /// The most bytes that a rank has had in its ledger for a purpose.
  int64_t mostBytes(const std::string& purpose) const {
    int64_t most = 0;
    for (const Ledger& ledger : ledgers_)
      for (const Ledger::Line& line : ledger.peaks())
        if (line.purpose == purpose) most = std::max(most, line.bytes);
    return most;
  }
  size_t mostParked() const { return mostParked_; }
  /// What is left over when nothing is under way; empty if there is nothing.
  std::string leftOver() const {
    std::string left;
    for (size_t r = 0; r < ranks_.size(); r++) {
      const FlightControl::Kept kept = ranks_[r]->kept();
      for (const auto& [what, number] : std::initializer_list<std::pair<const char*, int64_t>>{
               {"flights", int64_t(kept.flights)},
               {"parked messages", int64_t(kept.parkedMessages)},
               {"announced", int64_t(kept.announced)},
               {"completion sets", int64_t(kept.completionSets)},
               {"tasks", int64_t(kept.tasks)},
               {"credits", kept.credits},
               {"tenants with credits", int64_t(kept.tenantCredits.size())},
               {"bytes", ledgers_[r].total()}})
        if (number) left += "rank " + std::to_string(r) + ": " + std::to_string(number) + " " + what + "; ";
    }
    return left;
  }

  /// The sum of the numbers at the end of all walkers of a flight, and how many there are, as one rank finds
  /// them.
  static std::pair<uint64_t, uint64_t> expected(const Walk& walk, int ranks) {
    std::pair<uint64_t, uint64_t> total{0, 0};
    for (int r = 0; r < ranks; r++)
      for (int i = 0; i < walk.walkers; i++) add(walk, startOf(walk, r, i), total);
    return total;
  }

 private:
  struct At {
    Walker walker;
    int partition;
    bool child;
  };
  struct Hop {
    bool ends;
    At next;
    std::optional<At> child;
  };

  static uint64_t mix(uint64_t number) { return Random(number).next(); }
  static At startOf(const Walk& walk, int rank, int i) {
    const uint64_t number = mix(walk.salt ^ (uint64_t(rank) << 32 | uint64_t(i)));
    return {{number, 0}, int(mix(number) % uint64_t(walk.partitions)), false};
  }
  static Hop hop(const Walk& walk, const At& at) {
    const uint64_t number = mix(at.walker.number ^ mix(walk.salt + uint64_t(at.partition)));
    Hop hop{
        false, {{number, at.walker.hops + 1}, int(number / 64 % uint64_t(walk.partitions)), at.child}, {}};
    if (walk.endless == 2) hop.next.partition = at.partition;
    hop.ends = !walk.endless && (at.child ? number % 3 == 0 : number % 6 == 0 || hop.next.walker.hops == 12);
    if (walk.children && !at.child && number / 8 % 4 == 0)
      hop.child = At{{mix(number), 0}, int(number / 128 % uint64_t(walk.partitions)), true};
    return hop;
  }
  static void add(const Walk& walk, At at, std::pair<uint64_t, uint64_t>& total) {
    while (true) {
      const Hop h = hop(walk, at);
      if (h.child) add(walk, *h.child, total);
      if (h.ends) {
        total.first += h.next.walker.number;
        total.second++;
        return;
      }
      at = h.next;
    }
  }

  class WalkFlight final : public Flight<Walked> {
   public:
    WalkFlight(Walks& walks, FlightId id, int rank, const Walk& walk)
        : Flight(id, walks.options_.packet), walks_(walks), rank_(rank), walk_(walk) {}

    uint64_t sum = 0, count = 0;

    void prepare() override { failIf(Failure::Prepare); }
    Priority priority() const override { return {walk_.tenant, false, 0}; }
    size_t chunks() const override { return size_t((walk_.walkers - made_ + walk_.chunk - 1) / walk_.chunk); }
    int64_t cost() const override { return std::min(walk_.chunk, walk_.walkers - made_) * creditsOf(0); }
    int64_t creditsOf(uint32_t kind) const override { return kind == 0 && walk_.children ? 2 : 1; }
    LedgerEntry hold(int64_t bytes) const override { return walks_.items_[size_t(rank_)].another(bytes); }
    void end(bool counts) override {
      Outcome& outcome = walks_.outcomes_[id];
      outcome.ends.resize(size_t(walks_.options_.ranks));
      outcome.ends[size_t(rank_)]++;
      outcome.counted += counts;
      walks_.rank(rank_).report(id, Writer().write(sum).take());
    }
    int owner(int partition) const override {
      walks_.meanwhile();
      return partition % walks_.options_.ranks;
    }
    std::function<void(Done)> takeChunk() override {
      const int begin = made_;
      made_ = std::min(made_ + walk_.chunk, walk_.walkers);
      return [this, begin, end = made_](const Done& done) {
        failIf(Failure::Spawn);
        Walked result;
        for (int i = begin; i < end; i++) leave(result, startOf(walk_, rank_, i));
        answer(done, std::move(result));
      };
    }
    void advance(Walkers packet, Done done) override {
      failIf(Failure::Advance);
      if (int(packet.all.size()) > walks_.options_.packet) throw Error("the packet is too large");
      if (packet.partition % walks_.options_.ranks != rank_) throw Error("the partition is another rank's");
      Walked result;
      if (fails(Failure::Result)) {
        result.error = "the device is lost";
        result.retired = packet.all.size();
        return answer(done, std::move(result));
      }
      for (const Walker& walker : packet.all) {
        const Hop h = hop(walk_, {walker, packet.partition, packet.children});
        if (h.child) {
          leave(result, *h.child);
          result.created++;
        }
        if (h.ends) {
          result.ended.push_back(h.next.walker.number);
          result.retired++;
        } else {
          leave(result, h.next);
        }
      }
      answer(done, std::move(result));
    }
    // Half of the numbers are sent to other ranks.
    void deposit(Walked& result) override {
      walks_.meanwhile();
      for (const uint64_t number : result.ended) {
        if (walk_.sends && number / 4 % 2) {
          walks_.rank(rank_).created(id, 1);
          walks_.transports_[size_t(rank_)]->send(int(number % uint64_t(walks_.options_.ranks)),
                                                  Channel::Test, Writer().write(id).write(number).take());
        } else {
          take(number);
        }
      }
      walks_.meanwhile();
    }
    Walkers read(int partition, uint32_t kind, int n, std::span<const std::byte> bytes) const override {
      failIf(Failure::Read);
      if (partition < 0 || partition >= walk_.partitions || partition % walks_.options_.ranks != rank_)
        throw Error("partition " + std::to_string(partition) + " is not one of this rank");
      Reader in(bytes, "walkers");
      Walkers walkers{partition, kind == 1, std::vector<Walker>(size_t(n))};
      for (Walker& w : walkers.all) {
        w.number = in.read<uint64_t>();
        w.hops = kind == 1 ? 0 : in.read<uint32_t>();
      }
      in.expectEnd();
      return walkers;
    }
    void take(uint64_t number) {
      sum += number;
      count++;
    }

   private:
    bool fails(Failure failure) const { return walk_.failure == failure && walk_.failingRank == rank_; }
    void failIf(Failure failure) const {
      if (fails(failure)) throw Error("no room");
    }
    static void leave(Walked& result, const At& at) {
      for (Walkers& list : result.leaving)
        if (list.partition == at.partition && list.children == at.child) return list.all.push_back(at.walker);
      result.leaving.push_back({at.partition, at.child, {at.walker}});
    }
    void answer(const Done& done, Walked result) {
      if (walks_.ending_ || walks_.random_.below(3)) {
        done(std::move(result));
        return walks_.meanwhile();
      }
      walks_.late_++;
      walks_.world_->rank(rank_).post(
          [&walks = walks_, done, held = std::make_shared<Walked>(std::move(result))] {
            walks.late_--;
            done(std::move(*held));
          });
      walks_.meanwhile();
    }

    Walks& walks_;
    const int rank_;
    const Walk walk_;
    int made_ = 0;
  };

  FlightControl::Options optionsOf(int rank) {
    FlightControl::Options options;
    options.channels = {kControl, kItems, kCredits};
    options.words = {"walk", "walkers", "chunk"};
    options.tasks.queue.credits = options_.credits;
    options.tasks.most = options_.runners;
    // No clock decides whose turn it is, so a seed gives the same schedule everywhere.
    options.tasks.processorTime = [this] { return std::chrono::microseconds(++clock_); };
    options.ledger = &ledgers_[size_t(rank)];
    options.tenant = "test";
    return options;
  }
  std::shared_ptr<Flight<Walked>> make(FlightId id, int rank, const Walk& walk) {
    return flights_[id][rank] = std::make_shared<WalkFlight>(*this, id, rank, walk);
  }
  void receiveSum(int rank, Bytes message) {
    Reader in(message, "sum");
    const auto id = in.read<FlightId>();
    const auto number = in.read<uint64_t>();
    const auto flight = this->rank(rank).findOrPark(
        id, message, [this, rank](Bytes parked) { receiveSum(rank, std::move(parked)); });
    if (!flight) return;
    static_cast<WalkFlight&>(*flight).take(number);
    this->rank(rank).retired(id, 1);
  }
  // Ranks without ranks below them in the tree send nothing on this channel but answers.
  void countSent(int rank, Channel channel) {
    if (channel != Channel::Completion) return;
    completionMessages_++;
    if (2 * rank + 1 >= options_.ranks && rank > 0 && ranks_[size_t(rank)]->kept().tasks > 0)
      answersWhileTasksWaited_++;
  }
  /// What other threads do meanwhile.
  void meanwhile() {
    if (depth_ == 2 || random_.below(4)) return;
    depth_++;
    for (uint64_t steps = random_.below(6); steps > 0 && step(); steps--) {
    }
    depth_--;
  }

  const Options options_;
  Random random_;
  int depth_ = 0;  ///< steps within steps
  int64_t clock_ = 0;
  int late_ = 0;         ///< results to come
  bool ending_ = false;  ///< no more results come late
  std::vector<Ledger> ledgers_;
  std::vector<LedgerEntry> items_;
  std::vector<std::string> errors_;
  uint64_t completionMessages_ = 0, answersWhileTasksWaited_ = 0;
  size_t mostParked_ = 0;
  std::map<FlightId, Outcome> outcomes_;
  std::map<FlightId, std::map<int, std::shared_ptr<WalkFlight>>> flights_;
  std::unique_ptr<InProcessWorld> world_;
  std::vector<std::unique_ptr<ToldTransport>> transports_;
  std::vector<std::unique_ptr<Flights<Walked>>> ranks_;
};

}  // namespace gxy::test
