// SPDX-License-Identifier: Apache-2.0
#include "core/io/streamed_samples.h"

#include <cstring>

#include "core/comm/error.h"
#include "core/io/volume_formats.h"

namespace gxy {

namespace {
constexpr int64_t kChunk = 1 << 20;     ///< bytes of one block that are decoded at a time
constexpr int64_t kTogether = 4 << 20;  ///< bytes of several blocks that are decoded together
}  // namespace

/// One pass over the blocks. `buffer` begins with `held` bytes of point number `next`; its other bytes are
/// in the next block.
struct StreamedSamples::Reading {
  std::span<const Extent> wanted;
  const TakeSamples& take;
  int64_t last;  ///< last point that is wanted
  std::vector<std::byte> buffer{};
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

bool StreamedSamples::isWanted(std::span<const Extent> wanted, int64_t block) const {
  const int64_t at = block * bytes_->blockBytes();
  const int64_t last = std::min(at + bytes_->blockBytes(), bytes_->bytes()) - 1;
  const int64_t first = at / bytesPerPoint_, end = std::min(last / bytesPerPoint_ + 1, stored_.count());
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
  Reading reading{wanted, take, last};
  const int64_t size = bytes_->blockBytes(), blocks = ((last + 1) * bytesPerPoint_ + size - 1) / size;
  const int64_t most = std::max<int64_t>(kTogether / size, 1);
  for (int64_t block = 0, end = 0; block < blocks; block = end) {
    end = block + 1;
    if (!isWanted(wanted, block)) {
      reading.held = 0;
      continue;
    }
    while (end < blocks && end - block < most && isWanted(wanted, end)) ++end;
    readBlocks(reading, block, end);
  }
}

void StreamedSamples::readBlocks(Reading& r, int64_t block, int64_t endBlock) const {
  int64_t at = block * bytes_->blockBytes();
  const int64_t end = std::min(endBlock * bytes_->blockBytes(), bytes_->bytes());
  // Several blocks are decoded together, on all cores. One block may be of any size, so it is decoded in parts.
  const bool several = endBlock - block > 1;
  const ByteStreamPtr one = several ? nullptr : bytes_->open(block);
  decoded_->blocks += uint64_t(endBlock - block);
  int64_t passed = 0;  // bytes of a point that began in a block that was not read
  if (r.held == 0) {
    passed = (bytesPerPoint_ - at % bytesPerPoint_) % bytesPerPoint_;
    r.next = (at + passed) / bytesPerPoint_;
  }
  while (at < end && r.next <= r.last) {
    const auto n = size_t(several ? end - at : std::min(end - at, kChunk));
    if (r.buffer.size() < r.held + n) r.buffer.resize(r.held + n);
    const std::span out = std::span(r.buffer).subspan(r.held, n);
    if (const size_t made = several ? gxy::readBlocks(*bytes_, block, out) : one->read(out); made < n)
      throw Error(where_ + ": the samples end before point " +
                  std::to_string((at + int64_t(made)) / bytesPerPoint_) + ", expected " +
                  std::to_string(stored_.count()));
    decoded_->bytes += n;
    at += int64_t(n);
    r.held += n;
    const auto drop = [&](size_t bytes) {
      r.held -= bytes;
      std::memmove(r.buffer.data(), r.buffer.data() + bytes, r.held);
    };
    if (const auto some = std::min(passed, int64_t(r.held)); some > 0) {
      drop(size_t(some));
      passed -= some;
    }
    const int64_t points = int64_t(r.held) / bytesPerPoint_;
    const auto whole = size_t(points * bytesPerPoint_);
    give(r.wanted, r.next, std::span(r.buffer).first(whole), r.take);
    drop(whole);
    r.next += points;
  }
}

}  // namespace gxy
