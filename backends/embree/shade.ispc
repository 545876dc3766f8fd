// SPDX-License-Identifier: Apache-2.0
// What a hit means for the picture: light as if nothing blocked it, and the secondary rays that take away what is
// blocked (subtractive lighting; paper, section 4.4). Shares are quantised once, so what a ray takes away is exactly
// what was given.
#include "tube.isph"

static inline int units(float x) { return (int)floor(min(x, 31.0f) * CONTRIBUTION_ONE + 0.5f); }

struct Surface {
  vec3 point, normal;  // normal: for shading, unit, towards the viewer where two-sided
  vec3 geometric;      // of the surface itself: unit; secondary rays leave along it, on the side of `normal`
  float value;
  float size;          // of the numbers it was computed from, for the offset of secondary rays
  unsigned int start;  // RAY_START and RAY_SIDE bits
};

static inline Surface geometrySurface(const uniform OperatorView& op, unsigned int p, vec3 o, vec3 d, float tLast) {
  Surface f;
  f.start = 0;
  f.value = 0.0f;
  float t;
  const uniform float* uniform q = op.points;
  if (op.kind == KIND_PARTICLES) {
    int64 a = 4 * (int64)p;
    vec3 c = make_v3(q[a], q[a + 1], q[a + 2]);
    float radius = q[a + 3];
    hitSphere(o, d, c, radius, tLast, t, f.normal);
    f.geometric = f.normal;
    f.point = make_v3(c.x + radius * f.normal.x, c.y + radius * f.normal.y, c.z + radius * f.normal.z);
    f.size = max(max(abs(c.x), abs(c.y)), max(abs(c.z), radius));
    if (op.values != NULL) f.value = op.values[p];
  } else if (op.kind == KIND_PATHLINES) {
    unsigned int i = op.indices[2 * (int64)p], j = op.indices[2 * (int64)p + 1];
    int64 a = 4 * (int64)i, b = 4 * (int64)j;
    unsigned int before = i, after = j;
    if (op.neighbours != NULL) {
      before = op.neighbours[2 * (int64)p];
      after = op.neighbours[2 * (int64)p + 1];
    }
    int64 e = 4 * (int64)before, g = 4 * (int64)after;
    Tube tube;
    tube.a = make_v3(q[a], q[a + 1], q[a + 2]);
    tube.b = make_v3(q[b], q[b + 1], q[b + 2]);
    tube.before = make_v3(q[e], q[e + 1], q[e + 2]);
    tube.after = make_v3(q[g], q[g + 1], q[g + 2]);
    tube.radiusA = q[a + 3];
    tube.radiusB = q[b + 3];
    tube.radiusBefore = q[e + 3];
    tube.radiusAfter = q[g + 3];
    tube.hasBefore = before != i;
    tube.hasAfter = after != j;
    TubeHit h;
    hitTube(tube, o, d, tLast, h);
    vec3 local = tubePoint(tube, h);
    f.normal = h.normal;
    f.geometric = f.normal;
    f.point = make_v3(tube.a.x + local.x, tube.a.y + local.y, tube.a.z + local.z);
    f.size = max(max(max(abs(q[a]), abs(q[a + 1])), max(abs(q[a + 2]), q[a + 3])),
                 max(max(abs(q[b]), abs(q[b + 1])), max(abs(q[b + 2]), q[b + 3])));
    if (op.values != NULL) {
      // on the ball of one end that end's alone, also where the other has no data
      float va = op.values[i], vb = op.values[j];
      f.value = h.axial <= 0.0f ? va : h.axial >= 1.0f ? vb : lerp1(va, vb, h.axial);
    }
  } else {
    unsigned int i = op.indices[3 * (int64)p], j = op.indices[3 * (int64)p + 1], k = op.indices[3 * (int64)p + 2];
    vec3 a = make_v3(q[4 * (int64)i], q[4 * (int64)i + 1], q[4 * (int64)i + 2]);
    vec3 b = make_v3(q[4 * (int64)j], q[4 * (int64)j + 1], q[4 * (int64)j + 2]);
    vec3 c = make_v3(q[4 * (int64)k], q[4 * (int64)k + 1], q[4 * (int64)k + 2]);
    float wb, wc;
    hitTriangle(o, d, a, b, c, tLast, t, wb, wc);
    float wa = (1.0f - wb) - wc;
    f.point = make_v3((wa * a.x + wb * b.x) + wc * c.x, (wa * a.y + wb * b.y) + wc * c.y, (wa * a.z + wb * b.z) + wc * c.z);
    f.size = max(max(max(abs(a.x), abs(a.y)), max(abs(a.z), abs(b.x))), max(max(abs(b.y), abs(b.z)), max(max(abs(c.x), abs(c.y)), abs(c.z))));
    f.normal = triangleNormal(a, b, c);
    f.geometric = f.normal;
    if (op.normals != NULL) {
      int64 x = 3 * (int64)i, y = 3 * (int64)j, z = 3 * (int64)k;
      vec3 m = make_v3((wa * op.normals[x] + wb * op.normals[y]) + wc * op.normals[z],
                       (wa * op.normals[x + 1] + wb * op.normals[y + 1]) + wc * op.normals[z + 1],
                       (wa * op.normals[x + 2] + wb * op.normals[y + 2]) + wc * op.normals[z + 2]);
      if (dot3(m, m) > 1e-12f) f.normal = normalize3(m);
    }
    if (op.values != NULL) f.value = (wa * op.values[i] + wb * op.values[j]) + wc * op.values[k];
  }
  return f;
}

// The gradient of the trilinear interpolation itself, per unit of render space.
static inline vec3 cellGradientAt(VOLUME v, vec3 p) {
  ivec3 c = cellAt(v, p);
  Corners k = cellCorners(v, c);
  vec3 f = fractionIn(c, p);
  float x = lerp1(lerp1(k.v100 - k.v000, k.v110 - k.v010, f.y), lerp1(k.v101 - k.v001, k.v111 - k.v011, f.y), f.z);
  float y = lerp1(lerp1(k.v010 - k.v000, k.v110 - k.v100, f.x), lerp1(k.v011 - k.v001, k.v111 - k.v101, f.x), f.z);
  float z = lerp1(lerp1(k.v001 - k.v000, k.v101 - k.v100, f.x), lerp1(k.v011 - k.v010, k.v111 - k.v110, f.x), f.y);
  return make_v3(x * v.inverseX, y * v.inverseY, z * v.inverseZ);
}

static inline Surface fieldSurface(const uniform OperatorView& op, VOLUME v, int kind, unsigned int index, vec3 o, vec3 d, float t) {
  Surface f;
  f.point = make_v3(o.x + t * d.x, o.y + t * d.y, o.z + t * d.z);
  f.size = 0.5f;
  VolumeRay ray = volumeRay(v, o, d, 0.0f, 1e30f);
  vec3 p = pointAt(ray.g, t);
  if (kind == HIT_SLICE) {
    const uniform float* s = op.slice + 4 * index;
    f.normal = make_v3(s[0], s[1], s[2]);
    f.geometric = f.normal;
    f.value = sampleAt(v, p);
    f.start = START_SLICE << 18;
  } else {
    f.value = v.isovalue[index];
    // outwards is where values are lower, as for a contour in VTK; towards the viewer where the field is flat
    vec3 down = cellGradientAt(v, p);
    f.geometric = unit3(make_v3(-down.x, -down.y, -down.z));
    f.start = START_ISOSURFACE << 18;
    if (dot3(f.geometric, f.geometric) < 0.5f) {
      f.geometric = make_v3(-d.x, -d.y, -d.z);
      f.start = 0;
    }
    vec3 g = gradientAt(v, p);
    f.normal = unit3(make_v3(-g.x, -g.y, -g.z));
    if (dot3(f.normal, f.normal) < 0.5f) f.normal = f.geometric;
  }
  return f;
}

static inline void depositShares(uniform int32 sum[], int k, int sr, int sg, int sb) {
  sum[4 * k] += sr;
  sum[4 * k + 1] += sg;
  sum[4 * k + 2] += sb;
}

// Shades the hits which[0 ... n) of primaries: `sum` (4 per hit, zeroed by the caller) receives what the pixel gains,
// `out` the secondary rays, whose number is returned; A gains what the surface hides. `out` has room for
// n * (lights + occlusion rays).
export uniform int shadeHits(const void* uniform scene, const void* uniform frame, void* uniform rays,
                             const uniform int which[], uniform int n, uniform int32 sum[], void* uniform out) {
  USE_SCENE(s, scene);
  USE_FRAME(f, frame);
  USE_RAYS(r, rays);
  USE_RAYS(w, out);
  uniform int made = 0;
  foreach (k = 0 ... n) {
    int i = which[k];
    vec3 o = originOf(r, i), d = directionOf(r, i);
    Surface surface;
    vec3 color = make_v3(0.0f, 0.0f, 0.0f);
    float opacity = 1.0f;
    int hitOperator = r.hitOperator[i];
    for (uniform int op = 0; op < s.operators; op++) {
      if (hitOperator == op) {
        const uniform OperatorView& view = s.operator_[op];
        VOLUME v = s.field[op];
        if (view.kind == KIND_VOLUME) {
          surface = fieldSurface(view, v, r.hitKind[i], r.hitPrimitive[i], o, d, r.tHit[i]);
        } else {
          float clip0, clip1;
          clipInterval(v, o, d, clip0, clip1);
          float after = strictBound(r.tIn[i], r.tLast[i]);
          if (v.clips > 0) after = max(after, asReal(asUint(max(clip0, 1e-30f)) - 1));
          surface = geometrySurface(view, r.hitPrimitive[i], o, d, after);
        }
        bool away = dot3(surface.normal, d) > 0.0f;
        if (view.twoSided && away) surface.normal = make_v3(-surface.normal.x, -surface.normal.y, -surface.normal.z);
        if (dot3(surface.normal, surface.geometric) < 0.0f) {
          surface.geometric = make_v3(-surface.geometric.x, -surface.geometric.y, -surface.geometric.z);
          surface.start ^= (1 << 20);  // on the side of higher values
        }
        color = colorOf(v, surface.value);
        opacity = view.opacity;
      }
    }
    float weight = (1.0f - r.A[i]) * opacity;
    r.A[i] = opacity >= 1.0f ? 1.0f : r.A[i] + (1.0f - r.A[i]) * opacity;
    vec3 toEye = make_v3(-d.x, -d.y, -d.z);
    vec3 from = offsetOrigin(surface.point, surface.geometric, surface.size);
    unsigned int startBits = (surface.start & (START_ISOSURFACE | START_SLICE) << 18) | (surface.start & (1 << 20));
    unsigned int start = ((unsigned int)hitOperator << 16) | r.hitPrimitive[i];

    uniform int rayCount = f.lights + max(s.occlusionRays, 1);
    for (uniform int q = 0; q < rayCount; q++) {
      vec3 toward = surface.normal;
      float reach = NO_HIT;
      int sr, sg, sb;
      uniform int kind;
      bool wanted;
      if (q < f.lights) {
        const uniform float* uniform light = f.light + 4 * q;
        if (light[0] == LIGHT_DIRECTIONAL) {
          toward = make_v3(-light[1], -light[2], -light[3]);
        } else {
          vec3 l = make_v3(light[1] - from.x, light[2] - from.y, light[3] - from.z);
          float distance = sqrt(dot3(l, l));
          float inverse = distance > 0.0f ? 1.0f / distance : 0.0f;
          toward = make_v3(l.x * inverse, l.y * inverse, l.z * inverse);
          reach = distance;
        }
        float diffuse = s.diffuse * lambert(surface.normal, toward) * weight;
        float specular = 0.0f;
        if (s.specular > 0.0f) specular = s.specular * phong(surface.normal, toward, toEye, s.shininess) * weight;
        sr = units(diffuse * color.x + specular);
        sg = units(diffuse * color.y + specular);
        sb = units(diffuse * color.z + specular);
        depositShares(sum, k, sr, sg, sb);
        kind = RAY_SHADOW;
        wanted = s.shadows != 0 && (sr | sg | sb) != 0;  // a light behind the surface makes no ray
      } else {
        float share = s.ambient * weight;
        if (s.occlusionRays > 0) share = share / (float)s.occlusionRays;
        sr = units(share * color.x);
        sg = units(share * color.y);
        sb = units(share * color.z);
        depositShares(sum, k, sr, sg, sb);
        kind = RAY_OCCLUSION;
        wanted = s.occlusionRays > 0 && (sr | sg | sb) != 0;
        if (wanted) toward = occlusionDirection(surface.normal, r.pixel[i], RAY_SAMPLE(r.info[i]), f.frame, q - f.lights, s.occlusionRays);
        reach = s.occlusionRadius;
      }
      if (wanted) {
        packed_store_active(w.pixel + made, r.pixel[i]);
        packed_store_active(w.info + made, RAY_SAMPLE(r.info[i]) | ((unsigned int)kind << 16) | startBits);
        packed_store_active(w.start + made, start);
        packed_store_active((uniform int* uniform)(w.ox + made), intbits(from.x));
        packed_store_active((uniform int* uniform)(w.oy + made), intbits(from.y));
        packed_store_active((uniform int* uniform)(w.oz + made), intbits(from.z));
        packed_store_active((uniform int* uniform)(w.dx + made), intbits(toward.x));
        packed_store_active((uniform int* uniform)(w.dy + made), intbits(toward.y));
        packed_store_active((uniform int* uniform)(w.dz + made), intbits(toward.z));
        packed_store_active((uniform int* uniform)(w.tLast + made), intbits(-1.0f));
        packed_store_active((uniform int* uniform)(w.tBegun + made), intbits(-1.0f));
        packed_store_active((uniform int* uniform)(w.tMax + made), intbits(reach));
        packed_store_active((uniform int* uniform)(w.A + made), intbits(0.0f));
        packed_store_active(w.sr + made, sr);
        packed_store_active(w.sg + made, sg);
        made += packed_store_active(w.sb + made, sb);
      }
    }
  }
  return made;
}

// What the pixel of a ray that is done gains (primaries) or loses (secondaries): 4 per ray. A secondary that falls below
// tMin loses all, as if it had met an opaque surface: whether one lies behind is known or not, as the partitions fall.
export void settleRays(const void* uniform scene, void* uniform rays, const uniform int which[], uniform int n, uniform int32 sum[]) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  foreach (k = 0 ... n) {
    int i = which[k];
    float A = min(r.A[i], 1.0f);
    if (RAY_KIND(r.info[i]) == RAY_PRIMARY) {
      sum[4 * k] = units(r.r[i]);
      sum[4 * k + 1] = units(r.g[i]);
      sum[4 * k + 2] = units(r.b[i]);
      sum[4 * k + 3] = units(A);
    } else {
      int all = 1.0f - A < s.tMin || A == 1.0f ? 1 : 0;
      sum[4 * k] = -(all != 0 ? r.sr[i] : min((int)((float)r.sr[i] * A), r.sr[i]));
      sum[4 * k + 1] = -(all != 0 ? r.sg[i] : min((int)((float)r.sg[i] * A), r.sg[i]));
      sum[4 * k + 2] = -(all != 0 ? r.sb[i] : min((int)((float)r.sb[i] * A), r.sb[i]));
      sum[4 * k + 3] = 0;
    }
  }
}

// Rays that go on behind a translucent surface, or stop there: secondaries lose the surface's share, primaries have been
// shaded. `opacity` is per operator.
export void passSurfaces(const void* uniform scene, void* uniform rays, uniform int n) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  foreach (i = 0 ... n) {
    if (r.next[i] == END_SURFACE) {
      if (RAY_KIND(r.info[i]) != RAY_PRIMARY) {
        for (uniform int op = 0; op < s.operators; op++)
          if (r.hitOperator[i] == op) {
            float opacity = s.operator_[op].opacity;
            r.A[i] = opacity >= 1.0f ? 1.0f : r.A[i] + (1.0f - r.A[i]) * opacity;
          }
      }
      r.tLast[i] = r.tHit[i];
      r.tBegun[i] = -1.0f;
      r.next[i] = 1.0f - r.A[i] < s.tMin ? END_DONE : END_ACTIVE;
    }
  }
}
