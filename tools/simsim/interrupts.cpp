// SPDX-License-Identifier: Apache-2.0
#include "tools/simsim/interrupts.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <ctime>

namespace gxy::simsim {

Interrupts::Interrupts() {
  sigemptyset(&signals_);
  for (const int signal : {SIGINT, SIGTERM}) {
    struct sigaction now {};
    if (sigaction(signal, nullptr, &now) == 0 && now.sa_handler != SIG_IGN) sigaddset(&signals_, signal);
  }
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
}

void Interrupts::wait(double seconds) const {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  for (;;) {
    const double left = std::max(0.0, std::chrono::duration<double>(end - Clock::now()).count());
    const timespec time{time_t(left), long((left - std::floor(left)) * 1e9)};
    const int signal = sigtimedwait(&signals_, nullptr, &time);
    if (signal > 0) throw Interrupted(signal);
    if (errno != EINTR) return;  // EAGAIN: the time is over
  }
}

}  // namespace gxy::simsim
