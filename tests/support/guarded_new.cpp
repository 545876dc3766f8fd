// SPDX-License-Identifier: Apache-2.0
// operator new for tests of what sanitizers cannot see into, kernels in ISPC: memory that may not be touched lies before
// and behind what it gives, directly before it or, if GXY_GUARD_BEHIND, directly behind it but for its alignment. Loaded
// before a test program's own libraries.
#include <sys/mman.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>

namespace {

constexpr size_t kPage = 4096, kSlot = size_t(1) << 20, kSlots = size_t(1) << 25;
constexpr size_t kSmallest = 32,
                 kLargest = kSlot / 2;  // smaller ones are many and of the tests; larger ones have no slot
constexpr int kMostGuarded = 24000;     // of the 65530 mappings that Linux allows, at two each

char* reserve(void* at, size_t bytes) {
  const int fixed = at == nullptr ? 0 : MAP_FIXED;
  void* p = mmap(at, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | fixed, -1, 0);
  if (p == MAP_FAILED) std::abort();
  return static_cast<char*>(p);
}

std::atomic<size_t> nextSlot = 0;
std::atomic<int> guarded = 0;
// Null until this library begins, the last one: what others allocate when they begin would fill the slots.
char* const slots = reserve(nullptr, kSlot* kSlots);

bool inSlots(const void* p) {
  const uintptr_t begin = reinterpret_cast<uintptr_t>(slots), at = reinterpret_cast<uintptr_t>(p);
  return begin != 0 && at >= begin && at < begin + kSlot * kSlots;
}

void* guardedNew(size_t size, size_t alignment) {
  if (size < kSmallest || size > kLargest || alignment > kPage || slots == nullptr) return nullptr;
  if (guarded.fetch_add(1) < kMostGuarded) {
    const size_t slot = nextSlot.fetch_add(1), length = (size + kPage - 1) / kPage * kPage;
    if (slot < kSlots) {
      char* const first = slots + slot * kSlot + kSlot / 4;
      if (mprotect(first, length, PROT_READ | PROT_WRITE) == 0) {
#if defined(GXY_GUARD_BEHIND)
        return first + (length - size) / alignment * alignment;
#else
        return first;
#endif
      }
    }
  }
  guarded.fetch_sub(1);
  return nullptr;
}

void* anyNew(size_t size, size_t alignment) {
  void* p = guardedNew(size, alignment);
  if (p == nullptr) p = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}

void anyDelete(void* p) {
  if (!inSlots(p)) return std::free(p);
  // nothing of it is kept, and it is not given again
  reserve(slots + (static_cast<char*>(p) - slots) / kSlot * kSlot, kSlot);
  guarded.fetch_sub(1);
}

}  // namespace

void* operator new(size_t size) { return anyNew(size, __STDCPP_DEFAULT_NEW_ALIGNMENT__); }
void* operator new(size_t size, std::align_val_t alignment) { return anyNew(size, size_t(alignment)); }
void operator delete(void* p) noexcept { anyDelete(p); }
void operator delete(void* p, size_t) noexcept { anyDelete(p); }
void operator delete(void* p, std::align_val_t) noexcept { anyDelete(p); }
void operator delete(void* p, size_t, std::align_val_t) noexcept { anyDelete(p); }
