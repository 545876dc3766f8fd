// SPDX-License-Identifier: Apache-2.0
// The t at which a ray enters the boxes of a hierarchy.

// 1 / d, or a large number if the ray never crosses a face.
float perLength(float d) { return parallelTo(d) ? (d < 0.0 ? -1e37 : 1e37) : 1.0 / d; }

// The t at which a ray enters a box that contains all hits of its primitives; infinity if it does not enter
// it between `from` and `nearest`. It uses the direction's reciprocals, and is therefore wider than boxSpan, by 16
// roundings; leaf tests decide. No ray runs in a face, because primitive_bounds.h moves the faces of
// primitives outwards.
float entryOf(vec3 lo, vec3 hi, vec3 o, vec3 rd, float from, float nearest) {
  vec3 a = (lo - o) * rd, b = (hi - o) * rd;
  float enter = max1(max1(min1(a.x, b.x), min1(a.y, b.y)), max1(min1(a.z, b.z), from));
  float leave = min1(min1(max1(a.x, b.x), max1(a.y, b.y)), min1(max1(a.z, b.z), nearest));
  return enter <= leave + 1e-6 * abs(leave) ? enter : infinity();
}

// Sorts four children of a node by where the ray enters them, the nearest first.
void sortByEntry(inout vec4 t, inout uvec4 children) {
#define SORT(a, b)                                                                \
  {                                                                               \
    bool turn = t.b < t.a;                                                        \
    vec2 u = turn ? vec2(t.b, t.a) : vec2(t.a, t.b);                              \
    uvec2 v = turn ? uvec2(children.b, children.a) : uvec2(children.a, children.b); \
    t.a = u.x;                                                                    \
    t.b = u.y;                                                                    \
    children.a = v.x;                                                             \
    children.b = v.y;                                                             \
  }
  SORT(x, y)
  SORT(z, w)
  SORT(x, z)
  SORT(y, w)
  SORT(y, z)
}
