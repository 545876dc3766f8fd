// SPDX-License-Identifier: Apache-2.0
// Traces on all ranks of a seeded world.
#pragma once
#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/in_process.h"
#include "core/comm/random.h"
#include "tests/analysis/rank_flows.h"

namespace gxy::test {

/// What goes wrong on one rank.
enum class TraceFailure { None, Memory, Throws, Result };

/// Traces of one flow, whose device gives some answers later, and some of whose ranks fail.
class Traces {
 public:
  struct Options {
    int64_t heads = 1 << 18;
    int packet = 4;
    int runners = 1024;
    TraceFailure failure = TraceFailure::None;
    int failingRank = 0;
  };
  /// What is known of a trace.
  struct Outcome {
    int complete = 0;
    FlightEnding ending;
    std::vector<std::shared_ptr<TraceShare>> shares;  ///< by rank
  };

  Traces(uint64_t seed, const std::vector<RankFlow>& flow, const Options& options)
      : options_(options), random_(seed * 31 + 7), flow_(flow), ledgers_(flow.size()) {
    InProcessWorld::Options world;
    world.onError = [this](int, const std::string& error) { errors_.push_back(error); };
    world_ = std::make_unique<InProcessWorld>(int(flow.size()), seed, std::move(world));
    for (size_t r = 0; r < flow.size(); r++)
      tracers_.push_back(std::make_unique<Tracer>(world_->rank(int(r)), optionsOf(r)));
  }
  ~Traces() {
    ending_ = true;
    while (late_ > 0 && world_->step()) {  // Tracers wait for their devices
    }
    tracers_.clear();
    for (int i = 0; i < 300 && world_->step(); i++) {  // messages and tasks outlive them
    }
  }

  FlightId announce() { return tracers_[0]->announce(); }
  void begin(FlightId id, const std::vector<glm::dvec3>& seeds, const TraceOptions& options,
             TraceDirection direction, uint32_t tenant = 0) {
    Outcome& outcome = outcomes_[id];
    for (size_t r = 0; r < flow_.size(); r++) {
      TraceRequest request = requestOf(flow_[r], int(r), int(flow_.size()), seeds, options, direction);
      request.device = std::make_shared<Disturbed>(*this, int(r), tenant == 0);
      request.priority.tenant = tenant;
      request.takeMemory = [this, r, tenant](int64_t bytes) {
        if (tenant == 0 && fails(TraceFailure::Memory, int(r))) throw Error("no room");
        return ledgers_[r].enter("test", "lines", bytes);
      };
      outcome.shares.push_back(std::make_shared<TraceShare>(std::move(request)));
      tracers_[r]->join(id, outcome.shares.back());
    }
    tracers_[0]->begin(id, [&outcome](const FlightEnding& ending) {
      outcome.complete++;
      outcome.ending = ending;
    });
  }
  bool step() { return world_->step(); }
  /// Takes as many steps as it needs, at most `most`. Returns whether there is nothing left to do.
  bool run(int most = 300'000) {
    for (int i = 0; i < most; i++)
      if (!step()) return true;
    return false;
  }
  Tracer& tracer(int r) { return *tracers_[size_t(r)]; }
  const Outcome& outcome(FlightId id) { return outcomes_.at(id); }
  const std::vector<std::string>& errors() const { return errors_; }
  /// Leaves a trace on all ranks, and returns what they have stored.
  Lines take(FlightId id) {
    std::vector<TracedLines> ranks;
    for (size_t r = 0; r < tracers_.size(); r++) {
      tracers_[r]->leave(id);
      ranks.push_back(outcomes_.at(id).shares[r]->take());
    }
    outcomes_.at(id).shares.clear();
    return joined(std::move(ranks));
  }
  /// Whether all ranks have ended a trace.
  bool endedEverywhere(FlightId id) {
    return std::ranges::all_of(outcomes_.at(id).shares,
                               [](const auto& s) { return s->waitForEnd(std::chrono::milliseconds(0)); });
  }
  uint64_t forwarded() const {
    uint64_t heads = 0;
    for (const auto& tracer : tracers_) heads += tracer->counters().itemsForwarded;
    return heads;
  }
  /// What is left over when nothing is under way; empty if there is nothing.
  std::string leftOver() const {
    std::string left;
    for (size_t r = 0; r < tracers_.size(); r++) {
      const Tracer::Kept kept = tracers_[r]->kept();
      for (const auto& [what, number] : std::initializer_list<std::pair<const char*, int64_t>>{
               {"flights", int64_t(kept.flights.flights)},
               {"parked messages", int64_t(kept.flights.parkedMessages)},
               {"announced", int64_t(kept.flights.announced)},
               {"completion sets", int64_t(kept.flights.completionSets)},
               {"tasks", int64_t(kept.flights.tasks)},
               {"credits", kept.flights.credits},
               {"tenants with credits", int64_t(kept.flights.tenantCredits.size())},
               {"shares", int64_t(kept.shares)},
               {"bytes", ledgers_[r].total()}})
        if (number) left += "rank " + std::to_string(r) + ": " + std::to_string(number) + " " + what + "; ";
    }
    return left;
  }

 private:
  bool fails(TraceFailure failure, int rank) const {
    return options_.failure == failure && options_.failingRank == rank;
  }

  /// A device that answers late at times.
  class Disturbed final : public DeviceFields {
   public:
    Disturbed(Traces& traces, int rank, bool mayFail) : traces_(traces), rank_(rank), mayFail_(mayFail) {}
    void advance(int partition, HeadList heads, const TraceOptions& options, Done done) const override {
      if (heads.size() > traces_.options_.packet) throw Error("the packet is too large");
      if (mayFail_ && traces_.fails(TraceFailure::Throws, rank_)) throw Error("no room");
      if (mayFail_ && traces_.fails(TraceFailure::Result, rank_)) {
        AdvanceResult lost;
        lost.error = "the device is lost";
        lost.retired = uint64_t(heads.size());
        return done(std::move(lost));
      }
      if (traces_.ending_ || traces_.random_.below(3))
        return traces_.flow_[size_t(rank_)].device->advance(partition, std::move(heads), options, done);
      traces_.late_++;
      const auto held = std::make_shared<HeadList>(std::move(heads));
      traces_.world_->rank(rank_).post([&traces = traces_, rank = rank_, partition, held, options, done] {
        traces.late_--;
        traces.flow_[size_t(rank)].device->advance(partition, std::move(*held), options, done);
      });
    }
    size_t bytes() const override { return 0; }

   private:
    Traces& traces_;
    const int rank_;
    const bool mayFail_;
  };

  Tracer::Options optionsOf(size_t rank) {
    Tracer::Options options;
    options.heads = options_.heads;
    options.packetHeads = options_.packet;
    options.runners = options_.runners;
    options.longTasks = false;
    options.ledger = &ledgers_[rank];
    options.tenant = "test";
    // No clock decides whose turn it is, so a seed gives the same schedule everywhere.
    options.processorTime = [this] { return std::chrono::microseconds(++clock_); };
    return options;
  }

  const Options options_;
  Random random_;
  int64_t clock_ = 0;
  int late_ = 0;         ///< answers to come
  bool ending_ = false;  ///< no more answers come late
  const std::vector<RankFlow>& flow_;
  std::vector<Ledger> ledgers_;
  std::vector<std::string> errors_;
  std::map<FlightId, Outcome> outcomes_;
  std::unique_ptr<InProcessWorld> world_;
  std::vector<std::unique_ptr<Tracer>> tracers_;
};

}  // namespace gxy::test
