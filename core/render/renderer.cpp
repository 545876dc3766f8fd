// SPDX-License-Identifier: Apache-2.0
// The life of frames: asked for, prepared, superseded, delivered. renderer_rays.cpp has what is done with their
// rays, renderer_pictures.cpp what becomes of their pictures, and Flights what is the same for all items.
#include "core/render/renderer.h"

#include "core/comm/error.h"
#include "core/comm/wire.h"
#include "core/render/renderer_state.h"

namespace gxy {

namespace {

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

FlightControl::Options flightsOf(const Renderer::Options& options) {
  FlightControl::Options flights;
  flights.channels = {Channel::Frame, Channel::Rays, Channel::Credits};
  flights.words = {"frame", "rays", "tile"};
  flights.tasks.queue = {options.raysInFlight, options.urgentWork};
  flights.tasks.most = options.runners;
  flights.tasks.processorTime = options.processorTime;
  flights.ledger = options.ledger;
  flights.tenant = options.tenant;
  flights.trace = options.trace;
  return flights;
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
      options_(std::move(options)),
      account_(options_, options_.tenant),
      handOuts_(transport, {{}, options_.handOuts, true, options_.processorTime}),
      admission_(options_.framebufferBytes * transport.size(), 1 + size_t(transport.size())),
      flights_(
          transport, flightsOf(options_), [this](FrameId id, Reader& in) { return readFrame(id, in); },
          [this](FrameId id, Reader& in) {
            const std::string error = in.readString();
            in.expectEnd();
            delivered(id, error);
          }) {
  if (options_.packetRays < 16)
    throw Error("packets of " + std::to_string(options_.packetRays) + " rays, expected >= 16");
  if (options_.raysInFlight < 1) throw Error("the number of rays in flight must be >= 1");
  if (options_.ranksPerPart < 1) throw Error("the number of ranks for a part of a picture must be >= 1");
  transport_.onMessage(Channel::Contributions,
                       [this](int source, Bytes m) { receivePixels(source, std::move(m)); });
}

Renderer::~Renderer() {
  transport_.onMessage(Channel::Contributions, {});
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
  const FlightControl::Counters flights = flights_.counters();
  c.trace.raysRetired += flights.itemsDropped;
  c.raysForwarded = flights.itemsForwarded;
  c.rayBytes = flights.bytesForwarded;
  c.rayMessages = flights.messagesForwarded;
  c.messagesSkipped += flights.creditsSkipped;
  c.completionWaves = flights.waves;
  c.mostRaysInFlight = flights.mostCredits;
  c.mostFramebuffers = framebuffers_->most;
  return c;
}

Renderer::ResourceCounts Renderer::kept() const {
  const FlightControl::Kept flights = flights_.kept();
  ResourceCounts kept;
  kept.frames = flights.flights;
  kept.parkedMessages = flights.parkedMessages;
  kept.completionSets = flights.completionSets;
  kept.tasks = flights.tasks + handOuts_.queue().size();
  kept.credits = flights.credits;
  kept.tenantCredits = flights.tenantCredits;
  std::lock_guard lock(mutex_);
  kept.callbacks = pending_.size();
  kept.windows = windows_.size();
  kept.pictures = collecting_.size();
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
    id = flights_.announce();
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
  Writer w;
  writeRequest(w, request);
  w.write(operationBytes(request.operation));
  flights_.begin(std::make_shared<Frame>(*this, id, request), w.take(),
                 [this, id](const FlightEnding& ending) { complete(id, ending); });
}

// The other ranks: what beginFrame() has written.
Renderer::FramePtr Renderer::readFrame(FrameId id, Reader& in) {
  FrameRequest request = readRequest(in);
  Bytes operation = in.readVector<std::byte>();
  validate(request.camera);
  auto frame = std::make_shared<Frame>(*this, id, std::move(request));
  frame->operation = std::move(operation);
  return frame;
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
    if (it == pending_.end()) return;
    request.swap(it->second.waiting);
    if (request) admission_.beginAnyway(id);
  }
  flights_.cancel(id);
  if (request) beginFrame(id, *request);
}

// Rank 0: called once, when all work of a frame is done.
void Renderer::complete(FrameId id, const FlightEnding& ending) {
  std::lock_guard lock(mutex_);
  pending_.at(id).ending = Ending{ending.cancelled, ending.error};
}

void Renderer::delivered(FrameId id, const std::string& error) {
  Pending pending;
  std::vector<FrameId> next;
  {
    std::lock_guard lock(mutex_);
    const auto it = pending_.find(id);
    if (it == pending_.end() || !it->second.ending)
      throw Error("frame " + std::to_string(id) + " was said to be delivered, but is not under way");
    pending = std::move(it->second);
    pending_.erase(it);
    if (pending.ending->error.empty()) pending.ending->error = error;
    const auto window = windows_.find(pending.window);
    if (window != windows_.end() && window->second == id) windows_.erase(window);
    next = admission_.over(id);
  }
  if (pending.finished)
    flights_.tasks().push(
        pending.priority, id,
        [finished = std::move(pending.finished), id, ending = std::move(*pending.ending)] {
          finished(id, ending);
        },
        true);
  beginWaiting(next);
}

// Makes what this rank needs for a frame besides the request.
void Renderer::prepare(Frame& frame) {
  const FrameRequest& request = frame.request;
  const Bytes operation = std::exchange(frame.operation, {});
  if (frame.ownsPicture() && !operation.empty()) {
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
  if (frame.part) {
    auto hold = [entry = &frame.account().framebuffer, all = framebuffers_](int64_t bytes) {
      all->more();
      return std::shared_ptr<void>(new LedgerEntry(entry->another(bytes)), [all](LedgerEntry* held) {
        delete held;
        all->now--;
      });
    };
    frame.framebuffer = std::make_unique<Framebuffer>(frame.parts.size(), frame.parts.rows(*frame.part),
                                                      compiled.samples, compiled.depth, std::move(hold));
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
  if (frame.part && frame.parts.count() > 1) collecting_[frame.id] = frame.shared_from_this();
}

}  // namespace gxy
