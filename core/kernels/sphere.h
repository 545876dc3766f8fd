// SPDX-License-Identifier: Apache-2.0
// Ray against sphere.
//
// The discriminant is taken as radius^2 - |point of closest approach|^2 (Hearn & Baker; Haines, Gunther,
// Akenine-Moller, Ray Tracing Gems ch. 7). That point is computed from nearby (exact.h), so that neither a
// hit nor the normal loses digits with distance. Only t itself is rounded to its own ulp: take the position
// from the normal, centre + radius * normal. Radii and distances must be within [1e-12, 1e12]; a radius of
// 0 or less is never hit.

// The t at which origin + t direction enters and leaves a sphere around 0, for an origin no more than a few
// radii away.
FN bool sphereSpanNear(vec3 origin, vec3 direction, real radius, OUT(real) tEnter, OUT(real) tExit) {
  real dd = dot3(direction, direction);
  real middle = -dot3(origin, direction) / dd;
  vec3 nearest = make_v3(origin.x + middle * direction.x, origin.y + middle * direction.y,
                         origin.z + middle * direction.z);
  real room = radius * radius - dot3(nearest, nearest);
  real halfChord = sqrt(max1(room, R(0.0)) / dd);
  tEnter = middle - halfChord;
  tExit = middle + halfChord;
  return room >= R(0.0) && radius > R(0.0);
}

// The first hit with t > tMin: the entry, or the exit if the origin is inside. normal: unit, outwards.
FN bool hitSphere(vec3 origin, vec3 direction, vec3 centre, real radius, real tMin, OUT(real) t,
                  OUT(vec3) normal) {
  real tNear;
  vec3 base;
  closestApproach(origin, direction, centre, tNear, base);
  real tEnter;
  real tExit;
  bool met = sphereSpanNear(base, direction, radius, tEnter, tExit);
  real first = tNear + tEnter;
  real second = tNear + tExit;
  bool outside = first > tMin;
  real local = outside ? tEnter : tExit;
  t = outside ? first : second;
  normal = unit3(
      make_v3(base.x + local * direction.x, base.y + local * direction.y, base.z + local * direction.z));
  return met && t > tMin;
}
