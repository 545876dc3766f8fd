// SPDX-License-Identifier: Apache-2.0
// How far a long computation is, and whether it is to go on.
#pragma once
#include <cstddef>
#include <functional>

namespace gxy {

/// Called by a long computation with the share that it has done, from 0 to 1, every few milliseconds while the loops are its
/// own: what it throws ends the computation and arrives at its caller. From any thread, perhaps from several at once. Never
/// empty.
using Advance = std::function<void(double share)>;

/// Of part `i` of `n` of what `advance`, which must outlive it, is told of.
inline Advance partOf(const Advance& advance, size_t i, size_t n) {
  return [&advance, i, n](double share) { advance((double(i) + share) / double(n)); };
}

/// For loops that call it at each of `n` turns: tells of one in some thousands.
inline void tell(const Advance& advance, size_t i, size_t n) {
  constexpr size_t kTurns = 8192;
  if (i % kTurns == 0) advance(double(i) / double(n));
}

}  // namespace gxy
