// SPDX-License-Identifier: Apache-2.0
#include "insitu/client/interrupt.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>

#include "core/comm/error.h"

namespace gxy::insitu {

Interrupt::Interrupt() : event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (event_ < 0) throw Error("no file descriptor is left");
}

Interrupt::~Interrupt() { ::close(event_); }

void Interrupt::wake() {
  const uint64_t one = 1;
  [[maybe_unused]] const auto written =
      ::write(event_, &one, sizeof one);  // fails only where it is awake already
}

void Interrupt::close() {
  closed_ = true;
  wake();
}

void Interrupt::wait(std::span<pollfd> sockets, Clock::time_point until) {
  if (closed_) throw Closing();
  sockets.back() = {event_, POLLIN, 0};
  int milliseconds = -1;
  if (until != Clock::time_point::max()) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    milliseconds = int(std::clamp<int64_t>(left, 0, 3600 * 1000));
  }
  ::poll(sockets.data(), nfds_t(sockets.size()), milliseconds);
  uint64_t count;
  [[maybe_unused]] const auto bytes = ::read(event_, &count, sizeof count);
  if (closed_) throw Closing();
}

}  // namespace gxy::insitu
