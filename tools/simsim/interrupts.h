// SPDX-License-Identifier: Apache-2.0
// Ctrl-C (SIGINT) and SIGTERM, as requests to end at the next suitable moment.
#pragma once
#include <csignal>
#include <exception>

namespace gxy::simsim {

/// Thrown where the work ends because of a signal.
struct Interrupted : std::exception {
  explicit Interrupted(int which) : signal(which) {}
  const char* what() const noexcept override { return "interrupted"; }
  int signal;
};

/// Holds the two signals back from this thread and from all threads that it makes later. So no handler runs,
/// and no call is interrupted; wait() and check() see a signal that has come. A signal that whoever started
/// this process has it ignore stays ignored.
class Interrupts {
 public:
  Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;

  /// Waits for so many seconds. Throws Interrupted as soon as one of the signals comes.
  void wait(double seconds) const;
  /// Throws Interrupted if one of the signals has come.
  void check() const { wait(0); }

 private:
  sigset_t signals_;
};

}  // namespace gxy::simsim
