// SPDX-License-Identifier: Apache-2.0
// A segment of a path line as part of one body: what lies inside the segment before or after is not a
// surface.

// A round cone and the points at the far ends of its neighbours.
struct Tube {
  vec3 a, b, before, after;
  real radiusA, radiusB, radiusBefore, radiusAfter;
  bool hasBefore, hasAfter;
};

struct TubeHit {
  real t, axial;  // axial: 0 at a, 1 at b
  vec3 normal;    // unit, outwards
};

FN vec3 difference(vec3 a, vec3 b) { return make_v3(a.x - b.x, a.y - b.y, a.z - b.z); }

// The depth of p inside the round cone from a ball of radius `radius` at 0 to one of radius `farRadius` at
// `far`. x: the place of the ball between them that is nearest, as a length from 0, not clamped; infinite
// (NO_HIT) if one ball holds the other.
FN real depthInCone(vec3 p, vec3 far, real radius, real farRadius, OUT(real) x) {
  real size = sqrt(dot3(far, far)), change = radius - farRadius;
  bool nested = size <= abs(change);
  real perSize = nested ? R(0.0) : R(1.0) / size;
  real slope = change * perSize;
  vec3 u = make_v3(far.x * perSize, far.y * perSize, far.z * perSize);
  real y = dot3(p, u);
  vec3 across = make_v3(p.x - y * u.x, p.y - y * u.y, p.z - y * u.z);
  x = y - sqrt(dot3(across, across)) * slope / sqrt((R(1.0) - slope) * (R(1.0) + slope));
  if (nested) x = change >= R(0.0) ? -NO_HIT : NO_HIT;
  real at = nested ? (change >= R(0.0) ? R(0.0) : R(1.0)) : clamp1(x * perSize, R(0.0), R(1.0));
  vec3 c = make_v3(p.x - at * far.x, p.y - at * far.y, p.z - at * far.z);
  return radius - at * change - sqrt(dot3(c, c));
}

// The hit's position relative to a.
FN vec3 tubePoint(Tube s, TubeHit h) {
  real radius = s.radiusA + h.axial * (s.radiusB - s.radiusA);
  vec3 ab = difference(s.b, s.a);
  return make_v3(h.axial * ab.x + radius * h.normal.x, h.axial * ab.y + radius * h.normal.y,
                 h.axial * ab.z + radius * h.normal.z);
}

// Whether the hit lies inside a neighbour. The ball at a joint is on both segments. It is a surface of the
// first of them, up to where the second one's cone begins. Within rounding of that place it is a surface of
// both, because a ray may meet the cone of the second as its ball.
FN bool insideNeighbour(Tube s, TubeHit h) {
  bool inside = false;
  vec3 p = tubePoint(s, h), ab = difference(s.b, s.a);
  // The size of rounding errors. If more were let through, rays would cross both surfaces beside a joint.
  real slack = R(1e-6) * (max(s.radiusA, s.radiusB) + sqrt(dot3(ab, ab))), x;
  if (s.hasBefore) {
    real depth = depthInCone(p, difference(s.before, s.a), s.radiusA, s.radiusBefore, x);
    inside = depth > slack;
    if (h.axial <= R(0.0)) {  // x is now a length along this segment
      depthInCone(p, ab, s.radiusA, s.radiusB, x);
      inside = inside || x < -slack;
    }
  }
  if (s.hasAfter) {
    real depth = depthInCone(difference(p, ab), difference(s.after, s.b), s.radiusB, s.radiusAfter, x);
    inside = inside || (h.axial >= R(1.0) ? x > slack : depth > slack);
  }
  return inside;
}

// The segment from a to b that a ray has met last, at t (-1: none).
struct MetSegment {
  real t;
  vec3 a, b;
};

FN MetSegment noSegment() {
  MetSegment met;
  met.t = R(-1.0);
  met.a = make_v3(R(0.0), R(0.0), R(0.0));
  met.b = met.a;
  return met;
}

FN bool same3(vec3 a, vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

// Whether the segment is a neighbour of the one that was met.
FN bool neighbourMet(Tube s, MetSegment met) {
  return (s.hasBefore && same3(met.a, s.before) && same3(met.b, s.a)) ||
         (s.hasAfter && same3(met.a, s.b) && same3(met.b, s.after));
}

// The first surface of the line with t > after on this segment. If a neighbour was met at the same t, the two
// are one surface, which is not met again.
FN bool hitTube(Tube s, vec3 o, vec3 d, real after, MetSegment met, OUT(TubeHit) h) {
  bool hit = hitRoundCone(o, d, s.a, s.b, s.radiusA, s.radiusB, after, h.t, h.normal, h.axial);
  if (hit && (s.hasBefore || s.hasAfter)) {
    bool none = insideNeighbour(s, h);
    if (h.t == met.t) none = none || neighbourMet(s, met);
    if (none) {
      real entry = h.t;
      hit = hitRoundCone(o, d, s.a, s.b, s.radiusA, s.radiusB, entry, h.t, h.normal, h.axial);
      if (hit) hit = !insideNeighbour(s, h);
    }
  }
  return hit;
}
