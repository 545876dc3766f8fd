// SPDX-License-Identifier: Apache-2.0
// The life of a frame's rays on a rank: they are spawned against credits, traced and forwarded, and their
// contributions are added to pixels.
#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/comm/wire.h"
#include "core/render/renderer_state.h"

namespace gxy {

namespace {

struct RaysHeader {
  FrameId frame;
  int32_t partition, origin, count;
  uint32_t primary;
};

struct ContributionsHeader {
  FrameId frame;
  uint64_t contributions, depths;
};

}  // namespace

std::function<void()> Renderer::Tiles::take() {
  const SpawnTile tile = frame_->nextTile();
  const int64_t cost = frame_->nextCost();
  frame_->next++;
  auto active = std::make_shared<Completion::Active>(renderer_.completion_, frame_->id);
  return
      [&renderer = renderer_, frame = frame_, tile, cost, active] { renderer.spawnTile(frame, tile, cost); };
}

// Removes the tiles of a cancelled frame.
void Renderer::dropTiles(const FramePtr& frame) {
  if (!tasks_.queue().dropTiles(frame->request.priority, frame->id)) return;
  const size_t left = frame->allTiles() - frame->next;
  if ((frame->tilesLeft -= left) == 0) completion_.spawned(frame->id);
}

// Calls the device. If the answer is there when the call returns, it goes to `then` with the caller's stack;
// otherwise it goes to `then` with a new stack, in a task of its own. No thread waits for a device.
void Renderer::ask(const FramePtr& frame, int origin, uint64_t rays, const Call& call, Then then,
                   std::vector<QueuedRays>& stack) {
  const auto asked = std::make_shared<PendingDeviceCall>();
  asked->next.reset(new PendingDeviceCall::Next{
      tasks_.stay(), transport_.expectPost(), frame, origin, std::move(then), {completion_, frame->id}, {}});
  try {
    call([this, asked](TraceResult result) { answered(*asked, std::move(result)); });
  } catch (const std::exception& e) {
    asked->next->answer.retired = rays;
    asked->next->answer.error = textOf(e);
    asked->answered = true;
  }
  std::shared_ptr<PendingDeviceCall::Next> next;
  {
    std::lock_guard lock(asked->mutex);
    asked->left = true;
    if (asked->answered) next = std::move(asked->next);
  }
  if (next) next->then(next->answer, stack);
}

void Renderer::answered(PendingDeviceCall& asked, TraceResult result) {
  std::shared_ptr<PendingDeviceCall::Next> next;
  {
    std::lock_guard lock(asked.mutex);
    asked.answered = true;
    asked.next->answer = std::move(result);
    if (!asked.left) return;
    next = std::move(asked.next);
  }
  // The posted task does not keep the Renderer waiting, because it may never run.
  const std::shared_ptr<void> inside = std::move(next->inside), expected = std::move(next->expected);
  const FramePtr frame = next->frame;
  tasks_.push(frame->priority(), frame->id, [this, next = std::move(next)] {
    std::vector<QueuedRays> stack;
    next->then(next->answer, stack);
    process(next->frame, next->origin, std::move(stack));
  });
}

void Renderer::spawnTile(const FramePtr& frame, const SpawnTile& tile, int64_t reserved) {
  std::vector<QueuedRays> stack;
  TraceResult nothing;
  const Trace::Span span(options_.trace, "tile", frame->id);
  if (frame->cancelled)
    spawned(frame, nothing, reserved, stack);
  else
    ask(
        frame, transport_.rank(), 0,
        [&](DeviceScene::Done done) { frame->scene.device->spawn(*frame->device, tile, std::move(done)); },
        [this, frame, reserved](TraceResult& result, std::vector<QueuedRays>& rest) {
          spawned(frame, result, reserved, rest);
        },
        stack);
  process(frame, transport_.rank(), std::move(stack));
}

void Renderer::spawned(const FramePtr& frame, TraceResult& result, int64_t reserved,
                       std::vector<QueuedRays>& stack) {
  for (const LeavingRays& l : result.leaving) {
    completion_.created(frame->id, uint64_t(l.rays.size()));
    reserved -= l.rays.size() * (l.primary ? frame->perPrimary : 1);
  }
  take(frame, transport_.rank(), result, stack);
  if (--frame->tilesLeft == 0) completion_.spawned(frame->id);
  giveBack(transport_.rank(), frame->request.priority, reserved);
}

Renderer::QueuedRays Renderer::hold(const Frame& frame, LeavingRays rays) {
  LedgerEntry memory = frame.account().rays.another(rays.rays.bytes());
  return {std::move(rays), std::move(memory)};
}

// Distributes a device's answer: to the framebuffer, the counters, other ranks, and this rank's stack.
void Renderer::take(const FramePtr& frame, int origin, TraceResult& result, std::vector<QueuedRays>& stack) {
  if (!result.error.empty()) fail(frame, result.error);
  contribute(frame, result);
  frame->work += result.counters.nsWork();
  if (frame->device && !frame->priority().interactive) frame->device->setUrgent(false);
  {
    std::lock_guard lock(mutex_);
    counters_.trace += result.counters;
    counters_.messagesSkipped += !frame->framebuffer && result.contributions.empty() && result.depths.empty();
  }
  for (LeavingRays& l : result.leaving) {
    const int rank = frame->scene.compiled->partitioning->owner(l.partition);
    if (rank == transport_.rank())
      stack.push_back(hold(*frame, std::move(l)));
    else
      forward(frame, rank, l.partition, l.primary, origin, l.rays);
  }
}

void Renderer::traced(const FramePtr& frame, int origin, bool primary, TraceResult& result,
                      std::vector<QueuedRays>& stack) {
  completion_.created(frame->id, result.created);
  take(frame, origin, result, stack);
  completion_.retired(frame->id, result.retired);
  const int64_t credits =
      int64_t(result.retired) * (primary ? frame->perPrimary : 1) - int64_t(result.created);
  giveBack(origin, frame->request.priority, credits);
}

// Ends rays that will not be traced.
void Renderer::retire(const FramePtr& frame, int origin, bool primary, uint64_t rays) {
  TraceResult ended;
  ended.retired = ended.counters.raysRetired = rays;
  std::vector<QueuedRays> nothing;
  traced(frame, origin, primary, ended, nothing);
}

// Traces one packet. Puts off the rest, and all rays that it leaves on this rank.
void Renderer::process(const FramePtr& frame, int origin, std::vector<QueuedRays> stack) {
  while (!stack.empty()) {
    QueuedRays next = std::move(stack.back());
    stack.pop_back();
    LeavingRays& list = next.list;
    const int most = frame->packet.rays();
    if (list.rays.size() > most) {  // in packets, the last one first
      for (RayList& part : list.rays.split(most))
        stack.push_back(hold(*frame, {list.partition, list.primary, std::move(part)}));
      continue;
    }
    const auto rays = uint64_t(list.rays.size());
    const bool primary = list.primary;
    if (frame->cancelled) {
      retire(frame, origin, primary, rays);
      continue;
    }
    const Trace::Span span(options_.trace, "packet", rays);
    // Kept until the device answers.
    const auto memory = std::make_shared<LedgerEntry>(std::move(next.memory));
    const auto begin = options_.processorTime();
    ask(
        frame, origin, rays,
        [&](DeviceScene::Done done) {
          frame->scene.device->trace(*frame->device, list.partition, primary, std::move(list.rays),
                                     std::move(done));
        },
        [this, frame, origin, primary, memory](TraceResult& result, std::vector<QueuedRays>& rest) {
          traced(frame, origin, primary, result, rest);
        },
        stack);
    frame->packet.took(int(rays), options_.processorTime() - begin);
    if (!stack.empty()) putOff(frame, origin, std::move(stack));
    return;
  }
}

// Queues the rest of a task for later.
void Renderer::putOff(const FramePtr& frame, int origin, std::vector<QueuedRays> rest) {
  auto active = std::make_shared<Completion::Active>(completion_, frame->id);
  auto held = std::make_shared<std::vector<QueuedRays>>(std::move(rest));
  tasks_.push(
      frame->priority(), frame->id,
      [this, frame, origin, active, held] { process(frame, origin, std::move(*held)); }, true);
}

void Renderer::forward(const FramePtr& frame, int rank, int partition, bool primary, int origin,
                       const RayList& rays) {
  std::vector<int> all(size_t(rays.size()));
  for (int i = 0; i < rays.size(); i++) all[size_t(i)] = i;
  Writer header;
  Bytes message = header.write(RaysHeader{frame->id, partition, origin, rays.size(), primary}).take();
  rays.write(all, primary, message);
  {
    std::lock_guard lock(mutex_);
    counters_.raysForwarded += uint64_t(rays.size());
    counters_.rayBytes += message.size();
    counters_.rayMessages++;
  }
  transport_.send(rank, Channel::Rays, std::move(message));
}

void Renderer::contribute(const FramePtr& frame, TraceResult& result) {
  if (result.contributions.empty() && result.depths.empty()) return;
  if (frame->framebuffer) try {
      frame->framebuffer->add(result.contributions);
      frame->framebuffer->addDepths(result.depths);
      return;
    } catch (const std::exception& e) {  // no memory
      return fail(frame, textOf(e));
    }
  Writer w;
  w.write(ContributionsHeader{frame->id, result.contributions.size(), result.depths.size()});
  for (const Contribution& c : result.contributions) w.write(c);
  for (const DepthContribution& d : result.depths) w.write(d.pixel).write(d.depth);
  Bytes message = w.take();
  {
    std::lock_guard lock(mutex_);
    counters_.contributionBytes += message.size();
    counters_.contributionMessages++;
  }
  completion_.created(frame->id, 1);
  transport_.send(frame->owner, Channel::Contributions, std::move(message));
}

void Renderer::receiveRays(Bytes message) {
  Reader in(message, "rays");
  const auto header = in.read<RaysHeader>();
  const bool primary = header.primary == 1;
  if (header.primary > 1 || header.frame == 0 || header.count < 1 || header.origin < 0 ||
      header.origin >= transport_.size() ||
      in.rest().size() != size_t(header.count) * size_t(RayList::wireBytes(primary)))
    in.fail("its header does not fit its " + std::to_string(message.size()) + " bytes");
  const FramePtr frame = findOrPark(header.frame, Channel::Rays, message);
  if (!frame) return;
  if (!frame->device) return retire(frame, header.origin, primary, uint64_t(header.count));
  auto active = std::make_shared<Completion::Active>(completion_, header.frame);
  auto held = std::make_shared<std::vector<QueuedRays>>();  // shared, because tasks are copied
  try {
    const CompiledScene& scene = *frame->scene.compiled;
    if (header.partition < 0 || header.partition >= scene.partitioning->partitions() ||
        scene.partitioning->owner(header.partition) != transport_.rank() ||
        !scene.visible[size_t(header.partition)])
      in.fail("partition " + std::to_string(header.partition) + " is not one that this rank shows");
    RayList rays = RayList::read(in.rest(), header.count, primary);
    if (const char* wrong = wrongIn(rays, primary, frame->limits)) in.fail(wrong);
    held->push_back(hold(*frame, {header.partition, primary, std::move(rays)}));
  } catch (const std::exception& e) {  // the frame must end all the same
    fail(frame, textOf(e));
    retire(frame, header.origin, primary, uint64_t(header.count));
    throw;
  }
  tasks_.push(frame->priority(), frame->id, [this, frame, origin = header.origin, active, held] {
    process(frame, origin, std::move(*held));
  });
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
  const FramePtr frame = findOrPark(header.frame, Channel::Contributions, message);
  if (!frame) return;
  if (!frame->device) return completion_.retired(header.frame, 1);
  try {
    if (!frame->framebuffer) in.fail("the picture is not on this rank");
    std::vector<Contribution> contributions(header.contributions);
    for (Contribution& c : contributions) c = in.read<Contribution>();
    std::vector<DepthContribution> depths(header.depths);
    for (DepthContribution& d : depths) {
      d.pixel = in.read<uint32_t>();
      d.depth = in.read<double>();
    }
    if (!frame->framebuffer->add(contributions) || !frame->framebuffer->addDepths(depths))
      in.fail("a pixel lies outside the picture");
  } catch (const std::exception& e) {
    fail(frame, textOf(e));
    completion_.retired(header.frame, 1);
    throw;
  }
  completion_.retired(header.frame, 1);
}

void Renderer::giveBack(int origin, const Priority& priority, int64_t credits) {
  if (credits == 0) {
    if (origin == transport_.rank()) return;
    std::lock_guard lock(mutex_);
    counters_.messagesSkipped++;
    return;
  }
  if (origin != transport_.rank()) {
    Writer w;
    w.write(priority.tenant).write(priority.stream).write(credits);
    transport_.send(origin, Channel::Credits, w.take());
    return;
  }
  tasks_.queue().giveBack(priority, credits);
  tasks_.start();  // there may be room for a tile now
}

}  // namespace gxy
