// SPDX-License-Identifier: Apache-2.0
// The fields of a head of a line, described once. GXY_HEAD_FIELDS(F) calls F(type, name, sent) for each
// four-byte field; `sent` says whether the field travels between ranks. The structure of arrays in C++
// (heads.h), the view in ISPC and the wire form are generated from it. C++ and ISPC read this file, so it
// holds only macros.
//
//   line       bits 0-31 of the line's number
//   info       bits 0-7: bits 32-39 of the line's number; HEAD_BACKWARD
//   cell*      cell of the grid
//   f*         place in the cell, in [0, 1]
//   time, timeRest      time since the seed, without sign, in the kernel's unit (compiled_fields.h): a sum of two
//                       floats, the second of which is what rounding left of the first
//   length, lengthRest  length since the seed, likewise
//   steps      cells that the head has been in, without the first
//   points     numbers that the line's stored points have used up: the next one is number `points`
//   stalled    crossings of faces since the head has last moved on, and trial steps in its cell (kernels/advect.h)
//   way        cells of way since then
//
// Only while a packet is in one partition:
//   fresh      whether the head has moved since the last stored point
//   reason     LINE_* (kernels/advect.h)
#ifndef GXY_HEAD_FIELDS
#define GXY_HEAD_FIELDS(F) \
  F(uint32, line, 1)       \
  F(uint32, info, 1)       \
  F(int32, cellX, 1)       \
  F(int32, cellY, 1)       \
  F(int32, cellZ, 1)       \
  F(float, fx, 1)          \
  F(float, fy, 1)          \
  F(float, fz, 1)          \
  F(float, time, 1)        \
  F(float, timeRest, 1)    \
  F(float, length, 1)      \
  F(float, lengthRest, 1)  \
  F(int32, steps, 1)       \
  F(int32, points, 1)      \
  F(int32, stalled, 1)     \
  F(float, way, 1)         \
  F(int32, fresh, 0)       \
  F(int32, reason, 0)

#define HEAD_BACKWARD 256u
#define HEAD_LINE_HIGH 255u
#endif
