// SPDX-License-Identifier: Apache-2.0
// The act of a frame: its tiles are spawned, its rays are traced, and their contributions are added to pixels.
#include <algorithm>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/comm/wire.h"
#include "core/render/renderer_state.h"

namespace gxy {

namespace {

struct ContributionCounts {
  uint64_t contributions, depths;
};

// Takes the elements below a pixel from the front of a list that is sorted by pixels.
template <class T>
std::span<const T> takeBelow(std::span<const T>& list, size_t pixel) {
  const auto count = size_t(std::ranges::lower_bound(list, pixel, {}, &T::pixel) - list.begin());
  const std::span<const T> front = list.first(count);
  list = list.subspan(count);
  return front;
}

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

// Adds what a result has for the pixels to the parts that have them.
void Renderer::contribute(Frame& frame, TraceResult& result) {
  std::span<const Contribution> contributions = result.contributions;
  std::span<const DepthContribution> depths = result.depths;
  const int last = frame.parts.count() - 1;
  if (last > 0) {  // a part's pixels follow each other
    std::ranges::sort(result.contributions, {}, &Contribution::pixel);
    std::ranges::sort(result.depths, {}, &DepthContribution::pixel);
  }
  for (int part = 0; part < last; part++) {
    const size_t end = frame.parts.end(part);
    addTo(frame, part, takeBelow(contributions, end), takeBelow(depths, end));
  }
  addTo(frame, last, contributions, depths);
}

void Renderer::addTo(Frame& frame, int part, std::span<const Contribution> contributions,
                     std::span<const DepthContribution> depths) {
  if (contributions.empty() && depths.empty()) return;
  if (part == frame.part) try {
      frame.framebuffer->add(contributions);
      frame.framebuffer->addDepths(depths);
      return;
    } catch (const std::exception& e) {  // no memory
      return flights_.fail(frame, textOf(e));
    }
  Writer w;
  w.write(PixelMessage::Contributions).write(frame.id);
  w.write(ContributionCounts{contributions.size(), depths.size()});
  for (const Contribution& c : contributions) w.write(c);
  for (const DepthContribution& d : depths) w.write(d.pixel).write(d.depth);
  Bytes message = w.take();
  {
    std::lock_guard lock(mutex_);
    counters_.contributionBytes += message.size();
    counters_.contributionMessages++;
  }
  flights_.created(frame.id, 1);
  transport_.send(frame.parts.rank(part), Channel::Contributions, std::move(message));
}

void Renderer::receivePixels(int source, Bytes message) {
  Reader in(message, "pixels");
  const auto kind = in.read<PixelMessage>();
  if (kind == PixelMessage::Contributions) return receiveContributions(std::move(message));
  if (kind == PixelMessage::Parts) return receiveParts(source, std::move(message));
  in.fail("its kind is " + std::to_string(int(kind)) + ", expected 0 or 1");
}

void Renderer::receiveContributions(Bytes message) {
  constexpr size_t kDepthBytes = sizeof(uint32_t) + sizeof(double);
  Reader in(message, "pixel contributions");
  in.read<PixelMessage>();
  const auto id = in.read<FrameId>();
  const auto counts = in.read<ContributionCounts>();
  const size_t bytes = in.rest().size();
  if (id == 0 || counts.contributions > bytes / sizeof(Contribution) || counts.depths > bytes / kDepthBytes ||
      bytes != counts.contributions * sizeof(Contribution) + counts.depths * kDepthBytes)
    in.fail("its header does not fit its " + std::to_string(message.size()) + " bytes");
  const auto flight =
      flights_.findOrPark(id, message, [this](Bytes parked) { receiveContributions(std::move(parked)); });
  if (!flight) return;
  Frame& frame = static_cast<Frame&>(*flight);
  if (!frame.device) return flights_.retired(id, 1);
  try {
    if (!frame.framebuffer) in.fail("no part of the picture is on this rank");
    std::vector<Contribution> contributions(counts.contributions);
    for (Contribution& c : contributions) c = in.read<Contribution>();
    std::vector<DepthContribution> depths(counts.depths);
    for (DepthContribution& d : depths) {
      d.pixel = in.read<uint32_t>();
      d.depth = in.read<double>();
    }
    if (!frame.framebuffer->add(contributions) || !frame.framebuffer->addDepths(depths))
      in.fail("a pixel lies outside this rank's part of the picture");
  } catch (const std::exception& e) {
    flights_.fail(frame, textOf(e));
    flights_.retired(id, 1);
    throw;
  }
  flights_.retired(id, 1);
}

}  // namespace gxy
