// SPDX-License-Identifier: Apache-2.0
#include "tools/simsim/blend.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace gxy::simsim {
namespace {

template <class T>
T blendValue(T a, T b, double weight) {
  if constexpr (std::is_floating_point_v<T>) {
    return (T(1) - T(weight)) * a + T(weight) * b;
  } else {
    using Real = std::conditional_t<(sizeof(T) < 8), double, long double>;
    const Real x = Real(a), y = Real(b), value = (1 - Real(weight)) * x + Real(weight) * y;
    // Rounding must not lead out of the type's range.
    return T(std::clamp(std::round(value), std::min(x, y), std::max(x, y)));
  }
}

template <class T>
std::span<const T> valuesIn(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
}
template <class T>
std::span<T> valuesIn(std::span<std::byte> bytes) {
  return {reinterpret_cast<T*>(bytes.data()), bytes.size() / sizeof(T)};
}

}  // namespace

double Wave::weight(int64_t step) const {
  const double turns = double(step - 1) * cycles / double(steps), phase = turns - std::floor(turns);
  return phase < 0.5 ? 2 * phase : 2 - 2 * phase;
}

void blend(ScalarType type, double weight, std::span<const std::byte> a, std::span<const std::byte> b,
           std::span<std::byte> out) {
  // A product with 0 would lose the sign of zeros, and let in what is not finite in the other file.
  if (weight == 0 || weight == 1) {
    std::ranges::copy(weight == 0 ? a : b, out.begin());
    return;
  }
  withType(type, [&]<class T>(T) {
    std::ranges::transform(valuesIn<T>(a), valuesIn<T>(b), valuesIn<T>(out).begin(),
                           [weight](T x, T y) { return blendValue(x, y, weight); });
  });
}

void fillWithNoData(ScalarType type, std::span<std::byte> out) {
  withType(type, [&]<class T>(T) {
    using Limits = std::numeric_limits<T>;
    std::ranges::fill(valuesIn<T>(out), Limits::has_quiet_NaN ? Limits::quiet_NaN() : Limits::max());
  });
}

}  // namespace gxy::simsim
