// SPDX-License-Identifier: Apache-2.0
// Rays in the index space of a regular grid: p(t) = po + t * pd, with the ray's own parameter t.
//
// Everything that decides which cell, macrocell or partition a ray is in compares t with planeCrossing(), one
// function of (ray, axis, plane). It is monotone in the plane (a subtraction and a multiplication by a
// constant, both rounded monotonically). So intervals never overlap or leave gaps, and every partition
// computes the same numbers.

struct GridRay {
  vec3 po, pd;  // position at t = 0 and per unit of t, in cells
  vec3 rpd;     // 1 / pd, of magnitude 1e30 at most, so that (plane - po) * rpd is never 0 * infinity
};

FN real cappedReciprocal(real x) {
  if (abs(x) < R(1e-30)) return x < R(0.0) ? R(-1e30) : R(1e30);
  return R(1.0) / x;
}

FN GridRay gridRay(vec3 o, vec3 d, vec3 origin, vec3 inverseSpacing) {
  GridRay g;
  g.po = make_v3((o.x - origin.x) * inverseSpacing.x, (o.y - origin.y) * inverseSpacing.y,
                 (o.z - origin.z) * inverseSpacing.z);
  g.pd = make_v3(d.x * inverseSpacing.x, d.y * inverseSpacing.y, d.z * inverseSpacing.z);
  g.rpd = make_v3(cappedReciprocal(g.pd.x), cappedReciprocal(g.pd.y), cappedReciprocal(g.pd.z));
  return g;
}

// The t at which the ray crosses grid plane `plane` of one axis.
FN real crossingOf(real plane, real po, real rpd) { return (plane - po) * rpd; }
FN real planeCrossing(int plane, real po, real rpd) { return crossingOf(toReal(plane), po, rpd); }

// The plane through which a ray enters or leaves cell i of one axis.
FN int nearPlane(int i, real rpd) { return rpd < R(0.0) ? i + 1 : i; }
FN int farPlane(int i, real rpd) { return rpd < R(0.0) ? i : i + 1; }

// The part of the ray inside the grid's box, t0 >= 0; empty (t0 >= t1) if it misses.
FN void gridInterval(GridRay g, ivec3 cells, OUT(real) t0, OUT(real) t1) {
  real nx = planeCrossing(g.rpd.x < R(0.0) ? cells.x : 0, g.po.x, g.rpd.x);
  real ny = planeCrossing(g.rpd.y < R(0.0) ? cells.y : 0, g.po.y, g.rpd.y);
  real nz = planeCrossing(g.rpd.z < R(0.0) ? cells.z : 0, g.po.z, g.rpd.z);
  real fx = planeCrossing(g.rpd.x < R(0.0) ? 0 : cells.x, g.po.x, g.rpd.x);
  real fy = planeCrossing(g.rpd.y < R(0.0) ? 0 : cells.y, g.po.y, g.rpd.y);
  real fz = planeCrossing(g.rpd.z < R(0.0) ? 0 : cells.z, g.po.z, g.rpd.z);
  t0 = max1(max1(max1(nx, ny), nz), R(0.0));  // max1 orders 0 and -0 alike in every dialect
  t1 = min1(min1(fx, fy), fz);
}

// The cell of one axis, of n, that the ray is in at t: an estimate that planeCrossing corrects. A ray that
// crosses a plane exactly at t is behind it. `po`, `pd`, `rpd` may be scaled by a power of 2 to locate
// macrocells.
FN int locateCell(real t, real po, real pd, real rpd, int n) {
  int i = toInt(clamp1(floor(po + t * pd), R(0.0), toReal(n - 1)));
  if (rpd < R(0.0)) {
    while (i > 0 && planeCrossing(i, po, rpd) <= t) i -= 1;
    while (i < n - 1 && planeCrossing(i + 1, po, rpd) > t) i += 1;
  } else {
    while (i < n - 1 && planeCrossing(i + 1, po, rpd) <= t) i += 1;
    while (i > 0 && planeCrossing(i, po, rpd) > t) i -= 1;
  }
  return i;
}

FN real min3(vec3 v) { return min(min(v.x, v.y), v.z); }
FN real max3(vec3 v) { return max(max(v.x, v.y), v.z); }
