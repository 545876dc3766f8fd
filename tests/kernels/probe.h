// SPDX-License-Identifier: Apache-2.0
// Every function of core/kernels/all.h, philox.h and random_line.h on seeded inputs, in the common dialect: probe(f, i) is a number that function f
// computes from input i. C++, ISPC and GLSL read it after that file; their results have the same bits.

#define PROBES 56

// In [lo, hi).
FN real drawIn(uint i, uint salt, real lo, real hi) { return lo + (hi - lo) * unitReal(hash2(i, salt)); }

// Any float but infinities and NaN: every exponent, both signs, denormals and zeros included.
FN real drawAny(uint i, uint salt) {
  uint bits = hash2(i, salt);
  real wide = asReal((bits & 0x7f800000u) == 0x7f800000u ? bits & 0x807fffffu : bits);
  return (hash1(bits) & 31u) == 0u ? R(0.0) : wide;
}

// Half any float, half in [lo, hi).
FN real draw(uint i, uint salt, real lo, real hi) {
  return (hash2(i, salt + 1000u) & 1u) == 0u ? drawAny(i, salt) : drawIn(i, salt, lo, hi);
}

FN vec3 drawPoint(uint i, uint salt, real size) {
  real x = drawIn(i, salt, -size, size);
  real y = drawIn(i, salt + 1u, -size, size);
  real z = drawIn(i, salt + 2u, -size, size);
  return make_v3(x, y, z);
}

FN vec3 drawDirection(uint i, uint salt) { return unit3(drawPoint(i, salt, R(1.0))); }

FN real probeElementary(int f, uint i) {
  real x = f == 4 ? drawIn(i, 8u, R(0.0), R(2.0)) : draw(i, 1u, R(-90.0), R(90.0));
  real small = f == 4 || f == 5 ? drawIn(i, 2u, R(-70.0), R(70.0)) : x;
  real s;
  real c;
  sincos1(small, s, c);
  if (f == 0) return exp1(x);
  if (f == 1) return oneMinusExp(x);
  if (f == 2) return log1(x);
  if (f == 3) return minusLogOneMinus(x);
  if (f == 4) return s + pow1(x, drawIn(i, 9u, R(0.0), R(100.0)));
  if (f == 5) return c;
  return flushSmall(x);
}

FN real probeBox(int f, uint i) {
  vec3 lo = drawPoint(i, 10u, R(1.0));
  vec3 hi = drawPoint(i, 13u, R(1.0));
  vec3 low = make_v3(min1(lo.x, hi.x), min1(lo.y, hi.y), min1(lo.z, hi.z));
  vec3 high = make_v3(max1(lo.x, hi.x), max1(lo.y, hi.y), max1(lo.z, hi.z));
  vec3 origin = drawPoint(i, 16u, R(2.0));
  vec3 direction = make_v3(draw(i, 19u, R(-1.0), R(1.0)), drawIn(i, 20u, R(-1.0), R(1.0)), R(0.5));
  real tEnter;
  real tExit;
  bool hit = boxSpan(low, high, origin, direction, R(0.0), R(1e30), tEnter, tExit);
  if (f == 7) return hit ? tEnter : R(-1.0);
  if (f == 8) return hit ? tExit : R(-1.0);
  if (f == 9) return faceBefore(origin.x, direction.x, low.x);
  return faceAfter(draw(i, 21u, R(-1.0), R(1.0)), direction.x, draw(i, 22u, R(-1.0), R(1.0)));
}

FN real probeRound(int f, uint i) {
  bool isFar = (i & 1u) == 0u;
  vec3 a = drawPoint(i, 30u, R(1.0));
  vec3 b = drawPoint(i, 33u, R(1.0));
  real radiusA = drawIn(i, 36u, R(0.0), R(0.5));
  real radiusB = drawIn(i, 37u, R(0.0), R(0.5));
  vec3 from = drawDirection(i, 38u);
  real distance = isFar ? R(3000.0) : R(1.5);
  vec3 origin = make_v3(a.x + distance * from.x, a.y + distance * from.y, a.z + distance * from.z);
  vec3 spread = drawPoint(i, 41u, R(0.3));
  vec3 direction =
      unit3(make_v3((a.x + spread.x) - origin.x, (a.y + spread.y) - origin.y, (a.z + spread.z) - origin.z));
  real t;
  real axial = R(0.0);
  vec3 normal;
  bool hit = false;
  if (f < 14) {
    hit = hitSphere(origin, direction, a, radiusA, R(0.0), t, normal);
  } else {
    hit = hitRoundCone(origin, direction, a, b, radiusA, radiusB, R(0.0), t, normal, axial);
  }
  if (!hit) return R(-1.0);
  if (f == 11 || f == 14) return t;
  if (f == 12 || f == 15) return normal.x;
  if (f == 13 || f == 16) return normal.z;
  return axial;
}

FN real probeTriangle(int f, uint i) {
  vec3 a = drawPoint(i, 50u, R(1.0));
  vec3 b = drawPoint(i, 53u, R(1.0));
  vec3 c = drawPoint(i, 56u, R(1.0));
  vec3 origin = drawPoint(i, 59u, R(2.0));
  // A third of the rays aims at a vertex, a third at the middle of an edge.
  uint kind = hash2(i, 62u) % 3u;
  real wb = kind == 0u ? R(0.0) : (kind == 1u ? R(0.5) : R(0.25));
  real wc = kind == 2u ? R(0.25) : R(0.0);
  real wa = (R(1.0) - wb) - wc;
  real x = (wa * a.x + wb * b.x) + wc * c.x;
  real y = (wa * a.y + wb * b.y) + wc * c.y;
  real z = (wa * a.z + wb * b.z) + wc * c.z;
  real t;
  real weightB;
  real weightC;
  bool hit = hitTriangle(origin, make_v3(x - origin.x, y - origin.y, z - origin.z), a, b, c, R(0.0), t,
                         weightB, weightC);
  vec3 normal = triangleNormal(a, b, c);
  if (f == 18) return hit ? t : R(-1.0);
  if (f == 19) return hit ? weightB : R(-1.0);
  if (f == 20) return hit ? weightC : R(-1.0);
  if (f == 21) return normal.x;
  vec3 moved = offsetOrigin(a, normal, drawIn(i, 63u, R(0.0), R(4.0)));
  return f == 22 ? moved.x : moved.z;
}

FN real probeLight(int f, uint i) {
  vec3 n = drawDirection(i, 70u);
  vec3 d = occlusionDirection(n, i, 3u, i >> 4u, i & 15u, 16u);
  if (f == 24) return d.x;
  if (f == 25) return d.y;
  if (f == 26) return d.z;
  vec3 e = drawDirection(i, 73u);
  if (f == 27) return lambert(n, e);
  if (f == 28) return phong(n, d, e, drawIn(i, 76u, R(0.0), R(100.0)));
  if (f == 29) return clamp1(n.x, R(-0.5), R(0.5));
  vec3 unit = normalize3(make_v3(n.y, n.z, d.x));
  if (f == 30) return unit.x;
  return lerp1(n.x, n.y, d.z);
}

FN real probeTube(int f, uint i) {
  Tube s;
  s.a = drawPoint(i, 80u, R(1.0));
  s.b = drawPoint(i, 83u, R(1.0));
  s.before = drawPoint(i, 86u, R(1.0));
  s.after = drawPoint(i, 89u, R(1.0));
  s.radiusA = drawIn(i, 92u, R(0.0), R(0.5));
  s.radiusB = drawIn(i, 93u, R(0.0), R(0.5));
  s.radiusBefore = drawIn(i, 94u, R(0.0), R(0.5));
  s.radiusAfter = drawIn(i, 95u, R(0.0), R(0.5));
  s.hasBefore = (hash2(i, 96u) & 1u) == 0u;
  s.hasAfter = (hash2(i, 97u) & 1u) == 0u;
  vec3 origin = drawPoint(i, 98u, R(2.0));
  vec3 to = drawPoint(i, 101u, R(0.5));
  real x;
  real depth = depthInCone(difference(origin, s.a), difference(s.b, s.a), s.radiusA, s.radiusB, x);
  if (f == 32) return depth;
  if (f == 33) return x;
  TubeHit h;
  MetSegment met = noSegment();
  if ((hash2(i, 108u) & 3u) == 0u) {  // the neighbour, where this one is met
    hitTube(s, origin, unit3(difference(to, origin)), R(0.0), met, h);
    met.t = h.t;
    met.a = s.before;
    met.b = s.a;
  }
  if (!hitTube(s, origin, unit3(difference(to, origin)), R(0.0), met, h)) return R(-2.0);
  vec3 p = tubePoint(s, h);
  if (f == 34) return h.t;
  if (f == 35) return h.normal.y;
  return f == 36 ? h.axial : p.z;
}

FN real probeNumbers(int f, uint i) {
  real x = drawIn(i, 104u, R(-70.0), R(70.0));
  if (f == 38) return sin1(x);
  if (f == 39) return cos1(x);
  double wide = x;
  wide = wide * wide + wide;
  return floatOf(wide) + toReal(toUint(toInt(x + R(70.0)))) + toReal(asInt(asUint(x)));
}

FN real probeRandom(int f, uint i) {
  vec3 size = make_v3(drawIn(i, 110u, R(0.0), R(1.0)), drawIn(i, 111u, R(0.1), R(1.0)), R(1.0));
  vec3 start;
  vec3 direction;
  randomLine(hash1(i), 7u, i, i & 3u, size, start, direction);
  if (f == 41) return start.x;
  if (f == 42) return start.y;
  if (f == 43) return start.z;
  if (f == 44) return direction.x;
  if (f == 45) return direction.y;
  if (f == 46) return direction.z;
  uint a = i;
  uint b = hash1(i);
  uint c = hash2(i, 112u);
  uint d = 0u;
  philox4x32(i, 1u, a, b, c, d);
  return unitReal(a ^ (b >> 1u)) + unitReal(c ^ (d >> 1u));
}

// A tetrahedron around the ray, often with corners on it or beside each other.
FN real probeFace(int f, uint i) {
  real step = (hash1(i) & 1u) == 0u ? R(0.25) : R(1e-3);
  vec3 a = drawPoint(i, 120u, R(1.0));
  vec3 b = drawPoint(i, 123u, R(1.0));
  vec3 c = drawPoint(i, 126u, R(1.0));
  a = make_v3(floor(a.x / step) * step, floor(a.y / step) * step, a.z);
  b = make_v3(floor(b.x / step) * step, floor(b.y / step) * step, b.z);
  c = make_v3(floor(c.x / step) * step, floor(c.y / step) * step, c.z);
  if (f == 48) return toReal(triangleSign(a, b, c)) + a.z;
  real shareA;
  real shareB;
  real shareC;
  triangleShares(a, b, c, sideOf(b, c), sideOf(c, a), sideOf(a, b), shareA, shareB, shareC);
  if (f == 49) return meanOf(shareA, shareB, shareC, a.z, b.z, c.z) + R(2.0) * shareC;
  int signA = (hash2(i, 130u) & 1u) == 0u ? 1 : -1;
  int signB = signA == 1 || (hash2(i, 131u) & 1u) == 0u ? -1 : 1;
  int left = cornerLeft(1, signA, signB, floor(a.x * R(2.0)), floor(a.y * R(2.0)), floor(b.x * R(2.0)),
                        floor(b.y * R(2.0)), i & 3u, 1u, 2u, 3u);
  return toReal(left) + a.z;
}

FN vec4 drawCorner(uint i, uint k, real x, real y, real z) {
  vec3 by = drawPoint(i, 140u + 3u * k, (hash1(i) & 3u) == 0u ? R(1.5) : R(0.4));
  return make_v4(x + by.x, y + by.y, z + by.z, drawIn(i, 170u + k, R(-1.0), R(1.0)));
}

// A hexahedron around the ray, often a tangled one, or a wedge.
FN real probeHexahedron(int f, uint i) {
  Hexahedron h;
  h.c0 = drawCorner(i, 0u, R(-0.6), R(-0.5), R(-0.5));
  h.c1 = drawCorner(i, 1u, R(0.5), R(-0.5), R(-0.5));
  h.c2 = drawCorner(i, 2u, R(0.5), R(0.5), R(-0.5));
  h.c3 = drawCorner(i, 3u, R(-0.6), R(0.5), R(-0.5));
  h.c4 = drawCorner(i, 4u, R(-0.6), R(-0.5), R(0.5));
  h.c5 = drawCorner(i, 5u, R(0.5), R(-0.5), R(0.5));
  h.c6 = drawCorner(i, 6u, R(0.5), R(0.5), R(0.5));
  h.c7 = drawCorner(i, 7u, R(-0.6), R(0.5), R(0.5));
  uint orders = hash2(i, 180u) & 0x777777u;
  if ((i & 7u) == 0u) {  // sides 4 and 5 are triangles, and side 3 has no area
    h.c3 = h.c2;
    h.c7 = h.c6;
    orders = (orders & 0x777u) | 0x880000u;
  }
  if ((i & 7u) == 1u) {  // sides 1 and 2 are seen edge-on, and the ray is in one of them
    h.c1.x = h.c2.x, h.c5.x = h.c2.x, h.c6.x = h.c2.x;
    h.c0.y = R(0.0), h.c1.y = R(0.0), h.c5.y = R(0.0), h.c4.y = R(0.0);
  }
  uint signs = sideSigns(h);
  if (f == 51) return toReal(signs & 0xffffu) + toReal(timesPassed(signs)) * h.c1.w;
  uint from = hash2(i, 181u) % 6u;
  SidePoint p = sidePoint(h, from, orders);
  if (f == 52) return p.z + R(2.0) * p.value + R(4.0) * p.u + R(8.0) * p.v;
  int turn = 0;
  uint to = pairedSide(h, orders, signs, from, turn);
  if (f == 53) return toReal(to) + R(0.1) * toReal(turn) + lowestOf(h) + R(10.0) * highestOf(h);
  SidePoint q = sidePoint(h, to, orders);
  vec3 at = referencePlace(orderedCorners(from, orders), p.u, p.v);
  vec4 cubic = cubicBetween(h, p, at, q, referencePlace(orderedCorners(to, orders), q.u, q.v), R(0.7),
                            R(-1.0), R(1.0));
  if (f == 54) return isFinite(h) ? cubic.y + R(2.0) * cubic.z : R(0.0);
  vec3 found = coordinatesOfOrigin(h);
  real volume;
  vec3 gradient = scaledGradient(h, found, volume);
  return found.x + R(2.0) * found.y + R(4.0) * found.z + gradient.x + volume;
}

FN real probe(int f, uint i) {
  if (f < 7) return probeElementary(f, i);
  if (f < 11) return probeBox(f, i);
  if (f < 18) return probeRound(f, i);
  if (f < 24) return probeTriangle(f, i);
  if (f < 32) return probeLight(f, i);
  if (f < 38) return probeTube(f, i);
  if (f < 41) return probeNumbers(f, i);
  if (f < 48) return probeRandom(f, i);
  if (f < 51) return probeFace(f, i);
  return probeHexahedron(f, i);
}
