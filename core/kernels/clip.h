// SPDX-License-Identifier: Apache-2.0
// What bounds a ray's surfaces: the clip planes of an operator, and what it has met before.

// The part of the ray that an operator's clip planes leave.
FN void clipInterval(VOLUME v, vec3 o, vec3 d, OUT(real) t0, OUT(real) t1) {
  t0 = R(0.0);
  t1 = R(1e30);
  for (UNIFORM int k = 0; k < v.clips; k++) {
    vec3 n = make_v3(clipValue(v, 4 * k), clipValue(v, 4 * k + 1), clipValue(v, 4 * k + 2));
    real along = dot3(n, d);
    real room = clipValue(v, 4 * k + 3) - dot3(n, o);
    if (along > R(0.0))
      t0 = max(t0, room / along);
    else if (along < R(0.0))
      t1 = min(t1, room / along);
    else if (room > R(0.0))
      t1 = R(-1.0);
  }
}

// Whether a ray from there can meet geometry: builders of hierarchies take no box, and traversals no ray, that is farther away
// than 1.844e18.
FN bool meetsGeometry(vec3 o) { return abs(o.x) < R(1.8e18) && abs(o.y) < R(1.8e18) && abs(o.z) < R(1.8e18); }

// A lower bound that t must exceed: rays see surfaces from tIn on, and strictly behind the last one they met.
FN real strictBound(real tIn, real tLast) {
  real before = tIn > R(0.0) ? asReal(asUint(tIn) - 1u) : R(0.0);
  return max(before, tLast);
}

// The same for an operator whose clip planes leave what is behind clip0.
FN real boundBehind(VOLUME v, real bound, real clip0) {
  real after = bound;
  if (v.clips > 0) after = max(bound, asReal(asUint(max(clip0, R(1e-30))) - 1u));
  return after;
}
