// SPDX-License-Identifier: Apache-2.0
// Surfaces of particles, path lines and triangles: Embree finds candidates, the leaf tests of core/kernels decide, and
// ties go to the lowest (operator, primitive), so that neither packet width nor build order shows.
#include "embree.isph"

// What a callback needs besides Embree's ray: the query's own lower bound.
struct Query {
  QueryContext context;
  const SceneView* uniform scene;
  float* uniform tAfter;  // strict, per lane from that of the first ray
};

static inline bool hitPrimitive(const uniform OperatorView& op, uniform unsigned int p, vec3 o, vec3 d, float tAfter, float& t) {
  const uniform float* uniform q = op.points;
  vec3 normal;
  if (op.kind == KIND_PARTICLES) {
    const uniform float* uniform c = q + 4 * (uniform int64)p;
    return hitSphere(o, d, make_v3(c[0], c[1], c[2]), c[3], tAfter, t, normal);
  } else if (op.kind == KIND_PATHLINES) {
    const uniform unsigned int* uniform ends = op.indices + 2 * (uniform int64)p;
    const uniform unsigned int* uniform near = op.neighbours != NULL ? op.neighbours + 2 * (uniform int64)p : ends;
    const uniform float* uniform a = q + 4 * (uniform int64)ends[0];
    const uniform float* uniform b = q + 4 * (uniform int64)ends[1];
    const uniform float* uniform before = q + 4 * (uniform int64)near[0];
    const uniform float* uniform after = q + 4 * (uniform int64)near[1];
    Tube tube = {make_v3(a[0], a[1], a[2]), make_v3(b[0], b[1], b[2]), make_v3(before[0], before[1], before[2]),
                 make_v3(after[0], after[1], after[2]), a[3], b[3], before[3], after[3], near[0] != ends[0], near[1] != ends[1]};
    TubeHit h;
    bool hit = hitTube(tube, o, d, tAfter, h);
    t = h.t;
    return hit;
  } else {
    const uniform float* uniform a = q + 4 * (uniform int64)op.indices[3 * p];
    const uniform float* uniform b = q + 4 * (uniform int64)op.indices[3 * p + 1];
    const uniform float* uniform c = q + 4 * (uniform int64)op.indices[3 * p + 2];
    float wb, wc;
    return hitTriangle(o, d, make_v3(a[0], a[1], a[2]), make_v3(b[0], b[1], b[2]), make_v3(c[0], c[1], c[2]), tAfter, t, wb, wc);
  }
}

// Tests one primitive against the gang's rays.
static inline bool testPrimitive(const uniform Query* uniform query, uniform unsigned int geomID, uniform unsigned int primID,
                                 CallbackRay ray, float& t) {
  const uniform SceneView& s = *query->scene;
  bool hit = false;
  if (ray.active) {
    float clip0, clip1;
    VOLUME field = s.field[geomID];
    clipInterval(field, ray.o, ray.d, clip0, clip1);
    float after = boundBehind(field, query->tAfter[programIndex], clip0);
    hit = hitPrimitive(s.operator_[geomID], primID, ray.o, ray.d, after, t) && t <= ray.tFar && t <= clip1;
  }
  return hit;
}

unmasked void intersectPrimitive(const NearestArguments* uniform args) {
  const uniform Query* uniform query = (const uniform Query* uniform)args->context;
  uniform unsigned int geomID = args->geomID, primID = args->primID;
  CallbackRay ray = rayOf(args);
  float t = NO_HIT;
  if (testPrimitive(query, geomID, primID, ray, t)) {
    unsigned int g = foundGeometry(args), p = foundPrimitive(args);
    bool better = t < ray.tFar || (g != NO_GEOMETRY && (geomID < g || (geomID == g && primID < p)));
    if (better) acceptHit(args, t);
  }
}

unmasked void occludePrimitive(const AnyArguments* uniform args) {
  const uniform Query* uniform query = (const uniform Query* uniform)args->context;
  CallbackRay ray = rayOf(args);
  float t = NO_HIT;
  if (testPrimitive(query, args->geomID, args->primID, ray, t) && t < ray.tFar) acceptHit(args);
}

// The callbacks of the instruction set in use.
export void* uniform intersectCallback() { return (void* uniform) & intersectPrimitive; }
export void* uniform occludeCallback() { return (void* uniform) & occludePrimitive; }

// The nearest surface of geometry; with anyHit, rays that meet one just become opaque (A = 1), but for those of ambient occlusion,
// which are left to occlusion.ispc.
export void hitGeometry(const void* uniform scene, void* uniform rays, uniform int n, uniform bool anyHit) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  uniform Query query;
  beginQuery(query.context);
  query.scene = &s;
  uniform float after[programCount];
  query.tAfter = after;
  foreach (i = 0 ... n) {
    float tOut = min(min(r.tOut[i], r.tEnd[i]), NO_HIT);
    float bound = strictBound(r.tIn[i], r.tLast[i]);
    after[programIndex] = bound;
    vec3 o = originOf(r, i);
    if (!meetsGeometry(o)) continue;
    vec3 d = directionOf(r, i);
    float tNear = max(bound, 0.0f);
    if (anyHit) {
      if (RAY_KIND(r.info[i]) != RAY_OCCLUSION) {
        if (findAny(s.hierarchy, query.context, o, d, tNear, tOut)) r.A[i] = 1.0f;
      }
    } else {
      float t = tOut;
      unsigned int geometry, primitive;
      findNearest(s.hierarchy, query.context, o, d, tNear, t, geometry, primitive);
      if (geometry != NO_GEOMETRY && t < tOut) {
        r.tHit[i] = t;
        r.hitKind[i] = HIT_GEOMETRY;
        r.hitOperator[i] = geometry;
        r.hitPrimitive[i] = primitive;
      }
    }
  }
}
