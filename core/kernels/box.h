// SPDX-License-Identifier: Apache-2.0
// Crossings of a ray with axis-aligned planes and boxes.
//
// faceCrossing is the one function of (ray, axis, face) that gives the t at which a ray crosses a face
// (docs/numerics.md, "Methods"). Spawning, walking, skipping and routing all call it, so every partition
// computes the same number. It is a true division of a rounded difference. Both are monotone, so t is
// monotone in the face: faces that are met in order along the ray have t in order (equal t at worst).
//
// A direction component that is 0, -0 or denormal never crosses a face (parallelTo). faceBefore and faceAfter
// then return the infinity that drops the face out of a maximum of entries or a minimum of exits. Numbers
// below the least normal float count as 0, so that all devices agree (elementary.h).
//
// Slab test: Kay & Kajiya 1986; signs and zeros: Williams et al., JGT 10(1), 2005; rounding: Ize, JCGT 2(2),
// 2013.

// Whether the ray keeps a constant coordinate on this axis.
FN bool parallelTo(real direction) { return abs(direction) < R(1.2e-38); }

// face - origin; 0 if it, or a number that it is made of, is too small for a normal float.
FN real gapTo(real origin, real face) {
  real gap = flushSmall(face) - flushSmall(origin);
  return flushSmall(gap);
}

// The t at which origin + t direction = face. Needs !parallelTo(direction) and a finite origin; face may be
// infinite.
FN real faceCrossing(real origin, real direction, real face) {
  real t = gapTo(origin, face) / direction;
  return flushSmall(t);
}

// The crossing as an entry: -infinity if the ray is parallel to the face.
FN real faceBefore(real origin, real direction, real face) {
  return parallelTo(direction) ? -infinity() : faceCrossing(origin, direction, face);
}

// The crossing as an exit: +infinity if the ray is parallel to the face.
FN real faceAfter(real origin, real direction, real face) {
  return parallelTo(direction) ? infinity() : faceCrossing(origin, direction, face);
}

// The interval of t inside the closed slab lo <= x <= hi of one axis, not widened. If a parallel ray is
// outside it is (inf, -inf), which is empty.
FN void slabSpan(real origin, real direction, real lo, real hi, OUT(real) tEnter, OUT(real) tExit) {
  bool forward = direction > R(0.0);
  tEnter = faceBefore(origin, direction, forward ? lo : hi);
  tExit = faceAfter(origin, direction, forward ? hi : lo);
  bool missed = parallelTo(direction) && (gapTo(origin, lo) > R(0.0) || gapTo(origin, hi) < R(0.0));
  tEnter = missed ? infinity() : tEnter;
  tExit = missed ? -infinity() : tExit;
}

// Returns true if the ray meets the closed box within [tMin, tMax]; [tEnter, tExit] then contains every such
// t. Conservative: no hit of exact arithmetic is missed, because each crossing carries 2 roundings and the
// exit is moved out by 2 gamma_3 = 3.6e-7 of itself. So tExit may exceed tMax by that much.
FN bool boxSpan(vec3 lo, vec3 hi, vec3 origin, vec3 direction, real tMin, real tMax, OUT(real) tEnter,
                OUT(real) tExit) {
  real e0;
  real e1;
  real e2;
  real x0;
  real x1;
  real x2;
  slabSpan(origin.x, direction.x, lo.x, hi.x, e0, x0);
  slabSpan(origin.y, direction.y, lo.y, hi.y, e1, x1);
  slabSpan(origin.z, direction.z, lo.z, hi.z, e2, x2);
  tEnter = max1(max1(e0, e1), max1(e2, tMin));
  real nearest = min1(min1(x0, x1), min1(x2, tMax));
  tExit = nearest * (nearest > R(0.0) ? R(1.00000036) : R(0.99999964));
  return tEnter <= tExit;
}
