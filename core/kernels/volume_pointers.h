// SPDX-License-Identifier: Apache-2.0
// How a dialect with pointers, C++ or ISPC, reads a VolumeView: the part that both write alike. Each dialect's
// volume_fetch includes this file after it has defined OFFSET and storedAt.

FN int planAt(VOLUME v, int index) { return v.plan[index]; }
FN UNIFORM bool anyCellwise(VOLUME v) { return v.byCells != 0; }
FN int isoWord(VOLUME v, int index) { return v.isoMask[index]; }

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
FN_OUTLINE CellValues cellValuesOfAny(VOLUME v, ivec3 c) {
  CellValues k;
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
