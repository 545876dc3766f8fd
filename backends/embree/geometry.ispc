// SPDX-License-Identifier: Apache-2.0
// Surfaces of particles, path lines and triangles: Embree finds candidates, the leaf tests of core/kernels decide, and
// ties go to the lowest (operator, primitive), so that neither packet width nor build order shows.
#include "embree.isph"

// What a callback needs besides Embree's ray: the query's own lower bound.
struct Query {
  RTCIntersectContext context;
  const SceneView* uniform scene;
  float* uniform tAfter;  // strict, per lane
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

// Tests one primitive against the gang's rays, of which `active` take part.
static inline bool testPrimitive(const uniform Query* uniform query, uniform unsigned int geomID, uniform unsigned int primID,
                                 bool active, vec3 o, vec3 d, float tFar, float& t) {
  const uniform SceneView& s = *query->scene;
  bool hit = false;
  if (active) {
    float clip0, clip1;
    VOLUME field = s.field[geomID];
    clipInterval(field, o, d, clip0, clip1);
    float after = boundBehind(field, query->tAfter[programIndex], clip0);
    hit = hitPrimitive(s.operator_[geomID], primID, o, d, after, t) && t <= tFar && t <= clip1;
  }
  return hit;
}

unmasked void intersectPrimitive(const RTCIntersectFunctionNArguments* uniform args) {
  const uniform Query* uniform query = (const uniform Query* uniform)args->context;
  RTCRayN* uniform ray = RTCRayHitN_RayN(args->rayhit, args->N);
  RTCHitN* uniform hit = RTCRayHitN_HitN(args->rayhit, args->N);
  uniform unsigned int geomID = args->geomID, primID = args->primID, N = args->N;
  uniform unsigned int i = 0;  // the gang is the whole packet
  bool active = args->valid[programIndex] != 0;
  vec3 o = make_v3(RTCRayN_org_x(ray, N, i), RTCRayN_org_y(ray, N, i), RTCRayN_org_z(ray, N, i));
  vec3 d = make_v3(RTCRayN_dir_x(ray, N, i), RTCRayN_dir_y(ray, N, i), RTCRayN_dir_z(ray, N, i));
  float tFar = RTCRayN_tfar(ray, N, i), t = NO_HIT;
  if (testPrimitive(query, geomID, primID, active, o, d, tFar, t)) {
    unsigned int g = RTCHitN_geomID(hit, N, i), p = RTCHitN_primID(hit, N, i);
    bool better = t < tFar || (g != RTC_INVALID_GEOMETRY_ID && (geomID < g || (geomID == g && primID < p)));
    if (better) {
      RTCRayN_tfar(ray, N, i) = t;
      RTCHitN_geomID(hit, N, i) = geomID;
      RTCHitN_primID(hit, N, i) = primID;
    }
  }
}

unmasked void occludePrimitive(const RTCOccludedFunctionNArguments* uniform args) {
  const uniform Query* uniform query = (const uniform Query* uniform)args->context;
  RTCRayN* uniform ray = args->ray;
  uniform unsigned int N = args->N;
  uniform unsigned int i = 0;  // the gang is the whole packet
  bool active = args->valid[programIndex] != 0;
  vec3 o = make_v3(RTCRayN_org_x(ray, N, i), RTCRayN_org_y(ray, N, i), RTCRayN_org_z(ray, N, i));
  vec3 d = make_v3(RTCRayN_dir_x(ray, N, i), RTCRayN_dir_y(ray, N, i), RTCRayN_dir_z(ray, N, i));
  float tFar = RTCRayN_tfar(ray, N, i), t = NO_HIT;
  if (testPrimitive(query, args->geomID, args->primID, active, o, d, tFar, t) && t < tFar) RTCRayN_tfar(ray, N, i) = -infinity();
}

// The callbacks of the instruction set in use.
export void* uniform intersectCallback() { return (void* uniform) & intersectPrimitive; }
export void* uniform occludeCallback() { return (void* uniform) & occludePrimitive; }

// The nearest surface of geometry; with anyHit, rays that meet one just become opaque (A = 1).
export void hitGeometry(const void* uniform scene, void* uniform rays, uniform int n, uniform bool anyHit) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  uniform Query query;
  rtcInitIntersectContext(&query.context);
  query.context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  query.scene = &s;
  uniform float after[programCount];
  query.tAfter = after;
  foreach (i = 0 ... n) {
    float tOut = min(min(r.tOut[i], r.tEnd[i]), NO_HIT);
    float bound = strictBound(r.tIn[i], r.tLast[i]);
    after[programIndex] = bound;
    vec3 o = make_v3(r.ox[i], r.oy[i], r.oz[i]);
    if (!meetsGeometry(o)) continue;
    if (anyHit) {
      RTCRay ray;
      ray.org_x = o.x; ray.org_y = o.y; ray.org_z = o.z;
      ray.dir_x = r.dx[i]; ray.dir_y = r.dy[i]; ray.dir_z = r.dz[i];
      ray.tnear = max(bound, 0.0f);
      ray.tfar = tOut;
      ray.time = 0.0f;
      ray.mask = -1;
      ray.id = 0;
      ray.flags = 0;
      rtcOccludedV((RTCScene)s.hierarchy, &query.context, &ray);
      if (ray.tfar < 0.0f) r.A[i] = 1.0f;
    } else {
      RTCRayHit q;
      q.ray.org_x = o.x; q.ray.org_y = o.y; q.ray.org_z = o.z;
      q.ray.dir_x = r.dx[i]; q.ray.dir_y = r.dy[i]; q.ray.dir_z = r.dz[i];
      q.ray.tnear = max(bound, 0.0f);
      q.ray.tfar = tOut;
      q.ray.time = 0.0f;
      q.ray.mask = -1;
      q.ray.id = 0;
      q.ray.flags = 0;
      q.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      q.hit.primID = RTC_INVALID_GEOMETRY_ID;
      rtcIntersectV((RTCScene)s.hierarchy, &query.context, &q);
      if (q.hit.geomID != RTC_INVALID_GEOMETRY_ID && q.ray.tfar < tOut) {
        r.tHit[i] = q.ray.tfar;
        r.hitKind[i] = HIT_GEOMETRY;
        r.hitOperator[i] = q.hit.geomID;
        r.hitPrimitive[i] = q.hit.primID;
      }
    }
  }
}
