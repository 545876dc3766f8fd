// SPDX-License-Identifier: Apache-2.0
#include "draw.h"

#include <deque>

namespace gxy::agreement {

Picture draw(const Backend& backend, const TestScene& scene, uint32_t frameNumber, int packetRays) {
  const auto compiled = scene.compile();
  const auto device = backend.makeScene(compiled, 0);
  const CompiledFrame frame = compileFrame(*compiled, scene.camera, frameNumber, true);
  const auto deviceFrame = device->makeFrame(frame);
  Framebuffer framebuffer(frame.width, frame.height, frame.samples, true);
  std::deque<LeavingRays> waiting;
  auto take = [&](TraceResult result) {
    framebuffer.add(result.contributions);
    framebuffer.addDepths(result.depths);
    for (LeavingRays& l : result.leaving)
      for (RayList& packet : l.rays.split(packetRays))
        waiting.push_back({l.partition, l.primary, std::move(packet)});
  };
  for (int sample = 0; sample < frame.samples; sample++)
    for (int y = 0; y < frame.height; y += kTile)
      for (int x = 0; x < frame.width; x += kTile) {
        const Tile tile{x, y, std::min(x + kTile, frame.width), std::min(y + kTile, frame.height), sample};
        device->spawn(*deviceFrame, tile, take);
        while (!waiting.empty()) {
          LeavingRays next = std::move(waiting.front());
          waiting.pop_front();
          device->trace(*deviceFrame, next.partition, next.primary, std::move(next.rays), take);
        }
      }
  return framebuffer.picture(scene.settings.background);
}

}  // namespace gxy::agreement
