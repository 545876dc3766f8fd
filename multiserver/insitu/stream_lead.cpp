// SPDX-License-Identifier: Apache-2.0
#include "multiserver/insitu/stream_lead.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/comm/error.h"
#include "core/io/automatic_partitioning.h"
#include "core/scene/json_text.h"
#include "multiserver/server/datasets.h"

namespace gxy {

using insitu::Control;
using insitu::Description;
using nlohmann::json;
using protocol::MessageChannel;

namespace {

constexpr std::chrono::milliseconds kLook(100);   // between looks whether somebody wants a step
constexpr std::chrono::seconds kUnasked(10);      // between steps that nobody wants
constexpr std::chrono::seconds kAfterFailure(1);  // between steps that cannot be published
constexpr std::chrono::seconds kAppointed(5);    // until an appointment that no rank has come to is made anew
constexpr std::chrono::seconds kGathering(60);   // between the ranks of a simulation that say what they have
constexpr std::chrono::seconds kConnecting(12);  // for a rank that has joined, and tries it for 10 s
constexpr std::chrono::seconds kStepPatience(60);  // from the first rank that has taken a step to its end

protocol::WireMessage controlMessage(const Control& control) {
  return {MessageChannel::DataControl, 0, written(control)};
}

}  // namespace

StreamLead::StreamLead(ServerRank& serverRank, std::shared_ptr<StreamPart> part, StreamWishes wishes,
                       std::function<void()> onEnd)
    : serverRank_(serverRank),
      part_(std::move(part)),
      wishes_(std::move(wishes)),
      onEnd_(std::move(onEnd)),
      descriptions_(size_t(part_->identity().ranks)),
      thread_([this] { run(); }) {}

StreamLead::~StreamLead() {
  end("the server stops");
  join();
}

void StreamLead::join() {
  const std::lock_guard lock(joining_);
  if (thread_.joinable()) thread_.join();
}

void StreamLead::end(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  if (!end_) end_ = reason;
  changed_.notify_all();
}

bool StreamLead::ending() const {
  const std::lock_guard lock(mutex_);
  return end_.has_value();
}

void StreamLead::closed(int rank) {
  const std::lock_guard lock(mutex_);
  if (!end_) end_ = insitu::kClosedBy + std::to_string(rank) + " of the simulation";
  changed_.notify_all();
}

void StreamLead::complete(int owner, uint64_t count) {
  const std::lock_guard lock(mutex_);
  if (!conductor_) return;
  conductor_->complete(owner, count);
  if (conductor_->isComplete()) changed_.notify_all();
}

void StreamLead::take(int rank, const protocol::WireMessage& message) {
  if (message.channel == MessageChannel::Describe)
    return describe(rank, insitu::readDescription(message.payload));
  const bool isStep = message.channel == MessageChannel::Step;
  const insitu::StepHeader step = isStep ? insitu::readStep(message.payload) : insitu::StepHeader{};
  const Control control = isStep ? Control{} : insitu::readControl(message.payload);
  const std::lock_guard lock(mutex_);
  if (!conductor_) throw Error("a message about steps before there is a plan, expected it after that");
  if (isStep)
    conductor_->receive(rank, step);
  else
    tell(conductor_->receive(rank, control));
  if (conductor_->isComplete() || (!isStep && control.kind == Control::Kind::Waits)) changed_.notify_all();
}

void StreamLead::describe(int rank, Description description) {
  const std::lock_guard lock(mutex_);
  const bool all = described_ == size_t(identity().ranks);  // Then the lead's thread uses them.
  if (all || descriptions_.at(size_t(rank))) throw Error("a second description, expected one");
  if (mesh_ && !(*mesh_ == description.mesh))
    throw Error(
        "rank " + std::to_string(rank) +
        " has another grid or other fields than a rank before, expected the same size, origin, spacing, "
        "names, types and components");
  blocks_ += description.blocks.size();
  if (blocks_ > insitu::kMostBlocks)
    throw Error("the ranks have more than 2^20 blocks together, expected at most as many");
  mesh_ = std::move(description.mesh);
  descriptions_[size_t(rank)] = std::move(description.blocks);
  if (++described_ == descriptions_.size()) changed_.notify_all();
}

void StreamLead::tell(const std::vector<Control>& messages) {
  for (const Control& m : messages)
    for (int r = 0; r < identity().ranks; r++) part_->send(r, controlMessage(m));
}

void StreamLead::run() {
  try {
    awaitDescriptions();
    plan();
    publishSteps();
  } catch (const Ended&) {
  } catch (const std::exception& e) {
    end(e.what());
  }
  finish();
}

void StreamLead::awaitDescriptions() {
  std::unique_lock lock(mutex_);
  const auto complete = [&] { return end_ || described_ == size_t(identity().ranks); };
  size_t before = 0;
  auto last = Clock::now();  // that a rank said what it has
  while (!changed_.wait_until(lock, Clock::now() + kConnecting, complete)) {
    if (described_ != std::exchange(before, described_)) last = Clock::now();
    if (described_ > 0 && Clock::now() > last + kGathering)
      throw Error("only " + std::to_string(described_) + " of " + std::to_string(identity().ranks) +
                  " ranks of the simulation have published a step within a minute");
    lock.unlock();
    if (part_->connections() == 0) throw Error("no rank of the simulation is connected");
    lock.lock();
  }
  if (end_) throw Ended();
}

std::shared_ptr<const Partitioning> StreamLead::partitioning(const Grid& grid) const {
  if (!wishes_.partition.is_object())
    return automaticPartitioning(grid.box(), &grid, {}, serverRank_.ranks());
  const auto name = wishes_.partition.at("like").get<std::string>();
  auto like = serverRank_.datasets->getPinned(identity().tenant, name).second.get<Dataset>()->partitioning;
  const Box data = grid.box(), domain = like->domain();
  for (int a = 0; a < 3; a++)
    if (data.lo[a] < domain.lo[a] || data.hi[a] > domain.hi[a])
      throw Error("partition: the grid reaches beyond the domain of " + inQuotes(name) +
                  ", whose partitioning it was to share");
  return like;
}

// Refuses what cannot be kept before anything is made of it.
void StreamLead::checkRoom(const insitu::Mesh& mesh) const {
  const int64_t points = mesh.grid.points[0] * mesh.grid.points[1] * mesh.grid.points[2];
  int64_t bytes = 0;
  for (const insitu::Field& field : mesh.fields) bytes += points * int64_t(field.bytesPerPoint());
  const int64_t room = std::min(serverRank_.options.tenantMemory, serverRank_.options.memory);
  if (bytes / serverRank_.ranks() > room)
    throw Error("memory: a step has " + std::to_string(bytes) + " bytes, but " +
                std::to_string(serverRank_.ranks()) + " rank(s) with room for " + std::to_string(room) +
                " bytes of a tenant each cannot keep it");
}

void StreamLead::plan() {
  StreamPlan plan;
  plan.mesh = *mesh_;
  for (size_t r = 0; r < descriptions_.size(); r++)
    for (size_t b = 0; b < descriptions_[r]->size(); b++)
      plan.blocks.push_back({int(r), int(b), (*descriptions_[r])[b]});
  descriptions_ = {};
  checkRoom(plan.mesh);
  const Grid& grid = plan.mesh.grid;
  const insitu::BlockSearch search(plan.blocks);
  checkCover(search, grid.points);
  plan.partitioning = partitioning(grid);
  const Bytes bytes = written(plan);
  std::vector<std::vector<insitu::Destination>> all =
      destinations(identity().ranks, grid, *plan.partitioning, serverRank_.ranks(), search);
  std::set<int> owners;
  for (const auto& list : all)
    for (const insitu::Destination& d : list) owners.insert(d.owner);
  serverRank_.callAll("insitu.plan", {{"stream", identity().id}}, bytes);
  const std::lock_guard lock(mutex_);
  conductor_.emplace(identity().ranks, std::move(owners));
  for (size_t r = 0; r < all.size(); r++) part_->send(int(r), {MessageChannel::Plan, 0, written(all[r])});
}

// A step is taken when somebody waits for one, a client or the simulation itself, and else now and then, so that whoever comes
// sees something.
void StreamLead::publishSteps() {
  for (;;) {
    const auto begin = Clock::now();
    publishOne();
    awaitNext(begin);
  }
}

// `begin` is when the last step was begun.
void StreamLead::awaitNext(Clock::time_point begin) {
  std::unique_lock lock(mutex_);
  const bool failed = !problem_.empty();
  const auto until = begin + (failed ? kAfterFailure : kUnasked);
  while (!end_ && Clock::now() < until) {
    if (!failed && conductor_->isAwaited()) break;
    lock.unlock();
    const bool isWanted = !failed && wanted();
    lock.lock();
    if (isWanted) break;
    changed_.wait_for(lock, kLook);
  }
  if (end_) throw Ended();
}

bool StreamLead::wanted() const {
  for (const insitu::Field& field : mesh_->fields)
    if (serverRank_.datasets->wanted(identity().tenant, wishes_.scope, identity().name + "." + field.name))
      return true;
  return false;
}

void StreamLead::publishOne() {
  std::string problem;
  try {
    const auto exchange = serverRank_.exchanges.begin(Asker{[this] {
      if (ending()) throw Error("the stream has ended");
    }});
    std::vector<DatasetDraft> drafts;
    for (const insitu::Field& field : mesh_->fields)
      drafts.push_back({identity().name + "." + field.name, DatasetType::Volume});
    const auto names =
        serverRank_.datasets->beginNow(identity().tenant, *exchange, "stream " + inQuotes(identity().name),
                                       wishes_.scope, std::move(drafts));
    serverRank_.callAll("insitu.step",
                        {{"stream", identity().id}, {"exchange", *exchange}, {"items", names->items()}});
  } catch (const std::exception& e) {
    problem = e.what();
  }
  const std::lock_guard lock(mutex_);
  if (problem.empty()) newest_ = {conductor_->step().count, conductor_->step().step, conductor_->step().time};
  tell(problem.empty() ? conductor_->published() : conductor_->abandon());
  if (!problem.empty() && problem != problem_ && !end_)
    spdlog::info("rank 0: stream {}: a step is left out: {}", identity().name, problem);
  problem_ = problem;
}

CollectedStep StreamLead::collect(const std::function<void()>& check) {
  std::unique_lock lock(mutex_);
  tell(conductor_->begin());
  std::optional<Clock::time_point> until;
  auto appointed = Clock::now();
  while (!conductor_->isComplete()) {
    if (!conductor_->someTaken())
      until.reset();  // also after a miss
    else if (!until)
      until = Clock::now() + kStepPatience;
    if (!until && Clock::now() > appointed + kAppointed) {
      tell(conductor_->again());
      appointed = Clock::now();
    }
    changed_.wait_for(lock, kLook);
    if (end_) throw Error("the stream has ended");
    lock.unlock();
    check();
    lock.lock();
    if (until && Clock::now() > *until)
      throw Error("not all of a step came within " + std::to_string(kStepPatience.count()) +
                  " s: " + conductor_->missing());
  }
  const insitu::StepHeader& step = conductor_->step();
  if (newest_.count > 0 && step.step <= newest_.step)
    throw Error("step " + std::to_string(step.step) + " after step " + std::to_string(newest_.step) +
                ", expected steps that ascend");
  return {step.count, step.step, step.time};
}

uint64_t StreamLead::lastAppointed() const {
  const std::lock_guard lock(mutex_);
  return conductor_ ? conductor_->last() : 0;
}

void StreamLead::finish() {
  std::string reason;
  {
    const std::lock_guard lock(mutex_);
    reason = *end_;
  }
  spdlog::info("rank 0: stream {} has ended: {}", identity().name, reason);
  try {
    serverRank_.callAll("insitu.end", {{"stream", identity().id}, {"reason", reason}});
  } catch (const Error& e) {
    spdlog::warn("rank 0: stream {}: {}", identity().name, e.what());
  }
  onEnd_();
}

json StreamLead::statistics() const {
  const size_t connections = part_->connections();
  const std::lock_guard lock(mutex_);
  json fields = json::array();
  if (mesh_)
    for (const insitu::Field& field : mesh_->fields) fields.push_back(identity().name + "." + field.name);
  json result{{"stream", identity().id},   {"name", identity().name},  {"tenant", identity().tenant},
              {"ranks", identity().ranks}, {"connected", connections}, {"datasets", fields}};
  if (conductor_) {
    const insitu::Conductor::Counters& c = conductor_->counters();
    result.update(
        {{"published", c.published}, {"missed", c.missed}, {"abandoned", c.abandoned}, {"margin", c.margin}});
  }
  if (newest_.count > 0) {
    result["step"] = newest_.step;
    if (!std::isnan(newest_.time)) result["time"] = newest_.time;
  }
  if (!problem_.empty()) result["problem"] = problem_;
  return result;
}

}  // namespace gxy
