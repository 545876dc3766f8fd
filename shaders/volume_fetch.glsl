// SPDX-License-Identifier: Apache-2.0
// How GLSL reads a VolumeView (core/kernels/volume_view.h). Its arrays are places in the scene's tables and
// samples.

// Gives the result of grid.h's locateCell without loops. Software devices would run those masked in every
// round of a march, and count them (wasCutShort in resumable.glsl). Inside the grid the estimate is off by one at most.
#undef locateCell
int locateCell(real t, real po, real pd, real rpd, int n) {
  int i = toInt(clamp1(floor(po + t * pd), 0.0, toReal(n - 1)));
  bool backward = rpd < 0.0;
  real below = planeCrossing(i, po, rpd), above = planeCrossing(i + 1, po, rpd);
  bool down = backward ? below <= t : below > t, up = backward ? above > t : above <= t;
  if (up && i < n - 1)
    i += 1;
  else if (down && i > 0)
    i -= 1;
  return i;
}

int planAt(VOLUME v, int index) { return int(tableWord(v.plan + uint(index))); }
bool anyCellwise(VOLUME v) { return BY_CELLS && v.byCells != 0; }
int isoWord(VOLUME v, int index) { return int(tableWord(v.isoMask + uint(index))); }
real isovalueAt(VOLUME v, int i) { return tableReal(v.isovalue + uint(i)); }
bool holdsSamples(VOLUME v) { return v.samples != 0u; }

int sampleKindOf(VOLUME v) { return SAMPLE_KIND >= 0 ? SAMPLE_KIND : v.kind; }

// The number i of the block, of any stored type.
real storedAt(VOLUME v, uint i) {
  real value;
  if (sampleKindOf(v) == SAMPLE_F32) {
    value = uintBitsToFloat(sampleWord(v.samples, i));
  } else if (sampleKindOf(v) <= SAMPLE_I8) {
    uint word = sampleWord(v.samples, i >> 2);
    int at = int(uint(i) & 3u) * 8;
    float natural = float(bitfieldExtract(word, at, 8)), signed8 = float(bitfieldExtract(int(word), at, 8));
    value = sampleKindOf(v) == SAMPLE_U8 ? natural : signed8;
  } else {
    uint word = sampleWord(v.samples, i >> 1);
    int at = int(uint(i) & 1u) * 16;
    float natural = float(bitfieldExtract(word, at, 16)), signed16 = float(bitfieldExtract(int(word), at, 16));
    value = sampleKindOf(v) == SAMPLE_U16 ? natural : signed16;
  }
  return value;
}

uint pointPlace(VOLUME v, ivec3 p) {
  uint x = uint(p.x - v.firstX), y = uint(p.y - v.firstY), z = uint(p.z - v.firstZ);
  return BRICK_PLACE(x, 512u, 1u) + BRICK_PLACE(y, uint(v.brickRow), 8u) + BRICK_PLACE(z, uint(v.brickLayer), 64u);
}

// The eight corner values of a cell that the block holds: the only component, one of several, or the
// magnitude of all. Components are read in one loop, because devices compile code once for each place where
// it occurs.
CellValues cellValues(VOLUME v, ivec3 c) {
  uint x = uint(BRICK_STEP(c.x - v.firstX, 512, 1)), y = uint(BRICK_STEP(c.y - v.firstY, v.brickRow, 8));
  uint b = pointPlace(v, c);
  uint h = b + uint(BRICK_STEP(c.z - v.firstZ, v.brickLayer, 64));
  CellValues k;
#define EACH_CORNER(DO) DO(v000, b) DO(v100, b + x) DO(v010, b + y) DO(v110, b + y + x) \
  DO(v001, h) DO(v101, h + x) DO(v011, h + y) DO(v111, h + y + x)
#define READ(corner, i) k.corner = storedAt(v, i);
  if (SCALARS) {
    EACH_CORNER(READ)
  } else {
#define CLEAR(corner, i) k.corner = 0.0;
#define ADD_SQUARE(corner, i)                                \
  {                                                          \
    real value = storedAt(v, (i) * uint(v.stride) + uint(n)); \
    k.corner = all ? k.corner + value * value : value;       \
  }
#define ROOT(corner, i) k.corner = sqrt(k.corner);
    bool all = v.component < 0;
    int last = all ? v.stride : v.component + 1;
    EACH_CORNER(CLEAR)
    for (int n = all ? 0 : v.component; n < last; n++) {
      EACH_CORNER(ADD_SQUARE)
    }
    if (all) {
      EACH_CORNER(ROOT)
    }
  }
  return k;
}
#undef EACH_CORNER
#undef READ
#undef CLEAR
#undef ADD_SQUARE
#undef ROOT
