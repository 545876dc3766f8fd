// SPDX-License-Identifier: Apache-2.0
#include "core/space/large_vector.h"

#include <sys/mman.h>

#include <deque>
#include <iterator>
#include <mutex>

namespace gxy {

namespace {

constexpr std::align_val_t kAlignment{kHugePage};

// Blocks for reuse; the one that was given back last is at the end.
struct Kept {
  std::mutex mutex;
  std::deque<std::pair<void*, size_t>> blocks;
  size_t bytes = 0;
};

Kept& kept() {
  static Kept* const all = new Kept;  // never destroyed, because vectors may outlive static objects
  return *all;
}

}  // namespace

void* takeHugePages(size_t bytes) {
  {
    Kept& k = kept();
    const std::lock_guard lock(k.mutex);
    for (auto i = k.blocks.rbegin(); i != k.blocks.rend(); ++i)
      if (i->second == bytes) {
        void* const block = i->first;
        k.blocks.erase(std::next(i).base());
        k.bytes -= bytes;
        return block;
      }
  }
  void* const block = ::operator new(bytes, kAlignment);
  madvise(block, bytes, MADV_HUGEPAGE);  // If this fails, the memory is usable all the same.
  return block;
}

void giveBackHugePages(void* block, size_t bytes) noexcept {
  if (bytes > kMostKept) return ::operator delete(block, kAlignment);
  madvise(block, bytes, MADV_FREE);
  Kept& k = kept();
  const std::lock_guard lock(k.mutex);
  try {
    k.blocks.emplace_back(block, bytes);
  } catch (const std::bad_alloc&) {
    return ::operator delete(block, kAlignment);
  }
  for (k.bytes += bytes; k.bytes > kMostKept; k.blocks.pop_front()) {
    ::operator delete(k.blocks.front().first, kAlignment);
    k.bytes -= k.blocks.front().second;
  }
}

}  // namespace gxy
