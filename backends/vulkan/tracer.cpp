// SPDX-License-Identifier: Apache-2.0
#include "backends/vulkan/tracer.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <iterator>
#include <mutex>
#include <thread>
#include <utility>

#include "backends/vulkan/batch.h"

namespace gxy::vulkan {

namespace {

// One that the device does, one that it does next, and one that the host reads or prepares.
constexpr size_t kBatchesAtOnce = 3;
// A batch of a sampling may take thousands of submissions. One lane is left for pictures.
constexpr size_t kSamplingsAtOnce = kBatchesAtOnce - 1;
// This many batches of other frames are small after an urgent request, which is about a second of the
// device's time.
constexpr size_t kWatchedFor = 200;
constexpr size_t kWithSecondaries = 8;  // a batch with its secondaries may have this many times as many rays

}  // namespace

struct Tracer::State {
  State(const Device& d, Pipelines& p, DeviceTime& t, size_t rays)
      : device(d),
        pipelines(p),
        time(t),
        batchRays(rays),
        allRays(std::min(kWithSecondaries * rays, mostRays(d))),
        mostTiles(mostRays(d) / TILE_RAYS) {}

  // The time since the last call, while requests had no answer. (Locked.)
  std::chrono::nanoseconds countAsked() {
    const auto now = std::chrono::steady_clock::now();
    return now - std::exchange(askedFrom, now);
  }

  // Starts batches of what waits, while there are lanes for them.
  void feed() {
    endCancelled();
    std::unique_lock lock(mutex);
    while (!waiting.empty() && (!idle.empty() || lanes < kBatchesAtOnce)) {
      const auto next = nextInTurn();
      if (next == waiting.end()) return;
      auto batch = std::make_unique<Batch>(lotFrom(next));
      samplings += batch->samples();
      std::unique_ptr<Lane> lane;
      if (idle.empty()) {
        lanes++;
      } else {
        lane = std::move(idle.back());
        idle.pop_back();
      }
      lock.unlock();
      std::string error;
      try {
        if (!lane) lane = std::make_unique<Lane>(device, pipelines);
        batch->start(std::move(lane));
      } catch (const std::exception& e) {
        error = e.what();
      }
      if (!error.empty()) end(*batch, error);
      lock.lock();
      if (error.empty()) {
        underWay.push_back(std::move(batch));
        changed.notify_one();
      }
    }
  }

  // Answers requests of frames that are cancelled.
  void endCancelled() {
    std::vector<DeviceTask> ended;
    {
      std::lock_guard lock(mutex);
      const auto first = std::stable_partition(waiting.begin(), waiting.end(),
                                               [](const DeviceTask& r) { return !r.frame->cancelled(); });
      std::move(first, waiting.end(), std::back_inserter(ended));
      waiting.erase(first, waiting.end());
    }
    endUndone(ended, {});
  }

  // The first request of the urgent frame whose turn was longest ago; otherwise the first of all. None if all are of samplings,
  // which have their lanes. (Locked.)
  std::deque<DeviceTask>::iterator nextInTurn() {
    auto first = waiting.end(), next = waiting.end();
    for (auto r = waiting.begin(); r != waiting.end(); ++r) {
      if (r->frame->sampling && samplings == kSamplingsAtOnce) continue;
      if (first == waiting.end()) first = r;
      if (r->frame->urgent() && (next == waiting.end() || r->frame->lastTurn < next->frame->lastTurn))
        next = r;
    }
    return next == waiting.end() ? first : next;
  }

  // Takes a request, and others that are like it, up to a batch. (Locked.)
  std::vector<DeviceTask> lotFrom(std::deque<DeviceTask>::iterator r) {
    std::vector<DeviceTask> lot;
    r->urgent = r->frame->urgent();
    r->frame->lastTurn = ++turns;
    const size_t each = 1 + r->perHit();
    // A tile is spawned by as many invocations as the largest tile has pixels.
    const size_t requests = r->kind == DeviceTask::Kind::Spawn ? mostTiles : SIZE_MAX;
    size_t rays = r->size(), most = batchRays;
    if (r->urgent) {
      sinceUrgent = 0;
    } else if (sinceUrgent < kWatchedFor) {
      most = std::min(batchRays, size_t(r->scene->batchSize().rays()));
      sinceUrgent++;
    }
    lot.push_back(std::move(*r));
    waiting.erase(r);
    for (r = waiting.begin(); r != waiting.end() && lot.size() < requests;) {
      const size_t n = rays + r->size();
      if (r->isLike(lot[0]) && n <= most && n * each <= allRays) {
        rays = n;
        lot.push_back(std::move(*r));
        r = waiting.erase(r);
      } else {
        ++r;
      }
    }
    return lot;
  }

  // Ends a batch. The device goes on with the next one before the host looks at the answers of this one. A
  // lane is not used again after an error, since nobody knows what the device does with it. Nor is it, if
  // nothing waits, when a single request has made it larger than batches are.
  void end(Batch& batch, const std::string& error) {
    {
      std::unique_ptr<Lane> lane = batch.takeLane();
      std::lock_guard lock(mutex);
      samplings -= batch.samples();
      if (error.empty() && !(waiting.empty() && lane->isLargerThan(allRays)))
        idle.push_back(std::move(lane));
      else
        lanes--;
    }
    if (error.empty())
      feed(), batch.answer();
    else
      batch.fail(error);
  }

  const Device& device;
  Pipelines& pipelines;
  DeviceTime& time;
  const size_t batchRays, allRays, mostTiles;
  std::mutex mutex;  ///< guards what is below
  std::condition_variable changed;
  std::deque<DeviceTask> waiting;                   ///< in the order in which they came
  uint64_t turns = 0;                               ///< number of batches that were started
  std::chrono::steady_clock::time_point askedFrom;  ///< countAsked() has counted up to here
  size_t sinceUrgent = kWatchedFor;  ///< batches of other frames since an urgent request, at most kWatchedFor
  std::deque<std::unique_ptr<Batch>> underWay;
  std::vector<std::unique_ptr<Lane>> idle;
  size_t lanes = 0;      ///< number of lanes, idle or not
  size_t samplings = 0;  ///< number of batches under way that sample
  bool stopping = false;
  std::thread thread;
};

Tracer::Tracer(const Device& device, Pipelines& pipelines, DeviceTime& time, size_t batchRays)
    : state_(std::make_shared<State>(device, pipelines, time, batchRays)) {
  state_->thread = std::thread([state = state_] { collect(state); });
}

Tracer::~Tracer() {
  {
    std::lock_guard lock(state_->mutex);
    state_->stopping = true;
    state_->changed.notify_one();
    state_->idle.clear();
  }
  if (state_->thread.get_id() == std::this_thread::get_id())
    state_->thread.detach();
  else
    state_->thread.join();
}

void Tracer::add(DeviceTask request) {
  {
    std::lock_guard lock(state_->mutex);
    if (request.frame->urgent()) state_->sinceUrgent = 0;
    if (state_->waiting.empty() && state_->lanes == state_->idle.size()) state_->countAsked();
    state_->waiting.push_back(std::move(request));
  }
  state_->feed();
}

void Tracer::collect(const std::shared_ptr<State>& state) {
  for (;;) {
    std::unique_ptr<Batch> batch;
    {
      std::unique_lock lock(state->mutex);
      state->changed.wait(lock, [&] { return state->stopping || !state->underWay.empty(); });
      if (state->underWay.empty()) return;
      batch = std::move(state->underWay.front());
      state->underWay.pop_front();
    }
    std::string error;
    bool more = false;
    try {
      more = batch->advance(state->time);
    } catch (const std::exception& e) {
      error = e.what();
    }
    if (error.empty()) {
      std::lock_guard lock(state->mutex);
      batch->addAsked(state->countAsked());
      if (more) {
        state->underWay.push_back(std::move(batch));
        continue;
      }
    }
    state->end(*batch, error);
    if (!error.empty()) state->feed();  // its lane is gone, so what waits is started without it
  }
}

}  // namespace gxy::vulkan
