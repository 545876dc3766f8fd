// SPDX-License-Identifier: Apache-2.0
// The life of a window's frames: begun, at once or when the one before lets it, rendered stage by stage, ended.
#include <algorithm>
#include <cstring>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "multiserver/modules/viewer/window_frame.h"
#include "multiserver/protocol/json.h"
#include "multiserver/rendering/cost.h"

namespace gxy::viewer {

using nlohmann::json;
using protocol::PixelHeader;
using protocol::PixelKind;

namespace {

double secondsSince(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

bool isWanted(const Asker& asker) {
  try {
    asker.check();
    return true;
  } catch (const Error&) {
    return false;
  }
}

// The end of a pass or a frame.
Bytes endRecord(PixelHeader header, PixelKind kind, const std::string& data = {}) {
  header.kind = kind;
  header.x = header.y = header.w = header.h = 0;
  header.encoding = protocol::PixelEncoding::Raw;
  header.format = protocol::PixelFormat::Rgba8;
  return protocol::pixelRecord(header, protocol::bytesOf(data));
}

}  // namespace

uint64_t Window::render(const FrameOptions& options, const Asker& asker) {
  return render(options, asker, {});
}

// 0 where the window would do it by itself and somebody has asked meanwhile: what they want counts.
uint64_t Window::render(const FrameOptions& options, const Asker& asker, std::optional<Since> byItself) {
  Snapshot snapshot = takeSnapshot();
  const FramePtr frame = frameOf(options, snapshot);
  if (!byItself) {
    // If the frame is refused from here on, it is for a reason that may change: the data, or how much room
    // there is.
    const std::lock_guard lock(mutex_);
    asked_++;
    lastOptions_ = options;
  }
  compile(*frame, snapshot, asker);
  takeRoom(*frame);
  return enter(frame, std::move(snapshot), byItself);
}

Window::Snapshot Window::takeSnapshot() {
  const std::lock_guard lock(mutex_);
  if (!hasVisualization_)
    throw Error("window " + std::to_string(id_) +
                ": it shows nothing yet, expected a `set` with a Visualization");
  Snapshot snapshot{state_,   shown_,           state_.cameras[0], scene_, std::exchange(edited_, nullptr),
                    updates_, view_ != nullptr, content_};
  snapshot.camera.dimensions = settings_.size;
  return snapshot;
}

// Throws Error for what no client may ask for.
Window::FramePtr Window::frameOf(const FrameOptions& options, const Snapshot& snapshot) const {
  auto frame = std::make_shared<Frame>();
  frame->options = options;
  frame->camera = snapshot.camera;
  validate(frame->camera);
  RenderSettings settings = snapshot.state.settings;
  frame->samples = options.rays ? int(options.rays) : settings.raysPerPixel;
  settings.raysPerPixel = frame->samples;
  checkCost(settings, frame->camera.dimensions);
  constexpr int64_t kSamples = 65536;  // that a ray can name
  if (int64_t(options.passes) * frame->samples > kSamples)
    throw Error("render: " + std::to_string(options.passes) + " passes of " + std::to_string(frame->samples) +
                " rays per pixel, expected at most " + std::to_string(kSamples) + " rays");
  frame->background = snapshot.state.settings;
  return frame;
}

// What a graph keeps is not pinned as well: its publisher would not get its room back when the graph adopts it.
void Window::keep(Frame& frame, std::vector<Pin> pins, bool ofGraph, const ViewContent& content) {
  frame.pins.clear();
  frame.given = ofGraph ? content.data : SceneCache::GivenData();
  frame.revision = ofGraph ? content.revision : 0;
  if (!ofGraph) frame.pins = std::move(pins);
}

// Waits for the scene.
void Window::compile(Frame& frame, Snapshot& snapshot, const Asker& asker) {
  const State& state = snapshot.state;
  if (snapshot.ofGraph && !snapshot.content.visualization)
    throw Error("window " + std::to_string(id_) + ": " + snapshot.content.text);
  SceneCache::Pinned pinned;
  try {
    pinned = services_.scenes.get(tenant_, state.visualizations[0], state.settings, asker, snapshot.shown,
                                  snapshot.scene, nullptr, snapshot.given());
  } catch (const Error&) {
    // A client that has cancelled the making of an edited scene makes the next edit. That scene, too, can
    // take over parts of the scene before the edits, so that one is put back. After another error, such as a
    // lack of room, it is given up, because the room is needed.
    const bool wanted = isWanted(asker);
    const std::lock_guard lock(mutex_);
    if (!wanted && !scene_ && !edited_ && updates_ == snapshot.updates) edited_ = std::move(snapshot.edited);
    throw;
  }
  snapshot.edited = nullptr;
  snapshot.scene = nullptr;
  frame.scene = std::move(pinned.scene);
  keep(frame, std::move(pinned.pins), snapshot.ofGraph, snapshot.content);
  frame.camera = fitted(frame.camera, snapshot.shown.box);
  // Kept for the next frame, also where this one is refused, unless the state or the data have changed since.
  const std::lock_guard lock(mutex_);
  if (state_ == state && updates_ == snapshot.updates) scene_ = frame.scene;
  if (state_.visualizations == state.visualizations) shown_ = snapshot.shown;
}

void Window::takeRoom(Frame& frame) const {
  ServerRank& serverRank = services_.serverRank;
  const int64_t pixels = int64_t(frame.camera.dimensions.x) * frame.camera.dimensions.y;
  if (frame.options.passes > 1) frame.sumMemory = serverRank.takeMemory(tenant_, "passes", pixels * 64);
  frame.slot = serverRank.tenants.begin(tenant_, serverRank.costOf(tenant_, frame.camera.dimensions));
}

// The frame begins, or waits.
uint64_t Window::enter(const FramePtr& frame, Snapshot snapshot, std::optional<Since> byItself) {
  FramePtr older, skipped;
  bool waits = false;
  {
    const std::lock_guard lock(mutex_);
    if (phase_ == Phase::Closed) throw Error("window " + std::to_string(id_) + ": it is closed");
    if (byItself && (byItself->asked != asked_ || byItself->frames != frames_)) return 0;
    frame->number = ++frames_;
    unfinished_++;
    update_.refusal.clear();
    update_.due = updates_ != snapshot.updates;
    skipped = std::exchange(waiting_, nullptr);
    waits = frame->options.wait && (phase_ == Phase::Rendering || phase_ == Phase::Sending);
    if (waits) {
      frame->state = std::move(snapshot.state);
      waiting_ = frame;
    } else {
      older = makeCurrent(frame);
    }
  }
  if (skipped) finish(skipped, "superseded", {});
  if (!waits) {
    supersede(older);
    begin(frame);
  }
  return frame->number;
}

// Returns the frame that it supersedes; null: none. With the lock held.
Window::FramePtr Window::makeCurrent(const FramePtr& frame) {
  FramePtr older = std::exchange(current_, frame);
  if (older) older->over = "superseded";
  phase_ = Phase::Rendering;
  outbox_->dropTiles(id_);
  return older;
}

void Window::supersede(const FramePtr& older) {
  if (!older) return;
  std::unique_lock lock(mutex_);
  const FrameId rendering = older->rendering;
  lock.unlock();
  services_.serverRank.renderer.supersede(rendering);
}

void Window::begin(const FramePtr& frame) {
  {
    const std::lock_guard lock(mutex_);
    frame->begin = std::chrono::steady_clock::now();
  }
  startStage(frame);
}

void Window::onFirstPassSent(uint64_t number) {
  {
    const std::lock_guard lock(mutex_);
    if (phase_ != Phase::Sending || sending_ != number) return;
    phase_ = current_ ? Phase::Refining : Phase::Idle;
  }
  beginWaiting();
}

// If its time has come.
void Window::beginWaiting() {
  FramePtr frame, older;
  bool newData = false;
  {
    const std::lock_guard lock(mutex_);
    if (!waiting_ || phase_ == Phase::Rendering || phase_ == Phase::Sending) return;
    frame = std::exchange(waiting_, nullptr);
    older = makeCurrent(frame);
    newData = frame->scene == nullptr;
    if (!newData) frame->state = {};
  }
  supersede(older);
  if (!newData) return begin(frame);
  services_.serverRank.transport.postWaiting(
      [self = shared_from_this(), frame] { self->beginWithNewData(frame); });
}

// Its data were updated while it waited. Compiles, so on a thread that may wait.
void Window::beginWithNewData(const FramePtr& frame) {
  uint64_t updates = 0;
  ShownSoFar shown;
  bool ofGraph = false;
  ViewContent content;
  {
    const std::lock_guard lock(mutex_);
    updates = updates_;
    shown = shown_;
    ofGraph = view_ != nullptr;
    content = content_;
    if (ofGraph) frame->state = state_;  // What operators there are changes with the data.
  }
  Asker asker;
  asker.check = [&] {
    const std::lock_guard lock(mutex_);
    if (frame->over) throw Error(frame->over);
  };
  try {
    if (ofGraph && !content.visualization) throw Error(content.text);
    SceneCache::Pinned pinned =
        services_.scenes.get(tenant_, frame->state.visualizations[0], frame->state.settings, asker, shown,
                             nullptr, nullptr, ofGraph ? &content.data : nullptr);
    const std::lock_guard lock(mutex_);
    if (state_.visualizations == frame->state.visualizations) shown_ = shown;
    if (Camera camera = frame->state.cameras[0]; camera.fit) {
      camera.dimensions = frame->camera.dimensions;
      frame->camera = fitted(camera, shown.box);
    }
    frame->scene = std::move(pinned.scene);
    keep(*frame, std::move(pinned.pins), ofGraph, content);
    if (updates_ == updates && state_.visualizations == frame->state.visualizations &&
        state_.settings == frame->state.settings)
      scene_ = frame->scene;
    update_.due = updates_ != updates;
    frame->state = {};
  } catch (const Error& e) {
    const char* over = nullptr;
    {
      const std::lock_guard lock(mutex_);
      over = frame->over;
      update_.due = update_.due || !over;
    }
    return finish(frame, over ? over : "failed", e.what());
  }
  begin(frame);
}

void Window::startStage(const FramePtr& frame) {
  FrameRequest request;
  PictureFormat wanted;
  {
    const std::lock_guard lock(mutex_);
    const PixelHeader header = frame->header(id_);
    request.scene = frame->scene->id;
    request.camera = frame->camera;
    request.camera.dimensions = {int(header.width), int(header.height)};
    request.samples = frame->samples;
    request.firstSample = int32_t(frame->pass) * frame->samples;
    // Somebody waits for a level's first pass. Further ones, of which there may be thousands, are like a batch's pictures.
    request.priority = {services_.serverRank.tenants.number(tenant_), frame->pass == 0, stream_};
    request.account = tenant_;
    wanted.encoding = frame->options.encoding;
    wanted.quality = frame->options.quality;
    wanted.tile = frame->options.tile;
    if (frame->last() && frame->options.passes > 1) wanted.as = PictureFormat::As::Sums;
  }
  PictureReceiver receiver;
  const auto self = shared_from_this();
  receiver.tile = [self, frame](Bytes record) { self->onTile(frame, std::move(record)); };
  receiver.sums = [self, frame](Picture picture) { self->onSums(frame, std::move(picture)); };
  receiver.done = [self, frame](bool superseded, const std::string& error) {
    self->onStage(frame, superseded, error);
  };
  FrameId id = 0;
  try {
    id = services_.pictures.start(request, wanted, std::move(receiver));
  } catch (const std::exception& e) {
    return finish(frame, "failed", e.what());
  }
  std::unique_lock lock(mutex_);
  frame->rendering = std::max(frame->rendering, id);  // a later stage may have begun meanwhile
  const bool over = frame->over;
  lock.unlock();
  if (over) services_.serverRank.renderer.supersede(id);
}

void Window::onTile(const FramePtr& frame, Bytes record) {
  const std::lock_guard lock(mutex_);
  if (frame->over) return;
  PixelHeader header = protocol::pixelHeader(record);
  const PixelHeader ours = frame->header(id_);
  header.window = ours.window;
  header.frame = ours.frame;
  header.scale = ours.scale;
  header.pass = ours.pass;
  std::memcpy(record.data(), &header, sizeof header);
  if (!outbox_->pixels(std::move(record))) frame->dropped = true;
}

void Window::onSums(const FramePtr& frame, Picture picture) {
  const std::lock_guard lock(mutex_);
  frame->arrived = std::move(picture);
}

// A level or pass has been rendered, and its tiles are in the outbox or its sums have arrived.
void Window::onStage(const FramePtr& frame, bool superseded, const std::string& error) {
  std::unique_lock lock(mutex_);
  if (!frame->over && !superseded && error.empty() && !frame->arrived.sums.empty()) {
    lock.unlock();
    addPass(frame);
    lock.lock();
  }
  if (frame->over || superseded) {
    const char* const status = frame->over ? frame->over : "superseded";
    const std::string why = frame->why;
    lock.unlock();
    return finish(frame, status, why);
  }
  if (!error.empty()) {
    lock.unlock();
    return finish(frame, "failed", error);
  }
  sendEndOfPass(frame);
  bool more = true;
  if (!frame->last()) {
    frame->level++;
  } else {
    frame->passesSent++;
    more = ++frame->pass < frame->options.passes;
    if (more) endRefinement();
  }
  const char* const over = frame->over;
  const std::string why = frame->why;
  const bool dropped = frame->dropped;
  lock.unlock();
  if (dropped) return finish(frame, "failed", "too many pixels wait to be read: tiles were left out");
  if (over) return finish(frame, over, why);
  if (more) return startStage(frame);
  finish(frame, "complete", {});
}

// Puts the tiles of the mean of all passes so far into the outbox. Between stages, so nobody else uses the sums.
void Window::addPass(const FramePtr& frame) {
  Picture pass = std::exchange(frame->arrived, {});
  Picture& sum = frame->sum;
  if (frame->pass == 0)
    sum = std::move(pass);
  else
    parallelFor(size_t(0), sum.sums.size() / 4, [&](size_t i) {
      for (size_t k = 4 * i; k < 4 * i + 4; k++) sum.sums[k] += pass.sums[k];
    });
  const Picture mean{
      sum.width, sum.height,
      pixelsOf(sum.sums, frame->samples * int(frame->pass + 1), frame->background, {sum.width, sum.height})};
  for (Bytes& tile :
       tilesOfPicture(mean, frame->options.encoding, frame->options.quality, frame->options.tile))
    onTile(frame, std::move(tile));
}

// With the lock held.
void Window::sendEndOfPass(const FramePtr& frame) {
  std::function<void()> sent;
  if (phase_ == Phase::Rendering) {
    phase_ = Phase::Sending;
    sending_ = frame->number;
    sent = [self = shared_from_this(), number = frame->number] {
      self->services_.serverRank.transport.post([self, number] { self->onFirstPassSent(number); });
    };
  }
  outbox_->pixels(endRecord(frame->header(id_), PixelKind::EndOfPass,
                            protocol::dump({{"seconds", secondsSince(frame->begin)},
                                            {"generations", frame->generations()}})),
                  std::move(sent));
}

void Window::finish(const FramePtr& frame, const char* status, const std::string& error) {
  PixelHeader header;
  header.window = id_;
  header.frame = frame->number;
  header.width = uint32_t(frame->camera.dimensions.x);
  header.height = uint32_t(frame->camera.dimensions.y);
  json end{{"status", status},
           {"generations", frame->generations()},
           {"passes", frame->passesSent},
           {"seconds", secondsSince(frame->begin)}};
  if (std::string_view(status) == "failed") end["error"] = error;
  if (frame->revision > 0) end["revision"] = frame->revision;
  // Whoever is told that it has ended finds its room free.
  frame->pins.clear();
  frame->given.clear();
  frame->sum = {};
  frame->sumMemory = {};
  frame->slot = {};
  outbox_->pixels(endRecord(header, PixelKind::EndOfFrame, protocol::dump(end)));
  ScenePtr scene;  // outside the lock
  bool again = false;
  {
    const std::lock_guard lock(mutex_);
    scene = std::exchange(frame->scene, nullptr);
    if (current_ == frame) {
      current_ = nullptr;
      if (phase_ == Phase::Rendering || phase_ == Phase::Refining) phase_ = Phase::Idle;
    }
    if (!current_ && !waiting_)  // after a frame that was cancelled too
      again = update_.due && settings_.follow && phase_ != Phase::Closed;
    unfinished_--;
    ended_.notify_all();
  }
  if (again) renderNewData();
  beginWaiting();
  scene = nullptr;
  services_.retries.onEnd(tenant_);
}

}  // namespace gxy::viewer
