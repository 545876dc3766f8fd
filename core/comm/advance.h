// SPDX-License-Identifier: Apache-2.0
// Reports the progress of a long computation, and can end it.
#pragma once
#include <cstddef>
#include <functional>

namespace gxy {

/// A long computation calls this with the fraction that it has done, from 0 to 1, every few milliseconds, as
/// long as it is in Galaxy's own loops and not in a library's. An exception thrown from here ends the
/// computation and reaches its caller. Several threads may call it at once. It is never empty.
using Advance = std::function<void(double fraction)>;

/// Returns the Advance for part `i` of `n` equal parts of a computation that reports to `advance`. `advance`
/// must outlive the result.
inline Advance partOf(const Advance& advance, size_t i, size_t n) {
  return [&advance, i, n](double fraction) { advance((double(i) + fraction) / double(n)); };
}

/// Loops of `n` iterations call this in each iteration `i`. It reports every 8192nd one.
inline void tell(const Advance& advance, size_t i, size_t n) {
  constexpr size_t kTurns = 8192;
  if (i % kTurns == 0) advance(double(i) / double(n));
}

}  // namespace gxy
