// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace gxy::test {

/// Returns the number of schedules of a seeded world that a test tries. Such a world has one thread, in which
/// the thread sanitizer finds nothing at twenty times the cost, so with it a twentieth is tried.
constexpr int seeds(int many) {
#ifdef __SANITIZE_THREAD__
  return many / 20 > 2 ? many / 20 : 2;
#else
  return many;
#endif
}

}  // namespace gxy::test
