// SPDX-License-Identifier: Apache-2.0
// What the thread sanitizer has to be told of threads that it cannot see into.
#pragma once
#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace gxy {

/// Work that a thread hands to threads of a library built without the thread sanitizer (oneTBB, say), whose own
/// synchronisation the sanitizer therefore misses: handOver() before the call into the library, begin() and end() around
/// what each of its threads runs of ours, takeBack() once the library has said that all is done. Both sides know the
/// work by the address of an object of two bytes or more, which is not accessed. It declares an order that the library
/// keeps, and makes none; without the sanitizer it is nothing.
class ThreadOrder {
 public:
#ifdef __SANITIZE_THREAD__
  explicit ThreadOrder(const void* object) : key_(static_cast<char*>(const_cast<void*>(object))) {}
  void handOver() const { __tsan_release(key_); }
  void begin() const { __tsan_acquire(key_); }
  void end() const { __tsan_release(key_ + 1); }
  void takeBack() const { __tsan_acquire(key_ + 1); }

 private:
  char* key_;
#else
  explicit ThreadOrder(const void*) {}
  void handOver() const {}
  void begin() const {}
  void end() const {}
  void takeBack() const {}
#endif
};

}  // namespace gxy
