// SPDX-License-Identifier: Apache-2.0
// A hexahedron of a mesh: places and values are trilinear in reference coordinates from 0 to 1, so its sides are bilinear patches. Wedges,
// pyramids and tetrahedra are hexahedra with repeated corners here: wedge (0, 1, 2, 2, 3, 4, 5, 5), pyramid (0, 1, 2, 3, 4, 4, 4, 4),
// tetrahedron (0, 1, 2, 2, 3, 3, 3, 3); this is the same field as that of their own shape functions. Corners and sides are in VTK's order.
//
// A bilinear patch and a line meet in the root of a quadratic (Reshetov, Cool patches: a geometric approach to ray/bilinear patch
// intersections, Ray Tracing Gems, 2019). Of the two roots, the patch goes around the ray in one direction at one of them and in the
// other direction at the other one, so the sign of the side (face.h) says which one counts. Both cells of a side of four corners take
// these in the same order, given by the numbers of the points, so they find the same bits. Each cell takes those of a triangle in an order of
// its own, as means on triangles have the same bits in any order.

#define HEX_SIDES 6

// The corners of a side, one after the other around it, in four bits each from the lowest on.
FN uint sideCorners(uint side) {
  uint low = side == 0u ? 0x3740u : (side == 1u ? 0x5621u : 0x4510u);
  uint high = side == 3u ? 0x2673u : (side == 4u ? 0x1230u : 0x7654u);
  return side < 3u ? low : high;
}

// The same in the order in which the cell takes them. `orders` has four bits for each side: the place where the order begins
// (two bits), whether it goes the other way around, and whether the side is a triangle, whose third and fourth corner are the same one.
FN uint orderedCorners(uint side, uint orders) {
  uint order = orders >> (side * 4u);
  uint turn = (order & 3u) * 4u, c = sideCorners(side);
  c = ((c >> turn) | (c << (16u - turn))) & 0xffffu;
  uint swapped = (c & 0x0f0fu) | ((c & 0x00f0u) << 8u) | ((c >> 8u) & 0x00f0u);
  return (order & 4u) != 0u ? swapped : c;
}
FN bool isTriangle(uint side, uint orders) { return ((orders >> (side * 4u)) & 8u) != 0u; }

// x y z of its corners, and a number at each, which is trilinear, too: a value or a level.
struct Hexahedron {
  vec4 c0, c1, c2, c3, c4, c5, c6, c7;
};

FN vec4 hexCorner(Hexahedron h, uint k) {
  bool odd = (k & 1u) != 0u, second = (k & 2u) != 0u;
  vec4 low = second ? (odd ? h.c3 : h.c2) : (odd ? h.c1 : h.c0);
  vec4 high = second ? (odd ? h.c7 : h.c6) : (odd ? h.c5 : h.c4);
  return (k & 4u) != 0u ? high : low;
}

FN real lowestOf(Hexahedron h) {
  return min1(min1(min1(h.c0.w, h.c1.w), min1(h.c2.w, h.c3.w)),
              min1(min1(h.c4.w, h.c5.w), min1(h.c6.w, h.c7.w)));
}
FN real highestOf(Hexahedron h) {
  return max1(max1(max1(h.c0.w, h.c1.w), max1(h.c2.w, h.c3.w)),
              max1(max1(h.c4.w, h.c5.w), max1(h.c6.w, h.c7.w)));
}
// Whether the numbers at all corners are finite.
FN bool isFinite(Hexahedron h) {
  real sum = ((h.c0.w - h.c0.w) + (h.c1.w - h.c1.w)) + ((h.c2.w - h.c2.w) + (h.c3.w - h.c3.w));
  sum += ((h.c4.w - h.c4.w) + (h.c5.w - h.c5.w)) + ((h.c6.w - h.c6.w) + (h.c7.w - h.c7.w));
  return sum == R(0.0);
}

// The signs of its sides (face.h), 4 more than each, in four bits each. Corners are in the frame of the ray.
FN uint sideSigns(Hexahedron h) {
  vec3 p0 = placeOf(h.c0), p1 = placeOf(h.c1), p2 = placeOf(h.c2), p3 = placeOf(h.c3);
  vec3 p4 = placeOf(h.c4), p5 = placeOf(h.c5), p6 = placeOf(h.c6), p7 = placeOf(h.c7);
  int a = edgeCrossing(p0, p1), b = edgeCrossing(p1, p2), c = edgeCrossing(p2, p3), d = edgeCrossing(p3, p0);
  int e = edgeCrossing(p4, p5), f = edgeCrossing(p5, p6), g = edgeCrossing(p6, p7), i = edgeCrossing(p7, p4);
  int s = edgeCrossing(p0, p4), t = edgeCrossing(p1, p5), u = edgeCrossing(p2, p6), v = edgeCrossing(p3, p7);
  int signs = ((s - i - v + d) + 4) + (((b + u - f - t) + 4) << 4) + (((a + t - e - s) + 4) << 8) +
              (((v - g - u + c) + 4) << 12) + (((-d - c - b - a) + 4) << 16) + (((e + f + g + i) + 4) << 20);
  return toUint(signs);
}
#define NO_SIDES 0x444444u

FN int signOf(uint signs, uint side) { return asInt((signs >> (side * 4u)) & 15u) - 4; }

// How often the ray passes sides.
FN int timesPassed(uint signs) {
  int times = 0;
  for (UNIFORM int k = 0; k < HEX_SIDES; k++) times += abs(signOf(signs, toUint(k)));
  return times;
}

// The first side with this sign.
FN uint sideOfSign(uint signs, int sign) {
  uint found = 0u;
  for (UNIFORM int k = HEX_SIDES - 1; k >= 0; k--)
    found = signOf(signs, toUint(k)) == sign ? toUint(k) : found;
  return found;
}

// Where a ray passes a side.
struct SidePoint {
  real z;      // in the frame
  real value;  // the trilinear number there
  real u,
      v;  // the coordinates in the patch: from the first corner to the second one, and from there to the third one
};

FN real bilinear(real a, real b, real c, real d, real u, real v) {
  return lerp1(lerp1(a, b, u), lerp1(d, c, u), v);
}

// Whether a side is seen edge-on: its `area`, or a bound of it, is no more than rounding. The ray then runs in it, and is taken to pass it in
// the middle of the way from one of its edges to another one, which is on the ray and between what lies before and behind.
// alongX: whether it extends farther along x than along y.
FN bool isEdgeOn(vec3 a, vec3 b, vec3 c, vec3 d, real area, OUT(bool) alongX) {
  real x = max1(max1(abs(a.x), abs(b.x)), max1(abs(c.x), abs(d.x)));
  real y = max1(max1(abs(a.y), abs(b.y)), max1(abs(c.y), abs(d.y)));
  alongX = x >= y;
  real size = max1(x, y);
  return !(area > R(1e-6) * (size * size));
}

// Where the ray runs into a side and out of it: numbers that say where, and the depths.
struct EdgesMet {
  vec3 front, back;
  real zFront, zBack;
};

// Looks at the edge whose ends are beside the ray by p and q, and which the ray meets, if it does, in `at` at z.
FN void meetEdge(INOUT(EdgesMet) e, real p, real q, vec3 at, real z) {
  bool meets = (p <= R(0.0)) != (q <= R(0.0)) || p == R(0.0) || q == R(0.0);
  if (meets && z < e.zFront) {
    e.zFront = z;
    e.front = at;
  }
  if (meets && z > e.zBack) {
    e.zBack = z;
    e.back = at;
  }
}

FN EdgesMet noEdges() {
  EdgesMet e;
  e.front = make_v3(R(0.33333333333333333), R(0.33333333333333333), R(0.33333333333333333));
  e.back = e.front;
  e.zFront = infinity();
  e.zBack = -infinity();
  return e;
}

// The point where the ray passes a patch whose corners are in its frame. It always finds one in the patch; there is one where the sign
// of the patch is not 0.
FN SidePoint patchPoint(vec4 a, vec4 b, vec4 c, vec4 d) {
  vec3 pa = placeOf(a), pb = placeOf(b), pc = placeOf(c), pd = placeOf(d);
  int sign = (edgeCrossing(pa, pb) + edgeCrossing(pb, pc)) + (edgeCrossing(pc, pd) + edgeCrossing(pd, pa));
  // The ray is beside the line from (u, 0) to (u, 1) by q0 (1 - u)^2 + q1 u (1 - u) + q2 u^2.
  real q0 = sideOf(pa, pd), q1 = sideOf(pa, pc) + sideOf(pb, pd), q2 = sideOf(pb, pc);
  real most = max1(max1(abs(q0), abs(q2)), abs(q1));
  SidePoint p;
  bool alongX;
  if (isEdgeOn(pa, pb, pc, pd, most, alongX)) {
    real wa = alongX ? pa.x : pa.y, wb = alongX ? pb.x : pb.y, wc = alongX ? pc.x : pc.y,
         wd = alongX ? pd.x : pd.y;
    real ab = shareOf(wa, wb), bc = shareOf(wb, wc), dc = shareOf(wd, wc), ad = shareOf(wa, wd);
    EdgesMet e = noEdges();
    meetEdge(e, wa, wb, make_v3(ab, R(0.0), R(0.0)), lerp1(pa.z, pb.z, ab));
    meetEdge(e, wb, wc, make_v3(R(1.0), bc, R(0.0)), lerp1(pb.z, pc.z, bc));
    meetEdge(e, wd, wc, make_v3(dc, R(1.0), R(0.0)), lerp1(pd.z, pc.z, dc));
    meetEdge(e, wa, wd, make_v3(R(0.0), ad, R(0.0)), lerp1(pa.z, pd.z, ad));
    p.u = R(0.5) * (e.front.x + e.back.x);
    p.v = R(0.5) * (e.front.y + e.back.y);
  } else {
    real scale = R(1.0) / most;
    q0 = q0 * scale, q1 = q1 * scale, q2 = q2 * scale;
    real root = sqrt(max1(q1 * q1 - R(4.0) * (q0 * q2), R(0.0)));
    root = sign < 0 ? -root : root;
    bool alike = (q1 <= R(0.0)) == (root >= R(0.0));
    real far = alike ? root - q1 : -(root + q1);
    p.u = alike ? shareOf(far, q2 + q2) : shareOf(q0 + q0, far);
    real nearX = lerp1(pa.x, pb.x, p.u), nearY = lerp1(pa.y, pb.y, p.u);
    real farX = lerp1(pd.x, pc.x, p.u), farY = lerp1(pd.y, pc.y, p.u);
    bool byX = abs(farX - nearX) >= abs(farY - nearY);
    p.v = shareOf(byX ? nearX : nearY, byX ? farX : farY);
  }
  p.z = bilinear(pa.z, pb.z, pc.z, pd.z, p.u, p.v);
  p.value = bilinear(a.w, b.w, c.w, d.w, p.u, p.v);
  return p;
}

// The same for a triangle. z and value have the same bits in any order of the corners; u and v are those of a patch whose third and
// fourth corner are c.
FN SidePoint trianglePoint(vec4 a, vec4 b, vec4 c) {
  vec3 pa = placeOf(a), pb = placeOf(b), pc = placeOf(c);
  real shareA, shareB, shareC;
  triangleShares(pa, pb, pc, sideOf(pb, pc), sideOf(pc, pa), sideOf(pa, pb), shareA, shareB, shareC);
  SidePoint p;
  p.z = meanOf(shareA, shareB, shareC, a.z, b.z, c.z);
  p.value = meanOf(shareA, shareB, shareC, a.w, b.w, c.w);
  p.u = shareOf(shareB, shareA);
  p.v = shareC;
  return p;
}

FN SidePoint sidePoint(Hexahedron h, uint side, uint orders) {
  uint corners = orderedCorners(side, orders);
  vec4 a = hexCorner(h, corners & 7u), b = hexCorner(h, (corners >> 4u) & 7u),
       c = hexCorner(h, (corners >> 8u) & 7u);
  SidePoint p;
  if (isTriangle(side, orders))
    p = trianglePoint(a, b, c);
  else
    p = patchPoint(a, b, c, hexCorner(h, corners >> 12u));
  return p;
}

FN real depthOf(Hexahedron h, uint side, uint orders) {
  SidePoint p = sidePoint(h, side, orders);
  return p.z;
}

// How many passages with the sign of side `of` come before the passages of that side, by z and then by side.
FN int passagesBefore(uint signs, real z0, real z1, real z2, real z3, real z4, real z5, uint of, int sign) {
  real z = of < 3u ? (of == 0u ? z0 : (of == 1u ? z1 : z2)) : (of == 3u ? z3 : (of == 4u ? z4 : z5));
  int count = 0;
  for (UNIFORM int k = 0; k < HEX_SIDES; k++) {
    real zk = k < 3 ? (k == 0 ? z0 : (k == 1 ? z1 : z2)) : (k == 3 ? z3 : (k == 4 ? z4 : z5));
    int other = signOf(signs, toUint(k));
    bool alike = (other > 0) == (sign > 0);
    bool before = zk < z || (zk == z && toUint(k) < of);
    count += alike && before ? abs(other) : 0;
  }
  return count;
}

// The side by which the ray goes on that has come by passage number `turn` of side `from`, where the ray passes more than two: the n-th
// passage of one sign is paired with the n-th of the other sign. `turn` becomes the number of the passage of the side returned.
FN_OUTLINE uint pairedSide(Hexahedron h, uint orders, uint signs, uint from, INOUT(int) turn) {
  real z0 = depthOf(h, 0u, orders), z1 = depthOf(h, 1u, orders), z2 = depthOf(h, 2u, orders);
  real z3 = depthOf(h, 3u, orders), z4 = depthOf(h, 4u, orders), z5 = depthOf(h, 5u, orders);
  int came = signOf(signs, from);
  int place = passagesBefore(signs, z0, z1, z2, z3, z4, z5, from, came) + turn;
  uint found = from;
  int passage = 0;
  for (UNIFORM int k = 0; k < HEX_SIDES; k++) {
    int sign = signOf(signs, toUint(k));
    bool other = sign != 0 && (sign > 0) != (came > 0);
    int first = passagesBefore(signs, z0, z1, z2, z3, z4, z5, toUint(k), sign);
    bool is = other && first <= place && place < first + abs(sign);
    found = is ? toUint(k) : found;
    passage = is ? place - first : passage;
  }
  turn = passage;
  return found;
}

// The reference coordinates of the place (u, v) in a side, given its corners in order.
FN vec3 referencePlace(uint corners, real u, real v) {
  real w0 = (R(1.0) - u) * (R(1.0) - v), w1 = u * (R(1.0) - v), w2 = u * v, w3 = (R(1.0) - u) * v;
  uint halves =
      corners ^
      (corners >> 1u);  // its lowest bits say which corners are on the side of higher first coordinates
  real x = ((halves & 0x1u) != 0u ? w0 : R(0.0)) + ((halves & 0x10u) != 0u ? w1 : R(0.0));
  real y = ((corners & 0x2u) != 0u ? w0 : R(0.0)) + ((corners & 0x20u) != 0u ? w1 : R(0.0));
  real z = ((corners & 0x4u) != 0u ? w0 : R(0.0)) + ((corners & 0x40u) != 0u ? w1 : R(0.0));
  x += ((halves & 0x100u) != 0u ? w2 : R(0.0)) + ((halves & 0x1000u) != 0u ? w3 : R(0.0));
  y += ((corners & 0x200u) != 0u ? w2 : R(0.0)) + ((corners & 0x2000u) != 0u ? w3 : R(0.0));
  z += ((corners & 0x400u) != 0u ? w2 : R(0.0)) + ((corners & 0x4000u) != 0u ? w3 : R(0.0));
  return make_v3(x, y, z);
}

FN vec4 lerp4(vec4 a, vec4 b, real f) { return a + (b - a) * f; }

// The place and the number at reference coordinates.
FN vec4 trilinearIn(Hexahedron h, vec3 at) {
  vec4 low = lerp4(lerp4(h.c0, h.c1, at.x), lerp4(h.c3, h.c2, at.x), at.y);
  vec4 high = lerp4(lerp4(h.c4, h.c5, at.x), lerp4(h.c7, h.c6, at.x), at.y);
  return lerp4(low, high, at.z);
}
// Their derivatives by each of the reference coordinates.
FN vec4 derivativeX(Hexahedron h, vec3 at) {
  return lerp4(lerp4(h.c1 - h.c0, h.c2 - h.c3, at.y), lerp4(h.c5 - h.c4, h.c6 - h.c7, at.y), at.z);
}
FN vec4 derivativeY(Hexahedron h, vec3 at) {
  return lerp4(lerp4(h.c3 - h.c0, h.c2 - h.c1, at.x), lerp4(h.c7 - h.c4, h.c6 - h.c5, at.x), at.z);
}
FN vec4 derivativeZ(Hexahedron h, vec3 at) {
  return lerp4(lerp4(h.c4 - h.c0, h.c5 - h.c1, at.x), lerp4(h.c7 - h.c3, h.c6 - h.c2, at.x), at.y);
}

// The slope of the number by z along the ray, at reference coordinates on it; `otherwise` where the cell has no volume there.
FN real slopeAlong(Hexahedron h, vec3 at, real otherwise) {
  vec4 dx = derivativeX(h, at), dy = derivativeY(h, at), dz = derivativeZ(h, at);
  real wx = dy.x * dz.y - dy.y * dz.x, wy = dz.x * dx.y - dz.y * dx.x, wz = dx.x * dy.y - dx.y * dy.x;
  real slope = ((wx * dx.w + wy * dy.w) + wz * dz.w) / ((wx * dx.z + wy * dy.z) + wz * dz.z);
  return slope - slope == R(0.0) ? slope : otherwise;
}

// The number along the ray between two points of sides at these reference coordinates: Hermite's cubic, which has the right values and
// slopes at both, but goes nowhere beyond the numbers at the corners. It is exact in parallelepipeds. `length`: of the way, in z.
FN vec4 cubicBetween(Hexahedron h, SidePoint p, vec3 at, SidePoint q, vec3 to, real length, real low,
                     real high) {
  real third = length * R(0.33333333333333333), straight = (q.value - p.value) / length;
  return make_v4(p.value, clamp1(p.value + third * slopeAlong(h, at, straight), low, high),
                 clamp1(q.value - third * slopeAlong(h, to, straight), low, high), q.value);
}

// Solves J x = rhs, whose columns are a, b and c; 0 where J is singular.
FN vec3 solved(vec3 a, vec3 b, vec3 c, vec3 rhs) {
  vec3 bc = cross3(b, c);
  real one = R(1.0) / dot3(a, bc);
  vec3 x = make_v3(dot3(rhs, bc) * one, dot3(a, cross3(rhs, c)) * one, dot3(a, cross3(b, rhs)) * one);
  bool solvable = ((x.x - x.x) + (x.y - x.y)) + (x.z - x.z) == R(0.0);
  return solvable ? x : make_v3(R(0.0), R(0.0), R(0.0));
}

// The nearest reference coordinates in a cell, but for a rim, as where corners are repeated the map has no inverse.
FN vec3 inCell(vec3 at) {
  real least = R(1e-5), most = R(0.99999);
  return make_v3(clamp1(at.x, least, most), clamp1(at.y, least, most), clamp1(at.z, least, most));
}

// The reference coordinates of the point 0 in a hexahedron; the nearest ones found if it is outside.
FN vec3 coordinatesOfOrigin(Hexahedron h) {
  vec3 at = make_v3(R(0.5), R(0.5), R(0.5));
  bool goes = true;
  for (UNIFORM int k = 0; k < 12; k++) {
    if (goes) {
      vec3 by = solved(placeOf(derivativeX(h, at)), placeOf(derivativeY(h, at)), placeOf(derivativeZ(h, at)),
                       placeOf(trilinearIn(h, at)));
      at = inCell(make_v3(at.x - by.x, at.y - by.y, at.z - by.z));
      goes = max1(max1(abs(by.x), abs(by.y)), abs(by.z)) > R(1e-6);
    }
  }
  return at;
}

FN vec3 middleOf(vec3 a, vec3 b, real f) {
  return make_v3(lerp1(a.x, b.x, f), lerp1(a.y, b.y, f), lerp1(a.z, b.z, f));
}

// The reference coordinates of the point of the ray at depth z, near others, by Newton's method. It ends where the next step would be about
// 1e-6.
FN vec3 placeAtDepth(Hexahedron h, vec3 near, real z) {
  vec3 at = near;
  bool goes = true;
  for (UNIFORM int k = 0; k < 4; k++) {
    if (goes) {
      vec4 p = trilinearIn(h, at);
      vec3 by = solved(placeOf(derivativeX(h, at)), placeOf(derivativeY(h, at)), placeOf(derivativeZ(h, at)),
                       make_v3(p.x, p.y, p.z - z));
      at = inCell(make_v3(at.x - by.x, at.y - by.y, at.z - by.z));
      goes = max1(max1(abs(by.x), abs(by.y)), abs(by.z)) > R(1e-3);
    }
  }
  return at;
}

// A way through a hexahedron is cut into steps, so that the cubic of each is near to the field.

// The place of the way at depth z, near other reference coordinates, which become those of that place.
FN SidePoint pointAtDepth(Hexahedron h, real z, INOUT(vec3) at) {
  at = placeAtDepth(h, at, z);
  vec4 there = trilinearIn(h, at);
  SidePoint p;
  p.z = z;
  p.value = there.w;
  p.u = R(0.0);
  p.v = R(0.0);
  return p;
}

// How far a cubic is from the number in the middle. The error of Hermite's cubic goes with the fourth power of the length.
FN real errorInMiddle(vec4 cubic, real middle) {
  return abs(middle - (R(0.125) * (cubic.x + cubic.w) + R(0.375) * (cubic.y + cubic.z)));
}

// Steps are shares of the way, and not halved below this.
#define HEX_STEP_LEAST R(0.01)

// Where the step behind the one that ends at u ends, in a way from p to q at `last`. `step` is the length of the one before, whose cubic had
// this error, and becomes the length of this one, `then` its end.
FN SidePoint nextStep(Hexahedron h, SidePoint p, SidePoint q, vec3 last, real u, real error, real allowed,
                      INOUT(real) step, INOUT(vec3) then) {
  SidePoint to = q;
  if (R(16.0) * error <= allowed) step *= R(2.0);
  step = min(step, R(1.0) - u);
  if (u + step < R(1.0)) {
    then = middleOf(then, last, step / (R(1.0) - u));
    to = pointAtDepth(h, lerp1(p.z, q.z, u + step), then);
  } else {
    then = last;
  }
  return to;
}

// The direction in which the number grows, times the volume of the reference cell there.
FN vec3 scaledGradient(Hexahedron h, vec3 at, OUT(real) volume) {
  vec4 dx = derivativeX(h, at), dy = derivativeY(h, at), dz = derivativeZ(h, at);
  vec3 yz = cross3(placeOf(dy), placeOf(dz)), zx = cross3(placeOf(dz), placeOf(dx)),
       xy = cross3(placeOf(dx), placeOf(dy));
  volume = dot3(placeOf(dx), yz);
  return make_v3((dx.w * yz.x + dy.w * zx.x) + dz.w * xy.x, (dx.w * yz.y + dy.w * zx.y) + dz.w * xy.y,
                 (dx.w * yz.z + dy.w * zx.z) + dz.w * xy.z);
}
