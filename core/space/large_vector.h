// SPDX-License-Identifier: Apache-2.0
// A vector for arrays of many megabytes: samples of volumes, framebuffers, pictures.
#pragma once
#include <cstddef>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace gxy {

inline constexpr size_t kHugePage = size_t{2} << 20, kMostKept = size_t{256} << 20;

/// Allocates `bytes`, a multiple of kHugePage. Takes the block of this size that was given back last, or else
/// memory of the system. Thread safe. Throws std::bad_alloc.
void* takeHugePages(size_t bytes);
/// Gives a block back and keeps it for the next request of its size. At most kMostKept bytes are kept. Frames
/// take blocks of the same sizes again and again, and keeping them saves the system from clearing new memory.
/// The system may take the memory of kept blocks when it needs it (MADV_FREE). Thread safe.
void giveBackHugePages(void* block, size_t bytes) noexcept;

/// Allocates arrays of at least one huge page in whole huge pages, if the system grants them. Then there are
/// 512 times fewer page faults when an array is first written, and fewer TLB misses when rays read samples in
/// no order. Elements that are made without a value are not initialised: resize() writes nothing.
template <class T>
struct LargeAllocator {
  using value_type = T;

  LargeAllocator() = default;
  template <class U>
  LargeAllocator(const LargeAllocator<U>&) noexcept {}

  T* allocate(size_t n) {
    if (n > (size_t(-1) - kHugePage) / sizeof(T)) throw std::bad_array_new_length();
    const size_t bytes = n * sizeof(T);
    return static_cast<T*>(bytes < kHugePage ? ::operator new(bytes) : takeHugePages(whole(bytes)));
  }
  void deallocate(T* memory, size_t n) noexcept {
    const size_t bytes = n * sizeof(T);
    if (bytes < kHugePage)
      ::operator delete(memory);
    else
      giveBackHugePages(memory, whole(bytes));
  }

  template <class U>
  void construct(U* at) noexcept(std::is_nothrow_default_constructible_v<U>) {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
  }

  friend bool operator==(const LargeAllocator&, const LargeAllocator&) noexcept { return true; }

 private:
  static constexpr size_t whole(size_t bytes) { return (bytes + kHugePage - 1) / kHugePage * kHugePage; }
};

template <class T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

}  // namespace gxy
