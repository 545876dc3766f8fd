// SPDX-License-Identifier: Apache-2.0
// How doubles of a simulation are sent as floats, once the server knows what range they have.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/comm/transport.h"
#include "insitu/plan/description.h"

namespace gxy::insitu {

/// A field of a grid, of doubles, that is sent as floats: (value - shift) / scale (core/data/scalar.h).
struct FieldEncoding {
  uint32_t mesh = 0, field = 0;
  double shift = 0, scale = 1;
  bool operator==(const FieldEncoding&) const = default;
};
/// Of all fields that are sent so; others are sent as they are. At most one of each field.
using Encodings = std::vector<FieldEncoding>;

/// Returns the encoding of a field; null if it is sent as it is.
const FieldEncoding* encodingIn(const Encodings& encodings, size_t mesh, size_t field);
/// Whether a field may be sent as floats with this shift and scale: a double of a grid. The scale is a power of two whose inverse is
/// exact, and a field of several components has no shift.
bool mayBeEncoded(std::span<const Mesh> meshes, const FieldEncoding& encoding);
/// Returns the meshes with the types that their fields are sent as.
std::vector<Mesh> encoded(std::vector<Mesh> meshes, const Encodings& encodings);

Bytes written(const Encodings& encodings);
/// Throws Error for anything else, and for fields that may not be encoded.
Encodings readEncodings(std::span<const std::byte> message, std::span<const Mesh> meshes);

}  // namespace gxy::insitu
