// SPDX-License-Identifier: Apache-2.0
// The t at which a ray enters the boxes of a hierarchy.

// 1 / d, or a large number if the ray never crosses a face.
float perLength(float d) { return parallelTo(d) ? (d < 0.0 ? -1e37 : 1e37) : 1.0 / d; }

// The t at which a ray enters a box that contains all hits of its primitives; infinity if it does not enter
// it before `nearest`. It uses the direction's reciprocals, and is therefore wider than boxSpan, by 16
// roundings; leaf tests decide. No ray runs in a face, because primitive_bounds.h moves the faces of
// primitives outwards.
float entryOf(vec3 lo, vec3 hi, vec3 o, vec3 rd, float nearest) {
  vec3 a = (lo - o) * rd, b = (hi - o) * rd;
  float enter = max1(max1(min1(a.x, b.x), min1(a.y, b.y)), max1(min1(a.z, b.z), 0.0));
  float leave = min1(min1(max1(a.x, b.x), max1(a.y, b.y)), min1(max1(a.z, b.z), nearest));
  return enter <= leave * 1.000001 ? enter : infinity();
}
