// SPDX-License-Identifier: Apache-2.0
// One volume of one partition as the kernels see it. view_types.h must come before. Each dialect fetches in a file of its own, named
// volume_fetch: C++'s stands here, the others with their backends.

#if defined(GXY_GLSL) || defined(GXY_LAYOUT)
#define VOLUME VolumeView
#elif defined(ISPC)
#define VOLUME const uniform VolumeView&
#else
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
  PTR(int) isoMask;                           // see core/rays/iso_mask.h
  int macroX, macroY;                         // macrocells per row and per column
  int macroFirstX, macroFirstY, macroFirstZ;  // global index of the first

  int isovalues;
  PTR(real) isovalue;
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
#endif
