// SPDX-License-Identifier: Apache-2.0
#include "core/data/scalar.h"

#include <cmath>
#include <cstring>
#include <type_traits>

#include "core/comm/error.h"

namespace gxy {
namespace {

template <size_t N>
void swapEach(std::span<std::byte> samples) {
  for (size_t i = 0; i + N <= samples.size(); i += N) std::reverse(&samples[i], &samples[i] + N);
}

/// Returns the smallest power of two that is >= x, for finite x > 0, within the range that division can use.
double powerAbove(double x) {
  int exponent;
  const double fraction = std::frexp(x, &exponent);
  if (fraction == 0.5) --exponent;
  return std::ldexp(1.0, std::clamp(exponent, -1021, 1023));
}

/// A shift and a bound of what is left of the values.
struct SteadyShift {
  double shift, bound;
};

/// Returns the multiple of the power of two at or above `half` that is nearest to `middle`, and twice this power: both
/// stay as they are while the range drifts a little. `half` > 0 is less than a quarter of the largest magnitude.
SteadyShift steadyShift(double middle, double half) {
  int exponent;
  if (std::frexp(half, &exponent) == 0.5) --exponent;
  const double multiple = std::round(std::scalbn(middle, -exponent));
  return {std::scalbn(multiple, exponent), std::scalbn(1.0, exponent + 1)};
}

}  // namespace

size_t bytesOf(ScalarType type) {
  return withType(type, [](auto t) { return sizeof(t); });
}

const char* nameOf(ScalarType type) {
  switch (type) {
    case ScalarType::Int8:
      return "int8";
    case ScalarType::UInt8:
      return "uint8";
    case ScalarType::Int16:
      return "int16";
    case ScalarType::UInt16:
      return "uint16";
    case ScalarType::Int32:
      return "int32";
    case ScalarType::UInt32:
      return "uint32";
    case ScalarType::Int64:
      return "int64";
    case ScalarType::UInt64:
      return "uint64";
    case ScalarType::Float32:
      return "float32";
    case ScalarType::Float64:
      break;
  }
  return "float64";
}

void swapBytes(std::span<std::byte> samples, size_t bytesPerValue) {
  switch (bytesPerValue) {
    case 1:
      return;
    case 2:
      return swapEach<2>(samples);
    case 4:
      return swapEach<4>(samples);
    case 8:
      return swapEach<8>(samples);
    default:
      throw Error("byte swap: values of " + std::to_string(bytesPerValue) + " bytes, expected 1, 2, 4 or 8");
  }
}

bool isWide(ScalarType type) {
  switch (type) {
    case ScalarType::Int32:
    case ScalarType::UInt32:
    case ScalarType::Int64:
    case ScalarType::UInt64:
    case ScalarType::Float64:
      return true;
    default:
      return false;
  }
}
Encoding encodingOf(ScalarType type, int components, const Range& range) {
  const bool wide = isWide(type);
  if (!wide && type != ScalarType::Float32) return {type};
  if (range.empty()) return {};
  const double half = range.max / 2 - range.min / 2;
  double largest = std::max(std::abs(range.min), std::abs(range.max));
  Encoding encoding;
  if (wide && components == 1 && largest > 4 * half) {
    const double middle = range.min / 2 + range.max / 2;
    if (half > 0) {
      const SteadyShift steady = steadyShift(middle, half);
      encoding.shift = steady.shift, largest = steady.bound;
    } else {
      encoding.shift = middle;
      largest = std::max(std::abs(range.min - middle), std::abs(range.max - middle));
    }
  }
  const double ample = 0x1p64;
  if (largest > 0 && (largest > ample || largest < 1 / ample)) encoding.scale = powerAbove(largest);
  return encoding;
}

bool suffices(const Encoding& known, ScalarType type, int components, const Range& range) {
  if (type != ScalarType::Float64 || known.stored != ScalarType::Float32 ||
      (components > 1 && known.shift != 0))
    return false;
  if (range.empty()) return true;
  const Encoding own = encodingOf(type, components, range);
  const auto largest = [&](double shift) {
    return std::max(std::abs(range.min - shift), std::abs(range.max - shift));
  };
  const double whole = 0x1p24, ample = 0x1p64;
  const double stored = largest(known.shift) / known.scale;
  const bool staysWhole = largest(known.shift) <= whole || largest(own.shift) > whole;
  return largest(known.shift) <= 4 * largest(own.shift) && staysWhole &&
         (stored == 0 || (stored >= 1 / ample && stored <= ample));
}

Samples convert(std::span<const std::byte> values, ScalarType type, const Encoding& encoding,
                const Advance& advance) {
  constexpr size_t kTold = size_t(1) << 20;  ///< number of values between two reports of progress
  if (values.size() % bytesOf(type) != 0) {
    throw Error("samples: " + std::to_string(values.size()) + " bytes of " + nameOf(type) +
                ", expected a multiple of " + std::to_string(bytesOf(type)));
  }
  if (!isWide(type) && encoding == Encoding{type}) return {values.begin(), values.end()};
  if (!(isWide(type) || type == ScalarType::Float32) || encoding.stored != ScalarType::Float32) {
    throw Error(std::string("samples: ") + nameOf(type) + " asked to be stored as " +
                nameOf(encoding.stored) + ", expected narrow types as they are and others as float32");
  }
  return withType(type, [&](auto t) {
    using T = decltype(t);
    using Wide = std::conditional_t<std::is_integral_v<T> && sizeof(T) == 8, long double, double>;
    const size_t count = values.size() / sizeof(T);
    Samples stored(count * sizeof(float));
    const Wide shift = encoding.shift, scale = encoding.scale;
    for (size_t first = 0; first < count; first += kTold) {
      advance(double(first) / double(count));
      for (size_t i = first; i < std::min(count, first + kTold); ++i) {
        T value;
        std::memcpy(&value, &values[i * sizeof(T)], sizeof(T));
        const float f = float((Wide(value) - shift) / scale);
        std::memcpy(&stored[i * sizeof(float)], &f, sizeof(float));
      }
    }
    return stored;
  });
}

}  // namespace gxy
