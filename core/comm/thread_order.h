// SPDX-License-Identifier: Apache-2.0
// Tells the thread sanitizer about synchronisation inside libraries that are built without it.
#pragma once
#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace gxy {

/// Describes work that a thread hands to the threads of a library, such as oneTBB, whose own synchronisation
/// the thread sanitizer does not see. Call handOver() before the call into the library, begin() and end()
/// around the code of ours that each of its threads runs, and takeBack() once the library has said that all
/// is done. Both sides identify the work by the address of an object of two bytes or more; the object is not
/// accessed. The class only declares an order that the library keeps, and synchronises nothing itself.
/// Without the sanitizer it does nothing.
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
