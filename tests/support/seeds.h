// SPDX-License-Identifier: Apache-2.0
// How many seeds, rays or inputs a test tries, where sanitizers make each of them cost many times as much.
#pragma once

#if defined(__SANITIZE_ADDRESS__)
#define GXY_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define GXY_ADDRESS_SANITIZER 1
#endif
#endif

namespace gxy::test {

/// Returns the number of schedules of a seeded world that a test tries. Such a world has one thread, in which
/// the thread sanitizer finds nothing at twenty times the cost, so with it a twentieth is tried; with the
/// address sanitizer a tenth, as what schedules can do wrong is for the release suite to find.
constexpr int seeds(int many) {
#if defined(__SANITIZE_THREAD__)
  return many / 20 > 2 ? many / 20 : 2;
#elif defined(GXY_ADDRESS_SANITIZER)
  return many / 10 > 2 ? many / 10 : 2;
#else
  return many;
#endif
}

/// Returns how many rays, inputs or rounds of one kind a test tries: all in the release suite, which is to find wrong
/// numbers, and an eighth with a sanitizer, which is to find wrong accesses and races on the ways that all of them take.
constexpr int sweep(int many) {
#if defined(GXY_ADDRESS_SANITIZER) || defined(__SANITIZE_THREAD__)
  return many / 8 > 2 ? many / 8 : 2;
#else
  return many;
#endif
}

}  // namespace gxy::test
