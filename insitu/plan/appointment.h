// SPDX-License-Identifier: Apache-2.0
// How a rank of the simulation decides, without a lock, whether a publish is the one that the server has appointed.
#pragma once
#include <atomic>
#include <cstdint>

namespace gxy::insitu {

/// Publishes are counted from 1. All ranks publish the same sequence, so the same count is the same step on all ranks. The server
/// appoints a count in the future, and each rank takes exactly that one, without asking the others.
///
/// The thread of the simulation calls publish(), publishLast(), isDue(), isNext() and count(); one other thread calls the rest. An appointment is taken or missed,
/// never both: both threads decide by an exchange of one word.
class Appointment {
 public:
  /// Counts a publish. True: it is the appointed one, and the caller takes it.
  bool publish() {
    const uint64_t count = count_.load(std::memory_order_relaxed) + 1;
    count_.store(count);
    uint64_t appointed = appointed_.load();
    return appointed == count && appointed_.compare_exchange_strong(appointed, 0);
  }

  /// Whether the next publish, or one after it, is appointed.
  bool isDue() const { return appointed_.load() > count_.load(); }

  /// Whether the next publish is appointed.
  bool isNext() const { return appointed_.load() == count_.load() + 1; }

  /// Takes what is appointed, if anything is, for the last publish of all: no other can come to the appointment. True: the caller
  /// takes it, and its count is the appointed one. False: nothing is counted.
  bool publishLast() {
    uint64_t appointed = appointed_.load();
    if (appointed <= count_.load() || !appointed_.compare_exchange_strong(appointed, 0)) return false;
    count_.store(appointed);
    return true;
  }

  /// Appoints a count. False: it has been published already, so that it is missed.
  bool appoint(uint64_t count) {
    appointed_.store(count);
    // Either publish() sees the appointment, or this sees the count: both go through one order of all stores and loads.
    return count_.load() < count || !cancel(count);
  }

  /// Takes an appointment back. False: the count has been taken, or was not appointed.
  bool cancel(uint64_t count) { return appointed_.compare_exchange_strong(count, 0); }

  uint64_t count() const { return count_.load(); }

 private:
  std::atomic<uint64_t> count_ = 0;
  std::atomic<uint64_t> appointed_ = 0;  ///< 0: none
};

}  // namespace gxy::insitu
