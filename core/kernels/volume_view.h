// SPDX-License-Identifier: Apache-2.0
// One volume of one partition as the kernels see it, and how C++ and ISPC fetch from it. Filled by the host in
// gxy::single (ISPC reads the same bytes) or gxy::twin. In GLSL, and in C++ that writes for it (GXY_LAYOUT: the structures
// alone), what is a pointer here is a place in a buffer; GLSL fetches in shaders/fetch_volume.glsl.

#if defined(GXY_GLSL) || defined(GXY_LAYOUT)
#define PTR(T) uint
#define RAW uint
#define VOLUME VolumeView
#elif defined(ISPC)
#define PTR(T) const uniform T* uniform
#define RAW const void* uniform
#define BYTE unsigned int8
#define VOLUME const uniform VolumeView&
#else
#define PTR(T) const T*
#define RAW const void*
#define BYTE std::uint8_t
#define VOLUME const VolumeView&
#endif

// Sample kinds: stored type of the block, in the order of ISPC's cheapest first.
#define SAMPLE_F32 0
#define SAMPLE_U8 1
#define SAMPLE_I8 2
#define SAMPLE_U16 3
#define SAMPLE_I16 4

struct VolumeView {
  RAW samples;                        // in bricks, see below, `stride` components together
  int kind, stride, component;        // component < 0: the magnitude of all
  int wide;                           // 1: more than 2^31 bytes, needs 64-bit offsets
  int brickRow, brickLayer;           // places in a row of bricks, and in a layer of such rows
  int firstX, firstY, firstZ;         // global index of its first point
  int lastX, lastY, lastZ;            // global index of its last point
  int cellsX, cellsY, cellsZ;         // cells of the global grid
  real originX, originY, originZ;     // of the global grid, in render space
  real inverseX, inverseY, inverseZ;  // cells per unit of render space

  PTR(int) plan;                              // per macrocell of the block, see volume.h
  int byCells;                                // whether any of them goes cell by cell
  PTR(int) isoPlan;                           // see core/rays/iso_plan.h
  int macroX, macroY;                         // macrocells per row and per column
  int macroFirstX, macroFirstY, macroFirstZ;  // global index of the first

  int mapUniform, mapBuckets, mapIntervals;  // see map.h
  real mapOrigin, mapInverse;
  real nanRed, nanGreen, nanBlue;  // colour where there is no value
  real hidden;                     // CompiledOperator::hidden
  PTR(int) buckets;
  PTR(real) nodes;    // start of each interval
  PTR(real) lengths;  // inverse length of each interval
  PTR(real) rows;     // of at most 16 intervals: 10 rows of 16, the nodes, lengths and pieces; else null
  PTR(real) pieces;   // 8 per interval: sigma, its step, then r, g, b each with its step
  PTR(real)
  sums;  // 8 per interval: integrals of sigma and sigma * rgb from the last opaque interval to its start,
         // and what rounding left of them, which counts where two that are large and alike are subtracted
  PTR(int) opaque;  // the last opaque interval before it, or -1

  int isovalues;
  PTR(real) isovalue;
  int clips;
  PTR(real) clip;  // 4 per plane: keeps n . p >= offset, render space
};

#if !defined(GXY_LAYOUT)
// Points lie in bricks of 8^3, x fastest in each and among them. What index i of an axis adds to a point's place, and how far
// from there the next one is, of an axis on which points of a brick are `near` apart and bricks `far`.
#define BRICK_PLACE(i, far, near) (((i) >> 3) * (far) + ((i)&7) * (near))
#define BRICK_STEP(i, far, near) (((i)&7) == 7 ? (far)-7 * (near) : (near))

FN vec3 gridOrigin(VOLUME v) { return make_v3(v.originX, v.originY, v.originZ); }
FN vec3 gridInverse(VOLUME v) { return make_v3(v.inverseX, v.inverseY, v.inverseZ); }
FN ivec3 gridCells(VOLUME v) { return make_i3(v.cellsX, v.cellsY, v.cellsZ); }

FN int macroIndex(VOLUME v, ivec3 m) {
  return ((m.z - v.macroFirstZ) * (v.macroX * v.macroY) + (m.y - v.macroFirstY) * v.macroX) +
         (m.x - v.macroFirstX);
}
FN UNIFORM int macroRow(VOLUME v) { return v.macroX; }
FN UNIFORM int macroSlice(VOLUME v) { return v.macroX * v.macroY; }
FN UNIFORM int mapUniform(VOLUME v) { return v.mapUniform; }
FN UNIFORM real mapOrigin(VOLUME v) { return v.mapOrigin; }
FN UNIFORM real mapInverse(VOLUME v) { return v.mapInverse; }
FN UNIFORM int mapBuckets(VOLUME v) { return v.mapBuckets; }
FN UNIFORM int mapIntervals(VOLUME v) { return v.mapIntervals; }
#define MAP_SMALL \
  16  // intervals of maps that are searched by comparing; their nodes are filled up with infinities
#if !defined(GXY_GLSL)  // has constants for them
FN UNIFORM bool mapIsSmall(VOLUME v) { return v.mapIntervals <= MAP_SMALL; }
FN UNIFORM bool mapIsUniform(VOLUME v) { return v.mapUniform > 0; }
#endif
struct MapPiece {
  real sigma, sigmaStep;
  vec3 color, colorStep;
};
struct MapSum {
  real sigma, sigmaRest;
  vec3 source, sourceRest;
};
#if defined(GXY_GLSL)
#include "shaders/fetch_volume.glsl"
#else
FN int planAt(VOLUME v, int index) { return v.plan[index]; }
FN UNIFORM bool someByCells(VOLUME v) { return v.byCells != 0; }
FN int isoWord(VOLUME v, int index) { return v.isoPlan[index]; }
#if defined(ISPC)
static inline uniform float isovalueAt(VOLUME v, uniform int i) { return v.isovalue[i]; }
static inline uniform float clipValue(VOLUME v, uniform int i) { return v.clip[i]; }
#else
FN real isovalueAt(VOLUME v, int i) { return v.isovalue[i]; }
FN real clipValue(VOLUME v, int i) { return v.clip[i]; }
#endif
FN int mapBucket(VOLUME v, int i) { return v.buckets[i]; }
#if defined(ISPC)
// A gang of 16 or 8 reads a map of at most 16 intervals as rows, one or two vectors for each quantity: to pick lanes of a
// register is cheaper than to gather.
static inline uniform bool mapInRows(VOLUME v) { return programCount >= 8 && v.rows != NULL; }
static inline float fromRow(VOLUME v, uniform int row, int k) {
  float value;
  unmasked {
    value = shuffle(v.rows[16 * row + programIndex], k & (programCount - 1));
    if (programCount == 8 && v.mapIntervals > 8) {
      float upper = shuffle(v.rows[16 * row + 8 + programIndex], k & 7);
      value = k < 8 ? value : upper;
    }
  }
  return value;
}
static inline uniform float mapNode(VOLUME v, uniform int k) { return v.nodes[k]; }
static inline float mapNode(VOLUME v, int k) {
  if (mapInRows(v)) return fromRow(v, 0, k);
  return v.nodes[k];
}
static inline float mapInverseLength(VOLUME v, int k) {
  if (mapInRows(v)) return fromRow(v, 1, k);
  return v.lengths[k];
}
static inline MapPiece mapPiece(VOLUME v, int k) {
  MapPiece m;
  if (mapInRows(v)) {
    m.sigma = fromRow(v, 2, k);
    m.sigmaStep = fromRow(v, 3, k);
    m.color = make_v3(fromRow(v, 4, k), fromRow(v, 6, k), fromRow(v, 8, k));
    m.colorStep = make_v3(fromRow(v, 5, k), fromRow(v, 7, k), fromRow(v, 9, k));
  } else {
    m.sigma = v.pieces[8 * k];
    m.sigmaStep = v.pieces[8 * k + 1];
    m.color = make_v3(v.pieces[8 * k + 2], v.pieces[8 * k + 4], v.pieces[8 * k + 6]);
    m.colorStep = make_v3(v.pieces[8 * k + 3], v.pieces[8 * k + 5], v.pieces[8 * k + 7]);
  }
  return m;
}
#else
FN real mapNode(VOLUME v, int k) { return v.nodes[k]; }
FN real mapInverseLength(VOLUME v, int k) { return v.lengths[k]; }
FN MapPiece mapPiece(VOLUME v, int k) {
  PTR(real) p = v.pieces + 8 * k;
  return {p[0], p[1], make_v3(p[2], p[4], p[6]), make_v3(p[3], p[5], p[7])};
}
#endif
FN int mapNodesUpTo(VOLUME v, real s) {
  int k = 0;
  if (mapIntervals(v) > 8) {
    k += s >= mapNode(v, 8) ? 8 : 0;
    k += s >= mapNode(v, k + 4) ? 4 : 0;
    k += s >= mapNode(v, k + 2) ? 2 : 0;
    k += s >= mapNode(v, k + 1) ? 1 : 0;
  } else {
    for (UNIFORM int i = 1; i < mapIntervals(v); i++) k += s >= mapNode(v, i) ? 1 : 0;
  }
  return k;
}
FN int mapOpaque(VOLUME v, int k) { return v.opaque[k]; }
FN MapSum mapSum(VOLUME v, int k) {
  MapSum s;
  s.sigma = v.sums[8 * k];
  s.source = make_v3(v.sums[8 * k + 1], v.sums[8 * k + 2], v.sums[8 * k + 3]);
  s.sigmaRest = v.sums[8 * k + 4];
  s.sourceRest = make_v3(v.sums[8 * k + 5], v.sums[8 * k + 6], v.sums[8 * k + 7]);
  return s;
}

// Number i of the block, whatever the stored type.
#if defined(ISPC)
#define OFFSET int64
// Of one over 2^31 bytes: a gather of ISPC's takes 32-bit offsets, whatever the type of its index. Those from a base per 2^28
// samples fit.
static noinline float storedAt(VOLUME v, int64 i) {
  float value = 0;
  int page = (int)(i >> 28);
  int at = (int)(i & 0xfffffff);
  foreach_unique(p in page) {
    uniform int64 first = (uniform int64)p << 28;
    if (v.kind == SAMPLE_F32)
      value = ((const uniform float* uniform)v.samples + first)[at];
    else if (v.kind == SAMPLE_U8)
      value = (float)((const uniform unsigned int8* uniform)v.samples + first)[at];
    else if (v.kind == SAMPLE_I8)
      value = (float)((const uniform int8* uniform)v.samples + first)[at];
    else if (v.kind == SAMPLE_U16)
      value = (float)((const uniform unsigned int16* uniform)v.samples + first)[at];
    else
      value = (float)((const uniform int16* uniform)v.samples + first)[at];
  }
  return value;
}
#else
#define OFFSET std::int64_t
FN real storedAt(VOLUME v, OFFSET i) {
  if (v.kind == SAMPLE_F32) return real(static_cast<const float*>(v.samples)[i]);
  if (v.kind == SAMPLE_U8) return real(static_cast<const std::uint8_t*>(v.samples)[i]);
  if (v.kind == SAMPLE_I8) return real(static_cast<const std::int8_t*>(v.samples)[i]);
  if (v.kind == SAMPLE_U16) return real(static_cast<const std::uint16_t*>(v.samples)[i]);
  return real(static_cast<const std::int16_t*>(v.samples)[i]);
}
#endif

// The scalar of point i.
FN_OUTLINE real scalarAt(VOLUME v, OFFSET i) {
  if (v.component >= 0) return storedAt(v, i * v.stride + v.component);
  real s = R(0.0);
  for (UNIFORM int c = 0; c < v.stride; c++) {
    real x = storedAt(v, i * v.stride + c);
    s += x * x;
  }
  return sqrt(s);
}

FN OFFSET pointPlace(VOLUME v, ivec3 p) {
  int x = p.x - v.firstX, y = p.y - v.firstY, z = p.z - v.firstZ;
  return BRICK_PLACE((OFFSET)x, 512, 1) + BRICK_PLACE((OFFSET)y, v.brickRow, 8) +
         BRICK_PLACE((OFFSET)z, v.brickLayer, 64);
}

// Of any block; in ISPC of one over 2^31 bytes, as this is slow. Out of line: the common case stays small.
FN_OUTLINE Corners cellCornersOfAny(VOLUME v, ivec3 c) {
  Corners k;
  int x = BRICK_STEP(c.x - v.firstX, 512, 1), y = BRICK_STEP(c.y - v.firstY, v.brickRow, 8);
  OFFSET b = pointPlace(v, c);
  OFFSET h = b + BRICK_STEP(c.z - v.firstZ, v.brickLayer, 64);
  k.v000 = scalarAt(v, b);
  k.v100 = scalarAt(v, b + x);
  k.v010 = scalarAt(v, b + y);
  k.v110 = scalarAt(v, b + y + x);
  k.v001 = scalarAt(v, h);
  k.v101 = scalarAt(v, h + x);
  k.v011 = scalarAt(v, h + y);
  k.v111 = scalarAt(v, h + y + x);
  return k;
}

#if defined(ISPC)
// Of a block within 2^31 bytes, whose numbers are `x` and `y` apart from `b` and `h` on.
static inline Corners floatCorners(const uniform float* uniform s, int b, int h, int x, int y) {
  Corners k = {s[b], s[b + x], s[b + y], s[b + y + x], s[h], s[h + x], s[h + y], s[h + y + x]};
  return k;
}
// Integers come with the words that they lie in, 2^log2 in each, as there is no gather of less than a word.
// Blocks end with whole words.
static inline float integerAt(const uniform unsigned int32* uniform words, int i, uniform int log2,
                              uniform bool isSigned) {
  uniform int others = 32 - (32 >> log2);  // bits of the word's other numbers
  int top = (int)(words[i >> log2] << (others - ((i & ((1 << log2) - 1)) << (5 - log2))));
  return (float)(isSigned ? top >> others : (int)((unsigned int)top >> others));
}
static inline Corners integerCorners(VOLUME v, int b, int h, int x, int y, uniform int log2,
                                     uniform bool isSigned) {
  const uniform unsigned int32* uniform w = (const uniform unsigned int32* uniform)v.samples;
  Corners k = {integerAt(w, b, log2, isSigned),     integerAt(w, b + x, log2, isSigned),
               integerAt(w, b + y, log2, isSigned), integerAt(w, b + y + x, log2, isSigned),
               integerAt(w, h, log2, isSigned),     integerAt(w, h + x, log2, isSigned),
               integerAt(w, h + y, log2, isSigned), integerAt(w, h + y + x, log2, isSigned)};
  return k;
}
static noinline Corners storedCorners(VOLUME v, int b, int h, int x, int y) {
  if (v.kind == SAMPLE_U8) return integerCorners(v, b, h, x, y, 2, false);
  if (v.kind == SAMPLE_I8) return integerCorners(v, b, h, x, y, 2, true);
  if (v.kind == SAMPLE_U16) return integerCorners(v, b, h, x, y, 1, false);
  if (v.kind == SAMPLE_I16) return integerCorners(v, b, h, x, y, 1, true);
  return floatCorners((const uniform float* uniform)v.samples, b, h, x, y);
}
static noinline Corners componentCorners(VOLUME v, int b, int h, int x, int y) {
  uniform int n = v.stride, c = v.component;
  if (c >= 0) return storedCorners(v, b * n + c, h * n + c, x * n, y * n);
  Corners sum = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
  for (c = 0; c < n; c++) {
    Corners k = storedCorners(v, b * n + c, h * n + c, x * n, y * n);
    sum.v000 += k.v000 * k.v000;
    sum.v100 += k.v100 * k.v100;
    sum.v010 += k.v010 * k.v010;
    sum.v110 += k.v110 * k.v110;
    sum.v001 += k.v001 * k.v001;
    sum.v101 += k.v101 * k.v101;
    sum.v011 += k.v011 * k.v011;
    sum.v111 += k.v111 * k.v111;
  }
  Corners root = {sqrt(sum.v000), sqrt(sum.v100), sqrt(sum.v010), sqrt(sum.v110),
                  sqrt(sum.v001), sqrt(sum.v101), sqrt(sum.v011), sqrt(sum.v111)};
  return root;
}
#endif

// The eight corner values of a cell that the block holds.
FN Corners cellCorners(VOLUME v, ivec3 c) {
#if defined(ISPC)
  if (v.wide != 0) return cellCornersOfAny(v, c);
#else
  if (v.kind != SAMPLE_F32 || v.stride != 1 || v.wide != 0) return cellCornersOfAny(v, c);
#endif
  int cx = c.x - v.firstX, cy = c.y - v.firstY, cz = c.z - v.firstZ;
  int x = BRICK_STEP(cx, 512, 1), y = BRICK_STEP(cy, v.brickRow, 8);
  int b = BRICK_PLACE(cx, 512, 1) + BRICK_PLACE(cy, v.brickRow, 8) + BRICK_PLACE(cz, v.brickLayer, 64);
  int h = b + BRICK_STEP(cz, v.brickLayer, 64);
#if defined(ISPC)
  if (v.stride != 1) return componentCorners(v, b, h, x, y);
  if (v.kind != SAMPLE_F32) return storedCorners(v, b, h, x, y);
  return floatCorners((const uniform float* uniform)v.samples, b, h, x, y);
#else
  const float* s = static_cast<const float*>(v.samples);
  return {s[b], s[b + x], s[b + y], s[b + y + x], s[h], s[h + x], s[h + y], s[h + y + x]};
#endif
}
#endif
#endif
