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
real clipValue(VOLUME v, int i) { return tableReal(v.clip + uint(i)); }
bool holdsSamples(VOLUME v) { return v.samples != 0u; }

// The rows (VolumeView::rows) of the only map that a stage reads, read ahead if it has few intervals
// (MAP_AHEAD). A device that fetches lane by lane picks a node from eight registers faster than it fetches
// one, and a piece from four.
struct MapRow {
  vec4 low, high;
};
MapRow mapRows[10];
float fromRow(int row, int k) {
  vec4 low = mapRows[row].low, high = mapRows[row].high;
  bool odd = (k & 1) != 0, second = (k & 2) != 0;
  float value = second ? (odd ? low.w : low.z) : (odd ? low.y : low.x);
  if (MAP_AHEAD > 4) {
    float upper = second ? (odd ? high.w : high.z) : (odd ? high.y : high.x);
    value = k < 4 ? value : upper;
  }
  return value;
}
#define PIECES_AHEAD (MAP_AHEAD == 4)
#define READ_MAP_ROW(i) \
  mapRows[i] = MapRow(tablesAhead[v.rows / 4u + 4u * uint(i)], tablesAhead[v.rows / 4u + 4u * uint(i) + 1u]);
void readMapAhead(VOLUME v) {
  if (MAP_AHEAD > 0) {
    READ_MAP_ROW(0)
    READ_MAP_ROW(1)
  }
  if (PIECES_AHEAD) {
    READ_MAP_ROW(2)
    READ_MAP_ROW(3)
    READ_MAP_ROW(4)
    READ_MAP_ROW(5)
    READ_MAP_ROW(6)
    READ_MAP_ROW(7)
    READ_MAP_ROW(8)
    READ_MAP_ROW(9)
  }
}

bool mapIsSmall(VOLUME v) {
  return MAP_AHEAD > 0 || (MAP_KIND >= 0 ? MAP_KIND == MAP_KIND_SMALL : v.mapIntervals <= MAP_SMALL);
}
bool mapIsUniform(VOLUME v) { return MAP_KIND >= 0 ? MAP_KIND == MAP_KIND_UNIFORM : v.mapUniform > 0; }
int mapBucket(VOLUME v, int i) { return int(tableWord(v.buckets + uint(i))); }
real mapNode(VOLUME v, int k) { return MAP_AHEAD > 0 ? fromRow(0, k) : tableReal(v.nodes + uint(k)); }
real mapInverseLength(VOLUME v, int k) {
  return MAP_AHEAD > 0 ? fromRow(1, k) : tableReal(v.lengths + uint(k));
}
MapPiece mapPiece(VOLUME v, int k) {
  MapPiece m;
  if (PIECES_AHEAD) {
    m.sigma = fromRow(2, k);
    m.sigmaStep = fromRow(3, k);
    m.color = vec3(fromRow(4, k), fromRow(6, k), fromRow(8, k));
    m.colorStep = vec3(fromRow(5, k), fromRow(7, k), fromRow(9, k));
  } else {
    uint p = v.pieces + 8u * uint(k);
    vec4 a = uintBitsToFloat(tableQuad(p)), b = uintBitsToFloat(tableQuad(p + 4u));
    m.sigma = a.x;
    m.sigmaStep = a.y;
    m.color = vec3(a.z, b.x, b.z);
    m.colorStep = vec3(a.w, b.y, b.w);
  }
  return m;
}
// It has no loop, because Mesa's software device allows few rounds of loops (wasCutShort in resumable.glsl).
int mapNodesUpTo(VOLUME v, real s) {
  int k;
  if (MAP_AHEAD > 0) {
    vec4 low = mapRows[0].low, high = mapRows[0].high;  // padded with infinities
    k = int(s >= low.y) + int(s >= low.z) + int(s >= low.w);
    if (MAP_AHEAD > 4) k += int(s >= high.x) + int(s >= high.y) + int(s >= high.z) + int(s >= high.w);
  } else {
    k = s >= mapNode(v, 8) ? 8 : 0;
    k += s >= mapNode(v, k + 4) ? 4 : 0;
    k += s >= mapNode(v, k + 2) ? 2 : 0;
    k += s >= mapNode(v, k + 1) ? 1 : 0;
  }
  return k;
}
int mapOpaque(VOLUME v, int k) { return int(tableWord(v.opaque + uint(k))); }
MapSum mapSum(VOLUME v, int k) {
  uint p = v.sums + 8u * uint(k);
  vec4 a = uintBitsToFloat(tableQuad(p)), b = uintBitsToFloat(tableQuad(p + 4u));
  MapSum s;
  s.sigma = a.x;
  s.source = a.yzw;
  s.sigmaRest = b.x;
  s.sourceRest = b.yzw;
  return s;
}

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
