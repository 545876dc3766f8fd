// SPDX-License-Identifier: Apache-2.0
// The trilinear cell, and the cubic that it is along a ray.

struct Corners {
  real v000, v100, v010, v110, v001, v101, v011, v111;  // digits: x, y, z
};

// Exact at f = 0 and f = 1, so that two cells give their shared face the same value.
FN real mix1(real a, real b, real f) { return a * (R(1.0) - f) + b * f; }

// Value at fractions f in [0,1]^3; on a face it is the bilinear of that face's corners, to the bit.
FN real trilinear(Corners c, vec3 f) {
  real x00 = mix1(c.v000, c.v100, f.x);
  real x10 = mix1(c.v010, c.v110, f.x);
  real x01 = mix1(c.v001, c.v101, f.x);
  real x11 = mix1(c.v011, c.v111, f.x);
  return mix1(mix1(x00, x10, f.y), mix1(x01, x11, f.y), f.z);
}

FN real minCorner(Corners c) {
  return min(min(min(c.v000, c.v100), min(c.v010, c.v110)), min(min(c.v001, c.v101), min(c.v011, c.v111)));
}
FN real maxCorner(Corners c) {
  return max(max(max(c.v000, c.v100), max(c.v010, c.v110)), max(max(c.v001, c.v101), max(c.v011, c.v111)));
}
// NaN or infinite corners make the cell "no data" (numerics.md section 2).
FN bool holdsData(Corners c) {
  real s = ((c.v000 - c.v000) + (c.v100 - c.v100)) + ((c.v010 - c.v010) + (c.v110 - c.v110)) +
           (((c.v001 - c.v001) + (c.v101 - c.v101)) + ((c.v011 - c.v011) + (c.v111 - c.v111)));
  return s == R(0.0);
}

// Bernstein coefficients of the cell's values, minus `offset`, along the segment from fractions p to q: blossoms of the
// trilinear form. They bound the cubic; b0 and b3 are its end values.
struct Bernstein {
  real b0, b1, b2, b3;
};
FN Bernstein bernsteinAlong(Corners c, vec3 p, vec3 q, real offset) {
  Bernstein b;
  b.b0 = trilinear(c, p) - offset;
  b.b3 = trilinear(c, q) - offset;
  b.b1 = ((trilinear(c, make_v3(q.x, p.y, p.z)) + trilinear(c, make_v3(p.x, q.y, p.z))) +
          trilinear(c, make_v3(p.x, p.y, q.z))) *
             R(0.33333333333333333) -
         offset;
  b.b2 = ((trilinear(c, make_v3(q.x, q.y, p.z)) + trilinear(c, make_v3(q.x, p.y, q.z))) +
          trilinear(c, make_v3(p.x, q.y, q.z))) *
             R(0.33333333333333333) -
         offset;
  return b;
}
