// SPDX-License-Identifier: Apache-2.0
// What waits for the device, and what it works on.
#pragma once
#include <memory>

#include "backends/vulkan/pipelines.h"
#include "core/rays/backend.h"

namespace gxy::vulkan {

class DeviceTime;
struct Request;

/// Nobody waits for the device but one thread of the Tracer's own. A few batches are handed to the device at once, so that it
/// has the next when it has done one; what is asked for meanwhile waits here, and goes in one batch with what is like it. So
/// batches are small while there is little to do, and large when there is much. Those of frames that are not urgent are,
/// for a while after one that is, only so large that the device works on one for at most 5 ms (PacketSize), or a single
/// request.
///
/// Thread safe. Requests must be answered before it goes.
class Tracer {
 public:
  /// Batches of about `batchRays` rays. `time` hears of what the device does.
  Tracer(const Device& device, Pipelines& pipelines, DeviceTime& time, size_t batchRays);
  ~Tracer();
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  /// Done before what waits and is not urgent, if its frame is when its turn comes; urgent frames take turns. Answered without
  /// being done if its frame is cancelled before.
  void add(Request request);

 private:
  struct State;
  static void collect(const std::shared_ptr<State>& state);
  const std::shared_ptr<State> state_;  ///< the thread's, too: the Tracer may go in what it calls
};

}  // namespace gxy::vulkan
