// SPDX-License-Identifier: Apache-2.0
#include "core/io/streamed_samples.h"

#include <cstring>

#include "core/comm/error.h"
#include "core/io/volume_formats.h"

namespace gxy {

namespace {
constexpr int64_t kChunk = 1 << 20;  ///< bytes that are decoded at a time
}

/// One pass over the blocks. `buffer` begins with `held` bytes of point number `next`; its other bytes are
/// in the next block.
struct StreamedSamples::Reading {
  std::span<const Extent> wanted;
  const TakeSamples& take;
  int64_t last;  ///< last point that is wanted
  std::vector<std::byte> buffer;
  int64_t next = 0;
  size_t held = 0;
};

StreamedSamples::StreamedSamples(std::shared_ptr<const BlockedBytes> bytes, const Extent& stored,
                                 ScalarType type, int components, bool swapBytes, std::string where,
                                 std::shared_ptr<Decoded> decoded)
    : bytes_(std::move(bytes)),
      stored_(stored),
      bytesPerPoint_(int64_t(bytesOf(type)) * components),
      bytesPerSample_(bytesOf(type)),
      swapBytes_(swapBytes),
      where_(std::move(where)),
      decoded_(std::move(decoded)) {}

bool StreamedSamples::isWanted(std::span<const Extent> wanted, int64_t first, int64_t end) const {
  bool any = false;
  forBoxes(stored_, first, end - first, [&](const Extent& box, int64_t) {
    for (const Extent& w : wanted) any = any || intersection(w, box).count() > 0;
  });
  return any;
}

void StreamedSamples::give(std::span<const Extent> wanted, int64_t first, std::span<std::byte> samples,
                           const TakeSamples& take) const {
  if (swapBytes_) swapBytes(samples, bytesPerSample_);
  forBoxes(stored_, first, int64_t(samples.size()) / bytesPerPoint_, [&](const Extent& box, int64_t n) {
    const auto of =
        samples.subspan(size_t((n - first) * bytesPerPoint_), size_t(box.count() * bytesPerPoint_));
    for (size_t w = 0; w < wanted.size(); ++w)
      if (const Extent both = intersection(wanted[w], box); both.count() > 0) take({w, both, box, of});
  });
  take({0, {}, {}, {}});
}

void StreamedSamples::read(std::span<const Extent> wanted, const TakeSamples& take) const {
  int64_t last = -1;
  for (const Extent& w : wanted) {
    if (w.count() == 0) continue;
    int64_t number = 0;
    for (size_t a = 3; a-- > 0;)
      number = number * stored_.points[a] + w.first[a] + w.points[a] - 1 - stored_.first[a];
    last = std::max(last, number);
  }
  Reading reading{wanted, take, last, std::vector<std::byte>(size_t(kChunk + bytesPerPoint_))};
  for (int64_t block = 0; block * bytes_->blockBytes() < (last + 1) * bytesPerPoint_; ++block)
    readBlock(reading, block);
}

void StreamedSamples::readBlock(Reading& r, int64_t block) const {
  int64_t at = block * bytes_->blockBytes();
  const int64_t end = std::min(at + bytes_->blockBytes(), bytes_->bytes());
  if (!isWanted(r.wanted, at / bytesPerPoint_,
                std::min((end + bytesPerPoint_ - 1) / bytesPerPoint_, stored_.count()))) {
    r.held = 0;
    return;
  }
  const ByteStreamPtr stream = bytes_->open(block);
  ++decoded_->blocks;
  const auto more = [&](std::span<std::byte> out) {
    if (stream->read(out) < out.size())
      throw Error(where_ + ": the samples end before point " + std::to_string(at / bytesPerPoint_) +
                  ", expected " + std::to_string(stored_.count()));
    decoded_->bytes += out.size();
    at += int64_t(out.size());
  };
  if (r.held == 0) {  // The rest of a point that began in a block that was not read is skipped.
    const int64_t rest = std::min((bytesPerPoint_ - at % bytesPerPoint_) % bytesPerPoint_, end - at);
    std::vector<std::byte> passed(static_cast<size_t>(rest));
    more(passed);
    r.next = at / bytesPerPoint_;
  }
  while (at < end && r.next <= r.last) {
    const auto n = size_t(std::min(end - at, kChunk));
    more(std::span(r.buffer).subspan(r.held, n));
    r.held += n;
    const int64_t points = int64_t(r.held) / bytesPerPoint_;
    const auto whole = size_t(points * bytesPerPoint_);
    give(r.wanted, r.next, std::span(r.buffer).first(whole), r.take);
    r.held -= whole;
    std::memmove(r.buffer.data(), r.buffer.data() + whole, r.held);
    r.next += points;
  }
}

}  // namespace gxy
