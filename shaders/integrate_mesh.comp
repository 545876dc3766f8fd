// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Emission and absorption through an unstructured volume. A hierarchy over the faces of its shell finds where walks begin.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"
#include "shaders/box_entry.glsl"

vec4 geometryReals(uint i) { return uintBitsToFloat(geometryQuad(i)); }

#define OF_HEXAHEDRA ((SURFACES & SURFACE_HEXES) != 0)

bool passesTetFace(OperatorView op, FrameRay f, uint face, out float t) {
  vec3 a = placeOf(vertexOf(op, cornerOfFace(op, face, 0)));
  vec3 b = placeOf(vertexOf(op, cornerOfFace(op, face, 1)));
  vec3 c = placeOf(vertexOf(op, cornerOfFace(op, face, 2)));
  return passesFace(f, a, b, c, t);
}

bool passesHexFace(OperatorView op, FrameRay f, uint face, out float t) {
  uint orders = hexOrders(op, face >> 3), at = (face >> 3) * 8u, corners = orderedCorners(face & 7u, orders);
  vec3 a = placeOf(vertexOf(op, hexPoint(op, at + (corners & 7u))));
  vec3 b = placeOf(vertexOf(op, hexPoint(op, at + ((corners >> 4) & 7u))));
  vec3 c = placeOf(vertexOf(op, hexPoint(op, at + ((corners >> 8) & 7u))));
  vec3 d = placeOf(vertexOf(op, hexPoint(op, at + (corners >> 12))));
  return passesSide(f, a, b, c, d, isTriangle(face & 7u, orders), t);
}

// Finds the first face of the shell behind `last` that the ray passes before `most`, and puts it in place of that. Returns whether there
// is one.
bool nextOfShell(OperatorView op, FrameRay f, vec3 o, vec3 rd, float from, float most, inout ShellPlace last) {
  uint list = geometryWord(op.shellHierarchy), nodes = op.shellHierarchy + 4u;
  float nearest = most;
  bool found = false;
  uint number = 0u;
  uint stack[STACK_ENTRIES];
  int depth = 0;
  uint child = 0u;  // a node, a leaf, or NODE_NONE, which looks like a leaf
  while (child != NODE_NONE) {
    while ((child & NODE_LEAF) == 0u) {
      uint at = nodes + NODE_WORDS * child;
      vec4 loX = geometryReals(at), loY = geometryReals(at + 4u), loZ = geometryReals(at + 8u);
      vec4 hiX = geometryReals(at + 12u), hiY = geometryReals(at + 16u), hiZ = geometryReals(at + 20u);
      uvec4 children = geometryQuad(at + 24u);
      vec4 t;
#define VISIT(k)                                                                                    \
  t.k = entryOf(vec3(loX.k, loY.k, loZ.k), vec3(hiX.k, hiY.k, hiZ.k), o, rd, from, nearest);        \
  if (children.k == NODE_NONE) t.k = infinity();                                                    \
  if (!(t.k < infinity())) children.k = NODE_NONE;
      VISIT(x)
      VISIT(y)
      VISIT(z)
      VISIT(w)
      sortByEntry(t, children);
      if (children.w != NODE_NONE) stack[depth++] = children.w;
      if (children.z != NODE_NONE) stack[depth++] = children.z;
      if (children.y != NODE_NONE) stack[depth++] = children.y;
      child = children.x;
      if (child == NODE_NONE && depth > 0) child = stack[--depth];
    }
    if (child != NODE_NONE) {
      uint first = child & NODE_FIRST, count = ((child >> NODE_COUNT_SHIFT) & 7u) + 1u;
      for (uint k = first; k < first + count; k++) {
        uint p = geometryWord(list + 2u * k + 1u), face = shellFace(op, p);
        float t;
        bool passes = OF_HEXAHEDRA ? passesHexFace(op, f, face, t) : passesTetFace(op, f, face, t);
        if (passes && beginsBehind(last, t, p, face) && (t < nearest || (t == nearest && found && p < number))) {
          nearest = t;
          number = p;
          found = true;
        }
      }
      child = depth > 0 ? stack[--depth] : NODE_NONE;
    }
  }
  last.t = nearest;
  last.number = number;
  return found;
}

void main() {
  OperatorView op = operatorOf(push[PUSH_OPERATOR]);
  readMapAhead(op.map);
  if (!hasRay()) return;
  vec3 o = rayOrigin(), d = rayDirection();
  RaySlice slice = marchSlice();
  MarchRange m = marchRange(slice);
  Radiance L = rayRadiance();
  FrameRay f = frameRay(o, d);
  MeshMarch w = startMesh(op.clips, o, d, m, L.A);
  ShellPlace last = beforeShell();
  vec3 rd = vec3(perLength(d.x), perLength(d.y), perLength(d.z));
  float most = min(min(m.tOut, w.end), NO_HIT), unit = 1.0 / sqrt(dot3(d, d));
  int samples = 0, cells = 0;
  uint walks = 0u;
  bool goes = w.goes && meetsGeometry(o);
  while (goes) {
    float from = last.t - 1e-5 * (abs(last.t) + unit);  // boxes are met within rounding
    goes = nextOfShell(op, f, o, rd, from, most, last);
    if (goes) {
      uint face = shellFace(op, last.number);
      if (OF_HEXAHEDRA)
        last.ended = walkHexahedra(op, f, m, face, w, L, samples, cells);
      else
        last.ended = walkMesh(op, f, m, face, w, L, samples, cells);
      walks++;
      goes = w.goes;
    }
  }
  if (!endSlice(slice, false)) return;
  setRadiance(L);
  countUp(COUNT_SAMPLES, uint(samples));
  countUp(COUNT_MESH_CELLS, uint(cells));
  countUp(COUNT_MESH_WALKS, walks);
}
