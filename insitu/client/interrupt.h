// SPDX-License-Identifier: Apache-2.0
// Wakes a thread that waits for sockets.
#pragma once
#include <poll.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <span>

namespace gxy::insitu {

/// Thrown out of a wait once the interrupt is closed.
class Closing : public std::exception {};

/// One thread waits; any thread wakes it.
class Interrupt {
 public:
  using Clock = std::chrono::steady_clock;

  /// Throws Error if the process has no file descriptor left.
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// Ends the present wait, or the next one.
  void wake();
  /// From now on, waits throw Closing.
  void close();

  /// Waits until one of the sockets is ready, somebody wakes this, or the time has come. `sockets` has room for one more at its
  /// end. Throws Closing.
  void wait(std::span<pollfd> sockets, Clock::time_point until = Clock::time_point::max());

 private:
  const int event_;
  std::atomic<bool> closed_ = false;
};

}  // namespace gxy::insitu
