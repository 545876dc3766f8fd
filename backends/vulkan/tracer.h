// SPDX-License-Identifier: Apache-2.0
// Tracer: the queue of a device's work. It collects requests into batches and submits them.
#pragma once
#include <memory>

#include "backends/vulkan/pipelines.h"
#include "core/rays/backend.h"

namespace gxy::vulkan {

class DeviceTime;
struct DeviceTask;

/// Only one thread, which belongs to the Tracer, waits for the device. A few batches are submitted at once,
/// so that the device has the next one when it has done one. Requests that arrive meanwhile wait here, and
/// requests that are alike go in one batch. So batches are small while there is little to do, and large when
/// there is much. For a while after an urgent request, batches of frames that are not urgent are only so
/// large that the device works on one for at most 5 ms (PacketSize), or have a single request.
///
/// Thread safe. All requests must be answered before it is destroyed.
class Tracer {
 public:
  /// Batches have about `batchRays` rays. `time` is told what the device does.
  Tracer(const Device& device, Pipelines& pipelines, DeviceTime& time, size_t batchRays);
  ~Tracer();
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  /// Adds a request. If its frame is urgent when its turn comes, it is done before others that wait; urgent
  /// frames take turns. If its frame is cancelled before that, it is answered without being done.
  void add(DeviceTask request);

 private:
  struct State;
  static void collect(const std::shared_ptr<State>& state);
  /// Shared with the thread, because a callback of the thread may destroy the Tracer.
  const std::shared_ptr<State> state_;
};

}  // namespace gxy::vulkan
