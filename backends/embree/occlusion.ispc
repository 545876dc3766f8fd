// SPDX-License-Identifier: Apache-2.0
// Whether geometry is in the way of rays of ambient occlusion, where these end at the first thing that they meet, whatever it is.
// Each goes by itself, through trees as wide as the gang (occlusion_tree.h): such rays go each its own way.
#include "kernel.isph"
#include "occlusion_layout.h"

struct OcclusionTreeView {
  const uniform unsigned int* uniform nodes;
  const uniform float* uniform leaves;
};

struct LoneRay {
  uniform vec3 o, d;
  uniform float perSquare, perLength;  // 1 / d.d, and its root
  uniform float tNear;                 // no hit is nearer
  uniform float tAfter, tOut, tClip;   // hits lie behind the first, before the second, and no farther than the third
};

// Whether hitSphere may find a hit: a test of a third of its time, wider than rounding makes it wrong. Most that leaves
// hold is passed by.
static inline bool comesNear(const uniform LoneRay& ray, vec3 centre, float radius) {
  vec3 c = make_v3(centre.x - ray.o.x, centre.y - ray.o.y, centre.z - ray.o.z);
  float along = (c.x * ray.d.x + c.y * ray.d.y + c.z * ray.d.z) * ray.perSquare;
  vec3 q = make_v3(c.x - along * ray.d.x, c.y - along * ray.d.y, c.z - along * ray.d.z);
  float reach = radius + 4e-6f * (radius + abs(centre.x) + abs(centre.y) + abs(centre.z) + abs(c.x) + abs(c.y) + abs(c.z));
  float span = reach * ray.perLength;
  return q.x * q.x + q.y * q.y + q.z * q.z <= reach * reach && along + span >= ray.tNear && along - span <= ray.tOut;
}

#define ROW(k) q[(k) * programCount + programIndex]
#define ROWS_POINT(k) make_v3(ROW(k), ROW(k + 1), ROW(k + 2))

// Whether the ray meets any primitive of a leaf.
static inline uniform bool meetsLeaf(const uniform LoneRay& ray, uniform int kind, const uniform float* uniform q) {
  bool hit = false;
  float t = NO_HIT;
  if (kind == KIND_PARTICLES) {
    vec3 centre = ROWS_POINT(0), normal;
    if (comesNear(ray, centre, ROW(3))) hit = hitSphere(ray.o, ray.d, centre, ROW(3), ray.tAfter, t, normal);
  } else if (kind == KIND_PATHLINES) {
    Tube tube = {ROWS_POINT(0), ROWS_POINT(4), ROWS_POINT(8), ROWS_POINT(12), ROW(3), ROW(7), ROW(11), ROW(15),
                 ROW(16) != 0.0f, ROW(17) != 0.0f};
    TubeHit h;
    hit = hitTube(tube, ray.o, ray.d, ray.tAfter, h);
    t = h.t;
  } else {
    float wb, wc;
    hit = hitTriangle(ray.o, ray.d, ROWS_POINT(0), ROWS_POINT(3), ROWS_POINT(6), ray.tAfter, t, wb, wc);
  }
  return any(hit && t < ray.tOut && t <= ray.tClip);
}

static inline uniform float reciprocal(uniform float d) {
  return extract(parallelTo(d) ? (d < 0.0f ? -1e37f : 1e37f) : 1.0f / d, 0);
}

// Whether the ray meets anything in a tree. Boxes are met by reciprocals, and so tested wider, by 16 roundings; no ray runs in a
// face, as those of primitives are moved out (primitive_bounds.h).
static uniform bool meetsAny(const uniform LoneRay& ray, uniform int kind, const uniform OcclusionTreeView& tree) {
  uniform float rx = reciprocal(ray.d.x), ry = reciprocal(ray.d.y), rz = reciprocal(ray.d.z);
  // the rows of the faces through which it enters and leaves
  uniform int inX = rx < 0.0f ? 3 : 0, inY = ry < 0.0f ? 4 : 1, inZ = rz < 0.0f ? 5 : 2;
  uniform int outX = 3 - inX, outY = 5 - inY, outZ = 7 - inZ;
  uniform int64 rows = kind == KIND_PARTICLES ? TREE_SPHERE_ROWS : kind == KIND_PATHLINES ? TREE_TUBE_ROWS : TREE_TRIANGLE_ROWS;
  uniform unsigned int stack[(programCount - 1) * TREE_DEEPEST];
  uniform int waiting = 0;
  uniform unsigned int next = 0;
  while (true) {
    if (next & TREE_LEAF) {
      if (meetsLeaf(ray, kind, tree.leaves + rows * programCount * (next & ~TREE_LEAF))) return true;
    } else {
      const uniform unsigned int* uniform node = tree.nodes + (uniform int64)TREE_NODE_ROWS * programCount * next;
      const uniform float* uniform q = (const uniform float* uniform)node;
      float enter = max(max((ROW(inX) - ray.o.x) * rx, (ROW(inY) - ray.o.y) * ry), max((ROW(inZ) - ray.o.z) * rz, ray.tNear));
      float leave =
          min(min((ROW(outX) - ray.o.x) * rx, (ROW(outY) - ray.o.y) * ry), min((ROW(outZ) - ray.o.z) * rz, ray.tOut));
      uniform int64 met = packmask(enter <= leave * 1.000001f);
      if (met != 0) {
        const uniform unsigned int* uniform child = node + 6 * programCount;
        next = child[count_trailing_zeros(met)];
        for (met &= met - 1; met != 0; met &= met - 1) stack[waiting++] = child[count_trailing_zeros(met)];
        continue;
      }
    }
    if (waiting == 0) return false;
    next = stack[--waiting];
  }
  return false;
}

// Rays of ambient occlusion that meet a surface become opaque (A = 1). `trees`: an OcclusionTreeView for each operator.
export void occludeRays(const void* uniform scene, const void* uniform trees, void* uniform rays, uniform int n) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  const uniform OcclusionTreeView* uniform tree = (const uniform OcclusionTreeView* uniform)trees;
  for (uniform int i = 0; i < n; i++) {
    if (RAY_KIND(r.info[i]) != RAY_OCCLUSION) continue;
    uniform LoneRay ray;
    ray.o.x = r.ox[i], ray.o.y = r.oy[i], ray.o.z = r.oz[i];
    ray.d.x = r.dx[i], ray.d.y = r.dy[i], ray.d.z = r.dz[i];
    ray.perSquare = 1.0f / (ray.d.x * ray.d.x + ray.d.y * ray.d.y + ray.d.z * ray.d.z);
    ray.perLength = sqrt(ray.perSquare);
    if (!all(meetsGeometry(ray.o))) continue;
    float bound = strictBound(r.tIn[i], r.tLast[i]);
    ray.tNear = max(extract(bound, 0), 0.0f);
    ray.tOut = min(min(r.tOut[i], r.tEnd[i]), NO_HIT);
    for (uniform int k = 0; k < s.operators; k++) {
      if (tree[k].nodes == NULL) continue;
      VOLUME field = s.field[k];
      float clip0, clip1;
      clipInterval(field, ray.o, ray.d, clip0, clip1);
      ray.tAfter = extract(boundBehind(field, bound, clip0), 0);
      ray.tClip = extract(clip1, 0);
      if (meetsAny(ray, s.operator_[k].kind, tree[k])) {
        r.A[i] = 1.0f;
        break;
      }
    }
  }
}
