// SPDX-License-Identifier: Apache-2.0
// Hits of particles, path lines and triangles. Rays walk through trees as wide as the gang (geometry_tree.h),
// and the leaf tests of core/kernels decide. Ties go to the lowest (operator, primitive), so the result
// depends neither on the gang's width nor on a tree's shape.
//
// Rays of similar directions go as a bundle. A step tests what all of them can meet against all children of a
// node, by intervals of their origins and of their reciprocal directions (Boulos, Wald and Shirley,
// "Geometric and arithmetic culling methods for entire ray packets", 2006). Others, such as ambient-occlusion
// rays, go one by one, as bundles of one.
#include "backends/embree/kernel.isph"
#include "backends/embree/tree_layout.h"

struct GeometryTreeView {
  const uniform unsigned int* uniform nodes;
  const uniform float* uniform leaves;
};

static inline const uniform float* uniform nodeOf(const uniform GeometryTreeView& tree, uniform unsigned int number) {
  return (const uniform float* uniform)(tree.nodes + (uniform int64)TREE_NODE_ROWS * programCount * number);
}

#define NO_PRIMITIVE 0xffffffffu

// The gang's rays, one per lane.
struct GangRays {
  uniform float ox[programCount], oy[programCount], oz[programCount], dx[programCount], dy[programCount], dz[programCount];
  uniform float rx[programCount], ry[programCount], rz[programCount];  // reciprocals of d
  uniform float perSquare[programCount], perLength[programCount];     // 1 / d.d and its square root
  // The axis that becomes z in the frame (RayFrame) in which triangles are tested.
  uniform int last[programCount];
  uniform float perDepth[programCount], shearX[programCount], shearY[programCount];
  uniform float tNear[programCount];  // lower bound of t for hits
  uniform float tFar[programCount];   // t of the nearest hit, or the ray's end
  // Hits of the operator have t > tAfter and <= tClip.
  uniform float tAfter[programCount], tClip[programCount];
  // For rays that go on behind a surface: primitives from firstAgain on have t > tAgain instead of tAfter.
  uniform float tAgain[programCount];
  uniform unsigned int firstAgain[programCount];
  // Where (t) a segment of the operator's path lines was met last; -1: nowhere.
  uniform float tMet[programCount];
  uniform float metAX[programCount], metAY[programCount], metAZ[programCount];
  uniform float metBX[programCount], metBY[programCount], metBZ[programCount];
  uniform unsigned int primitive[programCount];  // the operator's primitive that is hit, or NO_PRIMITIVE
};

// Some of the gang's rays, whose directions all lie in one octant.
struct Bundle {
  uniform int64 lanes;
  uniform float tNear, tFar;            // least tNear and largest tFar of its rays
  uniform vec3 oIn, oOut;               // per axis, the origins that enter boxes first and leave them last
  uniform vec3 rLeast, rMost;
  uniform int inX, inY, inZ, outX, outY, outZ;  // rows of a node with the faces that rays enter and leave by
};

#define ROW(k) q[(k) * programCount + programIndex]
#define ROWS_POINT(k) make_v3(ROW(k), ROW(k + 1), ROW(k + 2))
#define TURNED_CORNER(k) make_v3(ROW(k + x) - from[x], ROW(k + y) - from[y], ROW(k + z) - from[z])
#define ENTRY_OF_NODE(b) make_v3(ROW(b.inX), ROW(b.inY), ROW(b.inZ))
#define EXIT_OF_NODE(b) make_v3(ROW(b.outX), ROW(b.outY), ROW(b.outZ))
#define ONE(k) q[(k) * programCount + p]
#define ONES_POINT(k) make_v3(ONE(k), ONE(k + 1), ONE(k + 2))
#define ONES_CORNER(k) turned(make_v3(ONE(k) - o.x, ONE(k + 1) - o.y, ONE(k + 2) - o.z), f.last)
#define LANE(g, field) g.field[programIndex]

static inline bool isIn(uniform int64 lanes) { return ((uniform int)lanes & (1 << programIndex)) != 0; }

static inline float reciprocal(float d) { return parallelTo(d) ? (d < 0.0f ? -1e37f : 1e37f) : 1.0f / d; }

// Whether hitSphere may find a hit. The test takes a third of hitSphere's time, and is wider than its
// rounding errors. It rejects most spheres of a leaf.
static inline bool comesNear(vec3 o, vec3 d, float perSquare, float perLength, float tNear, float tFar, vec3 centre,
                             float radius) {
  vec3 c = make_v3(centre.x - o.x, centre.y - o.y, centre.z - o.z);
  float along = (c.x * d.x + c.y * d.y + c.z * d.z) * perSquare;
  vec3 q = make_v3(c.x - along * d.x, c.y - along * d.y, c.z - along * d.z);
  float reach = radius + 4e-6f * (radius + abs(centre.x) + abs(centre.y) + abs(centre.z) + abs(c.x) + abs(c.y) + abs(c.z));
  float span = reach * perLength;
  return q.x * q.x + q.y * q.y + q.z * q.z <= reach * reach && along + span >= tNear && along - span <= tFar;
}

// Tests one ray against all primitives of a leaf, one per lane.
static inline bool hitLanes(const uniform GangRays& g, uniform int lane, uniform int kind, const uniform float* uniform q,
                            unsigned int id, uniform bool goesOn, float& t) {
  vec3 o = make_v3(g.ox[lane], g.oy[lane], g.oz[lane]), d = make_v3(g.dx[lane], g.dy[lane], g.dz[lane]);
  float tAfter = g.tAfter[lane];
  if (goesOn) tAfter = id >= g.firstAgain[lane] ? g.tAgain[lane] : tAfter;
  bool hit = false;
  t = NO_HIT;
  if (kind == KIND_PARTICLES) {
    vec3 centre = ROWS_POINT(0), normal;
    if (comesNear(o, d, g.perSquare[lane], g.perLength[lane], g.tNear[lane], g.tFar[lane], centre, ROW(3)))
      hit = hitSphere(o, d, centre, ROW(3), tAfter, t, normal);
  } else if (kind == KIND_PATHLINES) {
    Tube tube = {ROWS_POINT(0), ROWS_POINT(4), ROWS_POINT(8), ROWS_POINT(12), ROW(3), ROW(7), ROW(11), ROW(15),
                 ROW(16) != 0.0f, ROW(17) != 0.0f};
    TubeHit h;
    MetSegment met = noSegment();
    if (goesOn) {
      met.t = g.tMet[lane];
      met.a = make_v3(g.metAX[lane], g.metAY[lane], g.metAZ[lane]);
      met.b = make_v3(g.metBX[lane], g.metBY[lane], g.metBZ[lane]);
    }
    hit = hitTube(tube, o, d, tAfter, met, h);
    t = h.t;
  } else {
    uniform int z = g.last[lane];
    uniform int x = z == 2 ? 0 : z + 1, y = z == 0 ? 2 : z - 1;
    uniform float from[3] = {g.ox[lane], g.oy[lane], g.oz[lane]};
    RayFrame f = {z, g.perDepth[lane], g.shearX[lane], g.shearY[lane]};
    float wb, wc;
    hit = hitTurned(f, TURNED_CORNER(0), TURNED_CORNER(3), TURNED_CORNER(6), tAfter, t, wb, wc);
  }
  return hit && t <= g.tClip[lane];
}

// Tests all rays of the gang against primitive p of a leaf.
static inline bool hitOne(const uniform GangRays& g, uniform int p, uniform int kind, const uniform float* uniform q,
                          uniform unsigned int id, uniform bool goesOn, float& t) {
  vec3 o = make_v3(LANE(g, ox), LANE(g, oy), LANE(g, oz)), d = make_v3(LANE(g, dx), LANE(g, dy), LANE(g, dz));
  float tAfter = LANE(g, tAfter);
  if (goesOn) tAfter = id >= LANE(g, firstAgain) ? LANE(g, tAgain) : tAfter;
  bool hit = false;
  t = NO_HIT;
  if (kind == KIND_PARTICLES) {
    vec3 centre = ONES_POINT(0), normal;
    if (comesNear(o, d, LANE(g, perSquare), LANE(g, perLength), LANE(g, tNear), LANE(g, tFar), centre, ONE(3)))
      hit = hitSphere(o, d, centre, ONE(3), tAfter, t, normal);
  } else if (kind == KIND_PATHLINES) {
    Tube tube = {ONES_POINT(0), ONES_POINT(4), ONES_POINT(8), ONES_POINT(12), ONE(3), ONE(7), ONE(11), ONE(15),
                 ONE(16) != 0.0f, ONE(17) != 0.0f};
    TubeHit h;
    MetSegment met = noSegment();
    if (goesOn) {
      met.t = LANE(g, tMet);
      met.a = make_v3(LANE(g, metAX), LANE(g, metAY), LANE(g, metAZ));
      met.b = make_v3(LANE(g, metBX), LANE(g, metBY), LANE(g, metBZ));
    }
    hit = hitTube(tube, o, d, tAfter, met, h);
    t = h.t;
  } else {
    RayFrame f = {LANE(g, last), LANE(g, perDepth), LANE(g, shearX), LANE(g, shearY)};
    float wb, wc;
    hit = hitTurned(f, ONES_CORNER(0), ONES_CORNER(3), ONES_CORNER(6), tAfter, t, wb, wc);
  }
  return hit && t <= LANE(g, tClip);
}

// Whether the bundle may meet the box, by the interval of t in which its rays may be inside.
static inline bool meetsBox(const uniform Bundle& b, vec3 near, vec3 far, float& enter) {
  float x = near.x - b.oIn.x, y = near.y - b.oIn.y, z = near.z - b.oIn.z;
  enter = max(max(min(x * b.rLeast.x, x * b.rMost.x), min(y * b.rLeast.y, y * b.rMost.y)),
              max(min(z * b.rLeast.z, z * b.rMost.z), b.tNear));
  x = far.x - b.oOut.x, y = far.y - b.oOut.y, z = far.z - b.oOut.z;
  float leave = min(min(max(x * b.rLeast.x, x * b.rMost.x), max(y * b.rLeast.y, y * b.rMost.y)),
                    min(max(z * b.rLeast.z, z * b.rMost.z), b.tFar));
  return enter <= leave * 1.000001f;
}

static inline void widen(vec3 p, float radius, vec3& lo, vec3& hi) {
  float r = max(radius, 0.0f);
  lo.x = min(lo.x, p.x - r), lo.y = min(lo.y, p.y - r), lo.z = min(lo.z, p.z - r);
  hi.x = max(hi.x, p.x + r), hi.y = max(hi.y, p.y + r), hi.z = max(hi.z, p.z + r);
}

// Which primitives of a leaf the bundle may meet, by the same boxes as in primitive_bounds.h.
static inline uniform int64 primitivesMet(const uniform Bundle& b, uniform int kind, const uniform float* uniform q,
                                          uniform int count) {
  vec3 lo = make_v3(infinity(), infinity(), infinity()), hi = make_v3(-infinity(), -infinity(), -infinity());
  if (kind == KIND_PARTICLES) {
    widen(ROWS_POINT(0), ROW(3), lo, hi);
  } else if (kind == KIND_PATHLINES) {
    widen(ROWS_POINT(0), ROW(3), lo, hi);
    widen(ROWS_POINT(4), ROW(7), lo, hi);
  } else {
    widen(ROWS_POINT(0), 0.0f, lo, hi);
    widen(ROWS_POINT(3), 0.0f, lo, hi);
    widen(ROWS_POINT(6), 0.0f, lo, hi);
  }
  float slack = 2e-6f * max(max(max(abs(lo.x), abs(hi.x)), max(abs(lo.y), abs(hi.y))), max(abs(lo.z), abs(hi.z)));
  lo.x -= slack, lo.y -= slack, lo.z -= slack;
  hi.x += slack, hi.y += slack, hi.z += slack;
  uniform bool backX = b.inX != 0, backY = b.inY != 1, backZ = b.inZ != 2;
  float enter;
  bool met = meetsBox(b, make_v3(backX ? hi.x : lo.x, backY ? hi.y : lo.y, backZ ? hi.z : lo.z),
                      make_v3(backX ? lo.x : hi.x, backY ? lo.y : hi.y, backZ ? lo.z : hi.z), enter);
  return packmask(met && programIndex < count);
}

// Tests the bundle's rays against a leaf. With anyHit, rays that hit something leave the bundle; otherwise
// the nearest hit is kept. goesOn: some of the rays go on behind a surface.
static inline void meetLeaf(uniform GangRays& g, uniform Bundle& b, uniform int64 lanes, uniform int kind,
                            const uniform GeometryTreeView& tree, uniform unsigned int word, uniform bool anyHit,
                            uniform bool goesOn) {
  uniform int rows = kind == KIND_PARTICLES ? TREE_SPHERE_ROWS : kind == KIND_PATHLINES ? TREE_TUBE_ROWS : TREE_TRIANGLE_ROWS;
  uniform int64 number = word & TREE_LEAF_NUMBER;
  uniform int count = ((word & ~TREE_LEAF) >> TREE_COUNT_SHIFT) + 1;
  const uniform float* uniform q = tree.leaves + number * (rows + 1) * programCount;
  const uniform unsigned int* uniform ids = (const uniform unsigned int* uniform)(q + rows * programCount);
  uniform int rays = popcnt(lanes);
  uniform int64 met = 0;
  if (rays > 1) {
    met = primitivesMet(b, kind, q, count);
    if (met == 0) return;
  }
  if (rays == 1 || rays < popcnt(met)) {
    unsigned int id = ids[programIndex];
    for (; lanes != 0; lanes &= lanes - 1) {
      uniform int lane = count_trailing_zeros(lanes);
      float t;
      bool hit = hitLanes(g, lane, kind, q, id, goesOn, t);
      if (anyHit) {
        if (any(hit && t < g.tFar[lane])) b.lanes &= ~((uniform int64)1 << lane);
      } else {
        hit = hit && t <= g.tFar[lane];
        if (any(hit)) {
          uniform float nearest = reduce_min(hit ? t : NO_HIT);
          uniform unsigned int least = reduce_min(hit && t == nearest ? id : NO_PRIMITIVE);
          if (nearest < g.tFar[lane] || (g.primitive[lane] != NO_PRIMITIVE && least < g.primitive[lane])) {
            g.tFar[lane] = nearest;
            g.primitive[lane] = least;
          }
        }
      }
    }
  } else {
    bool mine = isIn(lanes);
    for (; met != 0; met &= met - 1) {
      uniform int p = count_trailing_zeros(met);
      float t;
      bool hit = hitOne(g, p, kind, q, ids[p], goesOn, t) && mine;
      if (anyHit) {
        hit = hit && t < LANE(g, tFar);
        b.lanes &= ~(uniform int64)packmask(hit);
        mine = mine && !hit;
      } else if (hit && (t < LANE(g, tFar) ||
                         (t == LANE(g, tFar) && LANE(g, primitive) != NO_PRIMITIVE && ids[p] < LANE(g, primitive)))) {
        LANE(g, tFar) = t;
        LANE(g, primitive) = ids[p];
      }
    }
  }
  if (!anyHit) b.tFar = reduce_max(isIn(b.lanes) ? LANE(g, tFar) : 0.0f);
}

// The lanes of those of the bundle's rays that meet child k of a node.
static inline uniform int64 lanesThrough(const uniform GangRays& g, const uniform Bundle& b, const uniform float* uniform node,
                                         uniform int k) {
  const uniform float* uniform q = node + k;
  float enter = max(max((q[b.inX * programCount] - LANE(g, ox)) * LANE(g, rx), (q[b.inY * programCount] - LANE(g, oy)) * LANE(g, ry)),
                    max((q[b.inZ * programCount] - LANE(g, oz)) * LANE(g, rz), LANE(g, tNear)));
  float leave = min(min((q[b.outX * programCount] - LANE(g, ox)) * LANE(g, rx), (q[b.outY * programCount] - LANE(g, oy)) * LANE(g, ry)),
                    min((q[b.outZ * programCount] - LANE(g, oz)) * LANE(g, rz), LANE(g, tFar)));
  return b.lanes & packmask(enter <= leave * 1.000001f);
}

// Takes the bundle's rays through a tree. Boxes are tested by reciprocals of directions, and so enlarged by
// 16 roundings. No ray runs in a face, because primitive_bounds.h moves the faces of primitives outwards.
static inline void walk(uniform GangRays& g, uniform Bundle& b, uniform int kind, const uniform GeometryTreeView& tree,
                        uniform bool anyHit, uniform bool goesOn) {
  uniform unsigned int stack[programCount * TREE_DEEPEST];  // node number * programCount + child
  uniform float from[programCount * TREE_DEEPEST];
  uniform int waiting = 0;
  uniform unsigned int next = 0;
  while (true) {
    const uniform float* uniform q = nodeOf(tree, next);
    float enter;
    uniform int64 met = packmask(meetsBox(b, ENTRY_OF_NODE(b), EXIT_OF_NODE(b), enter));
    while (met != 0) {  // push the nearest child last
      uniform int k = count_trailing_zeros(met);
      if (!anyHit) {
        from[waiting] = extract(enter, k);
        if ((met & (met - 1)) != 0) {
          from[waiting] = reduce_max(isIn(met) ? enter : -1.0f);
          k = count_trailing_zeros(met & packmask(enter == from[waiting]));
        }
      }
      stack[waiting++] = next * programCount + k;
      met &= ~((uniform int64)1 << k);
    }
    while (true) {
      if (waiting == 0) return;
      waiting--;
      if (!anyHit && from[waiting] > b.tFar * 1.000001f) continue;
      const uniform float* uniform node = nodeOf(tree, stack[waiting] / programCount);
      uniform int k = stack[waiting] % programCount;
      uniform int64 lanes = lanesThrough(g, b, node, k);
      if (lanes == 0) continue;
      uniform unsigned int word = intbits(node[6 * programCount + k]);
      if ((word & TREE_LEAF) == 0) {
        next = word;
        break;
      }
      meetLeaf(g, b, lanes, kind, tree, word, anyHit, goesOn);
      if (anyHit && b.lanes == 0) return;
    }
  }
}

// The same for a bundle of one ray.
static inline void walkAlone(uniform GangRays& g, uniform Bundle& b, uniform int kind, const uniform GeometryTreeView& tree,
                             uniform bool anyHit, uniform bool goesOn) {
  uniform unsigned int stack[programCount * TREE_DEEPEST];  // words of children
  uniform float from[programCount * TREE_DEEPEST];
  uniform int waiting = 0;
  uniform unsigned int next = 0;
  while (true) {
    if (next & TREE_LEAF) {
      meetLeaf(g, b, b.lanes, kind, tree, next, anyHit, goesOn);
      if (anyHit && b.lanes == 0) return;
    } else {
      const uniform float* uniform q = nodeOf(tree, next);
      vec3 near = ENTRY_OF_NODE(b), far = EXIT_OF_NODE(b);
      float enter = max(max((near.x - b.oIn.x) * b.rLeast.x, (near.y - b.oIn.y) * b.rLeast.y),
                        max((near.z - b.oIn.z) * b.rLeast.z, b.tNear));
      float leave = min(min((far.x - b.oIn.x) * b.rLeast.x, (far.y - b.oIn.y) * b.rLeast.y),
                        min((far.z - b.oIn.z) * b.rLeast.z, b.tFar));
      uniform int64 met = packmask(enter <= leave * 1.000001f);
      if (met != 0) {
        const uniform unsigned int* uniform child = (const uniform unsigned int* uniform)(q + 6 * programCount);
        uniform int k = count_trailing_zeros(met);
        if (!anyHit && (met & (met - 1)) != 0) {
          uniform float first = reduce_min(isIn(met) ? enter : infinity());
          k = count_trailing_zeros(met & packmask(enter == first));
        }
        next = child[k];
        for (met &= ~((uniform int64)1 << k); met != 0; met &= met - 1) {
          k = count_trailing_zeros(met);
          if (!anyHit) from[waiting] = extract(enter, k);
          stack[waiting++] = child[k];
        }
        continue;
      }
    }
    do {
      if (waiting == 0) return;
      next = stack[--waiting];
    } while (!anyHit && from[waiting] > b.tFar * 1.000001f);
  }
}

static inline void meetTree(uniform GangRays& g, uniform Bundle& b, uniform int kind, const uniform GeometryTreeView& tree,
                            uniform bool anyHit, uniform bool goesOn) {
  if ((b.lanes & (b.lanes - 1)) == 0)
    walkAlone(g, b, kind, tree, anyHit, goesOn);
  else
    walk(g, b, kind, tree, anyHit, goesOn);
}

#define SPAN(field, least, most)                       \
  least = reduce_min(mine ? LANE(g, field) : infinity()); \
  most = reduce_max(mine ? LANE(g, field) : -infinity())

// Makes the bundle of these lanes, whose rays are all of one octant.
static inline void bundleOf(const uniform GangRays& g, uniform int64 lanes, uniform Bundle& b) {
  bool mine = isIn(lanes);
  b.lanes = lanes;
  uniform vec3 least, most;
  SPAN(ox, least.x, most.x);
  SPAN(oy, least.y, most.y);
  SPAN(oz, least.z, most.z);
  SPAN(rx, b.rLeast.x, b.rMost.x);
  SPAN(ry, b.rLeast.y, b.rMost.y);
  SPAN(rz, b.rLeast.z, b.rMost.z);
  b.tNear = reduce_min(mine ? LANE(g, tNear) : infinity());
  b.tFar = reduce_max(mine ? LANE(g, tFar) : 0.0f);
  uniform bool backX = b.rMost.x < 0.0f, backY = b.rMost.y < 0.0f, backZ = b.rMost.z < 0.0f;
  b.inX = backX ? 3 : 0, b.inY = backY ? 4 : 1, b.inZ = backZ ? 5 : 2;
  b.outX = 3 - b.inX, b.outY = 5 - b.inY, b.outZ = 7 - b.inZ;
  b.oIn.x = backX ? least.x : most.x, b.oIn.y = backY ? least.y : most.y, b.oIn.z = backZ ? least.z : most.z;
  b.oOut.x = backX ? most.x : least.x, b.oOut.y = backY ? most.y : least.y, b.oOut.z = backZ ? most.z : least.z;
}

static inline void bundleOfOne(const uniform GangRays& g, uniform int i, uniform Bundle& b) {
  b.lanes = (uniform int64)1 << i;
  b.rLeast.x = g.rx[i], b.rLeast.y = g.ry[i], b.rLeast.z = g.rz[i];
  b.rMost = b.rLeast;
  b.oIn.x = g.ox[i], b.oIn.y = g.oy[i], b.oIn.z = g.oz[i];
  b.oOut = b.oIn;
  b.tNear = g.tNear[i], b.tFar = g.tFar[i];
  b.inX = b.rLeast.x < 0.0f ? 3 : 0, b.inY = b.rLeast.y < 0.0f ? 4 : 1, b.inZ = b.rLeast.z < 0.0f ? 5 : 2;
  b.outX = 3 - b.inX, b.outY = 5 - b.inY, b.outZ = 7 - b.inZ;
}

// Returns those of `lanes` whose rays go within 18 degrees of the first one and in its octant.
static inline uniform int64 alike(const uniform GangRays& g, uniform int64 lanes) {
  uniform int i = count_trailing_zeros(lanes);
  bool octant = (LANE(g, rx) < 0.0f) == (g.rx[i] < 0.0f) && (LANE(g, ry) < 0.0f) == (g.ry[i] < 0.0f) &&
                (LANE(g, rz) < 0.0f) == (g.rz[i] < 0.0f);
  float along = LANE(g, dx) * g.dx[i] + LANE(g, dy) * g.dy[i] + LANE(g, dz) * g.dz[i];
  bool cone = along * LANE(g, perLength) * g.perLength[i] > 0.95f;
  return lanes & packmask(octant && (cone || programIndex == i));
}

// Finds each ray's nearest hit of geometry. With anyHit, rays that hit something just become opaque (A = 1),
// and none goes on behind a surface.
export void hitGeometry(const void* uniform scene, void* uniform rays, uniform int n, uniform bool anyHit) {
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
      LANE(g, ox) = r.ox[i], LANE(g, oy) = r.oy[i], LANE(g, oz) = r.oz[i];
      LANE(g, dx) = r.dx[i], LANE(g, dy) = r.dy[i], LANE(g, dz) = r.dz[i];
      LANE(g, tFar) = min(min(r.tOut[i], r.tEnd[i]), NO_HIT);
      bound = strictBound(r.tIn[i], r.tLast[i]);
      again = bound;
      if (!anyHit && !s.opaqueSurfaces) {
        last = lastHit(s, r, i);
        again = strictBound(r.tIn[i], justBefore(last.t));
      }
    }
    vec3 o = make_v3(LANE(g, ox), LANE(g, oy), LANE(g, oz)), d = make_v3(LANE(g, dx), LANE(g, dy), LANE(g, dz));
    LANE(g, rx) = reciprocal(d.x), LANE(g, ry) = reciprocal(d.y), LANE(g, rz) = reciprocal(d.z);
    LANE(g, perSquare) = 1.0f / (d.x * d.x + d.y * d.y + d.z * d.z);
    LANE(g, perLength) = sqrt(LANE(g, perSquare));
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
      if (kind == KIND_TRIANGLES) {
        RayFrame f = frameOf(d);
        LANE(g, last) = f.last, LANE(g, perDepth) = f.perDepth, LANE(g, shearX) = f.shearX, LANE(g, shearY) = f.shearY;
      }
      for (uniform int64 left = lanes; left != 0;) {
        uniform Bundle b;
        uniform int64 these = left & -left;
        if ((lone & these) == 0) these = alike(g, left & ~lone);
        left &= ~these;
        if ((these & (these - 1)) == 0)
          bundleOfOne(g, count_trailing_zeros(these), b);
        else
          bundleOf(g, these, b);
        if (anyHit)
          meetTree(g, b, kind, tree[k], true, false);
        else if (goesOn)
          meetTree(g, b, kind, tree[k], false, true);
        else
          meetTree(g, b, kind, tree[k], false, false);
        if (anyHit) {
          lanes &= ~these | b.lanes;
          bool met = isIn(these & ~b.lanes);
          if (met) r.A[i] = 1.0f;
        }
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
