// SPDX-License-Identifier: Apache-2.0
// What a window shows, and what makes it show something else. Its frames are in window_frames.cpp.
#include "multiserver/modules/viewer/window.h"

#include <algorithm>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/scene/camera.h"
#include "multiserver/modules/viewer/window_frame.h"
#include "multiserver/rendering/data_hold.h"

namespace gxy::viewer {

Window::Window(Services& services, std::shared_ptr<Outbox> outbox, std::string tenant, uint32_t id)
    : services_(services),
      outbox_(std::move(outbox)),
      tenant_(std::move(tenant)),
      id_(id),
      stream_(services.rendering->nextStream()) {
  state_.cameras = {defaultCamera()};
  state_.visualizations.resize(1);
}

Window::Settings Window::settings() const {
  const std::lock_guard lock(mutex_);
  return settings_;
}

void Window::setSettings(const Settings& settings) {
  Change change;
  std::shared_ptr<GraphView> view;
  {
    const std::lock_guard lock(mutex_);
    settings_ = settings;
    view = view_;
    wantNews();
    change.ended = endRefinement();
    change.newData = update_.due && settings_.follow && !current_ && !waiting_;
  }
  if (view) view->setFollow(settings.follow);
  carryOut(change);
}

void Window::setVisualization(const Visualization& visualization, LedgerEntry memory) {
  std::shared_ptr<GraphView> view;  // let go of without the lock
  const std::lock_guard lock(mutex_);
  view.swap(view_);
  content_ = {};
  state_.visualizations[0] = visualization;
  shown_ = {};
  stateMemory_ = std::move(memory);
  hasVisualization_ = true;
  forgetScene();
  wantNews();
}

// With the lock held.
void Window::wantNews() {
  wish_ = nullptr;
  if (!settings_.follow || view_ || !hasVisualization_ || phase_ == Phase::Closed) return;
  std::vector<std::string> names;
  for (const Vis& vis : state_.visualizations[0].operators) names.push_back(vis.dataset);
  if (!names.empty()) wish_ = services_.serverRank.datasets->want(tenant_, names);
}

void Window::setRenderer(const RenderSettings& settings) {
  const std::lock_guard lock(mutex_);
  if (!(state_.settings == settings)) forgetScene();
  state_.settings = settings;
}

void Window::forgetScene() {
  if (scene_) edited_ = std::exchange(scene_, nullptr);
}

void Window::setCamera(const Camera& camera) {
  const std::lock_guard lock(mutex_);
  state_.cameras[0] = camera;
}

Window::Seen Window::seen(const std::optional<Camera>& camera) const {
  State now;
  ShownSoFar shown;
  std::optional<SceneCache::GivenData> given;
  {
    const std::lock_guard lock(mutex_);
    if (view_) given = content_.data;
    now.visualizations = state_.visualizations;
    now.cameras = {camera.value_or(state_.cameras[0])};
    now.cameras[0].dimensions = settings_.size;
    shown = shown_;
  }
  services_.scenes.widen(tenant_, now.visualizations[0], shown, given ? &*given : nullptr);
  return {fitted(now.cameras[0], shown.box), std::move(shown)};
}

State Window::state() const {
  const std::lock_guard lock(mutex_);
  State state = state_;
  state.cameras[0].dimensions = settings_.size;
  if (!hasVisualization_) state.visualizations.clear();
  return state;
}

Window::View Window::view(const Asker& asker) const {
  ScenePtr known;
  ShownSoFar shown;
  std::optional<SceneCache::GivenData> given;
  {
    const std::lock_guard lock(mutex_);
    known = scene_;
    shown = shown_;
    if (view_) given = content_.data;
  }
  const State shows = state();
  if (shows.visualizations.empty())
    throw Error("window " + std::to_string(id_) +
                ": it shows nothing yet, expected a `set` with a Visualization");
  validate(shows.cameras[0]);
  SceneCache::Pinned pinned = services_.scenes.get(tenant_, shows.visualizations[0], shows.settings, asker,
                                                   shown, known, nullptr, given ? &*given : nullptr);
  return {std::move(pinned), shows.visualizations[0], fitted(shows.cameras[0], shown.box)};
}

uint64_t Window::lastFrame() const {
  const std::lock_guard lock(mutex_);
  return frames_;
}

void Window::cancel() { end(Phase::Idle); }

void Window::endFrames() { end(Phase::Closed); }

void Window::end(Phase after) {
  FramePtr frame, waiting;
  {
    const std::lock_guard lock(mutex_);
    frame = std::exchange(current_, nullptr);
    waiting = std::exchange(waiting_, nullptr);
    if (phase_ != Phase::Closed) phase_ = after;
    wantNews();
    if (frame) frame->over = "cancelled";
    outbox_->dropTiles(id_);
  }
  supersede(frame);
  if (waiting) finish(waiting, "cancelled", {});
}

void Window::close() {
  endFrames();
  std::unique_lock lock(mutex_);
  ended_.wait(lock, [this] { return unfinished_ == 0; });
  scene_ = nullptr;
  edited_ = nullptr;
  const std::shared_ptr<GraphView> view = std::exchange(view_, nullptr);
  content_ = {};
  lock.unlock();  // before the view goes
}

void Window::onData(const DatasetEvent& event) {
  if (event.kind == DatasetEvent::Kind::Skipped) return;
  const Change change = changeBy(event);
  carryOut(change);
}

void Window::carryOut(const Change& change) {
  if (change.ended) services_.serverRank.renderer.supersede(change.ended);
  if (change.newData) renderNewData();
}

Window::Change Window::changeBy(const DatasetEvent& event) {
  Change change;
  const std::lock_guard lock(mutex_);
  if (view_) return change;
  if (event.kind == DatasetEvent::Kind::Dropped && current_ && current_->scene &&
      current_->scene->find(event.dataset.key) &&
      !services_.scenes.namesMean(tenant_, current_->scene->data)) {
    current_->why = "dataset " + inQuotes(event.dataset.name) + " was dropped: it is refined no further";
    change.ended = endRefinement();
  }
  if (!concerns(event)) return change;
  change.scenes = {std::exchange(scene_, nullptr), std::exchange(edited_, nullptr)};
  if (!allThereAfter(event)) return change;
  updates_++;
  if (waiting_) {
    change.scenes.push_back(std::exchange(waiting_->scene, nullptr));
    change.pins.swap(waiting_->pins);
    return change;
  }
  if (asked_ == 0 || phase_ == Phase::Closed) return change;
  // If the window follows and is idle, carryOut() calls renderNewData() at once, so the update is not due
  // later.
  update_.due = current_ || !settings_.follow;
  if (const FrameId refined = endRefinement()) change.ended = refined;
  change.newData = !update_.due;
  return change;
}

// Whether names that the window shows mean something else, or newer data, since the event. With the lock held.
bool Window::concerns(const DatasetEvent& event) const {
  using Kind = DatasetEvent::Kind;
  const auto& operators = state_.visualizations[0].operators;
  const auto shows = [&](const std::string& name) {
    return std::any_of(operators.begin(), operators.end(),
                       [&](const Vis& vis) { return vis.dataset == name; });
  };
  if (!shows(event.dataset.name) && !(event.kind == Kind::Renamed && shows(event.newName))) return false;
  // Names of others, or hidden by its own, or the same object in another directory.
  const auto means = services_.serverRank.datasets->find(tenant_, event.dataset.name);
  const bool came = event.kind == Kind::Added || event.kind == Kind::Updated;
  if (came && !(means && means->key == event.dataset.key)) return false;
  return event.kind == Kind::Updated || !scene_ || !services_.scenes.namesMean(tenant_, scene_->data);
}

// Whether there are datasets of all names that the window shows. Where another dataset comes in the place of one, that one is
// dropped first; one that was hidden by it is there at once. With the lock held.
bool Window::allThereAfter(const DatasetEvent& event) const {
  const auto& operators = state_.visualizations[0].operators;
  return std::all_of(operators.begin(), operators.end(), [&](const Vis& vis) {
    const auto now = services_.serverRank.datasets->find(tenant_, vis.dataset);
    const bool inItsPlace = event.kind == DatasetEvent::Kind::Dropped && vis.dataset == event.dataset.name;
    return now && !(inItsPlace && now->scope == event.dataset.scope);
  });
}

void Window::setGraph(std::shared_ptr<Graph> graph, const std::string& view) {
  // The graph calls the window without its own locks, and the window calls the graph without this one.
  auto shown = std::make_shared<GraphView>(std::move(graph), view, [weak = weak_from_this()] {
    if (const auto self = weak.lock()) self->onGraph();
  });
  {
    const std::lock_guard lock(mutex_);
    if (phase_ == Phase::Closed) throw Error("window " + std::to_string(id_) + ": it is closed");
    view_.swap(shown);
    settings_.follow = true;
    content_ = {};
    content_.text = "its data are not there yet";
    state_.visualizations[0] = {};
    shown_ = {};
    stateMemory_ = {};
    hasVisualization_ = true;
    forgetScene();
    wantNews();
  }
  onGraph();
}

// Takes what the view shows now.
void Window::onGraph() {
  std::shared_ptr<GraphView> view;
  {
    const std::lock_guard lock(mutex_);
    view = view_;
  }
  if (!view) return;
  ViewContent content = view->content();
  Change change;
  {
    const std::lock_guard lock(mutex_);
    if (view_ != view || content.serial < content_.serial || phase_ == Phase::Closed) return;
    const Visualization look = content.visualization.value_or(Visualization());
    const bool newLook = !(state_.visualizations[0] == look) || !(state_.settings == content.settings);
    const bool newData = content.data != content_.data;
    const bool newCamera = content.camera && content.camera != content_.camera;
    const bool newText = content.text != content_.text;
    content_ = std::move(content);
    state_.settings = content_.settings;
    if (newCamera) state_.cameras[0] = *content_.camera;
    if (newLook) state_.visualizations[0] = look;
    if (!newLook && !newData && !newCamera && !newText) return;
    if (newData) change.scenes = {std::exchange(scene_, nullptr), std::exchange(edited_, nullptr)};
    forgetScene();
    updates_++;
    if (waiting_) {
      change.scenes.push_back(std::exchange(waiting_->scene, nullptr));
      change.pins.swap(waiting_->pins);
    } else if (asked_ > 0 && content_.visualization) {
      update_.due = current_ || !settings_.follow;
      if (const FrameId refined = endRefinement()) change.ended = refined;
      change.newData = !update_.due;
    }
  }
  carryOut(change);
}

void Window::onWanted(Key key, Generation generation) {
  Change change;
  {
    const std::lock_guard lock(mutex_);
    if (waiting_) {
      change.scenes.push_back(takeIfShown(waiting_->scene, key, generation));
      if (change.scenes.back()) change.pins.swap(waiting_->pins);
    }
    if (!current_) return;
    const DataHold hold = dataHold(current_->scene, key, generation, tenant_, current_->begin);
    if (!hold.dataset) return;
    current_->why = "dataset " + inQuotes(hold.dataset->name) +
                    ": another update needs the room of generation " + std::to_string(generation) +
                    ", which is shown: it is refined no further";
    change.ended = endRefinement();
    if (!current_->over && hold.tooLong) {
      current_->over = "failed";
      change.ended = current_->rendering;
    }
  }
  carryOut(change);
}

// Ends the frame under way if it has a picture of all pixels and there is a reason to refine it no further. Returns the rendering
// that is to be superseded; 0: none. With the lock held.
FrameId Window::endRefinement() {
  if (!current_ || current_->over || !current_->whole()) return 0;
  if (update_.due && settings_.follow)
    current_->over = "superseded";
  else if (!current_->why.empty())
    current_->over = "failed";
  else
    return 0;
  return current_->rendering;
}

void Window::onBelowWatermark() {
  {
    const std::lock_guard lock(mutex_);
    update_.awaitsOutbox = false;
  }
  tryAgain();
}

void Window::tryAgain() {
  {
    const std::lock_guard lock(mutex_);
    update_.awaitsRoom = false;
    if (!update_.due || !settings_.follow || current_ || waiting_) return;
  }
  renderNewData();
}

// Begins a frame of the newest data, now or when the client has read enough: the ends of frames are kept for one that does not read.
void Window::renderNewData() {
  {
    const std::lock_guard lock(mutex_);
    if (phase_ == Phase::Closed) return;
    const auto drained = [weak = weak_from_this(), &transport = services_.serverRank.transport] {
      transport.post([weak] {
        if (const auto self = weak.lock()) self->onBelowWatermark();
      });
    };
    update_.due = update_.awaitsOutbox || outbox_->aboveWatermark(drained);
    update_.awaitsOutbox = update_.due;
    if (update_.due) return;
    unfinished_++;
  }
  services_.serverRank.transport.postWaiting([self = shared_from_this()] {
    const std::shared_ptr<void> leave(nullptr, [&](void*) {
      const std::lock_guard lock(self->mutex_);
      self->unfinished_--;
      self->ended_.notify_all();
    });
    self->renderByItself();
  });
}

// Compiles the scene, so on a thread that may wait.
void Window::renderByItself() {
  FrameOptions options;
  Since since{};
  {
    const std::lock_guard lock(mutex_);
    since = {asked_, frames_};
    options = lastOptions_;
    options.wait = true;  // a picture that is on its way to the client gets there
  }
  Asker asker;
  asker.check = [&] {
    const std::lock_guard lock(mutex_);
    if (phase_ == Phase::Closed) throw Error("window " + std::to_string(id_) + ": it is closed");
  };
  try {
    const uint64_t frame = render(options, asker, since);
    if (frame == 0) return tryAgainUnlessMade(since.frames);
    outbox_->event({{"event", "frame"}, {"window", id_}, {"frame", frame}, {"reason", "data"}});
  } catch (const Error& e) {
    onRefused(since.frames, e.what());
  }
}

// Somebody asked for a frame meanwhile, and may have been refused.
void Window::tryAgainUnlessMade(uint64_t lastFrame) {
  {
    const std::lock_guard lock(mutex_);
    if (frames_ != lastFrame) return;
    update_.due = true;
  }
  tryAgain();
}

// Newer data could not be rendered, for now.
void Window::onRefused(uint64_t lastFrame, const std::string& error) {
  {
    const std::lock_guard lock(mutex_);
    if (phase_ == Phase::Closed || frames_ != lastFrame) return;  // nobody waits for it
    update_.due = true;
    if (!std::exchange(update_.awaitsRoom, true)) services_.retries.add(tenant_, weak_from_this());
    if (update_.refusal == error) return;
    update_.refusal = error;
  }
  outbox_->event({{"event", "error"}, {"window", id_}, {"text", error}});
}

}  // namespace gxy::viewer
