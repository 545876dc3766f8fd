// SPDX-License-Identifier: Apache-2.0
// Ray against round cone: the union of all spheres along a segment whose radius is linear between its ends.
// It is the convex hull of the two end spheres: a cone frustum that touches them along circles, and their
// caps. Tubes of such segments are thus continuous at the joints.
//
// The sphere at axial length x has the centre x u and the radius r - x k (u: unit axis, k: slope). A point p
// is inside if min over x of |p - x u|^2 - (r - x k)^2 <= 0. The minimum, at x = (p.u - r k) / (1 - k^2),
// gives the cone as a quadratic in t. It also tells which sphere a surface point belongs to, from which the
// data value and the normal follow. The body is convex and contains each end sphere whole. So its entry is
// the least of the entries of both spheres and of the cone, the latter if its x lies on the segment; no
// clipping decides at a joint.
//
// Far rays: everything is computed from the ray's point nearest to the segment (exact.h). Degenerate cases: a
// segment of zero length, or one whose end sphere holds the other, is the bigger sphere; equal radii are a
// capsule. Sizes and distances must be within [1e-12, 1e12]; with both radii 0 it is never hit.

// The t at which the ray enters and leaves the infinite cone around axis u that has `radius` at 0 and loses
// `slope` per length. xEnter and xExit are the axial lengths of the spheres met there. Crossings that do not
// exist have x = -1e30.
FN void coneSpanNear(vec3 origin, vec3 direction, vec3 u, real radius, real slope, OUT(real) tEnter,
                     OUT(real) tExit, OUT(real) xEnter, OUT(real) xExit) {
  real m = (R(1.0) - slope) * (R(1.0) + slope);
  real k0 = dot3(origin, u) - radius * slope;
  real k1 = dot3(direction, u);
  real a = m * dot3(direction, direction) - k1 * k1;
  real b = m * dot3(origin, direction) - k0 * k1;
  real c = m * (dot3(origin, origin) - radius * radius) - k0 * k0;
  real discriminant = b * b - a * c;
  real h = sqrt(max1(discriminant, R(0.0)));
  // The entry is (-b - h) / a and the exit (-b + h) / a for either sign of a; the one that cancels is c / q.
  real q = b > R(0.0) ? -(b + h) : h - b;
  bool exists = discriminant >= R(0.0) && q != R(0.0) && m > R(0.0);
  bool both = exists && a != R(0.0);
  real byA = q / (both ? a : R(1.0));
  real byQ = c / (exists ? q : R(1.0));
  bool entryByA = b > R(0.0);
  tEnter = entryByA ? byA : byQ;
  tExit = entryByA ? byQ : byA;
  real perM = R(1.0) / (exists ? m : R(1.0));
  xEnter = (entryByA ? both : exists) ? (k0 + tEnter * k1) * perM : R(-1e30);
  xExit = (entryByA ? exists : both) ? (k0 + tExit * k1) * perM : R(-1e30);
}

// The first hit with t > tMin: the entry, or the exit if the origin is inside. normal: unit, outwards. axial:
// 0 at a, 1 at b, linear along the segment; it is the weight of b's data value.
FN bool hitRoundCone(vec3 origin, vec3 direction, vec3 a, vec3 b, real radiusA, real radiusB, real tMin,
                     OUT(real) t, OUT(vec3) normal, OUT(real) axial) {
  vec3 ab = make_v3(b.x - a.x, b.y - a.y, b.z - a.z);
  real size = sqrt(dot3(ab, ab));
  bool nested = size <= abs(radiusA - radiusB) || size < R(1e-18);
  real perSize = R(1.0) / (nested ? R(1.0) : size);
  vec3 u = make_v3(ab.x * perSize, ab.y * perSize, ab.z * perSize);
  real slope = nested ? R(0.0) : (radiusA - radiusB) * perSize;
  real span = nested ? R(0.0) : size;

  // Moves from the ray's start to its point nearest to one end, then to its point nearest to the axis at
  // xBase.
  bool fromB = nested && radiusB > radiusA;
  vec3 end = make_v3(fromB ? b.x : a.x, fromB ? b.y : a.y, fromB ? b.z : a.z);
  real tEnd;
  vec3 atEnd;
  closestApproach(origin, direction, end, tEnd, atEnd);
  real dd = dot3(direction, direction);
  real k1 = dot3(direction, u);
  real askew = dd - k1 * k1;
  real along = dot3(atEnd, u);
  real drift = dot3(atEnd, direction);
  real wanted = (along * dd - drift * k1) / (askew > R(1e-6) * dd ? askew : dd);
  real xBase = clamp1(wanted, R(0.0), span);
  real tBase = (xBase * k1 - drift) / dd;
  vec3 base =
      make_v3((atEnd.x - xBase * u.x) + tBase * direction.x, (atEnd.y - xBase * u.y) + tBase * direction.y,
              (atEnd.z - xBase * u.z) + tBase * direction.z);
  real radiusEnd = fromB ? radiusB : radiusA;
  real radiusFar = nested ? radiusEnd : radiusB;

  real tEnter;
  real tExit;
  real xEnter;
  real xExit;
  real radiusBase = radiusEnd - xBase * slope;
  coneSpanNear(base, direction, u, radiusBase, slope, tEnter, tExit, xEnter, xExit);
  xEnter = xEnter + xBase;
  xExit = xExit + xBase;
  bool coneIn = !nested && xEnter >= R(0.0) && xEnter <= span;
  bool coneOut = !nested && xExit >= R(0.0) && xExit <= span;
  tEnter = coneIn ? tEnter : R(1e30);
  tExit = coneOut ? tExit : R(-1e30);

  real far = span - xBase;
  real aIn;
  real aOut;
  real bIn;
  real bOut;
  bool metA = sphereSpanNear(make_v3(base.x + xBase * u.x, base.y + xBase * u.y, base.z + xBase * u.z),
                             direction, radiusEnd, aIn, aOut);
  bool metB = sphereSpanNear(make_v3(base.x - far * u.x, base.y - far * u.y, base.z - far * u.z), direction,
                             radiusFar, bIn, bOut);
  bool inA = metA && aIn < tEnter;
  tEnter = inA ? aIn : tEnter;
  xEnter = inA ? R(0.0) : xEnter;
  bool inB = metB && bIn < tEnter;
  tEnter = inB ? bIn : tEnter;
  xEnter = inB ? span : xEnter;
  bool outA = metA && aOut > tExit;
  tExit = outA ? aOut : tExit;
  xExit = outA ? R(0.0) : xExit;
  bool outB = metB && bOut > tExit;
  tExit = outB ? bOut : tExit;
  xExit = outB ? span : xExit;
  bool entered = coneIn || metA || metB;
  bool left = coneOut || metA || metB;

  real first = tEnd + (tBase + tEnter);
  real second = tEnd + (tBase + tExit);
  bool outside = entered && first > tMin;
  t = outside ? first : second;
  real local = outside ? tEnter : tExit;
  real x = outside ? xEnter : xExit;
  real offAxis = x - xBase;
  vec3 away =
      make_v3((base.x - offAxis * u.x) + local * direction.x, (base.y - offAxis * u.y) + local * direction.y,
              (base.z - offAxis * u.z) + local * direction.z);
  bool hit = outside || (left && second > tMin);
  normal = unit3(make_v3(hit ? away.x : R(1.0), hit ? away.y : R(0.0), hit ? away.z : R(0.0)));
  // It is exactly 1 on the ball at b, whatever span * perSize rounds to.
  axial = nested ? (fromB ? R(1.0) : R(0.0)) : (x < span ? min1(x * perSize, R(1.0)) : R(1.0));
  return hit;
}
