// SPDX-License-Identifier: Apache-2.0
// The fields of stored points of lines as kernels write them, described once. GXY_STORED_FIELDS(F) calls
// F(type, name) for each four-byte field. C++ and ISPC read this file, so it holds only macros.
//
//   head       index of the head in its packet; < 0: there is no point at this place
//   number     of the point in its line
//   the others as in head_fields.h; speed in kernel lengths per kernel time, NaN without data
#ifndef GXY_STORED_FIELDS
#define GXY_STORED_FIELDS(F) \
  F(int32, head)             \
  F(int32, number)           \
  F(int32, cellX)            \
  F(int32, cellY)            \
  F(int32, cellZ)            \
  F(float, fx)               \
  F(float, fy)               \
  F(float, fz)               \
  F(float, time)             \
  F(float, timeRest)         \
  F(float, length)           \
  F(float, lengthRest)       \
  F(float, speed)
#endif
