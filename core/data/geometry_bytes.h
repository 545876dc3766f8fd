// SPDX-License-Identifier: Apache-2.0
// How much memory geometry takes, and its form in messages.
#pragma once
#include <cstdint>

#include "core/comm/wire.h"
#include "core/data/geometry.h"

namespace gxy {

/// Returns the memory of the arrays of a block, in bytes.
inline int64_t bytesOf(const GeometryBlock& b) {
  const auto bytes = [](const auto& array) { return array.size() * sizeof(array[0]); };
  size_t fields = 0;
  for (const PointField& f : b.fields) fields += bytes(f.values);
  return int64_t(fields + bytes(b.points) + bytes(b.normals) + bytes(b.values) + bytes(b.colors) +
                 bytes(b.radiusValues) + bytes(b.triangles) + bytes(b.segments) + bytes(b.neighbours) +
                 bytes(b.ids));
}

/// Appends a block to a message.
void write(Writer& writer, const GeometryBlock& block);
/// Reads a block that write() has written. Throws Error if the message is too short, or announces more fields than there can be.
/// validate() checks the rest.
GeometryBlock readBlock(Reader& reader);

}  // namespace gxy
