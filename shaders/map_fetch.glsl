// SPDX-License-Identifier: Apache-2.0
// How GLSL reads a MapView and a ClipView (core/kernels/map_view.h). Their arrays are places in the scene's tables.

real clipValue(CLIPS clips, int i) { return tableReal(clips.plane + uint(i)); }

// The rows (MapView::rows) of the only map that a stage reads, read ahead if it has few intervals
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
  mapRows[i] = MapRow(tablesAhead[map.rows / 4u + 4u * uint(i)], tablesAhead[map.rows / 4u + 4u * uint(i) + 1u]);
void readMapAhead(MAP map) {
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

bool mapIsSmall(MAP map) {
  return MAP_AHEAD > 0 || (MAP_KIND >= 0 ? MAP_KIND == MAP_KIND_SMALL : map.intervals <= MAP_SMALL);
}
bool mapIsUniform(MAP map) { return MAP_KIND >= 0 ? MAP_KIND == MAP_KIND_UNIFORM : map.uniformIntervals > 0; }
int mapBucket(MAP map, int i) { return int(tableWord(map.bucket + uint(i))); }
real mapNode(MAP map, int k) { return MAP_AHEAD > 0 ? fromRow(0, k) : tableReal(map.nodes + uint(k)); }
real mapInverseLength(MAP map, int k) {
  return MAP_AHEAD > 0 ? fromRow(1, k) : tableReal(map.spans + 4u * uint(k) + 1u);
}
MapSpan mapSpan(MAP map, int k) {
  vec4 s = uintBitsToFloat(tableQuad(map.spans + 4u * uint(k)));
  return MapSpan(s.x, s.y, s.z);
}
MapPiece mapPiece(MAP map, int k) {
  MapPiece m;
  if (PIECES_AHEAD) {
    m.sigma = fromRow(2, k);
    m.sigmaStep = fromRow(3, k);
    m.color = vec3(fromRow(4, k), fromRow(6, k), fromRow(8, k));
    m.colorStep = vec3(fromRow(5, k), fromRow(7, k), fromRow(9, k));
  } else {
    uint p = map.pieces + 8u * uint(k);
    vec4 a = uintBitsToFloat(tableQuad(p)), b = uintBitsToFloat(tableQuad(p + 4u));
    m.sigma = a.x;
    m.sigmaStep = a.y;
    m.color = vec3(a.z, b.x, b.z);
    m.colorStep = vec3(a.w, b.y, b.w);
  }
  return m;
}
// It has no loop, because Mesa's software device allows few rounds of loops (wasCutShort in resumable.glsl).
int mapNodesUpTo(MAP map, real s) {
  int k;
  if (MAP_AHEAD > 0) {
    vec4 low = mapRows[0].low, high = mapRows[0].high;  // padded with infinities
    k = int(s >= low.y) + int(s >= low.z) + int(s >= low.w);
    if (MAP_AHEAD > 4) k += int(s >= high.x) + int(s >= high.y) + int(s >= high.z) + int(s >= high.w);
  } else {
    k = s >= mapNode(map, 8) ? 8 : 0;
    k += s >= mapNode(map, k + 4) ? 4 : 0;
    k += s >= mapNode(map, k + 2) ? 2 : 0;
    k += s >= mapNode(map, k + 1) ? 1 : 0;
  }
  return k;
}
int mapOpaque(MAP map, int k) { return int(tableWord(map.opaque + uint(k))); }
MapSum mapSum(MAP map, int k) {
  uint p = map.sums + 8u * uint(k);
  vec4 a = uintBitsToFloat(tableQuad(p)), b = uintBitsToFloat(tableQuad(p + 4u));
  MapSum s;
  s.sigma = a.x;
  s.source = a.yzw;
  s.sigmaRest = b.x;
  s.sourceRest = b.yzw;
  return s;
}
