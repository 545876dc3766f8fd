// SPDX-License-Identifier: Apache-2.0
// The act of a frame: its tiles are spawned, its rays are traced, and their contributions are added to pixels.
#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/comm/wire.h"
#include "core/render/renderer_state.h"

namespace gxy {

namespace {

struct ContributionsHeader {
  FrameId frame;
  uint64_t contributions, depths;
};

}  // namespace

int64_t Renderer::Frame::cost() const {
  const SpawnTile tile = nextTile();
  return int64_t(tile.x1 - tile.x0) * (tile.y1 - tile.y0) * perPrimary;
}

std::function<void(DeviceScene::Done)> Renderer::Frame::takeChunk() {
  const SpawnTile tile = nextTile();
  next++;
  return [this, tile](Done done) { scene.device->spawn(*device, tile, std::move(done)); };
}

void Renderer::Frame::advance(LeavingRays packet, Done done) {
  scene.device->trace(*device, packet.partition, packet.primary, std::move(packet.rays), std::move(done));
}

LeavingRays Renderer::Frame::read(int partition, uint32_t kind, int count,
                                  std::span<const std::byte> bytes) const {
  const Reader in(bytes, "rays");
  const CompiledScene& compiled = *scene.compiled;
  if (partition < 0 || partition >= compiled.partitioning->partitions() ||
      owner(partition) != renderer.transport_.rank() || !compiled.visible[size_t(partition)])
    in.fail("partition " + std::to_string(partition) + " is not one that this rank shows");
  const bool primary = kind == 1;
  RayList rays = RayList::read(bytes, count, primary);
  if (const char* wrong = wrongIn(rays, primary, limits)) in.fail(wrong);
  return {partition, primary, std::move(rays)};
}

// Takes what a device's answer has besides rays: to the framebuffer and to the counters.
void Renderer::takeResult(Frame& frame, TraceResult& result) {
  contribute(frame, result);
  frame.work += result.counters.nsWork();
  if (frame.device && !frame.priority().interactive) frame.device->setUrgent(false);
  std::lock_guard lock(mutex_);
  counters_.trace += result.counters;
  counters_.messagesSkipped += !frame.framebuffer && result.contributions.empty() && result.depths.empty();
}

void Renderer::contribute(Frame& frame, TraceResult& result) {
  if (result.contributions.empty() && result.depths.empty()) return;
  if (frame.framebuffer) try {
      frame.framebuffer->add(result.contributions);
      frame.framebuffer->addDepths(result.depths);
      return;
    } catch (const std::exception& e) {  // no memory
      return flights_.fail(frame, textOf(e));
    }
  Writer w;
  w.write(ContributionsHeader{frame.id, result.contributions.size(), result.depths.size()});
  for (const Contribution& c : result.contributions) w.write(c);
  for (const DepthContribution& d : result.depths) w.write(d.pixel).write(d.depth);
  Bytes message = w.take();
  {
    std::lock_guard lock(mutex_);
    counters_.contributionBytes += message.size();
    counters_.contributionMessages++;
  }
  flights_.created(frame.id, 1);
  transport_.send(frame.pictureOwner, Channel::Contributions, std::move(message));
}

void Renderer::receiveContributions(Bytes message) {
  constexpr size_t kDepthBytes = sizeof(uint32_t) + sizeof(double);
  Reader in(message, "pixel contributions");
  const auto header = in.read<ContributionsHeader>();
  const size_t bytes = in.rest().size();
  if (header.frame == 0 || header.contributions > bytes / sizeof(Contribution) ||
      header.depths > bytes / kDepthBytes ||
      bytes != header.contributions * sizeof(Contribution) + header.depths * kDepthBytes)
    in.fail("its header does not fit its " + std::to_string(message.size()) + " bytes");
  const auto flight = flights_.findOrPark(header.frame, message,
                                          [this](Bytes parked) { receiveContributions(std::move(parked)); });
  if (!flight) return;
  Frame& frame = static_cast<Frame&>(*flight);
  if (!frame.device) return flights_.retired(header.frame, 1);
  try {
    if (!frame.framebuffer) in.fail("the picture is not on this rank");
    std::vector<Contribution> contributions(header.contributions);
    for (Contribution& c : contributions) c = in.read<Contribution>();
    std::vector<DepthContribution> depths(header.depths);
    for (DepthContribution& d : depths) {
      d.pixel = in.read<uint32_t>();
      d.depth = in.read<double>();
    }
    if (!frame.framebuffer->add(contributions) || !frame.framebuffer->addDepths(depths))
      in.fail("a pixel lies outside the picture");
  } catch (const std::exception& e) {
    flights_.fail(frame, textOf(e));
    flights_.retired(header.frame, 1);
    throw;
  }
  flights_.retired(header.frame, 1);
}

}  // namespace gxy
