// SPDX-License-Identifier: Apache-2.0
// Types of sample values, and the conversion of wide types to float without losing their signal.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/comm/advance.h"
#include "core/data/box.h"
#include "core/space/large_vector.h"

namespace gxy {

enum class ScalarType : uint8_t {
  Int8,
  UInt8,
  Int16,
  UInt16,
  Int32,
  UInt32,
  Int64,
  UInt64,
  Float32,
  Float64
};
size_t bytesOf(ScalarType type);
const char* nameOf(ScalarType type);
/// Whether float cannot hold all of a type's values, so that they are stored as encodingOf() says.
bool isWide(ScalarType type);

/// Calls f(T{}) with the C++ type of `type`, and returns what it returns.
template <typename F>
auto withType(ScalarType type, F&& f) {
  switch (type) {
    case ScalarType::Int8:
      return f(int8_t{});
    case ScalarType::UInt8:
      return f(uint8_t{});
    case ScalarType::Int16:
      return f(int16_t{});
    case ScalarType::UInt16:
      return f(uint16_t{});
    case ScalarType::Int32:
      return f(int32_t{});
    case ScalarType::UInt32:
      return f(uint32_t{});
    case ScalarType::Int64:
      return f(int64_t{});
    case ScalarType::UInt64:
      return f(uint64_t{});
    case ScalarType::Float32:
      return f(float{});
    case ScalarType::Float64:
      break;
  }
  return f(double{});
}

/// Reverses the bytes of each value (for big-endian files). The size of `samples` is a multiple of
/// bytesPerValue. Throws Error unless bytesPerValue is 1, 2, 4 or 8.
void swapBytes(std::span<std::byte> samples, size_t bytesPerValue);

/// The relation of values to stored values: value = shift + scale * stored.
struct Encoding {
  ScalarType stored = ScalarType::Float32;
  double shift = 0, scale = 1;
  bool operator==(const Encoding&) const = default;
};

/// Returns the encoding of a field of `type` with values in `range`, which covers all ranks and all components.
///
/// Narrow types are stored as they are. Wide types become float. Their shift is 0 if the offset of the range
/// costs at most two bits. Otherwise it is the multiple of the power of two at or above half the range's width
/// that is nearest to the range's middle. It is off the middle by less than half the width, which costs at most
/// one of float's 24 bits, so that a range that drifts slowly keeps its encoding (docs/decisions/0023). It is
/// always 0 for several components, so that the magnitude of values is that of the stored values times the
/// scale. The scale is 1 if float's exponent has ample room: backends take denormals and squares that underflow
/// as 0. Otherwise it is a power of two that brings the values into [-1, 1]. Whole numbers stay exact where none
/// is further than 2^24 from the shift. Float is never shifted, so it loses no bit.
Encoding encodingOf(ScalarType type, int components, const Range& range);

/// Whether doubles may be stored as `known` says, as other values have been, in place of what encodingOf() says: it costs at most two
/// bits more, float's exponent has ample room, and whole numbers that would be exact stay so. False for other types.
bool suffices(const Encoding& known, ScalarType type, int components, const Range& range);

/// Samples of a volume in their stored type, as bytes.
using Samples = LargeVector<std::byte>;

/// Converts values of `type` to stored values, (value - shift) / scale, computed in double (long double for
/// 64-bit integers) and rounded once more to float. NaN and infinities stay as they are. Throws Error if the
/// size of `values` is no multiple of the type's size, or if a narrow type would change.
Samples convert(
    std::span<const std::byte> values, ScalarType type, const Encoding& encoding,
    const Advance& advance = [](double) {});

}  // namespace gxy
