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

// The share of x in x + y, which have the same sign but for rounding.
FN real shareOf(real x, real y) {
  real sum = abs(x) + abs(y);
  return sum > R(0.0) ? abs(x) / sum : R(0.5);
}

// The barycentric coordinates of triangleShares() for a triangle that looks like a line, along x or else along y. Two of its edges meet the
// ray in this direction; the point lies between these two meetings, where it is on the ray in the other direction, too. So it is on the ray
// but for rounding, even if the ray runs in the triangle and any point between the meetings will do.
FN void thinShares(vec3 a, vec3 b, vec3 c, bool alongX, OUT(real) shareA, OUT(real) shareB,
                   OUT(real) shareC) {
  real wa = alongX ? a.x : a.y, wb = alongX ? b.x : b.y, wc = alongX ? c.x : c.y;
  real ya = alongX ? a.y : a.x, yb = alongX ? b.y : b.x, yc = alongX ? c.y : c.x;
  bool beyondA = wa > R(0.0), beyondB = wb > R(0.0), beyondC = wc > R(0.0);
  if (beyondA == beyondB && beyondB == beyondC) {  // the sign is a rounding; the nearest corner
    real least = min1(min1(abs(wa), abs(wb)), abs(wc));
    shareA = abs(wa) == least ? R(1.0) : R(0.0);
    shareB = abs(wb) == least ? R(1.0) : R(0.0);
    shareC = abs(wc) == least ? R(1.0) : R(0.0);
    real one = R(1.0) / ((shareA + shareB) + shareC);
    shareA = shareA * one, shareB = shareB * one, shareC = shareC * one;
  } else {
    bool isA = beyondB == beyondC;  // whether a is the corner alone on its side
    bool isB = !isA && beyondA == beyondC;
    real wp = isA ? wa : (isB ? wb : wc), yp = isA ? ya : (isB ? yb : yc);
    real wq = isA ? wb : wa, yq = isA ? yb : ya;
    real wr = isA || isB ? wc : wb, yr = isA || isB ? yc : yb;
    real q = shareOf(wp, wq), r = shareOf(wp, wr);
    real besideQ = yp + q * (yq - yp), besideR = yp + r * (yr - yp);
    real onQ = shareOf(besideR, besideQ), onR = shareOf(besideQ, besideR);
    real shareP = onQ * (R(1.0) - q) + onR * (R(1.0) - r), shareQ = onQ * q, shareR = onR * r;
    shareA = isA ? shareP : shareQ;
    shareB = isA ? shareQ : (isB ? shareP : shareR);
    shareC = isA || isB ? shareR : shareP;
  }
}

// The barycentric coordinates of the point where the ray passes a triangle whose sign is not 0. sideA, sideB and sideC: sideOf its edges
// opposite a, b and c, one after the other around it. Their signs do not matter, so the coordinates have the same bits whichever way
// round the corners are. They are never negative.
FN void triangleShares(vec3 a, vec3 b, vec3 c, real sideA, real sideB, real sideC, OUT(real) shareA,
                       OUT(real) shareB, OUT(real) shareC) {
  shareA = abs(sideA), shareB = abs(sideB), shareC = abs(sideC);
  real sum = sumOf(shareA, shareB, shareC);
  real x = max1(max1(abs(a.x), abs(b.x)), abs(c.x)), y = max1(max1(abs(a.y), abs(b.y)), abs(c.y));
  real size = max1(x, y);
  if (sum > R(2e-3) * (size * size)) {
    real one = R(1.0) / sum;
    shareA = shareA * one, shareB = shareB * one, shareC = shareC * one;
  } else {  // the sides are near to their roundings
    thinShares(a, b, c, x >= y, shareA, shareB, shareC);
  }
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
