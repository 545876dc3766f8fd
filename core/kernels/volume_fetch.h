// SPDX-License-Identifier: Apache-2.0
// How C++ reads a VolumeView (volume_view.h).

FN real isovalueAt(VOLUME v, int i) { return v.isovalue[i]; }

// Number i of the block, whatever the stored type.
#define OFFSET std::int64_t
FN real storedAt(VOLUME v, OFFSET i) {
  if (v.kind == SAMPLE_F32) return real(static_cast<const float*>(v.samples)[i]);
  if (v.kind == SAMPLE_U8) return real(static_cast<const std::uint8_t*>(v.samples)[i]);
  if (v.kind == SAMPLE_I8) return real(static_cast<const std::int8_t*>(v.samples)[i]);
  if (v.kind == SAMPLE_U16) return real(static_cast<const std::uint16_t*>(v.samples)[i]);
  return real(static_cast<const std::int16_t*>(v.samples)[i]);
}

#include "core/kernels/volume_pointers.h"

// The eight corner values of a cell that the block holds.
FN CellValues cellValues(VOLUME v, ivec3 c) {
  if (v.kind != SAMPLE_F32 || v.stride != 1 || v.wide != 0) return cellValuesOfAny(v, c);
  int cx = c.x - v.firstX, cy = c.y - v.firstY, cz = c.z - v.firstZ;
  int x = BRICK_STEP(cx, 512, 1), y = BRICK_STEP(cy, v.brickRow, 8);
  int b = BRICK_PLACE(cx, 512, 1) + BRICK_PLACE(cy, v.brickRow, 8) + BRICK_PLACE(cz, v.brickLayer, 64);
  int h = b + BRICK_STEP(cz, v.brickLayer, 64);
  const float* s = static_cast<const float*>(v.samples);
  return {s[b], s[b + x], s[b + y], s[b + y + x], s[h], s[h + x], s[h + y], s[h + y + x]};
}
