// SPDX-License-Identifier: Apache-2.0
// An operator new for tests of ISPC kernels, which sanitizers do not check. Memory that must not be accessed
// lies before and behind each allocation: directly before it, or, with GXY_GUARD_BEHIND, directly behind it
// except for padding. The library is loaded before a test program's own libraries.
#include <sys/mman.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>

namespace {

constexpr size_t kPage = 4096, kSlot = size_t(1) << 20, kSlots = size_t(1) << 25;
// Smaller allocations are many and made by the tests themselves; larger ones do not fit into a slot.
constexpr size_t kSmallest = 32, kLargest = kSlot / 2;
constexpr int kPoison = 0xFF;        // -1 as an index, NaN as a number
constexpr int kMostGuarded = 24000;  // Each takes two of the 65530 mappings that Linux allows.

char* reserve(void* at, size_t bytes) {
  const int fixed = at == nullptr ? 0 : MAP_FIXED;
  void* p = mmap(at, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | fixed, -1, 0);
  if (p == MAP_FAILED) std::abort();
  return static_cast<char*>(p);
}

constexpr size_t kMostPages = kLargest / kPage;
std::atomic<size_t> nextSlot = 0;
std::atomic<int> guarded = 0;  // number of slots with accessible memory, in use or free
// Null until this library is initialised, which is the last one. Otherwise allocations of other libraries'
// initialisation would fill the slots.
char* const slots = reserve(nullptr, kSlot* kSlots);

std::atomic<uint8_t> pagesOf[kSlots];  // number of pages of each slot, minus one
// Free slots with accessible memory, by number of pages. Using one again needs no system call.
struct FreeSlot {
  FreeSlot* next;
};
std::mutex freeMutex;
FreeSlot* freeSlots[kMostPages];

bool inSlots(const void* p) {
  const uintptr_t begin = reinterpret_cast<uintptr_t>(slots), at = reinterpret_cast<uintptr_t>(p);
  return begin != 0 && at >= begin && at < begin + kSlot * kSlots;
}

char* firstByte(size_t slot) { return slots + slot * kSlot + kSlot / 4; }

/// Returns the first byte of this many pages in a slot, between memory that must not be accessed; null if
/// no slot is left.
char* takePages(size_t pages) {
  {
    std::lock_guard lock(freeMutex);
    if (FreeSlot* const taken = freeSlots[pages - 1]; taken != nullptr) {
      freeSlots[pages - 1] = taken->next;
      return static_cast<char*>(std::memset(static_cast<void*>(taken), kPoison, sizeof(FreeSlot)));
    }
  }
  if (guarded.fetch_add(1) < kMostGuarded) {
    const size_t slot = nextSlot.fetch_add(1);
    if (slot < kSlots && mprotect(firstByte(slot), pages * kPage, PROT_READ | PROT_WRITE) == 0) {
      pagesOf[slot] = uint8_t(pages - 1);
      return firstByte(slot);
    }
  }
  guarded.fetch_sub(1);
  return nullptr;
}

void* guardedNew(size_t size, size_t alignment) {
  if (size < kSmallest || size > kLargest || alignment > kPage || slots == nullptr) return nullptr;
  const size_t pages = (size + kPage - 1) / kPage;
  char* const first = takePages(pages);
#if defined(GXY_GUARD_BEHIND)
  if (first != nullptr) return first + (pages * kPage - size) / alignment * alignment;
#endif
  return first;
}

void* anyNew(size_t size, size_t alignment) {
  void* p = guardedNew(size, alignment);
  if (p == nullptr) p = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}

void anyDelete(void* p) {
  if (!inSlots(p)) return std::free(p);
  const size_t slot = size_t(static_cast<char*>(p) - slots) / kSlot, pages = size_t(pagesOf[slot]) + 1;
  std::memset(firstByte(slot), kPoison,
              pages * kPage);  // Code that still reads it gets no valid index or pointer.
  std::lock_guard lock(freeMutex);
  freeSlots[pages - 1] = new (firstByte(slot)) FreeSlot{freeSlots[pages - 1]};
}

}  // namespace

void* operator new(size_t size) { return anyNew(size, __STDCPP_DEFAULT_NEW_ALIGNMENT__); }
void* operator new(size_t size, std::align_val_t alignment) { return anyNew(size, size_t(alignment)); }
void operator delete(void* p) noexcept { anyDelete(p); }
void operator delete(void* p, size_t) noexcept { anyDelete(p); }
void operator delete(void* p, std::align_val_t) noexcept { anyDelete(p); }
void operator delete(void* p, size_t, std::align_val_t) noexcept { anyDelete(p); }
