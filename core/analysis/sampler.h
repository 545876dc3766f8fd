// SPDX-License-Identifier: Apache-2.0
// Sampler: sends rays through data on all ranks, and collects what they record where they meet surfaces.
#pragma once
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/analysis/ray_source.h"
#include "core/comm/collectives.h"
#include "core/render/flights.h"
#include "core/render/scene_builder.h"

namespace gxy {

/// What is to be sampled. The surfaces are those that the visualization's operators show: isosurfaces, slices and geometry, within
/// their clip planes. Volumes are on the partitioning of the scene.
struct SamplingSource {
  SceneSource scene;
  std::vector<SampledField> fields;  ///< the first `recorded` are stored, the others are for conditions
  int recorded = 0;
  bool gradient = false;
  bool met = false;            ///< SampleList::met is stored
  std::vector<HitRule> rules;  ///< by operator
  Priority priority;           ///< whose turn the work is done in; the same on all ranks
  std::string account;         ///< the ledger's tenant for rays; empty: that of Sampler::Options
};

/// A sampling on one rank, ready for the rays of any number of flights, until one of them is cancelled or fails. Immutable, thread safe.
struct Sampling {
  BuiltScene scene;
  std::shared_ptr<const CompiledSampling> compiled;
  std::shared_ptr<const DeviceFrame> frame;
  EnterMemory enter;
  Priority priority;
  std::string account;
};

/// Carries out samplings together with the Samplers of all other ranks; each rank has one, over its Transport.
///
/// A sampling is a flight (Flights) whose items are rays. Each rank begins the rays of its source, against credits. Rays are traced
/// where they are, and forwarded where they go; a sample stays on the rank where its ray has met the surface. Which samples there
/// are, to the last bit, depends neither on the partitions, ranks or threads nor on the order of messages. Where they are does.
///
/// It runs as long tasks of the Transport, so that pictures do not wait for it.
///
/// Threads: any thread may call all functions.
class Sampler {
 public:
  struct Options {
    int packetRays = 4096;           ///< most rays that are traced together; >= 16
    int64_t raysInFlight = 1 << 18;  ///< credits of a rank
    int runners = 0;                 ///< most tasks at once; 0: as many as there are processors
    Ledger* ledger = nullptr;        ///< for rays and for messages that wait; may be null
    std::string tenant = "analysis";
    Trace* trace = nullptr;  ///< may be null; outlives the object
    /// Makes the backend that samples where the one in use cannot; it is made when it is needed. Empty: there is none.
    BackendRegistry::Maker other;
    std::function<std::chrono::nanoseconds()> processorTime = PacketSize::processorTime;
  };

  /// `transport` and `backend` must outlive the object.
  Sampler(Transport& transport, const Backend& backend, Options options);
  /// Waits for running tasks. Drops the rest of samplings that are under way.
  ~Sampler() = default;
  Sampler(const Sampler&) = delete;
  Sampler& operator=(const Sampler&) = delete;

  /// Collective. Builds what rays of a sampling meet, on Options::other if the backend of some rank cannot sample. `enter` is asked
  /// for room for it and, in steps of 1 MiB and by any thread, for samples as they are recorded. Throws the same Error on all ranks.
  std::shared_ptr<const Sampling> prepare(
      SamplingSource source, Collectives& ranks, const EnterMemory& enter,
      const SceneBuilder::OnItem& onItem = [](int64_t, int64_t, const std::string&) {});

  /// Collective; blocks, on each rank, until all rays of all ranks have ended. TakenSamples are in no order. Calls ranks.check() every 10 ms. If that throws on any rank, or
  /// a rank or its device fails, nothing is kept and all ranks throw the same Error: the first of any rank, as "rank 3: <reason>".
  TakenSamples sample(std::shared_ptr<const Sampling> sampling, std::shared_ptr<const RaySource> source,
                      Collectives& ranks);

  // The same in steps that do not wait. All ranks add() a flight that rank 0 has announced. Then rank 0 begins it. Each rank
  // takes its samples when the flight has ended there.
  FlightId announce() { return flights_.announce(); }
  void add(FlightId id, std::shared_ptr<const Sampling> sampling, std::shared_ptr<const RaySource> source);
  /// Rank 0 only.
  void begin(FlightId id, FlightControl::OnComplete onComplete);
  void cancel(FlightId id) { flights_.cancel(id); }
  TakenSamples take(FlightId id);

  FlightControl::Counters counters() const { return flights_.counters(); }
  FlightControl::Kept kept() const { return flights_.kept(); }
  /// Counters of all samplings so far.
  TraceCounters traced() const;

 private:
  struct Run;
  class Rays;
  using RunPtr = std::shared_ptr<Run>;

  std::shared_ptr<Sampling> build(SceneBuilder& builder, SamplingSource source, Collectives& ranks,
                                  const EnterMemory& enter, const SceneBuilder::OnItem& onItem) const;
  SceneBuilder& otherBuilder();
  void takeResult(Rays& flight, Run& run, TraceResult& result);
  RunPtr find(FlightId id) const;
  bool waitFor(Run& run, Collectives& ranks);

  Transport& transport_;
  const Options options_;
  const Backend& backend_;
  SceneBuilder builder_;

  mutable std::mutex mutex_;  ///< guards the members below, but for flights_
  std::map<FlightId, RunPtr> runs_;
  TraceCounters traced_;
  std::unique_ptr<Backend> other_;  ///< Options::other, once it was needed
  std::unique_ptr<SceneBuilder> otherBuilder_;

  Flights<TraceResult> flights_;  ///< the last member, as it calls this Sampler from its constructor on
};

}  // namespace gxy
