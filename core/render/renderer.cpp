// SPDX-License-Identifier: Apache-2.0
// The life of frames: started, made known, cancelled, finished, delivered. renderer_rays.cpp has the life of
// their rays.
#include "core/render/renderer.h"

#include <algorithm>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/comm/tree.h"
#include "core/comm/wire.h"
#include "core/render/renderer_state.h"

namespace gxy {

namespace {

enum class FrameMessage : uint8_t { Start, Cancel, Finish, Delivered, Failed };

void writeRequest(Writer& w, const FrameRequest& r) {
  const Camera& c = r.camera;
  w.write(r.scene)
      .write(r.samples)
      .write(r.firstSample)
      .write(r.depth)
      .write(r.sums)
      .write(r.window)
      .write(r.priority.tenant);
  w.write(r.priority.interactive).write(r.priority.stream).write(r.account);
  w.write(c.viewpoint)
      .write(c.viewdirection)
      .write(c.viewup)
      .write(c.aov)
      .write(c.height)
      .write(c.dimensions);
}

FrameRequest readRequest(Reader& in) {
  FrameRequest r;
  Camera& c = r.camera;
  r.scene = in.read<SceneId>();
  r.samples = in.read<int32_t>();
  r.firstSample = in.read<int32_t>();
  r.depth = in.read<bool>();
  r.sums = in.read<bool>();
  r.window = in.read<uint64_t>();
  r.priority.tenant = in.read<uint32_t>();
  r.priority.interactive = in.read<bool>();
  r.priority.stream = in.read<uint64_t>();
  r.account = in.readString();
  c.viewpoint = in.read<glm::dvec3>();
  c.viewdirection = in.read<glm::dvec3>();
  c.viewup = in.read<glm::dvec3>();
  c.aov = in.read<double>();
  c.height = in.read<double>();
  c.dimensions = in.read<glm::ivec2>();
  constexpr int32_t kSamples = 1 << 16;  // as many as a ray can name
  if (r.samples < 0 || r.samples > kSamples || r.firstSample < 0 || r.firstSample > kSamples - r.samples)
    throw Error("a frame of " + std::to_string(r.samples) + " samples from " + std::to_string(r.firstSample) +
                " on, expected numbers from 0 to " + std::to_string(kSamples));
  return r;
}

// Nothing where there is no operation, else a byte before what the operation writes.
Bytes operationBytes(const PictureOperationPtr& operation) {
  Writer w;
  if (operation) operation->write(w.write(true));
  return w.take();
}

LedgerEntry entry(const Renderer::Options& options, const std::string& tenant, const char* purpose) {
  return options.ledger ? options.ledger->enter(tenant, purpose, 0) : LedgerEntry();
}

}  // namespace

Renderer::Account::Account(const Options& options, const std::string& tenant)
    : rays(entry(options, tenant, "rays")),
      framebuffer(entry(options, tenant, "framebuffer")),
      picture(entry(options, tenant, "picture")),
      tiles(entry(options, tenant, "tiles")) {}

void Renderer::Framebuffers::more() {
  const int held = ++now;
  int before = most;
  while (before < held && !most.compare_exchange_weak(before, held)) {
  }
}

Renderer::Renderer(Transport& transport, Options options)
    : transport_(transport),
      options_(options),
      completion_(transport),
      account_(options, options.tenant),
      parkedMemory_(entry(options, options.tenant, "parked messages")),
      tasks_(transport,
             {{options.raysInFlight, options.urgentWork}, options.runners, false, options.processorTime}),
      handOuts_(transport, {{}, options.handOuts, true, options.processorTime}),
      admission_(options.framebufferBytes * transport.size(), 1 + size_t(transport.size())) {
  if (options_.packetRays < 16)
    throw Error("packets of " + std::to_string(options_.packetRays) + " rays, expected >= 16");
  if (options_.raysInFlight < 1) throw Error("the number of rays in flight must be >= 1");
  transport_.onMessage(Channel::Frame, [this](int, const Bytes& m) { receiveFrame(m); });
  transport_.onMessage(Channel::Rays, [this](int, Bytes m) { receiveRays(std::move(m)); });
  transport_.onMessage(Channel::Contributions, [this](int, Bytes m) { receiveContributions(std::move(m)); });
  transport_.onMessage(Channel::Credits, [this](int, const Bytes& m) {
    Reader in(m, "ray credits");
    Priority priority;
    priority.tenant = in.read<uint32_t>();
    priority.stream = in.read<uint64_t>();
    const auto credits = in.read<int64_t>();  // negative for secondaries beyond what their primaries took
    in.expectEnd();
    constexpr int64_t kMost = int64_t(1) << 40;  // far beyond those of a packet's rays
    if (credits < -kMost || credits > kMost)
      in.fail(std::to_string(credits) + " credits come back, expected at most " + std::to_string(kMost));
    giveBack(transport_.rank(), priority, credits);
  });
}

Renderer::~Renderer() {
  for (Channel c : {Channel::Frame, Channel::Rays, Channel::Contributions, Channel::Credits})
    transport_.onMessage(c, {});
  tasks_.close();
  handOuts_.close();
}

void Renderer::addScene(SceneId id, std::shared_ptr<const CompiledScene> scene,
                        std::shared_ptr<const DeviceScene> device) {
  std::lock_guard lock(mutex_);
  scenes_[id] = {std::move(scene), std::move(device)};
}

void Renderer::removeScene(SceneId id) {
  std::lock_guard lock(mutex_);
  scenes_.erase(id);
}

void Renderer::onPicture(PictureHandler handler) {
  std::lock_guard lock(mutex_);
  pictureHandler_ = std::move(handler);
}

void Renderer::onOperation(PictureOperationReader reader) {
  std::lock_guard lock(mutex_);
  operationReader_ = std::move(reader);
}

Renderer::Counters Renderer::counters() const {
  std::lock_guard lock(mutex_);
  Counters c = counters_;
  c.mostRaysInFlight = tasks_.queue().credits().mostOut();
  c.mostFramebuffers = framebuffers_->most;
  return c;
}

Renderer::ResourceCounts Renderer::kept() const {
  ResourceCounts kept;
  kept.completionSets = completion_.setsKept();
  kept.tasks = tasks_.queue().size() + handOuts_.queue().size();
  const Credits credits = tasks_.queue().credits();
  kept.credits = credits.out();
  kept.tenantCredits = credits.byTenant();
  std::lock_guard lock(mutex_);
  kept.frames = frames_.size();
  for (const auto& [id, messages] : parked_) kept.parkedMessages += messages.size();
  kept.callbacks = pending_.size();
  kept.windows = windows_.size();
  return kept;
}

FrameId Renderer::render(const FrameRequest& request, Finished finished) {
  validate(request.camera);
  FrameId id, older = 0;
  bool waits = false;
  {
    std::lock_guard lock(mutex_);
    if (!scenes_.count(request.scene))
      throw Error("there is no scene " + std::to_string(request.scene) + " to render");
    id = nextFrame_++;
    Pending& pending = pending_[id];
    pending.finished = std::move(finished);
    pending.window = request.window;
    pending.priority = request.priority;
    if (request.window) older = std::exchange(windows_[request.window], id);
    const glm::ivec2 size = request.camera.dimensions;
    waits = !request.priority.interactive &&
            !admission_.enter(request.priority, id, Framebuffer::bytesOf(size.x, size.y, request.depth));
    if (waits) pending.waiting = request;
  }
  if (older) supersede(older);
  if (!waits) beginFrame(id, request);
  return id;
}

// Rank 0: makes a frame known on all ranks.
void Renderer::beginFrame(FrameId id, const FrameRequest& request) {
  completion_.begin(id, [this, id] { complete(id); });
  Writer w;
  w.write(FrameMessage::Start).write(id);
  writeRequest(w, request);
  w.write(operationBytes(request.operation));
  start(id, request, {}, w.take());
}

void Renderer::beginWaiting(const std::vector<FrameId>& ids) {
  for (const FrameId id : ids) {
    std::optional<FrameRequest> request;
    {
      std::lock_guard lock(mutex_);
      const auto it = pending_.find(id);  // none if it was superseded meanwhile, which begins it, and is over
      if (it != pending_.end()) request.swap(it->second.waiting);
    }
    if (request) beginFrame(id, *request);
  }
}

// A frame that has not begun is made known on all ranks, too, because each keeps track of the frames that are
// over.
void Renderer::supersede(FrameId id) {
  std::optional<FrameRequest> request;
  {
    std::lock_guard lock(mutex_);
    const auto it = pending_.find(id);
    if (it == pending_.end() || it->second.complete || it->second.ending.superseded) return;
    it->second.ending.superseded = true;
    request.swap(it->second.waiting);
    if (request) admission_.beginAnyway(id);
  }
  if (request) beginFrame(id, *request);
  cancelEverywhere(id);
}

void Renderer::cancelEverywhere(FrameId id) {
  Writer w;
  sendDown(w.write(FrameMessage::Cancel).write(id).take());
  cancel(id);
}

// Called on a rank whose device could not do its part. The message to rank 0 counts as work of the frame, so
// the frame does not end before it is received.
void Renderer::fail(const FramePtr& frame, const std::string& error) {
  frame->cancel();
  dropTiles(frame);
  if (frame->failed.exchange(true)) return;
  completion_.created(frame->id, 1);
  Writer w;
  transport_.send(0, Channel::Frame,
                  w.write(FrameMessage::Failed)
                      .write(frame->id)
                      .write("rank " + std::to_string(transport_.rank()) + ": " + error)
                      .take());
}

// Rank 0: the first error of a frame counts.
void Renderer::failed(FrameId id, const std::string& error) {
  {
    std::lock_guard lock(mutex_);
    const auto it = pending_.find(id);
    if (it == pending_.end() || it->second.complete)
      throw Error("frame " + std::to_string(id) + " was said to have failed, but is not under way");
    if (it->second.ending.error.empty()) it->second.ending.error = error;
  }
  cancelEverywhere(id);
  completion_.retired(id, 1);
}

// Rank 0: called once, when all work of a frame is done. Decides for all ranks whether the picture counts.
void Renderer::complete(FrameId id) {
  bool hasPicture;
  {
    std::lock_guard lock(mutex_);
    Pending& pending = pending_.at(id);
    pending.complete = true;
    hasPicture = pending.ending.hasPicture();
  }
  Writer w;
  sendDown(w.write(FrameMessage::Finish).write(id).write(hasPicture).take());
  finish(id, hasPicture);
}

// Sends a message down a binary tree rooted at rank 0. Each rank passes on what it receives.
void Renderer::sendDown(const Bytes& message) {
  forEachTreeChild(transport_.rank(), 0, transport_.size(),
                   [&](int child) { transport_.send(child, Channel::Frame, message); });
}

void Renderer::receiveFrame(const Bytes& message) {
  Reader in(message, "frame message");
  const auto kind = in.read<FrameMessage>();
  const auto id = in.read<FrameId>();
  if (kind > FrameMessage::Failed) in.fail("its kind is " + std::to_string(int(kind)) + ", expected 0 to 4");
  if (id == 0 || (kind >= FrameMessage::Delivered) != (transport_.rank() == 0))
    in.fail("it is not for rank " + std::to_string(transport_.rank()));
  if (kind == FrameMessage::Start) {
    const FrameRequest request = readRequest(in);
    const Bytes operation = in.readVector<std::byte>();
    in.expectEnd();
    validate(request.camera);
    {
      std::lock_guard lock(mutex_);
      if (find(id) || isOver(id)) in.fail("frame " + std::to_string(id) + " has started before");
    }
    start(id, request, operation, message);
  } else if (kind == FrameMessage::Cancel) {
    in.expectEnd();
    sendDown(message);
    cancel(id);
  } else if (kind == FrameMessage::Finish) {
    const bool hasPicture = in.read<bool>();
    in.expectEnd();
    sendDown(message);
    finish(id, hasPicture);
  } else if (kind == FrameMessage::Failed) {
    const std::string error = in.readString();
    in.expectEnd();
    failed(id, error);
  } else {
    const std::string error = in.readString();
    in.expectEnd();
    delivered(id, error);
  }
}

void Renderer::delivered(FrameId id, const std::string& error) {
  Pending pending;
  std::vector<FrameId> next;
  {
    std::lock_guard lock(mutex_);
    const auto it = pending_.find(id);
    if (it == pending_.end() || !it->second.complete)
      throw Error("frame " + std::to_string(id) + " was said to be delivered, but is not under way");
    pending = std::move(it->second);
    pending_.erase(it);
    if (pending.ending.error.empty()) pending.ending.error = error;
    const auto window = windows_.find(pending.window);
    if (window != windows_.end() && window->second == id) windows_.erase(window);
    next = admission_.over(id);
  }
  if (pending.finished)
    tasks_.push(
        pending.priority, id,
        [finished = std::move(pending.finished), id, ending = std::move(pending.ending)] {
          finished(id, ending);
        },
        true);
  beginWaiting(next);
}

// Makes what this rank needs for a frame besides the request. `operation` is the operation of the frame's picture as rank 0 has
// written it; empty where the request holds it already.
void Renderer::prepare(Frame& frame, const Bytes& operation) {
  const FrameRequest& request = frame.request;
  if (frame.owner == transport_.rank() && !operation.empty()) {
    PictureOperationReader read;
    {
      std::lock_guard lock(mutex_);
      read = operationReader_;
    }
    if (!read) throw Error("its picture comes with an operation, expected Renderer::onOperation() before");
    Reader in(operation, "picture operation");
    if (!in.read<bool>()) in.fail("there is none, expected one");
    frame.request.operation = read(in);
    in.expectEnd();
  }
  if (!request.account.empty()) frame.own.emplace(options_, request.account);
  {
    std::lock_guard lock(mutex_);
    const auto scene = scenes_.find(request.scene);
    if (scene == scenes_.end()) throw Error("there is no scene " + std::to_string(request.scene));
    frame.scene = scene->second;
  }
  const CompiledScene& scene = *frame.scene.compiled;
  const Lighting& lighting = scene.visualization.lighting;
  frame.perPrimary = 1 + lighting.aoCount + (lighting.shadows ? int64_t(lighting.sources.size()) : 0);
  CompiledFrame compiled = compileFrame(scene, request.camera, 0, request.depth);
  if (request.samples > 0) compiled.samples = request.samples;
  compiled.firstSample = request.firstSample;
  frame.samples = compiled.samples;
  frame.limits = limitsOf(scene, compiled);
  if (frame.owner == transport_.rank()) {
    auto hold = [entry = &frame.account().framebuffer, all = framebuffers_](int64_t bytes) {
      all->more();
      return std::shared_ptr<void>(new LedgerEntry(entry->another(bytes)), [all](LedgerEntry* held) {
        delete held;
        all->now--;
      });
    };
    frame.framebuffer = std::make_unique<Framebuffer>(compiled.width, compiled.height, compiled.samples,
                                                      compiled.depth, std::move(hold));
  }
  TileList list =
      tilesOf(scene, compiled, transport_.rank(), tileSide(options_.raysInFlight, frame.perPrimary));
  frame.tiles = std::move(list.tiles);
  frame.tileMemory = frame.account().tiles.another(int64_t(frame.tiles.capacity() * sizeof(SpawnTile)));
  frame.device = frame.scene.device->makeFrame(compiled);
  frame.device->setUrgent(request.priority.interactive);
  std::lock_guard lock(mutex_);
  counters_.tilesSkipped += list.skipped * uint64_t(frame.samples);
  for (int p : scene.partitioning->owned(transport_.rank()))
    counters_.partitionsSkipped += !scene.visible[size_t(p)];
}

void Renderer::start(FrameId id, FrameRequest request, const Bytes& operation, const Bytes& message) {
  sendDown(message);
  auto frame = std::make_shared<Frame>(options_);
  frame->id = id;
  frame->request = std::move(request);
  frame->owner = int(id % uint64_t(transport_.size()));
  frame->shared = &account_;
  try {
    prepare(*frame, operation);
  } catch (const std::exception& e) {
    frame->tiles.clear();    // the frame spawns nothing here, and rays that arrive are retired
    fail(frame, textOf(e));  // before other ranks can end the frame
  }
  frame->tilesLeft = frame->allTiles();
  // Asked here, since other threads take tiles once the frame is known.
  const bool spawnsNothing = frame->tiles.empty();

  std::vector<EarlyMessage> parked;
  {
    std::lock_guard lock(mutex_);
    frames_[id] = frame;
    const auto waiting = parked_.find(id);
    if (waiting != parked_.end()) {
      parked = std::move(waiting->second);
      parked_.erase(waiting);
    }
  }
  for (EarlyMessage& p :
       parked)  // each in a task of its own, so that a refused one does not keep others back
    tasks_.post([this, id, p = std::make_shared<EarlyMessage>(std::move(p))] {
      if (p->channel == Channel::Rays)
        receiveRays(std::move(p->message));
      else if (p->channel == Channel::Contributions)
        receiveContributions(std::move(p->message));
      else
        cancel(id);
    });
  if (spawnsNothing) return completion_.spawned(id);
  tasks_.queue().addTiles(frame->request.priority, id, std::make_shared<Tiles>(*this, frame));
  if (frame->cancelled) dropTiles(frame);
  tasks_.start();
}

void Renderer::cancel(FrameId id) {
  FramePtr frame;
  {
    std::lock_guard lock(mutex_);
    if (isOver(id)) return;
    frame = find(id);
    if (!frame) return parked_[id].push_back({Channel::Frame, {}, nullptr, {}});
    frame->cancel();
  }
  dropTiles(frame);
}

void Renderer::finish(FrameId id, bool hasPicture) {
  FramePtr frame;
  {
    std::lock_guard lock(mutex_);
    frame = find(id);
    if (!frame) throw Error("frame " + std::to_string(id) + " was said to be finished, but is not under way");
    frames_.erase(id);
    over_.insert(id);
    while (over_.erase(firstNotOver_)) firstNotOver_++;
  }
  if (options_.trace) options_.trace->addLong("frame", id, frame->begin);
  if (frame->owner != transport_.rank()) return;
  std::function<void()> task = [this, frame, hasPicture] { deliver(frame, hasPicture); };
  if (frame->request.priority.interactive) return tasks_.push(frame->request.priority, id, std::move(task));
  handOuts_.push(frame->request.priority, id, std::move(task));
}

void Renderer::deliver(const FramePtr& frame, bool hasPicture) {
  // Rank 0 is told even if there is no memory for the picture or the handler throws, because the frame is
  // over.
  std::string error;
  const std::shared_ptr<void> tell(nullptr, [&](void*) {
    Writer w;
    transport_.send(0, Channel::Frame, w.write(FrameMessage::Delivered).write(frame->id).write(error).take());
  });
  const PictureOperationPtr& operation = frame->request.operation;
  PictureHandler handler;
  {
    std::lock_guard lock(mutex_);
    handler = pictureHandler_;
    const bool wanted = operation ? operationReader_ != nullptr : handler != nullptr;
    if (!wanted || !hasPicture) return;
    counters_.pixelsSkipped += frame->framebuffer->pixelsLeft();
  }
  const Trace::Span span(options_.trace, "picture", frame->id);
  try {
    Picture picture = frame->request.sums ? frame->framebuffer->takeSums()
                                          : frame->framebuffer->picture(frame->scene.compiled->settings,
                                                                        frame->request.priority.interactive);
    frame->framebuffer->release();
    const LedgerEntry memory = frame->account().picture.another(int64_t(picture.bytes()));
    if (operation)
      operation->run(std::move(picture));
    else
      handler(frame->id, frame->request, std::move(picture));
  } catch (const std::exception& e) {
    error = "rank " + std::to_string(transport_.rank()) + ": " + textOf(e);
    throw;
  }
}

Renderer::FramePtr Renderer::find(FrameId id) const {
  const auto it = frames_.find(id);
  return it == frames_.end() ? nullptr : it->second;
}

// Returns the frame of a message. If it has not started, the message is taken and kept until then, and null
// is returned.
Renderer::FramePtr Renderer::findOrPark(FrameId id, Channel channel, Bytes& message) {
  std::lock_guard lock(mutex_);
  if (isOver(id)) throw Error("a message came for frame " + std::to_string(id) + ", which is over");
  FramePtr frame = find(id);
  if (!frame) {
    std::shared_ptr<Completion::Active> active;
    if (channel == Channel::Rays) active = std::make_shared<Completion::Active>(completion_, id);
    LedgerEntry memory = parkedMemory_.another(int64_t(message.size()));
    parked_[id].push_back({channel, std::move(message), std::move(active), std::move(memory)});
  }
  return frame;
}

}  // namespace gxy
