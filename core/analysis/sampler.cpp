// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <optional>
#include <thread>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/comm/wire.h"

namespace gxy {

namespace {

constexpr std::chrono::milliseconds kLook{10};  // how often a waiting rank looks whether it is cancelled

FlightControl::Options flightsOf(const Sampler::Options& options) {
  FlightControl::Options flights;
  flights.channels = {Channel::SampleFlight, Channel::SampleRays, Channel::SampleCredits,
                      Channel::SampleCompletion};
  flights.words = {"sampling", "sampling rays", "rays"};
  flights.tasks.queue = {options.raysInFlight, std::chrono::seconds(1)};
  flights.tasks.most =
      options.runners > 0 ? options.runners : std::max(1, int(std::thread::hardware_concurrency()));
  flights.tasks.longTasks = true;
  flights.tasks.processorTime = options.processorTime;
  flights.ledger = options.ledger;
  flights.tenant = options.tenant;
  flights.trace = options.trace;
  return flights;
}

// What is wrong with rays that have arrived; null if nothing is.
const char* wrongAmong(const RayList& rays, const CompiledScene& scene) {
  double reach = 1;
  for (int k = 0; k < 3; k++) reach = std::max({reach, std::abs(scene.lo[k]), std::abs(scene.hi[k])});
  const RayView& r = rays.view();
  for (int i = 0; i < rays.size(); i++) {
    if (RAY_KIND(r.info[i]) != RAY_SAMPLE) return "a ray is of another kind than the message";
    for (float x : {r.ox[i], r.oy[i], r.oz[i]})
      if (!(std::abs(x) <= float(2 * reach))) return "a ray starts outside the visible domain";
    const float length2 = r.dx[i] * r.dx[i] + r.dy[i] * r.dy[i] + r.dz[i] * r.dz[i];
    if (!(std::abs(length2 - 1) < 1e-3f)) return "a ray's direction is not of unit length";
    if (!(r.tLast[i] >= -1 && std::isfinite(r.tLast[i]))) return "a ray's last surface is not on the ray";
    if (!(r.tMax[i] >= 0)) return "a ray ends before it begins";
    if (r.A[i] != 0 || r.sg[i] < 0) return "a ray is not one of a sampling";
  }
  return nullptr;
}

}  // namespace

/// A sampling that is under way on this rank, or whose samples have not been taken.
struct Sampler::Run {
  std::shared_ptr<const Sampling> sampling;
  std::shared_ptr<const RaySource> source;

  std::mutex mutex;  ///< guards the members below
  std::condition_variable changed;
  TakenSamples samples;
  FlightBase* flight = nullptr;  ///< while it is under way here
  size_t chunksDone = 0;
  bool ended = false, counts = false;
};

/// The flight: its items are rays, and its act is to trace them and to record samples.
class Sampler::Rays final : public Flight<TraceResult> {
 public:
  Rays(Sampler& sampler, FlightId id) : Flight(id, sampler.options_.packetRays), sampler_(sampler) {}

  void prepare() override {
    run_ = sampler_.find(id);
    if (!run_) throw Error("there is no sampling " + std::to_string(id));
    const Options& options = sampler_.options_;
    const std::string& account = run_->sampling->account;
    if (options.ledger)
      rays_ = options.ledger->enter(account.empty() ? options.tenant : account, "sampling rays", 0);
    const std::lock_guard lock(run_->mutex);
    run_->flight = this;
  }
  Priority priority() const override { return run_ ? run_->sampling->priority : Priority(); }
  size_t chunks() const override { return run_ ? run_->source->chunks() - next_ : 0; }
  int64_t cost() const override { return run_->source->raysOf(next_); }
  int64_t creditsOf(uint32_t) const override { return 1; }
  LedgerEntry hold(int64_t bytes) const override { return rays_.another(bytes); }
  void onCancel() override {
    if (run_) run_->sampling->frame->cancel();
  }
  void end(bool counts) override {
    if (!run_) return;
    const std::lock_guard lock(run_->mutex);
    run_->flight = nullptr;
    run_->ended = true;
    run_->counts = counts;
    run_->changed.notify_all();
  }
  int owner(int partition) const override { return scene().partitioning->owner(partition); }
  std::function<void(Done)> takeChunk() override {
    return [run = run_, chunk = next_++](Done done) {
      const Sampling& s = *run->sampling;
      s.scene.device->spawnRays(*s.frame, run->source->rays(chunk, s.scene.compiled->space), std::move(done));
      const std::lock_guard lock(run->mutex);
      run->chunksDone++;
    };
  }
  void advance(LeavingRays packet, Done done) override {
    const Sampling& s = *run_->sampling;
    s.scene.device->trace(*s.frame, packet.partition, false, std::move(packet.rays), std::move(done));
  }
  void deposit(TraceResult& result) override { sampler_.takeResult(*this, *run_, result); }
  LeavingRays read(int partition, uint32_t kind, int count, std::span<const std::byte> bytes) const override {
    const Reader in(bytes, "sampling rays");
    if (kind != 0) in.fail("they are primaries, expected sampling rays");
    if (partition < 0 || partition >= scene().partitioning->partitions() ||
        owner(partition) != sampler_.transport_.rank() || !scene().visible[size_t(partition)])
      in.fail("partition " + std::to_string(partition) + " is not one that this rank shows");
    RayList rays = RayList::read(bytes, count, false);
    if (const char* wrong = wrongAmong(rays, scene())) in.fail(wrong);
    return {partition, false, std::move(rays)};
  }

 private:
  const CompiledScene& scene() const { return *run_->sampling->scene.compiled; }

  Sampler& sampler_;
  RunPtr run_;
  LedgerEntry rays_;
  size_t next_ = 0;  ///< the chunk that is begun next
};

Sampler::Sampler(Transport& transport, const Backend& backend, Options options)
    : transport_(transport),
      options_(std::move(options)),
      backend_(backend),
      builder_(backend, transport.rank()),
      flights_(
          transport, flightsOf(options_),
          [this](FlightId id, Reader&) { return std::make_shared<Rays>(*this, id); },
          [](FlightId, Reader& in) { in.fail("samplings send no reports"); }) {
  if (options_.packetRays < 16)
    throw Error("packets of " + std::to_string(options_.packetRays) + " rays, expected >= 16");
  if (options_.raysInFlight < 1) throw Error("the number of rays in flight must be >= 1");
}

std::shared_ptr<const Sampling> Sampler::prepare(SamplingSource source, Collectives& ranks,
                                                 const EnterMemory& enter,
                                                 const SceneBuilder::OnItem& onItem) {
  source.scene.visualization = forSampling(std::move(source.scene.visualization));
  source.scene.sampled = true;
  const auto samplesEverywhere = [&ranks](const Sampling& made) {
    const auto all = gatherValues<uint8_t>(ranks, std::array{uint8_t(made.frame != nullptr)});
    return std::all_of(all.begin(), all.end(), [](const auto& one) { return one[0] != 0; });
  };
  std::shared_ptr<Sampling> sampling = build(builder_, source, ranks, enter, onItem);
  if (samplesEverywhere(*sampling)) return sampling;
  sampling.reset();
  SceneBuilder* other = nullptr;
  agree(ranks, [&] { other = &otherBuilder(); });
  sampling = build(*other, std::move(source), ranks, enter, onItem);
  if (!samplesEverywhere(*sampling)) throw Error("no backend of this program can sample");
  return sampling;
}

std::shared_ptr<Sampling> Sampler::build(SceneBuilder& builder, SamplingSource source, Collectives& ranks,
                                         const EnterMemory& enter, const SceneBuilder::OnItem& onItem) const {
  auto sampling = std::make_shared<Sampling>();
  sampling->priority = source.priority;
  sampling->account = source.account;
  sampling->enter = enter;
  sampling->scene = builder.build(std::move(source.scene), ranks, enter, onItem);
  agree(ranks, [&] {
    sampling->compiled = compileSampling(sampling->scene.compiled, std::move(source.fields), source.recorded,
                                         std::move(source.rules), source.gradient, source.met);
    sampling->frame = sampling->scene.device->makeSampling(sampling->compiled, enter);
  });
  return sampling;
}

SceneBuilder& Sampler::otherBuilder() {
  const std::lock_guard lock(mutex_);
  if (!otherBuilder_) {
    if (!options_.other)
      throw Error("backend " + backend_.name() + " cannot sample, and there is no other to do it");
    other_ = options_.other(options_.ledger);
    otherBuilder_ = std::make_unique<SceneBuilder>(*other_, transport_.rank());
  }
  return *otherBuilder_;
}

TakenSamples Sampler::sample(std::shared_ptr<const Sampling> sampling,
                             std::shared_ptr<const RaySource> source, Collectives& ranks) {
  const bool first = transport_.rank() == 0;
  const FlightId id = gatherValues<FlightId>(ranks, std::array{first ? announce() : FlightId(0)})[0][0];
  add(id, std::move(sampling), std::move(source));
  const RunPtr run = find(id);
  ranks.allGather({});  // all have added it
  std::string error;    // of rank 0
  if (first) begin(id, [&error](const FlightEnding& ending) { error = ending.error; });
  const bool counts = waitFor(*run, ranks);
  TakenSamples samples = take(id);
  const std::vector<Bytes> all = ranks.allGather(Writer().write(error).take());
  if (counts) return samples;
  Reader in(all[0], "the end of a sampling");
  const std::string why = in.readString();
  throw Error(why.empty() ? "the sampling was cancelled" : why);
}

// Returns when all rays of all ranks have ended: whether the samples are whole.
bool Sampler::waitFor(Run& run, Collectives& ranks) {
  std::unique_lock lock(run.mutex);
  while (!run.changed.wait_for(lock, kLook, [&] { return run.ended; })) {
    const double done = double(run.chunksDone) / double(std::max<size_t>(1, run.source->chunks()));
    lock.unlock();
    std::string stopped;
    try {
      ranks.check();
      ranks.done(done);
    } catch (const std::exception& e) {
      stopped = textOf(e);
    }
    lock.lock();
    // The flight does not end here while the lock is held.
    if (!stopped.empty() && run.flight && !run.flight->cancelled()) flights_.fail(*run.flight, stopped);
  }
  return run.counts;
}

void Sampler::add(FlightId id, std::shared_ptr<const Sampling> sampling,
                  std::shared_ptr<const RaySource> source) {
  auto run = std::make_shared<Run>();
  run->sampling = std::move(sampling);
  run->source = std::move(source);
  const std::lock_guard lock(mutex_);
  runs_[id] = std::move(run);
}

void Sampler::begin(FlightId id, FlightControl::OnComplete onComplete) {
  flights_.begin(std::make_shared<Rays>(*this, id), {}, std::move(onComplete));
}

TakenSamples Sampler::take(FlightId id) {
  RunPtr run;
  {
    const std::lock_guard lock(mutex_);
    const auto it = runs_.find(id);
    if (it == runs_.end()) throw Error("there is no sampling " + std::to_string(id));
    run = std::move(it->second);
    runs_.erase(it);
  }
  const std::lock_guard lock(run->mutex);
  return run->counts ? std::move(run->samples) : TakenSamples();
}

Sampler::RunPtr Sampler::find(FlightId id) const {
  const std::lock_guard lock(mutex_);
  const auto it = runs_.find(id);
  return it == runs_.end() ? nullptr : it->second;
}

void Sampler::takeResult(Rays& flight, Run& run, TraceResult& result) {
  {
    const std::lock_guard lock(mutex_);
    traced_ += result.counters;
  }
  if (flight.cancelled()) return;
  std::string refused;
  {
    const std::lock_guard lock(run.mutex);
    run.samples.append(std::move(result.samples));
    if (!run.samples.enter(run.sampling->enter, true)) refused = run.samples.refused;
  }
  if (!refused.empty()) flights_.fail(flight, refused);
}

TraceCounters Sampler::traced() const {
  const std::lock_guard lock(mutex_);
  return traced_;
}

}  // namespace gxy
