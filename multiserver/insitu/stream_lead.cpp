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

DatasetType typeOf(const insitu::Mesh& mesh) {
  if (mesh.kind == insitu::Mesh::Kind::Grid) return DatasetType::Volume;
  if (mesh.kind == insitu::Mesh::Kind::Points) return DatasetType::Particles;
  if (mesh.shape == insitu::Mesh::Shape::Volume) return DatasetType::Volume;
  return mesh.shape == insitu::Mesh::Shape::Lines ? DatasetType::PathLines : DatasetType::Triangles;
}

}  // namespace

StreamLead::StreamLead(ServerRank& serverRank, std::shared_ptr<StreamPart> part, StreamWishes wishes,
                       Triggers::Tell tell, std::function<void()> onEnd)
    : serverRank_(serverRank),
      part_(std::move(part)),
      wishes_(std::move(wishes)),
      tell_(std::move(tell)),
      onEnd_(std::move(onEnd)),
      triggers_(serverRank, part_->identity().name, part_->identity().tenant, tell_,
                [this](const insitu::Steering& values) { steer(values); }),
      said_(size_t(part_->identity().ranks)),
      conductor_(part_->identity().ranks),
      thread_([this] { run(); }) {}

StreamLead::~StreamLead() {
  stop("the server stops");
  join();
}

void StreamLead::stop(const std::string& reason) {
  end(reason);
  triggers_.end();
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

void StreamLead::complete(int owner, uint64_t count, uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  uint64_t& soFar = bytes_[owner];
  soFar = std::max(soFar, bytes);
  conductor_.complete(owner, count);
  if (conductor_.isComplete()) changed_.notify_all();
}

void StreamLead::refused(uint64_t count, const std::string& reason) {
  const std::lock_guard lock(mutex_);
  refused_ = {count, reason};
  changed_.notify_all();
}

void StreamLead::take(int rank, const protocol::WireMessage& message) {
  if (message.channel == MessageChannel::Describe)
    return describe(rank, insitu::readDescription(message.payload));
  const bool isStep = message.channel == MessageChannel::Step;
  const insitu::StepHeader step = isStep ? insitu::readStep(message.payload) : insitu::StepHeader{};
  const Control control = isStep ? Control{} : insitu::readControl(message.payload);
  const std::lock_guard lock(mutex_);
  if (isStep) {
    if (!conductor_.someTaken()) course_.taken = Clock::now();
    conductor_.receive(rank, step);
  } else {
    tell(conductor_.receive(rank, control));
  }
  const bool canPlan = conductor_.needsPlan() && conductor_.canPlan();
  if (conductor_.isComplete() || canPlan || (!isStep && control.kind == Control::Kind::Waits))
    changed_.notify_all();
}

void StreamLead::describe(int rank, Description description) {
  const std::lock_guard lock(mutex_);
  Said& said = said_.at(size_t(rank));
  if (said.from > 0) insitu::checkContinues(*said.meshes, description.meshes);
  size_t blocks = blocks_;
  for (const insitu::Part& part : said.parts) blocks -= part.blocks.size();
  for (const insitu::Part& part : description.parts) blocks += part.blocks.size();
  if (blocks > insitu::kMostBlocks)
    throw Error("the ranks have more than 2^20 blocks together, expected at most as many");
  conductor_.describe(rank, description.from);  // Nothing has changed where it throws.
  blocks_ = blocks;
  if (said.from == 0) described_++;
  if (!newestSaid_ || *newestSaid_ != description.meshes)
    newestSaid_ = std::make_shared<const std::vector<insitu::Mesh>>(std::move(description.meshes));
  said = {description.from, newestSaid_, std::move(description.parts)};
  changed_.notify_all();
}

// With the lock held.
std::vector<insitu::Mesh> StreamLead::mergedMeshes() const {
  std::vector<insitu::Mesh> meshes = *said_.front().meshes;
  for (size_t r = 1; r < said_.size(); r++)
    if (said_[r].meshes != said_[r - 1].meshes) insitu::mergeMeshes(meshes, *said_[r].meshes, int(r));
  for (insitu::Mesh& mesh : meshes)  // No rank has cells so far.
    if (mesh.kind == insitu::Mesh::Kind::Cells && mesh.shape == insitu::Mesh::Shape::Unknown)
      mesh.shape = insitu::Mesh::Shape::Triangles;
  insitu::checkVolumes(meshes);
  return meshes;
}

void StreamLead::steer(const insitu::Steering& values) {
  for (const auto& steered : values) {
    const std::string& name = steered.first;
    const double value = steered.second;
    const auto known = std::find_if(wishes_.steerable.begin(), wishes_.steerable.end(),
                                    [&](const StreamWishes::Steerable& s) { return s.name == name; });
    if (known == wishes_.steerable.end())
      throw Error("steer: parameter " + inQuotes(name) + " of stream " + inQuotes(identity().name) +
                  " cannot be steered; `insitu.streams` lists those that can");
    if (!(value >= known->least && value <= known->largest))
      throw Error("steer: " + inQuotes(name) + ": found " + std::to_string(value) + ", expected " +
                  std::to_string(known->least) + " to " + std::to_string(known->largest));
  }
  const std::lock_guard lock(mutex_);
  for (const auto& [name, value] : values) steering_[name] = value;
  steered_++;
  changed_.notify_all();
}

// Values that were steered stand before an appointment, so that they are there when the step is taken.
void StreamLead::tell(const std::vector<Control>& messages) {
  for (const Control& m : messages)
    if (m.kind == Control::Kind::Appoint && steered_ > 0) {
      told_ = steered_;
      for (int r = 0; r < identity().ranks; r++)
        part_->send(r, {MessageChannel::Steer, 0, insitu::written(steering_)});
    }
  for (const Control& m : messages)
    for (int r = 0; r < identity().ranks; r++) part_->send(r, controlMessage(m));
}

// With the lock held, before a step is appointed.
void StreamLead::tellEncodings() {
  if (encodings_ == toldEncodings_) return;
  for (int r = 0; r < identity().ranks; r++)
    part_->send(r, {MessageChannel::Encode, 0, insitu::written(encodings_)});
  toldEncodings_ = encodings_;
}

void StreamLead::run() {
  try {
    plan();
    publishSteps();
  } catch (const Ended&) {
  } catch (const std::exception& e) {
    end(e.what());
  }
  finish();
}

// Waits until all ranks have said what they have, and none can say anything else of the same publishes. Returns with the lock, without
// which that may change.
std::unique_lock<std::mutex> StreamLead::awaitDescriptions() {
  constexpr std::chrono::seconds kRarely(1);
  const auto begun = Clock::now();
  size_t before = 0;
  auto last = begun;  // that a rank said for the first time what it has
  auto asked = begun - kLook;
  Clock::duration interval = kLook;
  uint64_t announced = 0;  // the publish that is appointed until there is a first plan
  std::unique_lock lock(mutex_);
  while (!end_ && !conductor_.canPlan()) {
    const bool isAll = described_ == said_.size();
    if (described_ != std::exchange(before, described_)) last = Clock::now();
    if (described_ > 0 && !isAll && Clock::now() > last + kGathering)
      throw Error("only " + std::to_string(described_) + " of " + std::to_string(identity().ranks) +
                  " ranks of the simulation have published a step within a minute");
    if (isAll && !partitioning_ && announced != conductor_.described()) {
      // A rank that waits for its first step may be behind one that has left it out. It goes on when a later one is appointed.
      if (announced > 0) tell({{Control::Kind::Cancel, announced, 0}});
      announced = conductor_.described();
      tell({{Control::Kind::Appoint, announced, 0}});
    }
    if (isAll && Clock::now() >= asked + interval) {
      tell(conductor_.look());
      if (asked > begun) interval = std::min<Clock::duration>(2 * interval, kRarely);
      asked = Clock::now();
    }
    changed_.wait_for(lock, kLook);
    lock.unlock();
    if (Clock::now() > begun + kConnecting && part_->connections() == 0)
      throw Error("no rank of the simulation is connected");
    lock.lock();
  }
  if (end_) throw Ended();
  if (announced > 0) tell({{Control::Kind::Cancel, announced, 0}});  // No rank can have taken it.
  return lock;
}

// Where the particles and cells of the first step are, or the simulation says that they will be.
Box StreamLead::domain(const Bounds& bounds) const {
  Box domain;
  for (size_t m = 0; m < meshes_.size(); m++) {
    if (meshes_[m].kind == insitu::Mesh::Kind::Grid) continue;
    Box box = meshes_[m].box;
    if (box.empty()) {
      for (const std::vector<Box>& ofRank : bounds) box.extend(ofRank[m]);
      if (!box.empty()) {
        const glm::dvec3 more = 0.05 * (box.hi - box.lo);
        box = {box.lo - more, box.hi + more};
      }
    }
    domain.extend(box);
  }
  return domain.empty() ? Box{glm::dvec3(0), glm::dvec3(1)} : domain;
}

// A stream has one partitioning, so that all of its data can be shown together.
std::shared_ptr<const Partitioning> StreamLead::cut(const StreamPlan& plan, const Bounds& bounds) const {
  if (wishes_.partition.is_object()) {
    const auto name = wishes_.partition.at("like").get<std::string>();
    return serverRank_.datasets->getPinned(identity().tenant, name).second.get<Dataset>()->partitioning;
  }
  for (size_t m = 0; m < meshes_.size(); m++) {
    if (meshes_[m].kind != insitu::Mesh::Kind::Grid) continue;
    const Grid& grid = meshes_[m].grid;
    // Ranks of the server would have nothing to do if there were more of them than of the simulation.
    if (wishes_.partition == "simulation" && identity().ranks >= serverRank_.ranks()) {
      auto own = insitu::partitionsOf(grid, plan.blocks[m], identity().ranks, serverRank_.ranks());
      if (own) return std::make_shared<const Partitioning>(*std::move(own));
      spdlog::warn(
          "rank 0: stream {}: its blocks are too irregular for partitions, so the grid is cut evenly",
          identity().name);
    }
    return automaticPartitioning(grid.box(), &grid, {}, serverRank_.ranks());
  }
  return automaticPartitioning(domain(bounds), nullptr, {}, serverRank_.ranks());
}

void StreamLead::checkInside(const Partitioning& partitioning) const {
  const std::string whose = wishes_.partition.is_object()
                                ? inQuotes(wishes_.partition.at("like").get<std::string>())
                                : "the first grid";
  for (const insitu::Mesh& mesh : meshes_) {
    if (mesh.kind != insitu::Mesh::Kind::Grid) continue;
    const Box data = mesh.grid.box(), domain = partitioning.domain();
    for (int a = 0; a < 3; a++) {
      const double rounding = 1e-9 * (domain.hi[a] - domain.lo[a]);
      if (data.lo[a] < domain.lo[a] - rounding || data.hi[a] > domain.hi[a] + rounding)
        throw Error("partition: the grid " + inQuotes(mesh.name) + " reaches beyond the domain of " + whose +
                    ", whose partitioning it was to share");
    }
  }
}

// The rank that gets the particles and cells of each rank of the simulation: that in whose partitions most of them are, if it can be told
// from their box. Any will do, as they are brought to where they are drawn.
std::vector<int> StreamLead::homes(const Partitioning& partitioning, const Bounds& bounds) const {
  std::vector<int> homes;
  for (size_t r = 0; r < bounds.size(); r++) {
    Box box;
    for (const Box& ofMesh : bounds[r]) box.extend(ofMesh);
    homes.push_back(box.empty() ? int(r) % serverRank_.ranks()
                                : partitioning.owner(partitioning.nearest(0.5 * box.lo + 0.5 * box.hi)));
  }
  return homes;
}

// Refuses what cannot be kept before anything is made of it.
void StreamLead::checkRoom(const Partitioning& partitioning) const {
  std::vector<int64_t> bytes(size_t(serverRank_.ranks()));
  for (const insitu::Mesh& mesh : meshes_) {
    if (mesh.kind != insitu::Mesh::Kind::Grid) continue;
    int64_t ofPoint = 0;
    for (const insitu::Field& field : mesh.fields) ofPoint += int64_t(field.bytesPerPoint());
    for (int p = 0; p < partitioning.partitions(); p++)
      bytes[size_t(partitioning.owner(p))] += ofPoint * ownedPoints(mesh.grid, partitioning, p).count();
  }
  const int64_t room = std::min(serverRank_.options.tenantMemory, serverRank_.options.memory);
  const auto most = std::max_element(bytes.begin(), bytes.end());
  if (*most > room)
    throw Error("memory: rank " + std::to_string(most - bytes.begin()) + " of " +
                std::to_string(serverRank_.ranks()) + " gets " + std::to_string(*most) +
                " bytes of a step, but has room for " + std::to_string(room) + " bytes of a tenant");
}

// Plans where samples go from now on. A simulation whose ranks share a grid in another way goes on in the partitions that there are,
// unless these are to be its own.
void StreamLead::plan() {
  StreamPlan plan;
  uint64_t from = 0;
  bool isOther = false;  // the meshes are not what they were
  Bounds bounds(said_.size());
  {
    const std::unique_lock lock = awaitDescriptions();
    from = conductor_.described();
    plan.meshes = mergedMeshes();
    isOther = plan.meshes != meshes_;
    meshes_ = plan.meshes;
    plan.blocks.resize(meshes_.size());
    for (size_t r = 0; r < said_.size(); r++)
      for (size_t m = 0; m < meshes_.size(); m++) {
        const insitu::Part& mine = said_[r].parts[m];
        for (size_t b = 0; b < mine.blocks.size(); b++)
          plan.blocks[m].push_back({int(r), int(b), mine.blocks[b]});
        bounds[r].push_back(mine.bounds);
      }
  }
  const bool isFirst = !partitioning_, moves = isFirst || isOther || plan.blocks != plannedBlocks_;
  std::vector<insitu::BlockSearch> searches;
  for (size_t m = 0; m < meshes_.size(); m++) {
    searches.emplace_back(plan.blocks[m]);
    if (meshes_[m].kind == insitu::Mesh::Kind::Grid) checkCover(searches[m], meshes_[m].grid.points);
  }
  const bool follows = moves && wishes_.partition == "simulation";
  if (isFirst || follows || (isOther && !wishes_.partition.is_object())) partitioning_ = cut(plan, bounds);
  checkInside(*partitioning_);
  checkRoom(*partitioning_);
  if (homes_.empty()) homes_ = homes(*partitioning_, bounds);
  plan.partitioning = partitioning_;
  plan.homes = homes_;
  const Bytes bytes = written(plan);
  const std::vector<std::vector<insitu::Destination>> all = insitu::destinations(
      identity().ranks, serverRank_.ranks(), {meshes_, searches, homes_, *partitioning_});
  std::set<int> owners;
  for (const auto& list : all)
    for (const insitu::Destination& d : list) owners.insert(d.owner);
  if (moves) serverRank_.callAll("insitu.plan", {{"stream", identity().id}}, bytes);
  plannedBlocks_ = std::move(plan.blocks);
  const std::lock_guard lock(mutex_);
  conductor_.plan(from, std::move(owners));
  for (size_t r = 0; r < all.size(); r++)
    part_->send(int(r), {MessageChannel::Plan, 0, insitu::written(from, all[r])});
}

// A step is taken when somebody waits for one, a client or the simulation itself, and else now and then, so that whoever comes
// sees something.
void StreamLead::publishSteps() {
  for (;;) {
    const auto begin = Clock::now();
    publishNext();
    if (part_->wasUnfit()) publishNext();  // as it is
    pullTriggers();
    awaitNext(begin);
  }
}

// Publishes the next step that there is, by another plan if ranks have something else than before. A rank that waits for a plan may be
// behind another one that has said something new since. Then it can only go on to the next appointment, and there is no plan before.
void StreamLead::publishNext() {
  constexpr int kTries =
      3;  // so that a simulation that always has something new does not have all of the server's time
  for (int i = 0; i < kTries; i++) {
    std::unique_lock lock(mutex_);
    const bool plans = conductor_.needsPlan() && (conductor_.canPlan() || !conductor_.ranksWait());
    lock.unlock();
    if (plans) plan();
    if (publishOne()) return;
  }
}

// `begin` is when the last step was begun.
void StreamLead::awaitNext(Clock::time_point begin) {
  std::unique_lock lock(mutex_);
  const bool failed = !problem_.empty();
  const auto until = begin + (failed ? kAfterFailure : kUnasked);
  while (!end_ && Clock::now() < until) {
    if (!failed && (conductor_.isAwaited() || steers())) break;
    lock.unlock();
    const bool isWanted = !failed && wanted();
    lock.lock();
    if (isWanted) break;
    if (const Triggers::Wants triggers = triggers_.wants(); triggers.any && !failed) {
      from_ = triggers.from ? publishOf(*triggers.from) : 0;
      if (!triggers.from || isNear(from_, Clock::now())) return;
    }
    changed_.wait_for(lock, kLook);
  }
  from_ = 0;
  if (end_) throw Ended();
}

// Whether the simulation will come to a publish soon. It is asked now and then how far it is. So nothing is reserved, and nothing
// appointed, long before it is needed. With the lock held.
bool StreamLead::isNear(uint64_t publish, Clock::time_point now) {
  constexpr double kSoon = 3;  // times kLook
  tell(conductor_.look());
  const Look before = std::exchange(look_, {conductor_.newest(), now});
  const double looks = std::chrono::duration<double>(now - before.at) / kLook;
  if (look_.newest < before.newest || before.newest == 0 || looks <= 0) return publish <= look_.newest + 1;
  const double perLook = double(look_.newest - before.newest) / looks;
  return double(publish) <= double(look_.newest) + 1 + double(conductor_.counters().margin) + kSoon * perLook;
}

// The publish that will have a step, if the steps between publishes stay what they were. With the lock held.
uint64_t StreamLead::publishOf(int64_t step) const {
  if (before_.count == 0 || newest_.count <= before_.count) return 0;
  const double between =
      (double(newest_.step) - double(before_.step)) / double(newest_.count - before_.count);
  const double publishes = std::ceil((double(step) - double(newest_.step)) / between);
  return publishes > 0 && publishes < 1e12 ? newest_.count + uint64_t(publishes) : 0;
}

StepValues StreamLead::valuesOf(const std::string& field) const {
  const std::string name = identity().name + "." + field;
  const auto dataset = serverRank_.datasets->getPinned(identity().tenant, name).second.get<Dataset>();
  const Range range = dataset->range();
  int64_t noData = 0;
  if (dataset->volume) noData = dataset->volume->noDataSamples;
  if (dataset->mesh) {
    const MeshReport& report = dataset->mesh->report;
    noData = int64_t(dataset->mesh->ofCells ? report.noDataCells : report.noDataPoints);
  }
  return {range.min, range.max, noData};
}

// Does what is to be done with the step that was just published.
void StreamLead::pullTriggers() {
  CollectedStep step;
  {
    const std::lock_guard lock(mutex_);
    if (!problem_.empty()) return;
    step = newest_;
  }
  triggers_.published(
      step.step, step.time, [this](const std::string& field) { return valuesOf(field); },
      [this] {
        if (ending()) throw Ended();
      });
}

bool StreamLead::wanted() const {
  const std::vector<insitu::Publishes> all = insitu::datasetsOf(meshes_);
  return std::any_of(all.begin(), all.end(), [this](const insitu::Publishes& d) {
    return serverRank_.datasets->wanted(identity().tenant, wishes_.scope, identity().name + "." + d.name);
  });
}

// Returns false if there is to be another plan first.
bool StreamLead::publishOne() {
  std::string problem;
  {
    const std::lock_guard lock(mutex_);
    course_ = {};
    course_.begun = Clock::now();
    // A step whose encodings do not fit is left out. A simulation that waits has ruled this out, and thresholds are there for just
    // the steps whose values jump.
    const Triggers::Wants wants = triggers_.wants();
    const bool isEachNeeded = conductor_.ranksWait() || (wants.any && !wants.from);
    encodings_ = isEachNeeded ? insitu::Encodings() : part_->encodings();
  }
  try {
    const auto exchange = serverRank_.exchanges.begin(Asker{[this] {
      if (ending()) throw Error("the stream has ended");
    }});
    std::vector<DatasetDraft> drafts;
    for (const insitu::Publishes& d : insitu::datasetsOf(meshes_)) {
      drafts.push_back({identity().name + "." + d.name, typeOf(meshes_[d.mesh])});
    }
    const auto names =
        serverRank_.datasets->beginNow(identity().tenant, *exchange, "stream " + inQuotes(identity().name),
                                       wishes_.scope, std::move(drafts));
    json encodings = json::array();  // used by this thread only
    for (const insitu::FieldEncoding& e : encodings_)
      encodings.push_back({e.mesh, e.field, e.shift, e.scale});
    serverRank_.callAll("insitu.step", {{"stream", identity().id},
                                        {"exchange", *exchange},
                                        {"items", names->items()},
                                        {"encodings", std::move(encodings)}});
  } catch (const std::exception& e) {
    problem = e.what();
  }
  const std::lock_guard lock(mutex_);
  if (problem.empty()) isPublished();
  tell(problem.empty() ? conductor_.published() : conductor_.abandon());
  if (!problem.empty() && problem != problem_ && !end_ && !isHeldUp_)
    spdlog::info("rank 0: stream {}: a step is left out: {}", identity().name, problem);
  problem_ = problem;
  return !std::exchange(isHeldUp_, false);
}

// With the lock held.
void StreamLead::isPublished() {
  before_ = newest_;
  newest_ = {conductor_.step().count, conductor_.step().step, conductor_.step().time};
  const auto seconds = [](Clock::duration d) { return std::chrono::duration<double>(d).count(); };
  seconds_.reserve += seconds(course_.hasRoom - course_.begun);
  seconds_.collect += seconds(course_.collected - course_.taken);
  seconds_.complete += seconds(Clock::now() - course_.collected);
  late_ = conductor_.latest();
}

CollectedStep StreamLead::collect(const std::function<void()>& check) {
  std::unique_lock lock(mutex_);
  course_.hasRoom = Clock::now();
  refused_ = {};
  tellEncodings();
  tell(conductor_.begin(from_));
  constexpr auto kNone = Clock::time_point::max();
  auto until = kNone;
  auto appointed = Clock::now();
  while (!conductor_.isComplete()) {
    if (!conductor_.someTaken())
      until = kNone;  // also after a miss
    else if (until == kNone)
      until = Clock::now() + kStepPatience;
    if (until == kNone && Clock::now() > appointed + kAppointed) {
      tell(conductor_.again());
      appointed = Clock::now();
    }
    changed_.wait_for(lock, kLook);
    if (end_) throw Error("the stream has ended");
    if (conductor_.isHeldUp()) {
      isHeldUp_ = true;
      tell(conductor_.abandon());
      throw Error("ranks of the simulation have other blocks or another grid than before");
    }
    if (refused_.count > 0 && refused_.count == conductor_.last()) throw Error(refused_.reason);
    lock.unlock();
    check();
    lock.lock();
    if (Clock::now() > until)
      throw Error("not all of a step came within " + std::to_string(kStepPatience.count()) +
                  " s: " + conductor_.missing());
  }
  course_.collected = Clock::now();
  const insitu::StepHeader& step = conductor_.step();
  if (newest_.count > 0 && step.step <= newest_.step)
    throw Error("step " + std::to_string(step.step) + " after step " + std::to_string(newest_.step) +
                ", expected steps that ascend");
  return {step.count, step.step, step.time};
}

uint64_t StreamLead::lastAppointed() const {
  const std::lock_guard lock(mutex_);
  return conductor_.last();
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
  triggers_.finish();
  triggers_.end();
  tell_({{"event", "stream ended"}, {"stream", identity().name}, {"reason", reason}});
  onEnd_();
}

json StreamLead::statistics() const {
  const size_t connections = part_->connections(), checked = part_->checkedConnections();
  const uint64_t sameCells = part_->stepsWithTheSameCells();
  const std::lock_guard lock(mutex_);
  json fields = json::array();
  for (const insitu::Publishes& d : insitu::datasetsOf(meshes_))
    fields.push_back(identity().name + "." + d.name);
  json result{{"stream", identity().id},   {"name", identity().name},  {"tenant", identity().tenant},
              {"ranks", identity().ranks}, {"connected", connections}, {"checked", checked},
              {"datasets", fields}};
  if (!meshes_.empty()) {
    const insitu::Conductor::Counters& c = conductor_.counters();
    result.update(
        {{"published", c.published}, {"missed", c.missed}, {"abandoned", c.abandoned}, {"margin", c.margin}});
    uint64_t bytes = 0;
    for (const auto& [owner, some] : bytes_) bytes += some;
    result["bytes"] = bytes;
    if (std::any_of(meshes_.begin(), meshes_.end(),
                    [](const insitu::Mesh& mesh) { return mesh.shape == insitu::Mesh::Shape::Volume; }))
      result["same cells"] = sameCells;
  }
  if (newest_.count > 0) {
    result["step"] = newest_.step;
    if (!std::isnan(newest_.time)) result["time"] = newest_.time;
    result["late"] = late_;
    result["seconds"] = {
        {"reserve", seconds_.reserve}, {"collect", seconds_.collect}, {"complete", seconds_.complete}};
  }
  for (const StreamWishes::Steerable& s : wishes_.steerable) {
    json& one = result["steerable"][s.name];
    one = {{"least", s.least}, {"largest", s.largest}};
    if (const auto value = steering_.find(s.name); value != steering_.end()) one["value"] = value->second;
  }
  if (!problem_.empty()) result["problem"] = problem_;
  if (end_) result["ending"] = *end_;
  return result;
}

}  // namespace gxy
