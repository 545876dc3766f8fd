// SPDX-License-Identifier: Apache-2.0
// The fields of a head of a line, described once. GXY_HEAD_FIELDS(F) calls F(type, name, sent) for each
// four-byte field that all heads have, GXY_MESH_HEAD_FIELDS(F) for those that only heads in meshes have; `sent` says whether the field travels between ranks. The structure of arrays in C++
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
//
// Heads in meshes have doubles, each as two fields, the first of which has the lower half of its bits: (time, timeRest),
// (length, lengthRest), (fx, gx), (fy, gy) and (fz, gz). Their unit is that of the world, and the place is one in the
// cell's reference coordinates; of a head with HEAD_UNPLACED, which is a seed whose cell is not known yet, it is one in
// the world.
//   cellX, cellY        a number that is made of the places of the cell's points: the same one wherever the cell is
//   cellZ               the cell's number in its block, or -1 where the head has come from another one
//   near*               a place in the world near the head, for finding its cell
//   step                cells of way that the next step may have
//   info                HEAD_FACE(f): the head leaves its cell through face f
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

#define GXY_MESH_HEAD_FIELDS(F) \
  F(uint32, gx, 1)              \
  F(uint32, gy, 1)              \
  F(uint32, gz, 1)              \
  F(float, nearX, 1)            \
  F(float, nearY, 1)            \
  F(float, nearZ, 1)            \
  F(float, step, 1)

#define HEAD_BACKWARD 256u
#define HEAD_UNPLACED 512u
#define HEAD_FACE(face) (((face) + 1u) << 12)
#define HEAD_FACES 0x7000u
#define HEAD_LINE_HIGH 255u
#endif
