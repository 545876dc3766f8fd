// SPDX-License-Identifier: Apache-2.0
// Bounds on where a ray may meet surfaces: the clip planes of an operator, and the surface that the ray met
// last.

// The interval of t that an operator's clip planes leave of the ray.
FN void clipInterval(CLIPS clips, vec3 o, vec3 d, OUT(real) t0, OUT(real) t1) {
  t0 = R(0.0);
  t1 = R(1e30);
  for (UNIFORM int k = 0; k < clips.planes; k++) {
    vec3 n = make_v3(clipValue(clips, 4 * k), clipValue(clips, 4 * k + 1), clipValue(clips, 4 * k + 2));
    real along = dot3(n, d);
    real room = clipValue(clips, 4 * k + 3) - dot3(n, o);
    if (along > R(0.0))
      t0 = max(t0, room / along);
    else if (along < R(0.0))
      t1 = min(t1, room / along);
    else if (room > R(0.0))
      t1 = R(-1.0);
  }
}

// Whether a ray from o can meet geometry. Builders of hierarchies take no box, and traversals no ray, that is
// farther away than 1.844e18.
FN bool meetsGeometry(vec3 o) { return abs(o.x) < R(1.8e18) && abs(o.y) < R(1.8e18) && abs(o.z) < R(1.8e18); }

// The float before t; -1 for t = 0, before which no ray begins.
FN real justBefore(real t) { return t > R(0.0) ? asReal(asUint(t) - 1u) : R(-1.0); }

// A lower bound that t must exceed: rays see surfaces from tIn on, and behind tLast.
FN real strictBound(real tIn, real tLast) { return max(max(justBefore(tIn), R(0.0)), tLast); }

// The surface that a ray has met last: at t (-1: none), of operator `op`, with its number (numberOf) there. A
// surface lies behind it if it is farther along the ray, or as far and of a higher (operator, number). So
// surfaces that coincide are met one after the other, in this order.
struct LastHit {
  real t;
  int op;
  uint number;
};

#define STEPS 0x40000000u        // the number of all steps of an operator, above those of its slices
#define ISOSURFACES 0x80000000u  // the number of all isosurfaces of an operator, above those of its slices

// The number of a surface among those of its operator: that of the primitive or slice, or ISOSURFACES.
FN uint numberOf(int hitKind, uint primitive) { return hitKind == HIT_ISOSURFACE ? ISOSURFACES : primitive; }

// The least number of a surface of operator `op` that lies behind the last one at the same t.
FN uint firstBehind(LastHit last, int op) {
  uint first = op > last.op ? 0u : 0xffffffffu;
  return op == last.op ? last.number + 1u : first;
}

// The bound that a surface's t must exceed to be behind the last one.
FN real behindLast(LastHit last, int op, uint number) {
  return number >= firstBehind(last, op) ? justBefore(last.t) : last.t;
}

// The same bound for an operator whose clip planes keep what is behind clip0.
FN real boundBehind(CLIPS clips, real bound, real clip0) {
  real after = bound;
  if (clips.planes > 0) after = max(bound, justBefore(max(clip0, R(1e-30))));
  return after;
}
