// SPDX-License-Identifier: Apache-2.0
// The fields of a ray, described once. GXY_RAY_FIELDS(F) calls F(type, name, primary, secondary) for each
// four-byte field; the last two say whether the field travels with a primary and with a secondary ray. The
// structure of arrays in C++ (ray_list.h), the view in ISPC and the wire form are generated from it. C++,
// ISPC and GLSL read this file, so it holds only macros.
//
// A primary's origin and direction are not sent, because every rank regenerates the same bits from camera,
// pixel and sample.
//
//   pixel      index in the image, row 0 at the bottom
//   info       bits 0-15 sample, 16-17 kind (RAY_PRIMARY, ...), 18-19 start (START_*), 20 side of the start
//   start      secondary: surface it starts on, operator << 16 | isovalue or slice index
//   o*, d*     origin and unit direction in render space; t = 0 where the ray enters the visible domain,
//              or on the surface that it starts from
//   tLast      t of the last surface met (translucent), -1 if none; everything before it is done
//   tResume    t where a segment of the march begins that the partition before has handed on, -1 if none. A
//              segment is evaluated by the partition in which it ends (kernels/volume.h). So a partition
//              does not evaluate a segment that ends behind it, and hands on where the segment begins.
//   tMax       secondary: t of the light, or the ambient-occlusion radius
//   A          opacity so far, 1 - transmittance
//   r, g, b    primary: radiance accumulated so far
//   sr, sg, sb secondary: what the pixel loses if the ray is blocked, in units of 1 / CONTRIBUTION_ONE
//
// A sampling ray (RAY_SAMPLE) records data where it meets surfaces. It is traced as a primary is, to the
// first hit, and is sent as a secondary. Its fields mean
//   pixel, sr  its number, 64 bits, the lower half first
//   info       bits 0-15: the hits so far; the others as above
//   sg         how many rays it descends from
//   sb         not used
//   A          0
//
// Only while a packet is in one partition:
//   tIn, tOut  where the ray enters and leaves the partition (t in [tIn, tOut) belongs to it)
//   tEnd       where the ray leaves the visible domain or reaches tMax
//   tHit       nearest surface in this partition, NO_HIT if none
//   hitKind, hitOperator, hitPrimitive
//              the surface at tHit: HIT_*, its operator, and its number there
//   lastOperator, lastPrimitive
//              the surface at tLast, if that is in this partition: its operator, and its number (clip.h)
//   next       END_* or the partition that the ray goes to
#ifndef GXY_RAY_FIELDS
#define GXY_RAY_FIELDS(F)        \
  F(uint32, pixel, 1, 1)         \
  F(uint32, info, 1, 1)          \
  F(uint32, start, 0, 1)         \
  F(float, ox, 0, 1)             \
  F(float, oy, 0, 1)             \
  F(float, oz, 0, 1)             \
  F(float, dx, 0, 1)             \
  F(float, dy, 0, 1)             \
  F(float, dz, 0, 1)             \
  F(float, tLast, 1, 1)          \
  F(float, tResume, 1, 1)        \
  F(float, tMax, 0, 1)           \
  F(float, A, 1, 1)              \
  F(float, r, 1, 0)              \
  F(float, g, 1, 0)              \
  F(float, b, 1, 0)              \
  F(int32, sr, 0, 1)             \
  F(int32, sg, 0, 1)             \
  F(int32, sb, 0, 1)             \
  F(float, tIn, 0, 0)            \
  F(float, tOut, 0, 0)           \
  F(float, tEnd, 0, 0)           \
  F(float, tHit, 0, 0)           \
  F(int32, hitKind, 0, 0)        \
  F(int32, hitOperator, 0, 0)    \
  F(uint32, hitPrimitive, 0, 0)  \
  F(int32, lastOperator, 0, 0)   \
  F(uint32, lastPrimitive, 0, 0) \
  F(int32, next, 0, 0)

#define RAY_PRIMARY 0
#define RAY_SHADOW 1
#define RAY_OCCLUSION 2
#define RAY_SAMPLE 3
#define RAY_KIND(info) (((info) >> 16) & 3)
#define RAY_SAMPLE_NUMBER(info) ((info)&0xffff)
#define RAY_HITS(info) ((info)&0xffff)  // of a sampling ray

#define START_NONE 0
#define START_ISOSURFACE 1
#define START_SLICE 2
#define RAY_START(info) (((info) >> 18) & 3)
#define RAY_SIDE(info) (((info) >> 20) & 1)

#define HIT_NONE 0
#define HIT_GEOMETRY 1
#define HIT_SLICE 2
#define HIT_ISOSURFACE 3
#define HIT_STEP 4  // a multiple of a length, in a volume

// The reason why a ray ended in a partition, in place of a partition number.
#define END_DONE -1     // left the visible domain, reached its tMax, or became opaque
#define END_SURFACE -2  // met a surface, which is to be shaded
#define END_ACTIVE -3   // goes on in this partition behind a translucent surface

// One unit of a contribution to a pixel is 2^-26: 32-bit integers reach +-32, and quantisation (1.5e-8) is
// finer than float rounding.
#define CONTRIBUTION_ONE 67108864.0f
#endif
