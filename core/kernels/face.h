// SPDX-License-Identifier: Apache-2.0
// Which faces of the cells of a mesh a ray passes, and where: marching from face to face (Garrity, Raytracing irregular volume data,
// 1990; Bunyk, Kaufman & Silva, Simple, fast, and robust ray casting of irregular grids, 1997).
//
// Points are in the frame of triangle.h: the ray is the z axis. The sign of a face is how often its border, counterclockwise, winds
// around the ray: the number of its edges that cross a half-line from the ray upwards, less the number of those that cross it
// downwards. An edge of a cell is in two of its faces, once in each direction, so the signs of a cell's faces add up to 0, whatever
// rounding does: a ray enters each cell as often as it leaves it. If entering and leaving faces are paired in each cell, a walk from
// face to face is a path in a graph in which every node has two neighbours: it meets no face twice, and ends. This needs no exact
// arithmetic and no cells that are well formed. It only needs edgeCrossing(p, q) = -edgeCrossing(q, p).

// p.x q.y - p.y q.x: which side of the edge from p to q the ray passes. Rounding may make the sign wrong, but for both cells alike.
FN real sideOf(vec3 p, vec3 q) { return p.x * q.y - p.y * q.x; }

// How the edge from p to q crosses the half-line of points (x > 0, y = 0): 1 upwards, -1 downwards, else 0. As in triangle.h a ray
// that meets an edge or a point exactly passes beside it.
FN int edgeCrossing(vec3 p, vec3 q) {
  bool up = q.y > R(0.0);
  real side = sideOf(p, q);
  if (side == R(0.0)) side = sideBeside(p.x, p.y, q.x, q.y);
  bool crosses = (p.y > R(0.0)) != up && (side > R(0.0)) == up;
  return crosses ? (up ? 1 : -1) : 0;
}

// The sign of a triangle: 1, -1, or 0 if the ray does not pass it.
FN int triangleSign(vec3 a, vec3 b, vec3 c) {
  return (edgeCrossing(a, b) + edgeCrossing(b, c)) + edgeCrossing(c, a);
}

// Where the ray passes a triangle whose sign is not 0: its depth, and the barycentric coordinates of b and c. If the corners are in
// the order of their numbers, the bits are the same for all cells that have this face. A triangle that is seen edge-on has no such
// point in this arithmetic; then it is a.
FN void trianglePoint(vec3 a, vec3 b, vec3 c, OUT(real) depth, OUT(real) weightB, OUT(real) weightC) {
  real sideA = sideOf(b, c);
  real sideB = sideOf(c, a);
  real sideC = sideOf(a, b);
  real sum = (sideA + sideB) + sideC;
  real share = sum != R(0.0) ? R(1.0) / sum : R(0.0);
  real weightA = sum != R(0.0) ? sideA * share : R(1.0);
  weightB = sideB * share;
  weightC = sideC * share;
  depth = (weightA * a.z + weightB * b.z) + weightC * c.z;
}

FN real component4(vec4 v, int i) { return i < 2 ? (i == 0 ? v.x : v.y) : (i == 2 ? v.z : v.w); }

// How many faces of a tetrahedron have this sign and come before face `of`, by t and then by number.
FN int facesBefore(vec4 sign, vec4 t, real ofSign, int of) {
  int count = 0;
  real at = component4(t, of);
  for (UNIFORM int i = 0; i < 4; i++) {
    real ti = component4(t, i);
    bool before = ti < at || (ti == at && i < of);
    count += component4(sign, i) == ofSign && before ? 1 : 0;
  }
  return count;
}

// The face of a tetrahedron through which a ray that passes face `from` goes on: the first that enters is paired with the first that
// leaves, the second with the second. sign: of the four faces; t: where the ray passes them.
FN int pairedFace(vec4 sign, vec4 t, int from) {
  real own = component4(sign, from);
  int place = facesBefore(sign, t, own, from);
  int paired = -1;
  for (UNIFORM int i = 0; i < 4; i++) {
    bool is = component4(sign, i) == -own && facesBefore(sign, t, -own, i) == place;
    paired = is ? i : paired;
  }
  return paired;
}
