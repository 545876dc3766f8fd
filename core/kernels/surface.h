// SPDX-License-Identifier: Apache-2.0
// The surface that a ray has hit: where it is, which way it faces, and the value or the colour that it shows.

struct Surface {
  vec3 point, normal;  // normal: for shading, unit, towards the viewer if two-sided
  // Normal of the surface itself: unit, on the side of `normal`; secondary rays leave along it.
  vec3 geometric;
  real value;
  vec3 own;    // its own colour, if the operator has colours
  real size;   // largest number that it was computed from, for the offset of secondary rays
  uint start;  // RAY_START and RAY_SIDE bits of the rays that leave it
};

FN Surface sphereSurface(OPERATOR op, uint p, vec3 o, vec3 d, real after) {
  Surface f;
  vec3 c = pointOf(op, p);
  real radius = radiusOf(op, p), t;
  hitSphere(o, d, c, radius, after, t, f.normal);
  f.geometric = f.normal;
  f.point = make_v3(c.x + radius * f.normal.x, c.y + radius * f.normal.y, c.z + radius * f.normal.z);
  f.size = max(largest3(c), radius);
  f.own = make_v3(R(0.0), R(0.0), R(0.0));
  f.value = R(0.0);
  if (hasValues(op)) f.value = valueOf(op, p);
  if (hasColors(op)) f.own = ownColorOf(op, p);
  f.start = 0u;
  return f;
}

FN Surface tubeSurface(OPERATOR op, uint p, vec3 o, vec3 d, real after) {
  Surface f;
  Tube tube = tubeOf(op, p);
  TubeHit h;
  hitTube(tube, o, d, after, noSegment(), h);
  vec3 local = tubePoint(tube, h);
  f.normal = h.normal;
  f.geometric = f.normal;
  f.point = make_v3(tube.a.x + local.x, tube.a.y + local.y, tube.a.z + local.z);
  f.size = max(max(largest3(tube.a), tube.radiusA), max(largest3(tube.b), tube.radiusB));
  f.own = make_v3(R(0.0), R(0.0), R(0.0));
  f.value = R(0.0);
  if (hasValues(op)) {
    // On the ball of one end it has only that end's value, also if the other has no data.
    real va = valueOf(op, cornerOf(op, 2u * p)), vb = valueOf(op, cornerOf(op, 2u * p + 1u));
    real between = lerp1(va, vb, h.axial);
    f.value = h.axial <= R(0.0) ? va : (h.axial >= R(1.0) ? vb : between);
  }
  if (hasColors(op)) {
    vec3 a = ownColorOf(op, cornerOf(op, 2u * p)), b = ownColorOf(op, cornerOf(op, 2u * p + 1u));
    real u = clamp1(h.axial, R(0.0), R(1.0));
    f.own = make_v3(lerp1(a.x, b.x, u), lerp1(a.y, b.y, u), lerp1(a.z, b.z, u));
  }
  f.start = 0u;
  return f;
}

FN Surface triangleSurface(OPERATOR op, uint p, vec3 o, vec3 d, real after) {
  Surface f;
  uint i = cornerOf(op, 3u * p), j = cornerOf(op, 3u * p + 1u), k = cornerOf(op, 3u * p + 2u);
  vec3 a = pointOf(op, i), b = pointOf(op, j), c = pointOf(op, k);
  real t, wb, wc;
  hitTriangle(o, d, a, b, c, after, t, wb, wc);
  real wa = (R(1.0) - wb) - wc;
  f.point = make_v3((wa * a.x + wb * b.x) + wc * c.x, (wa * a.y + wb * b.y) + wc * c.y,
                    (wa * a.z + wb * b.z) + wc * c.z);
  f.size = max(max(largest3(a), largest3(b)), largest3(c));
  f.normal = triangleNormal(a, b, c);
  f.geometric = f.normal;
  if (hasNormals(op)) {
    vec3 x = normalOf(op, i), y = normalOf(op, j), z = normalOf(op, k);
    vec3 m = make_v3((wa * x.x + wb * y.x) + wc * z.x, (wa * x.y + wb * y.y) + wc * z.y,
                     (wa * x.z + wb * y.z) + wc * z.z);
    if (dot3(m, m) > R(1e-12)) f.normal = normalize3(m);
  }
  f.own = make_v3(R(0.0), R(0.0), R(0.0));
  f.value = R(0.0);
  if (hasValues(op)) f.value = (wa * valueOf(op, i) + wb * valueOf(op, j)) + wc * valueOf(op, k);
  if (hasColors(op)) {
    vec3 x = ownColorOf(op, i), y = ownColorOf(op, j), z = ownColorOf(op, k);
    // The weights are those of a point that may lie beside the triangle by rounding.
    f.own = make_v3(clamp1((wa * x.x + wb * y.x) + wc * z.x, R(0.0), R(1.0)),
                    clamp1((wa * x.y + wb * y.y) + wc * z.y, R(0.0), R(1.0)),
                    clamp1((wa * x.z + wb * y.z) + wc * z.z, R(0.0), R(1.0)));
  }
  f.start = 0u;
  return f;
}

// A slice or an isosurface (by hitKind), number `index` of the operator, met at t.
FN Surface fieldSurface(OPERATOR op, VOLUME v, int hitKind, uint index, vec3 o, vec3 d, real t) {
  Surface f;
  f.point = make_v3(o.x + t * d.x, o.y + t * d.y, o.z + t * d.z);
  f.size = R(0.5);
  f.own = make_v3(R(0.0), R(0.0), R(0.0));
  VolumeRay ray = volumeRay(v, o, d, R(0.0), R(1e30));
  vec3 p = pointAt(ray.g, t);
  if (hitKind == HIT_SLICE) {
    f.normal = sliceNormal(op, index);
    f.geometric = f.normal;
    f.value = sampleAt(v, p);
    f.start = START_SLICE << 18;
  } else {
    f.value = isovalueOf(v, index);
    // The outside is where values are lower, as for a contour in VTK; towards the viewer if the field is
    // flat.
    ivec3 c = cellMet(v, ray.g, t);
    vec3 g = gradientIn(v, c, p);
    vec3 down = cellGradientIn(v, c, p);
    f.normal = unit3(make_v3(-g.x, -g.y, -g.z));
    f.geometric = unit3(make_v3(-down.x, -down.y, -down.z));
    f.start = START_ISOSURFACE << 18;
    if (!(dot3(f.geometric, f.geometric) >= R(0.5))) {
      f.geometric = make_v3(-d.x, -d.y, -d.z);
      f.start = 0u;
    }
    if (!(dot3(f.normal, f.normal) >= R(0.5))) f.normal = f.geometric;
  }
  return f;
}

// The colour of an operator's surface without lighting.
FN vec3 surfaceColor(OPERATOR op, Surface f) {
  vec3 color = f.own;
  if (!hasColors(op)) color = colorOf(op.map, f.value);
  return color;
}

// The surface as seen along d: both sides are lit, or only the one that its normal is on.
FN Surface surfaceSeen(Surface seen, vec3 d, bool twoSided) {
  Surface f = seen;
  bool away = dot3(f.normal, d) > R(0.0);
  if (twoSided && away) f.normal = make_v3(-f.normal.x, -f.normal.y, -f.normal.z);
  if (dot3(f.normal, f.geometric) < R(0.0)) {
    f.geometric = make_v3(-f.geometric.x, -f.geometric.y, -f.geometric.z);
    f.start = f.start ^ (1u << 20);  // the ray starts on the side of higher values
  }
  return f;
}
