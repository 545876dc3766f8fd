// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/tracer.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/comm/wire.h"

namespace gxy {

namespace {

/// What a rank tells rank 0 of a trace.
enum class TraceReport : uint8_t { Ends, Stop };

FlightControl::Options flightsOf(const Tracer::Options& options) {
  if (options.packetHeads < 1 || options.packetHeads > 4096)
    throw Error("packets of " + std::to_string(options.packetHeads) +
                " heads of lines, expected numbers from 1 to 4096");
  if (options.heads < 1) throw Error("the number of heads of lines under way must be >= 1");
  FlightControl::Options flights;
  flights.channels = {Channel::Flight, Channel::Items, Channel::ItemCredits, Channel::ItemCompletion};
  flights.words = {"trace", "heads of lines", "seeds"};
  flights.tasks.queue.credits = options.heads;
  flights.tasks.most = options.runners;
  flights.tasks.longTasks = options.longTasks;
  flights.tasks.processorTime = options.processorTime;
  flights.ledger = options.ledger;
  flights.tenant = options.tenant;
  flights.trace = options.trace;
  return flights;
}

/// Throws Error for a request that cannot be.
void checkRequest(const TraceRequest& request) {
  if (!request.fields || !request.device) throw Error("trace: there are no fields, expected some");
  if (request.seeds.size() != request.lines.size())
    throw Error("trace: " + std::to_string(request.seeds.size()) + " seeds have " +
                std::to_string(request.lines.size()) + " numbers of lines, expected as many");
  checkOptions(request.options, *request.fields);
  for (const uint64_t line : request.lines)
    if (line > kLastLine)
      throw Error("trace: a line has the number " + std::to_string(line) + ", expected at most 2^40 - 1");
}

/// The text of an error that begins with its rank, as agree() would have it.
std::string toldBy(const std::string& error, int ranks) {
  const std::string only = "rank 0: ";
  return ranks == 1 && error.starts_with(only) ? error.substr(only.size()) : error;
}

}  // namespace

/// The act of a trace: its seeds become heads, which are advanced, and what they store is kept.
class Tracer::HeadFlight final : public Flight<AdvanceResult> {
 public:
  HeadFlight(Tracer& tracer, FlightId id, const Priority& priority, const std::string& account)
      : Flight(id, tracer.options_.packetHeads), tracer_(tracer), priority_(priority), account_(account) {}

  void prepare() override {
    share_ = tracer_.find(id);
    if (!share_) throw Error("this rank has not joined the trace");
    const Options& options = tracer_.options_;
    if (options.ledger)
      heads_ = options.ledger->enter(account_.empty() ? options.tenant : account_, "heads", 0);
    const int64_t most = std::min<int64_t>(options.packetHeads, std::max<int64_t>(1, options.heads / 16));
    chunk_ = size_t(std::max<int64_t>(1, most / request().directions()));
  }
  Priority priority() const override { return priority_; }
  size_t chunks() const override {
    return share_ ? (request().seeds.size() - next_ + chunk_ - 1) / chunk_ : 0;
  }
  int64_t cost() const override {
    return int64_t(std::min(chunk_, request().seeds.size() - next_)) * request().directions();
  }
  int64_t creditsOf(uint32_t) const override { return 1; }
  LedgerEntry hold(int64_t bytes) const override { return heads_.another(bytes); }
  void end(bool) override {
    if (share_) share_->end();
  }
  int owner(int partition) const override { return request().fields->partitioning().owner(partition); }

  std::function<void(Done)> takeChunk() override {
    const size_t begin = next_, count = std::min(chunk_, request().seeds.size() - begin);
    next_ += count;
    return [this, begin, count](const Done& done) {
      const TraceRequest& r = request();
      SeedHeads seeds = r.fields->seeds(std::span(r.seeds).subspan(begin, count),
                                        std::span(r.lines).subspan(begin, count), r.direction);
      AdvanceResult result;
      result.leaving = std::move(seeds.heads);
      result.ends = std::move(seeds.ends);
      done(std::move(result));
    };
  }
  void advance(HeadList packet, Done done) override {
    const int partition = packet.partition;
    request().device->advance(partition, std::move(packet), request().options, std::move(done));
  }
  void deposit(AdvanceResult& result) override {
    if (cancelled() || !result.error.empty()) return;
    try {
      share_->store(result);
    } catch (const std::exception& e) {  // no memory
      tracer_.flights_.fail(*this, textOf(e));
    }
  }
  HeadList read(int partition, uint32_t kind, int count, std::span<const std::byte> bytes) const override {
    const Reader in(bytes, "heads of lines");
    const LineFields& fields = *request().fields;
    if (partition < 0 || partition >= fields.partitioning().partitions() ||
        owner(partition) != tracer_.transport_.rank())
      in.fail("partition " + std::to_string(partition) + " is not one whose field this rank has");
    if (kind != fields.headKind()) in.fail("the heads are of another kind than the field's");
    HeadList heads = HeadList::read(partition, bytes, count, kind);
    if (const char* wrong = fields.wrongHeads(heads)) in.fail(wrong);
    return heads;
  }

 private:
  const TraceRequest& request() const { return share_->request; }

  Tracer& tracer_;
  const Priority priority_;
  const std::string account_;
  std::shared_ptr<TraceShare> share_;  ///< null: prepare() has failed
  LedgerEntry heads_;
  size_t chunk_ = 1, next_ = 0;  ///< seeds in a chunk, and the first seed that no chunk has had
};

Tracer::Tracer(Transport& transport, Options options)
    : transport_(transport),
      options_(std::move(options)),
      flights_(
          transport, flightsOf(options_), [this](FlightId id, Reader& in) { return readFlight(id, in); },
          [this](FlightId id, Reader& in) { receiveReport(id, in); }) {}

Tracer::~Tracer() = default;

std::shared_ptr<TraceShare> Tracer::find(FlightId id) const {
  const std::lock_guard lock(mutex_);
  const auto found = joined_.find(id);
  return found == joined_.end() ? nullptr : found->second.share;
}

void Tracer::join(FlightId id, std::shared_ptr<TraceShare> share) {
  const std::lock_guard lock(mutex_);
  joined_[id] = {std::move(share), {}, {}};
}

void Tracer::leave(FlightId id) {
  const std::lock_guard lock(mutex_);
  joined_.erase(id);
}

void Tracer::begin(FlightId id, std::function<void(const FlightEnding&)> onComplete) {
  Priority priority;
  std::string account;
  if (const auto share = find(id)) {
    priority = share->request.priority;
    account = share->request.account;
  }
  Writer parameters;
  parameters.write(priority.tenant).write(priority.interactive).write(priority.stream).write(account);
  flights_.begin(
      std::make_shared<HeadFlight>(*this, id, priority, account), parameters.take(),
      [this, id, onComplete = std::move(onComplete)](const FlightEnding& e) { onComplete(endingOf(id, e)); });
}

Tracer::FlightPtr Tracer::readFlight(FlightId id, Reader& in) {
  Priority priority;
  priority.tenant = in.read<uint32_t>();
  priority.interactive = in.read<bool>();
  priority.stream = in.read<uint64_t>();
  const std::string account = in.readString();
  return std::make_shared<HeadFlight>(*this, id, priority, account);
}

// ----------------------------------------------------------------------------------------------------------
// what ranks tell rank 0

void Tracer::stop(FlightId id, const std::string& why) {
  const std::string told = "rank " + std::to_string(transport_.rank()) + ": " + why;
  if (transport_.rank() == 0) return stopped(id, told);
  flights_.report(id, Writer().write(TraceReport::Stop).write(told).take());
}

void Tracer::tellEnds(FlightId id, uint64_t ends) {
  flights_.report(id, Writer().write(TraceReport::Ends).write(int32_t(transport_.rank())).write(ends).take());
}

uint64_t Tracer::endsElsewhere(FlightId id) const {
  const std::lock_guard lock(mutex_);
  uint64_t sum = 0;
  if (const auto found = joined_.find(id); found != joined_.end())
    for (const auto& [rank, ends] : found->second.ends) sum += ends;
  return sum;
}

void Tracer::receiveReport(FlightId id, Reader& in) {
  const auto kind = in.read<TraceReport>();
  if (kind == TraceReport::Stop) {
    const std::string why = in.readString();
    in.expectEnd();
    return stopped(id, why);
  }
  const auto rank = in.read<int32_t>();
  const auto ends = in.read<uint64_t>();
  in.expectEnd();
  if (kind != TraceReport::Ends || rank < 1 || rank >= transport_.size())
    in.fail("it is not what a rank tells of a trace");
  const std::lock_guard lock(mutex_);
  if (const auto found = joined_.find(id); found != joined_.end()) {
    uint64_t& known = found->second.ends[rank];
    known = std::max(known, ends);  // messages overtake each other
  }
}

// Rank 0.
void Tracer::stopped(FlightId id, const std::string& why) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = joined_.find(id);
    if (found == joined_.end()) return;
    if (found->second.stopped.empty()) found->second.stopped = why;
  }
  flights_.cancel(id);
}

FlightEnding Tracer::endingOf(FlightId id, FlightEnding ending) const {
  const std::lock_guard lock(mutex_);
  const auto found = joined_.find(id);
  if (ending.cancelled && ending.error.empty())
    ending.error =
        found == joined_.end() || found->second.stopped.empty() ? "cancelled" : found->second.stopped;
  return ending;
}

// ----------------------------------------------------------------------------------------------------------

Tracer::Kept Tracer::kept() const {
  Kept kept;
  kept.flights = flights_.kept();
  const std::lock_guard lock(mutex_);
  kept.shares = joined_.size();
  return kept;
}

namespace {

/// Waits until a trace has ended on this rank. Meanwhile it asks whether the trace is still wanted, and says
/// how far it is.
void waitForTrace(Tracer& tracer, FlightId id, TraceShare& share, uint64_t heads, Collectives& ranks) {
  constexpr std::chrono::milliseconds kAsk{20};
  bool stopped = false;
  uint64_t told = 0;
  while (!share.waitForEnd(kAsk)) {
    const uint64_t ends = share.ends();
    if (ranks.rank() > 0 && ends != told) tracer.tellEnds(id, told = ends);
    if (stopped) continue;
    try {
      ranks.check();
      const uint64_t all = ends + (ranks.rank() == 0 ? tracer.endsElsewhere(id) : 0);
      ranks.done(double(all) / double(std::max<uint64_t>(heads, 1)));
    } catch (const std::exception& e) {
      stopped = true;
      tracer.stop(id, textOf(e));
    }
  }
}

Bytes bytesOf(const std::string& text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

std::string textIn(const Bytes& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

}  // namespace

TracedLines Tracer::trace(TraceRequest request, Collectives& ranks) {
  std::shared_ptr<TraceShare> share;
  agree(ranks, [&] {
    checkRequest(request);
    share = std::make_shared<TraceShare>(std::move(request));
    ranks.check();
  });
  const uint64_t heads = sumOfCounts(ranks, share->request.heads());
  const FlightId id = gatherCounts(ranks, ranks.rank() == 0 ? announce() : 0).at(0);
  join(id, share);
  ranks.allGather({});  // nobody begins before all have joined
  std::string error;    // rank 0
  if (ranks.rank() == 0) begin(id, [&error](const FlightEnding& ending) { error = ending.error; });
  waitForTrace(*this, id, *share, heads, ranks);
  leave(id);
  TracedLines lines = share->take();
  error = textIn(ranks.allGather(bytesOf(error)).at(0));
  if (!error.empty()) throw Error(toldBy(error, ranks.size()));
  ranks.done(1);
  return lines;
}

}  // namespace gxy
