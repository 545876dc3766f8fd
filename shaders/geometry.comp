// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// The nearest surface of geometry, and of isosurfaces and slices of meshes: a hierarchy of boxes finds candidates, nearest first, the leaf tests of core/kernels decide, and ties
// go to the lowest (operator, primitive), so that the order in which they are found does not show. With ANY_HIT, rays
// that meet one just become opaque.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"
#include "shaders/box_entry.glsl"

bool hitPrimitive(OperatorView op, uint p, vec3 o, vec3 d, float after, LastHit last, out float t) {
  bool hit = false;
  t = NO_HIT;
  if ((SURFACES & SURFACE_PARTICLES) != 0 && op.kind == KIND_PARTICLES) {
    vec3 normal;
    hit = hitSphere(o, d, pointOf(op, p), radiusOf(op, p), after, t, normal);
  }
  if ((SURFACES & SURFACE_PATHLINES) != 0 && op.kind == KIND_PATHLINES) {
    TubeHit h;
    MetSegment met = noSegment();
    if (last.t >= 0.0) met = metSegment(op, last.number, last.t);
    hit = hitTube(tubeOf(op, p), o, d, after, met, h);
    t = h.t;
  }
  if ((SURFACES & SURFACE_TRIANGLES) != 0 && op.kind == KIND_TRIANGLES) {
    float wb, wc;
    uint i = cornerOf(op, 3u * p), j = cornerOf(op, 3u * p + 1u), k = cornerOf(op, 3u * p + 2u);
    hit = hitTriangle(o, d, pointOf(op, i), pointOf(op, j), pointOf(op, k), after, t, wb, wc);
  }
  if ((SURFACES & SURFACE_CELLS) != 0 && op.kind == KIND_MESH)
    hit = hitCell(frameRay(o, d), levelCorner(op, p, 0), levelCorner(op, p, 1), levelCorner(op, p, 2), levelCorner(op, p, 3), after, t);
  if ((SURFACES & SURFACE_HEXES) != 0 && op.kind == KIND_HEX_MESH) {
    Hexahedron h = Hexahedron(hexLevel(op, p, 0), hexLevel(op, p, 1), hexLevel(op, p, 2), hexLevel(op, p, 3),
                              hexLevel(op, p, 4), hexLevel(op, p, 5), hexLevel(op, p, 6), hexLevel(op, p, 7));
    hit = hitHexahedron(frameRay(o, d), h, levelOrders(op, p), after, t);
  }
  return hit;
}

vec4 geometryReals(uint i) { return uintBitsToFloat(geometryQuad(i)); }

void main() {
  if (!hasRay()) return;
  vec3 o = rayOrigin(), d = rayDirection();
  float tOut = min(min(GIVEN(tOut), GIVEN(tEnd)), NO_HIT);
  float bound = strictBound(GIVEN(tIn), GIVEN(tLast)), again = bound;
  LastHit lastMet = LastHit(-1.0, -1, 0u);
  if (GOES_ON && !ANY_HIT) {
    lastMet = lastHit();
    again = strictBound(GIVEN(tIn), justBefore(lastMet.t));
  }
  float nearest = tOut;
  int hitOperator = -1;
  uint hitPrimitiveId = 0u;
  uint list = geometryWord(theScene.hierarchy), nodes = theScene.hierarchy + 4u;
  // A slice is a range of nodes here: those whose leaves are tested.
  RaySlice slice = sliceOf(0.0, geometryReal(theScene.hierarchy + 1u));
  uint begin = uint(slice.from), end = uint(slice.to);
  if (isResumed(slice) && GIVEN(hitKind) == HIT_GEOMETRY) {
    nearest = GIVEN(tHit);
    hitOperator = GIVEN(hitOperator);
    hitPrimitiveId = GIVEN(hitPrimitive);
  }
  vec3 rd = vec3(perLength(d.x), perLength(d.y), perLength(d.z));
  uint nodesMet = 0u, primitivesMet = 0u;
  uint stack[STACK_ENTRIES];
  int depth = 0;
  // a node, a leaf, or NODE_NONE, which looks like a leaf
  uint child = meetsGeometry(o) ? 0u : NODE_NONE;
  while (child != NODE_NONE) {
    while ((child & NODE_LEAF) == 0u) {
      uint at = nodes + NODE_WORDS * child;
      nodesMet++;
      vec4 loX = geometryReals(at), loY = geometryReals(at + 4u), loZ = geometryReals(at + 8u);
      vec4 hiX = geometryReals(at + 12u), hiY = geometryReals(at + 16u), hiZ = geometryReals(at + 20u);
      uvec4 children = geometryQuad(at + 24u), found;
      vec4 t;
#define VISIT(k, behind)                                                                      \
  t.k = entryOf(vec3(loX.k, loY.k, loZ.k), vec3(hiX.k, hiY.k, hiZ.k), o, rd, 0.0, nearest);   \
  if (children.k == NODE_NONE || !mayHoldOfSlice(children.k, behind, child, begin, end)) \
    t.k = infinity();                                                                         \
  found.k = t.k < infinity() ? children.k : NODE_NONE;
      VISIT(x, children.yzw)
      VISIT(y, children.zww)
      VISIT(z, children.www)
      VISIT(w, uvec3(NODE_NONE))
      sortByEntry(t, found);
      if (found.w != NODE_NONE) stack[depth++] = found.w;
      if (found.z != NODE_NONE) stack[depth++] = found.z;
      if (found.y != NODE_NONE) stack[depth++] = found.y;
      child = found.x;
      if (child == NODE_NONE && depth > 0) child = stack[--depth];
    }
    if (child != NODE_NONE) {
      uint first = child & NODE_FIRST, count = ((child >> NODE_COUNT_SHIFT) & 7u) + 1u;
      primitivesMet += count;
      for (uint k = first; k < first + count; k++) {
        int op = int(geometryWord(list + 2u * k));
        uint p = geometryWord(list + 2u * k + 1u);
        float t, after = bound, last = NO_HIT;
        LastHit met = LastHit(-1.0, op, 0u);  // of the operator
        if (GOES_ON && !ANY_HIT) {
          after = p >= firstBehind(lastMet, op) ? again : bound;
          if (again < bound && op == lastMet.op) met = lastMet;
        }
        if ((SURFACES & SURFACE_CLIPPED) != 0) {
          ClipView clips = operatorOf(op).clips;
          float clip0;
          clipInterval(clips, o, d, clip0, last);
          after = boundBehind(clips, after, clip0);
        }
        if (hitPrimitive(operatorOf(op), p, o, d, after, met, t) && t <= nearest && t <= last) {
          bool before = hitOperator >= 0 && (op < hitOperator || (op == hitOperator && p < hitPrimitiveId));
          if (t < nearest || before) {
            nearest = t;
            hitOperator = op;
            hitPrimitiveId = p;
          }
        }
      }
      child = NODE_NONE;
      if (depth > 0 && !(ANY_HIT && hitOperator >= 0)) child = stack[--depth];
    }
  }
  if ((SURFACES & SURFACE_COUNTS) != 0) {
    countUp(COUNT_NODES, nodesMet);
    countUp(COUNT_PRIMITIVES, primitivesMet);
  }
  float middle = floor(0.5 * (slice.from + slice.to)), next = slice.to + (slice.to - slice.from);
  if (!endSlice(slice, middle, next, ANY_HIT && hitOperator >= 0)) return;
  if (hitOperator >= 0) {
    if (ANY_HIT) {
      RAY(A) = 1.0;
    } else {
      RAY(tHit) = nearest;
      RAY(hitKind) = HIT_GEOMETRY;
      RAY(hitOperator) = hitOperator;
      RAY(hitPrimitive) = hitPrimitiveId;
    }
  }
}
