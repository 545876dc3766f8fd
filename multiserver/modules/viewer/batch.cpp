// SPDX-License-Identifier: Apache-2.0
#include "multiserver/modules/viewer/batch.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <map>
#include <set>

#include "core/annotate/annotations.h"
#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/scene/state_pictures.h"
#include "multiserver/protocol/file_record.h"
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
  std::vector<ScenePtr>
      scenes;  ///< null where one is not made yet, or where the next picture is to show newer data
  std::shared_ptr<const PinnedData>
      data;  ///< that the next scenes show, scene by scene; null: they look anew
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

constexpr size_t kMostPictures = 10000;

void checkCount(size_t pictures) {
  if (pictures > kMostPictures)
    throw Error("batch: " + std::to_string(pictures) + " pictures, expected at most " +
                std::to_string(kMostPictures));
}

std::string nameOf(const BatchRender& batch, size_t index) {
  return batch.pictures[index].name + "." + batch.format;
}

std::vector<std::string> namesIn(const BatchRender& batch) {
  std::set<std::string> names;
  for (const BatchScene& scene : batch.scenes)
    for (const Vis& vis : scene.visualization.operators) names.insert(vis.dataset);
  return {names.begin(), names.end()};
}

class Run {
 public:
  Run(Services& services, Request& request, const BatchRender& batch)
      : services_(services),
        request_(request),
        batch_(batch),
        total_(batch.pictures.size()),
        names_(namesIn(batch)),
        stream_(services.rendering->nextStream()) {
    asker_.check = [this] { check(); };
  }

  json run() {
    const auto begin = std::chrono::steady_clock::now();
    checkCount(total_);
    for (const BatchPicture& picture : batch_.pictures) {
      const Camera& camera = picture.camera;
      validate(camera);
      const auto pixels = uint64_t(camera.dimensions.x) * uint64_t(camera.dimensions.y);
      if (pixels > request_.session().limits().pixels)
        throw Error("batch: a picture of " + std::to_string(pixels) + " pixels, expected at most " +
                    std::to_string(request_.session().limits().pixels));
      checkCost(batch_.scenes[picture.scene].settings, camera.dimensions);
    }
    for (const BatchScene& scene : batch_.scenes) checkCost(scene.visualization);
    json names = json::array();
    for (size_t i = 0; i < total_; i++) {
      names.push_back(nameOf(batch_, i));
      if (!batch_.toClient && !batch_.filesOf)
        paths_.push_back(services_.serverRank.folders.toWrite(nameOf(batch_, i)));
    }
    job_->scenes.resize(batch_.scenes.size());
    const auto wanted = services_.serverRank.observers.subscribe({}, [this](const ObjectEvent& event) {
      if (event.kind == ObjectEvent::Kind::Wanted) letGo(event.key, event.generation);
    });
    const std::shared_ptr<void> end(nullptr, [this](void*) { giveUp(); });
    std::vector<std::string> warnings;
    lookAnew(warnings);
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
    std::shared_ptr<const PinnedData> data;
    const std::lock_guard lock(job_->mutex);
    if (job_->data && holds(*job_->data, key, generation)) data.swap(job_->data);
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

  static bool holds(const PinnedData& data, Key key, Generation generation) {
    return std::any_of(data.begin(), data.end(), [&](const auto& d) {
      return d.second.first.key == key && d.second.first.generation == generation;
    });
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
      const Bytes record = protocol::fileRecord(
          {{"name", nameOf(batch_, index)}, {"index", index}, {"of", total_}}, content.picture);
      if (!request_.session().outbox().file(request_.id(), record, [this] { return request_.cancelled(); }))
        throw Error("cancelled");
      content = {};
    }
    if (done < total_) request_.progress(int64_t(done), int64_t(total_), "rendered");
  }

  const BatchScene& sceneAt(size_t index) const { return batch_.scenes[batch_.pictures[index].scene]; }
  ShownSoFar& shownOf(size_t index) { return shown_[batch_.pictures[index].scene]; }

  void start(size_t index) {
    ServerRank& serverRank = services_.serverRank;
    const std::string& tenant = request_.session().tenant();
    const Camera& camera = batch_.pictures[index].camera;
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
    const PictureFormat format = formatOf(index, frame.camera, pinned);
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

  // Makes what the document has, and the scenes of all pictures unless they are made one by one, of the data of one moment. Returns the
  // data that they show, and adds what of the files is not used to `warnings`.
  std::shared_ptr<const PinnedData> lookAnew(std::vector<std::string>& warnings) {
    const auto pinned = std::make_shared<PinnedData>();
    Datasets::Import what;
    what.specs = batch_.datasets;
    what.onlyMissing = true;
    if (!what.specs.empty())
      warnings = services_.serverRank.filterRuns->importAndMake(request_, std::move(what), names_, *pinned);
    std::vector<ScenePtr> scenes;
    if (batch_.sceneByScene)
      services_.serverRank.datasets->pin(request_.session().tenant(), names_, *pinned);
    else
      for (size_t i = 0; i < shown_.size(); i++) scenes.push_back(sceneOf(i, nullptr, *pinned).scene);
    if (batch_.sceneByScene) {
      keepData(pinned);
    } else {
      const std::lock_guard lock(job_->mutex);
      job_->scenes.swap(scenes);
    }
    return pinned;
  }

  void keepData(std::shared_ptr<const PinnedData> which) {
    const std::lock_guard lock(job_->mutex);
    job_->data.swap(which);  // and what was there goes without the lock
  }

  // The data that the next scene shows: scene by scene those of the scenes before, while these are there and no update needs their room.
  std::shared_ptr<const PinnedData> dataOfScene() {
    std::shared_ptr<const PinnedData> data;
    {
      const std::lock_guard lock(job_->mutex);
      data = job_->data;
    }
    if (data) {
      std::vector<NamedDataset> named;
      for (const auto& d : *data) named.push_back(d.second.first);
      if (services_.scenes.namesMean(request_.session().tenant(), named)) return data;
      data = nullptr;
      keepData(nullptr);
    }
    std::vector<std::string> warnings;
    return lookAnew(warnings);
  }

  SceneCache::Pinned sceneOf(size_t scene, const ScenePtr& known, const PinnedData& pinned) {
    return services_.scenes.get(request_.session().tenant(), batch_.scenes[scene].visualization,
                                batch_.scenes[scene].settings, asker_, shown_[scene], known, &pinned);
  }

  // Returns the scene of a picture, with its data pinned. The scene is kept for the next picture that shows it.
  SceneCache::Pinned sceneOf(size_t index) {
    const size_t scene = batch_.pictures[index].scene;
    const size_t last = index == 0 ? scene : batch_.pictures[index - 1].scene;
    if (batch_.sceneByScene && last != scene) keep(last, nullptr);
    const auto kept = [&] {
      const std::lock_guard lock(job_->mutex);
      return job_->scenes[scene];
    };
    if (const ScenePtr known = kept())
      if (auto pinned = services_.scenes.pin(request_.session().tenant(), known)) return *std::move(pinned);
    SceneCache::Pinned pinned = sceneOf(scene, kept(), *dataOfScene());
    if (batch_.sceneByScene) keep(scene, pinned.scene);
    return pinned;
  }

  void keep(size_t scene, ScenePtr which) {
    const std::lock_guard lock(job_->mutex);
    job_->scenes[scene].swap(which);  // and what was there goes without the lock
  }

  PictureFormat formatOf(size_t index, const Camera& camera, const SceneCache::Pinned& pinned) {
    PictureFormat format;
    format.as = batch_.toClient ? PictureFormat::As::Bytes : PictureFormat::As::File;
    format.format = batch_.format;
    if (!batch_.toClient) {
      BatchRender::Files files =
          batch_.filesOf ? batch_.filesOf(index, pinned) : BatchRender::Files{paths_[index], {}};
      format.path = std::move(files.picture);
      format.depthPath = std::move(files.depth);
    }
    const BatchScene& scene = sceneAt(index);
    if (scene.annotations == Annotations()) return format;
    Generation newest = 0;
    for (const NamedDataset& d : pinned.scene->data) newest = std::max(newest, d.generation);
    format.overlay = overlayOf(scene.annotations,
                               {scene.visualization, shownOf(index), camera, scene.settings, size_t(newest)});
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
                     held, &made = batch_.made](bool superseded, const std::string& error) {
      if (made && !superseded && error.empty()) made(index);  // the batch is there until nothing is in flight
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
    keepData(nullptr);
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
  const std::vector<std::string> names_;  ///< of the datasets that pictures show
  const uint64_t stream_;                 ///< of its frames
  std::vector<std::string> paths_;
  std::vector<ShownSoFar> shown_ = std::vector<ShownSoFar>(batch_.scenes.size());  ///< by scene
  const std::shared_ptr<Job> job_ = std::make_shared<Job>();
};

}  // namespace

void addPictures(BatchRender& batch, const State& state, const std::string& prefix) {
  const std::vector<StatePicture> pictures = picturesOf(state);
  checkCount(pictures.size());
  batch.datasets = state.datasets;
  for (const Visualization& visualization : state.visualizations)
    batch.scenes.push_back({visualization, state.settings, state.annotations});
  for (size_t i = 0; i < pictures.size(); i++) {
    const StatePicture& p = pictures[i];
    batch.pictures.push_back(
        {p.visualization, p.camera, pictureName(prefix, i, state.visualizations[p.visualization], p.camera)});
  }
}

json renderBatch(Services& services, Request& request, const BatchRender& batch) {
  return Run(services, request, batch).run();
}

}  // namespace gxy::viewer
