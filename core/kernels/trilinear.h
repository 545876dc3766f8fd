// SPDX-License-Identifier: Apache-2.0
// The trilinear cell, and the cubic that its value is along a ray.

struct CellValues {
  real v000, v100, v010, v110, v001, v101, v011, v111;  // digits: x, y, z
};

// Interpolates between a and b; exact at f = 0, at f = 1 and for a = b. So two cells give their shared face
// the same value, and no value leaves the range of the samples. A cell that is skipped by its range thus has
// no root through rounding.
FN real mix1(real a, real b, real f) {
  real d = b - a;
  real fromA = a + f * d, fromB = b - (R(1.0) - f) * d;
  return f < R(0.5) ? fromA : fromB;
}

// The value at fractions f in [0,1]^3; on a face it is the bilinear interpolation of that face's corners, to
// the bit.
FN real trilinear(CellValues c, vec3 f) {
  real x00 = mix1(c.v000, c.v100, f.x);
  real x10 = mix1(c.v010, c.v110, f.x);
  real x01 = mix1(c.v001, c.v101, f.x);
  real x11 = mix1(c.v011, c.v111, f.x);
  return mix1(mix1(x00, x10, f.y), mix1(x01, x11, f.y), f.z);
}

FN real minCorner(CellValues c) {
  return min(min(min(c.v000, c.v100), min(c.v010, c.v110)), min(min(c.v001, c.v101), min(c.v011, c.v111)));
}
FN real maxCorner(CellValues c) {
  return max(max(max(c.v000, c.v100), max(c.v010, c.v110)), max(max(c.v001, c.v101), max(c.v011, c.v111)));
}
// Whether all corners are finite; a cell with NaN or infinite corners has no data.
FN bool holdsData(CellValues c) {
  real s = ((c.v000 - c.v000) + (c.v100 - c.v100)) + ((c.v010 - c.v010) + (c.v110 - c.v110)) +
           (((c.v001 - c.v001) + (c.v101 - c.v101)) + ((c.v011 - c.v011) + (c.v111 - c.v111)));
  return s == R(0.0);
}

// The mean, exact if all are equal: on a plateau at the isovalue every coefficient is then exactly 0.
FN real mean3(real a, real b, real c) { return a + ((b - a) + (c - a)) * R(0.33333333333333333); }

// The same cell with `offset` subtracted from the values. For values near the offset the difference is exact
// (Sterbenz 1974), and what is computed from differences rounds in proportion to them. Samples around 300 K
// with an isovalue among them keep their digits behind the point.
FN CellValues cellValuesMinus(CellValues c, real offset) {
  CellValues d;
  d.v000 = c.v000 - offset;
  d.v100 = c.v100 - offset;
  d.v010 = c.v010 - offset;
  d.v110 = c.v110 - offset;
  d.v001 = c.v001 - offset;
  d.v101 = c.v101 - offset;
  d.v011 = c.v011 - offset;
  d.v111 = c.v111 - offset;
  return d;
}

// The Bernstein coefficients of the cell's values along the segment from fractions p to q: blossoms of the
// trilinear form. They bound the cubic; the first and the last are its end values.
FN vec4 bernsteinAlong(CellValues c, vec3 p, vec3 q) {
  // Interpolates at the x of p and of q, which gives four values on the edges along x each; then at the y of
  // p and of q.
  real p00 = mix1(c.v000, c.v100, p.x), p10 = mix1(c.v010, c.v110, p.x);
  real p01 = mix1(c.v001, c.v101, p.x), p11 = mix1(c.v011, c.v111, p.x);
  real q00 = mix1(c.v000, c.v100, q.x), q10 = mix1(c.v010, c.v110, q.x);
  real q01 = mix1(c.v001, c.v101, q.x), q11 = mix1(c.v011, c.v111, q.x);
  real pp0 = mix1(p00, p10, p.y), pp1 = mix1(p01, p11, p.y), pq0 = mix1(p00, p10, q.y),
       pq1 = mix1(p01, p11, q.y);
  real qp0 = mix1(q00, q10, p.y), qp1 = mix1(q01, q11, p.y), qq0 = mix1(q00, q10, q.y),
       qq1 = mix1(q01, q11, q.y);
  vec4 b;
  b.x = mix1(pp0, pp1, p.z);
  b.y = mean3(mix1(qp0, qp1, p.z), mix1(pq0, pq1, p.z), mix1(pp0, pp1, q.z));
  b.z = mean3(mix1(qq0, qq1, p.z), mix1(qp0, qp1, q.z), mix1(pq0, pq1, q.z));
  b.w = mix1(qq0, qq1, q.z);
  return b;
}
