// SPDX-License-Identifier: Apache-2.0
// How much memory geometry takes, and its form in messages.
#pragma once
#include <cstdint>

#include "core/comm/wire.h"
#include "core/data/block_arrays.h"
#include "core/data/geometry.h"

namespace gxy {

/// Returns the memory of the arrays of a block, in bytes.
inline int64_t bytesOf(const GeometryBlock& block) {
  int64_t sum = 0;
  const auto add = [&](auto of) { sum += int64_t(of(block).size() * sizeof(of(block)[0])); };
  forPointArrays(block.fields, [&](auto of, size_t) { add(of); });
  forPrimitiveArrays(add);
  return sum;
}

/// Appends a block to a message.
void write(Writer& writer, const GeometryBlock& block);
/// Reads a block that write() has written. Throws Error if the message is too short, or announces more fields than there can be.
/// validate() checks the rest.
GeometryBlock readBlock(Reader& reader);

}  // namespace gxy
