// SPDX-License-Identifier: Apache-2.0
// Hits of particles, path lines, triangles, and isosurfaces and slices of meshes.
#include "backends/embree/geometry.isph"
#include "core/kernels/export.h"

// Finds each ray's nearest hit of geometry. With anyHit, rays that hit something just become opaque (A = 1),
// and none goes on behind a surface.
EXPORT void hitGeometry(const void* uniform scene, void* uniform rays, uniform int n, uniform bool anyHit) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  // One per operator.
  const uniform GeometryTreeView* uniform tree = (const uniform GeometryTreeView* uniform)s.hierarchy;
  uniform GangRays g;
  for (uniform int first = 0; first < n; first += programCount) {
    int i = first + programIndex;
    bool there = i < n;
    float bound = 0.0f, again = 0.0f;
    LastHit last;
    if (there) {
      takeRay(g, r, i);
      LANE(g, tFar) = min(min(r.tOut[i], r.tEnd[i]), NO_HIT);
      bound = strictBound(r.tIn[i], r.tLast[i]);
      again = bound;
      if (!anyHit && !s.opaqueSurfaces) {
        last = lastHit(s, r, i);
        again = strictBound(r.tIn[i], justBefore(last.t));
      }
    }
    vec3 o = make_v3(LANE(g, ox), LANE(g, oy), LANE(g, oz)), d = make_v3(LANE(g, dx), LANE(g, dy), LANE(g, dz));
    uniform bool goesOn = !anyHit && any(again < bound);
    LANE(g, tNear) = max(again, 0.0f);
    bool going = there && meetsGeometry(o) && LANE(g, tNear) <= LANE(g, tFar);
    bool alone = false;
    if (there) alone = RAY_KIND(r.info[i]) == RAY_OCCLUSION;
    uniform int64 lanes = packmask(going), lone = packmask(alone);
    unsigned int geometry = NO_PRIMITIVE, primitive = 0;
    for (uniform int k = 0; k < s.operators && lanes != 0; k++) {
      if (tree[k].nodes == NULL) continue;
      CLIPS clips = s.operator_[k].clips;
      float clip0, clip1;
      clipInterval(clips, o, d, clip0, clip1);
      LANE(g, tClip) = clip1;
      LANE(g, tAfter) = boundBehind(clips, bound, clip0);
      LANE(g, tMet) = -1.0f;
      LANE(g, primitive) = NO_PRIMITIVE;
      uniform int kind = s.operator_[k].kind;
      if (goesOn) {
        LANE(g, tAgain) = boundBehind(clips, again, clip0);
        LANE(g, firstAgain) = firstBehind(last, k);
        if (kind == KIND_PATHLINES && again < bound && last.op == k) {
          MetSegment met = metSegment(s.operator_[k], last.number, last.t);
          LANE(g, tMet) = met.t;
          LANE(g, metAX) = met.a.x, LANE(g, metAY) = met.a.y, LANE(g, metAZ) = met.a.z;
          LANE(g, metBX) = met.b.x, LANE(g, metBY) = met.b.y, LANE(g, metBZ) = met.b.z;
        }
      }
      if (kind >= KIND_TRIANGLES) takeFrame(g, frameOf(d));
      if (anyHit) {
        uniform int64 goOn = meetBundles(g, lanes, lone, kind, tree[k], true, false);
        bool met = isIn(lanes & ~goOn);
        if (met) r.A[i] = 1.0f;
        lanes = goOn;
      } else if (goesOn) {
        meetBundles(g, lanes, lone, kind, tree[k], false, true);
      } else {
        meetBundles(g, lanes, lone, kind, tree[k], false, false);
      }
      if (LANE(g, primitive) != NO_PRIMITIVE) {
        geometry = k;
        primitive = LANE(g, primitive);
      }
    }
    if (!anyHit && geometry != NO_PRIMITIVE && there) {
      r.tHit[i] = LANE(g, tFar);
      r.hitKind[i] = HIT_GEOMETRY;
      r.hitOperator[i] = geometry;
      r.hitPrimitive[i] = primitive;
    }
  }
}
