// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/viewer/batch.h"

#include <chrono>
#include <condition_variable>
#include <cstring>
#include <map>

#include "core/annotate/annotations.h"
#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/scene/picture_name.h"
#include "multiserver/protocol/json.h"
#include "multiserver/rendering/cost.h"
#include "multiserver/rendering/data_hold.h"
#include "multiserver/server/filter_runs.h"

namespace gxy::viewer {

using nlohmann::json;

namespace {

/// What frames of a batch have in common; they hold it.
struct Job {
  std::mutex mutex;
  std::vector<ScenePtr> scenes;  ///< by visualization; null where the next picture is to show newer data
  std::condition_variable changed;
  struct Flight {
    std::weak_ptr<const SceneHandle> scene;
    FrameId id = 0;  ///< once it is known
    std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
  };
  std::map<size_t, Flight> inFlight;  ///< by picture
  /// Has come and is to be sent; counts as the tenant's until then.
  struct Content {
    Bytes picture;
    Tenants::RenderSlot slot;
  };
  std::map<size_t, Content> contents;
  size_t done = 0;
  std::string error;
};

std::string nameOf(const BatchRender& batch, size_t index) {
  return pictureName(batch.prefix, batch.state, index) + "." + batch.format;
}

Bytes fileRecord(const json& header, std::span<const std::byte> content) {
  const std::string text = protocol::dump(header);
  const auto size = uint32_t(text.size());
  Bytes record(sizeof size + text.size() + content.size());
  std::memcpy(record.data(), &size, sizeof size);
  std::memcpy(record.data() + sizeof size, text.data(), text.size());
  std::copy(content.begin(), content.end(), record.begin() + std::ptrdiff_t(sizeof size + text.size()));
  return record;
}

class Run {
 public:
  Run(Services& services, Request& request, const BatchRender& batch)
      : services_(services),
        request_(request),
        batch_(batch),
        total_(batch.state.cameras.size() * batch.state.visualizations.size()),
        stream_(services.rendering->nextStream()) {
    asker_.check = [this] { check(); };
  }

  json run() {
    const auto begin = std::chrono::steady_clock::now();
    constexpr size_t kPictures = 10000;
    if (total_ > kPictures)
      throw Error("batch: " + std::to_string(total_) + " pictures, expected at most " +
                  std::to_string(kPictures));
    for (const Camera& camera : batch_.state.cameras) {
      validate(camera);
      const auto pixels = uint64_t(camera.dimensions.x) * uint64_t(camera.dimensions.y);
      if (pixels > request_.session().limits().pixels)
        throw Error("batch: a picture of " + std::to_string(pixels) + " pixels, expected at most " +
                    std::to_string(request_.session().limits().pixels));
      checkCost(batch_.state.settings, camera.dimensions);
    }
    for (const Visualization& v : batch_.state.visualizations) checkCost(v);
    json names = json::array();
    for (size_t i = 0; i < total_; i++) {
      names.push_back(nameOf(batch_, i));
      if (!batch_.toClient) paths_.push_back(services_.serverRank.folders.toWrite(nameOf(batch_, i)));
    }
    PinnedData pinned;
    std::vector<std::string> warnings = look(pinned);
    pinned.clear();
    const auto wanted = services_.serverRank.observers.subscribe({}, [this](const ObjectEvent& event) {
      if (event.kind == ObjectEvent::Kind::Wanted) letGo(event.key, event.generation);
    });
    const std::shared_ptr<void> end(nullptr, [this](void*) { giveUp(); });
    for (size_t i = 0; i < total_; i++) {
      waitFor([&] { return job_->inFlight.size() < size_t(batch_.concurrent); });
      start(i);
    }
    waitFor([&] { return job_->done == total_; });
    check();  // the last picture, too
    request_.progress(int64_t(total_), int64_t(total_), "rendered");
    return {{"pictures", names},
            {"warnings", std::move(warnings)},
            {"seconds", std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count()},
            {"text", std::to_string(total_) + " pictures"}};
  }

 private:
  // An update needs the room of a generation: pictures under way show it, further ones do not, and where one has long kept
  // another tenant waiting the batch fails.
  void letGo(Key key, Generation generation) {
    std::vector<ScenePtr> gone;  // outside the lock
    const std::lock_guard lock(job_->mutex);
    for (ScenePtr& scene : job_->scenes)
      if (ScenePtr taken = takeIfShown(scene, key, generation)) gone.push_back(std::move(taken));
    for (const auto& [index, flight] : job_->inFlight) {
      const ScenePtr& scene = gone.emplace_back(flight.scene.lock());
      const DataHold hold = dataHold(scene, key, generation, request_.session().tenant(), flight.begin);
      if (!hold.tooLong) continue;
      if (job_->error.empty())
        job_->error = "batch: dataset " + inQuotes(hold.dataset->name) +
                      ": an update needs the room of generation " + std::to_string(generation) +
                      ", of which picture " + std::to_string(index) + " takes too long";
      job_->changed.notify_all();
    }
  }

  void check() {
    request_.check();
    std::string error;
    {
      const std::lock_guard lock(job_->mutex);
      error = job_->error;
    }
    if (!error.empty()) throw Error(error);
  }

  // Meanwhile what has come is sent on.
  template <class Condition>
  void waitFor(const Condition& condition) {
    for (;;) {
      check();
      {
        std::unique_lock lock(job_->mutex);
        job_->changed.wait_for(lock, std::chrono::milliseconds(100), [&] {
          return condition() || !job_->contents.empty() || !job_->error.empty();
        });
      }
      sendWhatHasCome();
      const std::lock_guard lock(job_->mutex);
      if (condition() && job_->contents.empty()) return;
    }
  }

  void sendWhatHasCome() {
    std::map<size_t, Job::Content> contents;
    size_t done;
    {
      const std::lock_guard lock(job_->mutex);
      contents.swap(job_->contents);
      done = job_->done;
    }
    for (auto& [index, content] : contents) {
      const Bytes record =
          fileRecord({{"name", nameOf(batch_, index)}, {"index", index}, {"of", total_}}, content.picture);
      if (!request_.session().outbox().file(request_.id(), record, [this] { return request_.cancelled(); }))
        throw Error("cancelled");
      content = {};
    }
    if (done < total_) request_.progress(int64_t(done), int64_t(total_), "rendered");
  }

  const Visualization& visualizationOf(size_t index) const {
    return batch_.state.visualizations[index % shown_.size()];
  }
  ShownSoFar& shownOf(size_t index) { return shown_[index % shown_.size()]; }

  void start(size_t index) {
    ServerRank& serverRank = services_.serverRank;
    const std::string& tenant = request_.session().tenant();
    const Camera& camera = batch_.state.cameras[index / shown_.size()];
    auto slot =
        serverRank.tenants.beginWhenFree(tenant, serverRank.costOf(tenant, camera.dimensions), [this] {
          check();
          sendWhatHasCome();  // it takes room as long as it is here
        });
    SceneCache::Pinned pinned = sceneOf(index);
    FrameRequest frame;
    frame.scene = pinned.scene->id;
    frame.camera = fitted(camera, shownOf(index).box);
    frame.priority = {serverRank.tenants.number(tenant), false, stream_};
    frame.account = tenant;
    const PictureFormat format = formatOf(index, frame.camera, *pinned.scene);
    {
      const std::lock_guard lock(job_->mutex);
      job_->inFlight[index].scene = pinned.scene;
    }
    FrameId id;
    try {
      id = services_.pictures.start(frame, format, receiverOf(index, std::move(slot), std::move(pinned)));
    } catch (const std::exception&) {
      const std::lock_guard lock(job_->mutex);
      job_->inFlight.erase(index);
      throw;
    }
    const std::lock_guard lock(job_->mutex);
    if (const auto at = job_->inFlight.find(index); at != job_->inFlight.end()) at->second.id = id;
  }

  // Makes what the document has and the scenes of all visualizations, of the data of one moment. `pinned` gets the data that they show.
  // Returns what of the files is not used.
  std::vector<std::string> look(PinnedData& pinned) {
    std::vector<std::string> names, warnings;
    for (const Visualization& v : batch_.state.visualizations)
      for (const Vis& vis : v.operators) names.push_back(vis.dataset);
    Datasets::Import what;
    what.specs = batch_.state.datasets;
    what.onlyMissing = true;
    if (!what.specs.empty())
      warnings = services_.serverRank.filterRuns->importAndMake(request_, std::move(what), names, pinned);
    std::vector<ScenePtr> scenes;
    for (size_t i = 0; i < shown_.size(); i++) scenes.push_back(sceneOf(i, nullptr, pinned).scene);
    const std::lock_guard lock(job_->mutex);
    job_->scenes.swap(scenes);
    return warnings;
  }

  SceneCache::Pinned sceneOf(size_t visualization, const ScenePtr& known, const PinnedData& pinned) {
    return services_.scenes.get(request_.session().tenant(), batch_.state.visualizations[visualization],
                                batch_.state.settings, asker_, shown_[visualization], known, &pinned);
  }

  // Returns the scene of a picture, with its data pinned. The scene is kept for the visualization's next picture.
  SceneCache::Pinned sceneOf(size_t index) {
    const size_t visualization = index % shown_.size();
    const auto kept = [&] {
      const std::lock_guard lock(job_->mutex);
      return job_->scenes[visualization];
    };
    if (const ScenePtr scene = kept())
      if (auto pinned = services_.scenes.pin(request_.session().tenant(), scene)) return *std::move(pinned);
    PinnedData pinned;
    look(pinned);
    return sceneOf(visualization, kept(), pinned);
  }

  PictureFormat formatOf(size_t index, const Camera& camera, const SceneHandle& scene) {
    PictureFormat format;
    format.as = batch_.toClient ? PictureFormat::As::Bytes : PictureFormat::As::File;
    format.format = batch_.format;
    if (!batch_.toClient) format.path = paths_[index];
    if (batch_.state.annotations == Annotations()) return format;
    Generation newest = 0;
    for (const NamedDataset& d : scene.data) newest = std::max(newest, d.generation);
    format.overlay = overlayOf(batch_.state.annotations, {visualizationOf(index), shownOf(index), camera,
                                                          batch_.state.settings, size_t(newest)});
    return format;
  }

  // The receiver holds the tenant's slot until the picture has been sent, and the scene and its data until the frame has ended.
  PictureReceiver receiverOf(size_t index, Tenants::RenderSlot tenantsSlot, SceneCache::Pinned pinned) const {
    const auto slot = std::make_shared<Tenants::RenderSlot>(std::move(tenantsSlot));
    const auto held = std::make_shared<SceneCache::Pinned>(std::move(pinned));
    PictureReceiver receiver;
    receiver.bytes = [job = job_, index, slot](Bytes content) {
      const std::lock_guard lock(job->mutex);
      job->contents[index] = {std::move(content), std::move(*slot)};
    };
    receiver.done = [&services = services_, tenant = request_.session().tenant(), job = job_, index, slot,
                     held](bool, const std::string& error) {
      *slot = {};
      services.retries.onEnd(tenant);
      held->pins.clear();
      held->scene = nullptr;
      const std::lock_guard lock(job->mutex);
      job->inFlight.erase(index);
      job->done++;
      if (job->error.empty()) job->error = error;
      job->changed.notify_all();
    };
    return receiver;
  }

  // Whatever is still under way ends before the request does.
  void giveUp() {
    std::unique_lock lock(job_->mutex);
    const auto inFlight = job_->inFlight;
    lock.unlock();
    for (const auto& [index, flight] : inFlight) services_.serverRank.renderer.supersede(flight.id);
    lock.lock();
    job_->changed.wait(lock, [this] { return job_->inFlight.empty(); });
  }

  Services& services_;
  Request& request_;
  const BatchRender& batch_;
  Asker asker_ = askerOf(request_);  ///< for its scenes
  const size_t total_;
  const uint64_t stream_;  ///< of its frames
  std::vector<std::string> paths_;
  std::vector<ShownSoFar> shown_ =
      std::vector<ShownSoFar>(batch_.state.visualizations.size());  ///< by visualization
  const std::shared_ptr<Job> job_ = std::make_shared<Job>();
};

}  // namespace

json renderBatch(Services& services, Request& request, const BatchRender& batch) {
  return Run(services, request, batch).run();
}

}  // namespace gxy::viewer
