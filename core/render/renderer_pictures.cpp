// SPDX-License-Identifier: Apache-2.0
// What becomes of a frame's picture once all of its pixels are known: its parts are made, come together, and the
// whole is handed out.
#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/comm/tree.h"
#include "core/comm/wire.h"
#include "core/render/renderer_state.h"

namespace gxy {

namespace {

constexpr size_t kPartsHeader = sizeof(PixelMessage) + sizeof(FrameId);

Bytes partsMessage(FrameId id, const Bytes& parts) {
  Bytes message = Writer().write(PixelMessage::Parts).write(id).take();
  message.insert(message.end(), parts.begin(), parts.end());
  return message;
}

}  // namespace

// On each rank, when the frame is over.
void Renderer::finish(const FramePtr& frame, bool hasPicture) {
  if (options_.trace) options_.trace->addLong("frame", frame->id, frame->begun);
  if (!frame->part) return;
  if (hasPicture && frame->parts.count() > 1)
    return flights_.tasks().push(frame->request.priority, frame->id, [this, frame] { makePart(frame); });
  {
    std::lock_guard lock(mutex_);
    collecting_.erase(frame->id);
  }
  if (frame->ownsPicture()) handOut(frame, hasPicture);
}

void Renderer::handOut(const FramePtr& frame, bool hasPicture) {
  TaskRunner& runner = frame->request.priority.interactive ? flights_.tasks() : handOuts_;
  runner.push(frame->request.priority, frame->id, [this, frame, hasPicture] { deliver(frame, hasPicture); });
}

void Renderer::makePart(const FramePtr& frame) {
  const Trace::Span span(options_.trace, "part of a picture", frame->id);
  const int part = *frame->part;
  try {
    const Picture rows = ownRows(*frame);
    const LedgerEntry memory =
        frame->account().picture.another(2 * int64_t(rows.bytes()));  // with their bytes
    collect(frame, transport_.rank(), partsMessage(frame->id, bytesOfPart(part, rows)));
  } catch (const std::exception& e) {  // no memory
    collect(frame, transport_.rank(), partsMessage(frame->id, bytesOfPart(part, textOf(e))));
    throw;
  }
}

// Converts this rank's part, and gives the framebuffer's memory back.
Picture Renderer::ownRows(Frame& frame) {
  {
    std::lock_guard lock(mutex_);
    counters_.pixelsSkipped += frame.framebuffer->pixelsLeft();
  }
  Picture rows = frame.request.sums ? frame.framebuffer->takeSums()
                                    : frame.framebuffer->picture(frame.scene.compiled->settings,
                                                                 frame.request.priority.interactive);
  frame.framebuffer->release();
  return rows;
}

// Keeps a message with finished parts. Once all that are expected on this rank have come, they go on as one.
void Renderer::collect(const FramePtr& frame, int source, Bytes message) {
  {
    std::lock_guard lock(mutex_);
    LedgerEntry& memory = frame->finishedMemory;
    if (frame->finished.empty()) memory = frame->account().picture.another(0);
    memory.resize(memory.bytes() + int64_t(message.size()));
    frame->finished[source] = std::move(message);
    const int expected = 1 + treeChildren(*frame->part, 0, frame->parts.count());
    if (int(frame->finished.size()) < expected) return;
    collecting_.erase(frame->id);
  }
  if (frame->ownsPicture()) return handOut(frame, true);
  flights_.tasks().push(frame->request.priority, frame->id, [this, frame] { sendParts(frame); });
}

void Renderer::receiveParts(int source, Bytes message) {
  Reader in(message, "parts of a picture");
  in.read<PixelMessage>();
  const auto id = in.read<FrameId>();
  FramePtr frame;
  {
    std::lock_guard lock(mutex_);
    if (const auto it = collecting_.find(id); it != collecting_.end()) frame = it->second;
    const auto part = frame ? frame->parts.ofRank(source) : std::nullopt;
    if (!part || treeParent(*part, 0, frame->parts.count()) != frame->part || frame->finished.count(source))
      in.fail("rank " + std::to_string(source) + " has no part of frame " + std::to_string(id) +
              " to send to rank " + std::to_string(transport_.rank()));
  }
  collect(frame, source, std::move(message));
}

void Renderer::sendParts(const FramePtr& frame) {
  Bytes message = partsMessage(frame->id, {});
  try {
    size_t bytes = message.size();
    for (const auto& [source, parts] : frame->finished) bytes += parts.size() - kPartsHeader;
    message.reserve(bytes);
    for (auto& [source, parts] : frame->finished) {
      message.insert(message.end(), parts.begin() + kPartsHeader, parts.end());
      parts = {};
    }
  } catch (const std::exception& e) {  // no memory; the owner must not wait for ever
    message = partsMessage(frame->id, bytesOfPart(*frame->part, textOf(e)));
  }
  const int above = treeParent(*frame->part, 0, frame->parts.count());
  transport_.send(frame->parts.rank(above), Channel::Contributions, std::move(message));
  frame->finishedMemory = {};
}

Picture Renderer::wholePicture(Frame& frame) {
  if (frame.parts.count() == 1) return ownRows(frame);
  const std::map<int, Bytes> messages = std::exchange(frame.finished, {});
  const LedgerEntry memory = std::move(frame.finishedMemory);
  std::vector<std::span<const std::byte>> parts;
  for (const auto& [source, message] : messages) parts.push_back(std::span(message).subspan(kPartsHeader));
  return joined(frame.parts, frame.request.sums, frame.request.depth, parts);
}

void Renderer::deliver(const FramePtr& frame, bool hasPicture) {
  // Rank 0 is told even if there is no memory for the picture or the handler throws, because the frame is
  // over.
  std::string error;
  const std::shared_ptr<void> tell(nullptr,
                                   [&](void*) { flights_.report(frame->id, Writer().write(error).take()); });
  const PictureOperationPtr& operation = frame->request.operation;
  PictureHandler handler;
  {
    std::lock_guard lock(mutex_);
    handler = pictureHandler_;
    const bool wanted = operation ? operationReader_ != nullptr : handler != nullptr;
    if (!wanted || !hasPicture) return;
  }
  const Trace::Span span(options_.trace, "picture", frame->id);
  try {
    Picture picture = wholePicture(*frame);
    const LedgerEntry memory = frame->account().picture.another(int64_t(picture.bytes()));
    if (operation)
      operation->run(std::move(picture));
    else
      handler(frame->id, frame->request, std::move(picture));
  } catch (const std::exception& e) {
    error = "rank " + std::to_string(transport_.rank()) + ": " + textOf(e);
    throw;
  }
}

}  // namespace gxy
