// SPDX-License-Identifier: Apache-2.0
// Lines through a box that are uniformly distributed in the sense of integral geometry: none of their places and
// directions is preferred. Such a line meets a surface inside the box as often as any other of the same area
// (the formula of Cauchy and Crofton; Santalo, Integral Geometry and Geometric Probability, 1976, ch. 14). Its mean number of hits is
// twice the area of the surface over the area of the box.
//
// A line begins at a uniform point of the box's surface and goes inwards with a density proportional to the
// cosine. philox.h, light.h must come before.

// What a random number is for. Numbers for different purposes are independent.
#define DRAW_LINE 0u
#define DRAW_LINE_REST 1u

// The counter of Philox for hit `hit` of a ray, and child `child` (at most 2^24) that is born there.
FN uint drawCounter(uint child, uint purpose) { return (child << 8u) | purpose; }

// Computes line `number` (two words) of the sequence that `seed` (two words) selects, in a box from 0 to `size`.
// The start is on the face exactly.
FN void randomLine(uint seedLow, uint seedHigh, uint numberLow, uint numberHigh, vec3 size, OUT(vec3) start,
                   OUT(vec3) direction) {
  uint a = numberLow;
  uint b = numberHigh;
  uint c = 0u;
  uint d = drawCounter(0u, DRAW_LINE);
  philox4x32(seedLow, seedHigh, a, b, c, d);
  uint e = numberLow;
  uint f = numberHigh;
  uint g = 0u;
  uint h = drawCounter(0u, DRAW_LINE_REST);
  philox4x32(seedLow, seedHigh, e, f, g, h);
  real alongX = size.y * size.z;
  real alongY = size.z * size.x;
  real alongZ = size.x * size.y;
  real which = unitReal(a) * ((alongX + alongY) + alongZ);
  bool upper = (a & 1u) != 0u;  // unitReal leaves the lower bits
  real side = upper ? R(-1.0) : R(1.0);
  real far = upper ? R(1.0) : R(0.0);
  real u = unitReal(b);
  real v = unitReal(c);
  vec3 normal = make_v3(side, R(0.0), R(0.0));
  vec3 at = make_v3(far, u, v);
  if (which >= alongX) {
    normal = make_v3(R(0.0), side, R(0.0));
    at = make_v3(v, far, u);
  }
  if (which >= alongX + alongY) {
    normal = make_v3(R(0.0), R(0.0), side);
    at = make_v3(u, v, far);
  }
  start = make_v3(at.x * size.x, at.y * size.y, at.z * size.z);
  direction = cosineDirection(normal, unitReal(d), unitReal(e));
}
