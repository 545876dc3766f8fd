// SPDX-License-Identifier: Apache-2.0
// What a window shows, and what makes it show something else. Its frames are in window_frames.cpp.
#include "multiserver/modules/viewer/window.h"

#include <algorithm>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/scene/camera.h"
#include "multiserver/modules/viewer/window_frame.h"

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
  FrameId refined = 0;
  bool again = false;
  {
    const std::lock_guard lock(mutex_);
    settings_ = settings;
    refined = endRefinement();
    again = stale_ && settings_.follow && !current_ && !waiting_;
  }
  if (refined) services_.node.renderer.supersede(refined);
  if (again) renderAgain();
}

void Window::setVisualization(const Visualization& visualization, LedgerEntry memory) {
  const std::lock_guard lock(mutex_);
  state_.visualizations[0] = visualization;
  shown_ = {};
  stateMemory_ = std::move(memory);
  hasVisualization_ = true;
  forgetScene();
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
  {
    const std::lock_guard lock(mutex_);
    now.visualizations = state_.visualizations;
    now.cameras = {camera.value_or(state_.cameras[0])};
    now.cameras[0].dimensions = settings_.size;
    shown = shown_;
  }
  services_.scenes.widen(tenant_, now.visualizations[0], shown);
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
  {
    const std::lock_guard lock(mutex_);
    known = scene_;
    shown = shown_;
  }
  const State shows = state();
  if (shows.visualizations.empty())
    throw Error("window " + std::to_string(id_) +
                ": it shows nothing yet, expected a `set` with a Visualization");
  validate(shows.cameras[0]);
  SceneCache::Pinned pinned =
      services_.scenes.get(tenant_, shows.visualizations[0], shows.settings, asker, shown, known);
  return {std::move(pinned), shows.visualizations[0], fitted(shows.cameras[0], shown.box)};
}

uint64_t Window::lastFrame() const {
  const std::lock_guard lock(mutex_);
  return frames_;
}

void Window::cancel() {
  FramePtr frame, waiting;
  FrameId rendering = 0;
  {
    const std::lock_guard lock(mutex_);
    frame = std::exchange(current_, nullptr);
    waiting = std::exchange(waiting_, nullptr);
    inOutbox_ = 0;
    if (frame) frame->over = "cancelled", rendering = frame->rendering;
    outbox_->dropTiles(id_);
  }
  if (frame) services_.node.renderer.supersede(rendering);
  if (waiting) finish(waiting, "cancelled", {});
}

void Window::endFrames() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  cancel();
}

void Window::close() {
  endFrames();
  std::unique_lock lock(mutex_);
  ended_.wait(lock, [this] { return underWay_ == 0; });
  scene_ = nullptr;
  edited_ = nullptr;
}

void Window::onData(const DatasetEvent& event) {
  using Kind = DatasetEvent::Kind;
  if (event.kind == Kind::Skipped) return;
  Datasets& datasets = *services_.node.datasets;
  ScenePtr released, edited, waitings;  // outside the lock
  std::vector<Pin> pins;
  FrameId refined = 0;
  bool again = false;
  const auto update = [&] {
    const std::lock_guard lock(mutex_);
    if (event.kind == Kind::Dropped && current_ && current_->scene &&
        current_->scene->find(event.dataset.key) &&
        !services_.scenes.namesMean(tenant_, current_->scene->data)) {
      current_->why = "dataset " + inQuotes(event.dataset.name) + " was dropped: it is refined no further";
      refined = endRefinement();
    }
    const auto& operators = state_.visualizations[0].operators;
    const auto shows = [&](const std::string& name) {
      return std::any_of(operators.begin(), operators.end(),
                         [&](const Vis& vis) { return vis.dataset == name; });
    };
    if (!shows(event.dataset.name) && !(event.kind == Kind::Renamed && shows(event.newName))) return;
    // Names of others, or hidden by its own, or the same object in another directory.
    const auto means = datasets.find(tenant_, event.dataset.name);
    const bool came = event.kind == Kind::Added || event.kind == Kind::Updated;
    if (came && !(means && means->key == event.dataset.key)) return;
    if (event.kind != Kind::Updated && scene_ && services_.scenes.namesMean(tenant_, scene_->data)) return;
    released = std::exchange(scene_, nullptr);
    edited = std::exchange(edited_, nullptr);
    // A dataset in whose place another one comes is dropped first; one that was hidden by it is there at once.
    const bool there = std::all_of(operators.begin(), operators.end(), [&](const Vis& vis) {
      const auto now = datasets.find(tenant_, vis.dataset);
      const bool inItsPlace = event.kind == Kind::Dropped && vis.dataset == event.dataset.name;
      return now && !(inItsPlace && now->scope == event.dataset.scope);
    });
    if (!there) return;
    updates_++;
    if (waiting_) {
      waitings = std::exchange(waiting_->scene, nullptr);
      pins.swap(waiting_->pins);
      return;
    }
    if (asked_ == 0 || closed_) return;
    stale_ = current_ || !settings_.follow;
    refined = endRefinement();
    again = !stale_;
  };
  update();
  if (refined) services_.node.renderer.supersede(refined);
  if (again) renderAgain();
}

void Window::onWanted(Key key, Generation generation) {
  ScenePtr scene;  // outside the lock
  std::vector<Pin> pins;
  FrameId refined = 0;
  {
    const std::lock_guard lock(mutex_);
    if (waiting_ && waiting_->scene && waiting_->scene->find(key, generation)) {
      scene = std::exchange(waiting_->scene, nullptr);
      pins.swap(waiting_->pins);
    }
    const NamedDataset* const shown =
        current_ && current_->scene ? current_->scene->find(key, generation) : nullptr;
    if (!shown) return;
    current_->why = "dataset " + inQuotes(shown->name) + ": another update needs the room of generation " +
                    std::to_string(generation) + ", which is shown: it is refined no further";
    refined = endRefinement();
    if (!current_->over && shown->owner != tenant_ &&
        std::chrono::steady_clock::now() - current_->begin > services_.node.options.longestHold) {
      current_->over = "failed";
      refined = current_->rendering;
    }
  }
  if (refined) services_.node.renderer.supersede(refined);
}

// Of the frame under way, if it is whole and there is a reason: what it is over with. With the lock held. The rendering that
// is to be superseded then; 0: none.
FrameId Window::endRefinement() {
  if (!current_ || current_->over || !current_->whole()) return 0;
  if (stale_ && settings_.follow)
    current_->over = "superseded";
  else if (!current_->why.empty())
    current_->over = "failed";
  else
    return 0;
  return current_->rendering;
}

void Window::onDrained() {
  {
    const std::lock_guard lock(mutex_);
    drains_ = false;
  }
  tryAgain();
}

void Window::tryAgain() {
  {
    const std::lock_guard lock(mutex_);
    tries_ = false;
    if (!stale_ || !settings_.follow || current_ || waiting_) return;
  }
  renderAgain();
}

// Compiles, so on a thread that may wait.
void Window::renderAgain() {
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    // Ends of frames are kept for a client that does not read.
    stale_ = drains_ || outbox_->congested([weak = weak_from_this(), &transport = services_.node.transport] {
      transport.post([weak] {
        if (const auto self = weak.lock()) self->onDrained();
      });
    });
    drains_ = stale_;
    if (stale_) return;
    underWay_++;
  }
  services_.node.transport.postWaiting([self = shared_from_this()] {
    const std::shared_ptr<void> leave(nullptr, [&](void*) {
      const std::lock_guard lock(self->mutex_);
      self->underWay_--;
      self->ended_.notify_all();
    });
    FrameOptions options;
    Since since{};
    {
      const std::lock_guard lock(self->mutex_);
      since = {self->asked_, self->frames_};
      options = self->lastOptions_;
      options.wait = true;  // a picture that is on its way to the client gets there
    }
    Asker asker;
    asker.check = [&] {
      const std::lock_guard lock(self->mutex_);
      if (self->closed_) throw Error("window " + std::to_string(self->id_) + ": it is closed");
    };
    try {
      const uint64_t frame = self->render(options, asker, since);
      if (frame == 0) return self->tryAgainUnlessMade(since.frames);
      self->outbox_->event({{"event", "frame"}, {"window", self->id_}, {"frame", frame}, {"reason", "data"}});
    } catch (const Error& e) {
      self->onRefused(since.frames, e.what());
    }
  });
}

// Somebody asked for a frame meanwhile, and may have been refused.
void Window::tryAgainUnlessMade(uint64_t lastFrame) {
  {
    const std::lock_guard lock(mutex_);
    if (frames_ != lastFrame) return;
    stale_ = true;
  }
  tryAgain();
}

// Newer data could not be rendered, for now.
void Window::onRefused(uint64_t lastFrame, const std::string& error) {
  {
    const std::lock_guard lock(mutex_);
    if (closed_ || frames_ != lastFrame) return;  // nobody waits for it
    stale_ = true;
    if (!std::exchange(tries_, true)) services_.retries.add(tenant_, weak_from_this());
    if (told_ == error) return;
    told_ = error;
  }
  outbox_->event({{"event", "error"}, {"window", id_}, {"text", error}});
}

}  // namespace gxy::viewer
