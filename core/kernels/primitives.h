// SPDX-License-Identifier: Apache-2.0
// Primitive p of an operator, from the arrays in which geometry is stored. Each dialect supplies
// (scene_fetch.h) pointOf, radiusOf, normalOf and valueOf of a point; cornerOf, the point that is corner k of
// a primitive; and neighbourOf, the point at the far end of the segment before (k = 0) or after (k = 1).

FN Tube tubeOf(OPERATOR op, uint p) {
  uint i = cornerOf(op, 2u * p), j = cornerOf(op, 2u * p + 1u);
  uint before = i, after = j;
  if (hasNeighbours(op)) {
    before = neighbourOf(op, 2u * p);
    after = neighbourOf(op, 2u * p + 1u);
  }
  Tube tube;
  tube.a = pointOf(op, i);
  tube.b = pointOf(op, j);
  tube.before = pointOf(op, before);
  tube.after = pointOf(op, after);
  tube.radiusA = radiusOf(op, i);
  tube.radiusB = radiusOf(op, j);
  tube.radiusBefore = radiusOf(op, before);
  tube.radiusAfter = radiusOf(op, after);
  tube.hasBefore = before != i;
  tube.hasAfter = after != j;
  return tube;
}

// Primitive p of an operator of path lines, as the segment that was met at t.
FN MetSegment metSegment(OPERATOR op, uint p, real t) {
  MetSegment met;
  met.t = t;
  met.a = pointOf(op, cornerOf(op, 2u * p));
  met.b = pointOf(op, cornerOf(op, 2u * p + 1u));
  return met;
}

// The largest of a point's absolute coordinates.
FN real largest3(vec3 p) { return max(max(abs(p.x), abs(p.y)), abs(p.z)); }
