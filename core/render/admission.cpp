// SPDX-License-Identifier: Apache-2.0
#include "core/render/admission.h"

#include <algorithm>

namespace gxy {

bool Admission::mayBegin(const Stream& stream, int64_t bytes) const {
  return stream.begun.size() < few_ || stream.bytes + bytes <= bytes_;
}

bool Admission::enter(const Priority& priority, FrameId frame, int64_t bytes) {
  const Key key{priority.tenant, priority.stream};
  Stream& stream = streams_[key];
  keys_[frame] = key;
  const bool begins = stream.waiting.empty() && mayBegin(stream, bytes);
  if (begins) {
    stream.begun.push_back({frame, bytes});
    stream.bytes += bytes;
  } else {
    stream.waiting.push_back({frame, bytes});
  }
  return begins;
}

std::vector<Admission::FrameId> Admission::over(FrameId frame) {
  std::vector<FrameId> next;
  const auto key = keys_.find(frame);
  if (key == keys_.end()) return next;
  const auto at = streams_.find(key->second);
  keys_.erase(key);
  Stream& stream = at->second;
  std::erase_if(stream.begun, [&](const Entry& entry) {
    if (entry.frame != frame) return false;
    stream.bytes -= entry.bytes;
    return true;
  });
  while (!stream.waiting.empty() && mayBegin(stream, stream.waiting.front().bytes)) {
    const Entry entry = stream.waiting.front();
    stream.waiting.pop_front();
    stream.begun.push_back(entry);
    stream.bytes += entry.bytes;
    next.push_back(entry.frame);
  }
  if (stream.begun.empty()) streams_.erase(at);
  return next;
}

void Admission::beginAnyway(FrameId frame) {
  Stream& stream = streams_.at(keys_.at(frame));
  const auto entry = std::ranges::find(stream.waiting, frame, &Entry::frame);
  if (entry == stream.waiting.end()) return;
  stream.begun.push_back(*entry);
  stream.bytes += entry->bytes;
  stream.waiting.erase(entry);
}

size_t Admission::waiting() const {
  size_t frames = 0;
  for (const auto& [key, stream] : streams_) frames += stream.waiting.size();
  return frames;
}

}  // namespace gxy
