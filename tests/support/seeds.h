// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace gxy::test {

/// How many schedules of a seeded world are tried. Such a world has one thread, of which the thread sanitizer has nothing to
/// say at twenty times the price: there, a twentieth.
constexpr int seeds(int many) {
#ifdef __SANITIZE_THREAD__
  return many / 20 > 2 ? many / 20 : 2;
#else
  return many;
#endif
}

}  // namespace gxy::test
