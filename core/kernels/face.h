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

FN vec3 placeOf(vec4 vertex) { return make_v3(vertex.x, vertex.y, vertex.z); }

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

// The sum of three numbers, with the same bits in any order of them. None of them may be NaN.
FN real sumOf(real x, real y, real z) {
  real lo = min1(x, y), hi = max1(x, y);
  real least = min1(lo, z), rest = max1(lo, z);
  return (least + min1(rest, hi)) + max1(rest, hi);
}

// The barycentric coordinates of the point where the ray passes a triangle whose sign is not 0. sideA, sideB and sideC: sideOf its edges
// opposite a, b and c, one after the other around it. Their signs do not matter, so the coordinates have the same bits whichever way
// round the corners are. They are never negative. A triangle that is seen edge-on has no such point in this arithmetic; then it is the
// middle.
FN void triangleShares(real sideA, real sideB, real sideC, OUT(real) shareA, OUT(real) shareB,
                       OUT(real) shareC) {
  real a = abs(sideA), b = abs(sideB), c = abs(sideC);
  real sum = sumOf(a, b, c);
  real one = R(1.0) / (sum > R(0.0) ? sum : R(1.0));
  bool edgeOn = !(sum > R(0.0));
  shareA = edgeOn ? R(0.33333333333333333) : a * one;
  shareB = edgeOn ? R(0.33333333333333333) : b * one;
  shareC = edgeOn ? R(0.33333333333333333) : c * one;
}

// The mean of what the corners have, with the same bits in any order of the corners: the number of the corner with the largest share,
// and the differences to the others. So it is exact where all are equal, and on an edge between equal ones. If one of the numbers is NaN
// or infinite, the mean is NaN or infinite.
FN real meanOf(real shareA, real shareB, real shareC, real a, real b, real c) {
  bool bLeads = shareB > shareA || (shareB == shareA && b > a);
  real most = bLeads ? shareB : shareA;
  real leading = bLeads ? b : a;
  real share = bLeads ? shareA : shareB;
  real other = bLeads ? a : b;
  bool cLeads = shareC > most || (shareC == most && c > leading);
  real mean = cLeads ? c : leading;
  real last = cLeads ? leading : c;
  return mean + (share * (other - mean) + (cLeads ? most : shareC) * (last - mean));
}

// Whether a face that the ray passes at t comes before another one at u. `number` and `other` are those of the corners opposite them.
FN bool passesBefore(real t, uint number, real u, uint other) { return t < u || (t == u && number < other); }

// The corner of a tetrahedron opposite the face by which a ray goes on (0: a, 1: b, 2: c) that has come by the face opposite d and
// passes all four faces. `came`, signA, signB and signC are the signs of the faces, t, tA, tB and tC where the ray passes them, and a,
// b, c and d the numbers of the corners opposite them. Of the two faces with the sign `came` the first is paired with the first of the
// two others, the second with the second.
FN int cornerLeft(int came, int signA, int signB, real t, real tA, real tB, real tC, uint a, uint b, uint c,
                  uint d) {
  bool likeA = signA == came;
  bool likeB = signB == came && !likeA;
  real tLike = likeA ? tA : (likeB ? tB : tC);
  uint like = likeA ? a : (likeB ? b : c);
  bool second = passesBefore(tLike, like, t, d);
  // The two others, in the order of a, b and c.
  bool firstIsB = likeA, lastIsB = !likeA && !likeB;
  real tFirst = firstIsB ? tB : tA, tLast = lastIsB ? tB : tC;
  uint first = firstIsB ? b : a, last = lastIsB ? b : c;
  bool inTurn = passesBefore(tFirst, first, tLast, last);
  int placeFirst = firstIsB ? 1 : 0, placeLast = lastIsB ? 1 : 2;
  return inTurn != second ? placeFirst : placeLast;
}
