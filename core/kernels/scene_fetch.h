// SPDX-License-Identifier: Apache-2.0
// How C++ and ISPC read the structures of scene_view.h. GLSL reads them in shaders/scene_fetch.glsl.

#if defined(ISPC)
#define SCENE const uniform SceneView&
#define FRAME const uniform FrameView&
#define OPERATOR const uniform OperatorView&
#define VOLUMES const uniform int* uniform
#define PLACE(i) ((int64)(i))
#else
#define SCENE const SceneView&
#define FRAME const FrameView&
#define OPERATOR const OperatorView&
#define VOLUMES const int*
#define PLACE(i) std::int64_t(i)
#endif
#define OPERATOR_AT(s, list, k) (s).operator_[(list)[k]]
#define VOLUME_AT(s, list, k) (s).field[(list)[k]]
// Face i of an axis of the lattice.
FN real latticeFace(SCENE s, UNIFORM int axis, int i) {
  if (axis == 0) return s.facesX[i];
  if (axis == 1) return s.facesY[i];
  return s.facesZ[i];
}
FN int partitionOf(SCENE s, int cell) { return s.cellPartition[cell]; }
FN bool isVisible(SCENE s, int partition) { return s.visible[partition] != 0; }
FN UNIFORM real lightValue(FRAME f, UNIFORM int i) { return f.light[i]; }

FN UNIFORM bool hasNormals(OPERATOR op) { return op.normals != NULL; }
FN UNIFORM bool hasValues(OPERATOR op) { return op.values != NULL; }
FN UNIFORM bool hasColors(OPERATOR op) { return op.colors != NULL; }
FN UNIFORM bool hasNeighbours(OPERATOR op) { return op.neighbours != NULL; }
FN vec3 pointOf(OPERATOR op, uint i) {
  return make_v3(op.points[4 * PLACE(i)], op.points[4 * PLACE(i) + 1], op.points[4 * PLACE(i) + 2]);
}
FN real radiusOf(OPERATOR op, uint i) { return op.points[4 * PLACE(i) + 3]; }
FN vec3 normalOf(OPERATOR op, uint i) {
  return make_v3(op.normals[3 * PLACE(i)], op.normals[3 * PLACE(i) + 1], op.normals[3 * PLACE(i) + 2]);
}
FN real valueOf(OPERATOR op, uint i) { return op.values[i]; }
FN vec3 ownColorOf(OPERATOR op, uint i) {
  return make_v3(op.colors[3 * PLACE(i)], op.colors[3 * PLACE(i) + 1], op.colors[3 * PLACE(i) + 2]);
}
FN uint cornerOf(OPERATOR op, uint i) { return op.indices[i]; }
FN uint neighbourOf(OPERATOR op, uint i) { return op.neighbours[i]; }
#if defined(ISPC)
#define MESH_AT(op, array, i) ((op).wide != 0 ? (op).array[PLACE(i)] : (op).array[(int)(i)])
#else
#define MESH_AT(op, array, i) (op).array[PLACE(i)]
#endif
#if !defined(ISPC)
FN vec4 vertexOf(OPERATOR op, uint i) {
  uint k = 4 * i;
  return make_v4(MESH_AT(op, points, k), MESH_AT(op, points, k + 1), MESH_AT(op, points, k + 2),
                 MESH_AT(op, points, k + 3));
}
FN HexPoints hexPoints(OPERATOR op, uint i) {
  uint k = 8 * i;
  return {MESH_AT(op, indices, k),     MESH_AT(op, indices, k + 1), MESH_AT(op, indices, k + 2),
          MESH_AT(op, indices, k + 3), MESH_AT(op, indices, k + 4), MESH_AT(op, indices, k + 5),
          MESH_AT(op, indices, k + 6), MESH_AT(op, indices, k + 7)};
}
#else
FN vec4 vertexOf(OPERATOR op, uint i) {
  Record r = recordAt(op.points, 4, i);
  return make_v4(r.x, r.y, r.z, r.w);
}
FN HexPoints hexPoints(OPERATOR op, uint i) {
  const uniform float* uniform points = (const uniform float* uniform)op.indices;
  Record a = recordAt(points, 8, i), b = recordAt(points + 4, 8, i);
  HexPoints p;
  p.p0 = intbits(a.x), p.p1 = intbits(a.y), p.p2 = intbits(a.z), p.p3 = intbits(a.w);
  p.p4 = intbits(b.x), p.p5 = intbits(b.y), p.p6 = intbits(b.z), p.p7 = intbits(b.w);
  return p;
}
#endif
FN uint cellCorner(OPERATOR op, uint i) { return MESH_AT(op, indices, i); }
FN uint cellNeighbour(OPERATOR op, uint i) { return MESH_AT(op, neighbours, i); }
FN real cellValue(OPERATOR op, uint i) { return MESH_AT(op, values, i); }
FN uint hexPoint(OPERATOR op, uint i) { return MESH_AT(op, indices, i); }
FN uint hexNeighbour(OPERATOR op, uint i) { return MESH_AT(op, neighbours, i); }
FN uint hexOrders(OPERATOR op, uint i) { return MESH_AT(op, orders, i); }
FN uint shellFace(OPERATOR op, uint i) { return MESH_AT(op, shell, i); }
FN UNIFORM bool leavesOutBricks(OPERATOR op) { return op.unseen != NULL; }
FN uint unseenWord(OPERATOR op, uint i) { return MESH_AT(op, unseen, i); }
FN vec4 levelCorner(OPERATOR op, uint p, int k) {
  return make_v4(op.levelCorners[16 * PLACE(p) + 4 * k], op.levelCorners[16 * PLACE(p) + 4 * k + 1],
                 op.levelCorners[16 * PLACE(p) + 4 * k + 2], op.levelCorners[16 * PLACE(p) + 4 * k + 3]);
}
FN vec4 levelValues(OPERATOR op, uint p) {
  return make_v4(op.levelValues[4 * PLACE(p)], op.levelValues[4 * PLACE(p) + 1],
                 op.levelValues[4 * PLACE(p) + 2], op.levelValues[4 * PLACE(p) + 3]);
}
FN vec4 hexLevel(OPERATOR op, uint p, int k) {
  return make_v4(op.levelCorners[32 * PLACE(p) + 4 * k], op.levelCorners[32 * PLACE(p) + 4 * k + 1],
                 op.levelCorners[32 * PLACE(p) + 4 * k + 2], op.levelCorners[32 * PLACE(p) + 4 * k + 3]);
}
FN real hexValue(OPERATOR op, uint p, int k) { return op.levelValues[8 * PLACE(p) + k]; }
FN uint levelOrders(OPERATOR op, uint p) { return op.levelOrders[p]; }
FN uint surfaceOf(OPERATOR op, uint p) { return op.surfaces[p]; }
FN UNIFORM bool hasGradients(OPERATOR op) { return op.levelPoints != NULL; }
FN uint levelPoint(OPERATOR op, uint i) { return op.levelPoints[PLACE(i)]; }
FN vec3 levelGradient(OPERATOR op, uint i) {
  return make_v3(op.levelGradients[3 * PLACE(i)], op.levelGradients[3 * PLACE(i) + 1],
                 op.levelGradients[3 * PLACE(i) + 2]);
}
#undef MESH_AT
FN vec3 sliceNormal(OPERATOR op, uint i) {
  return make_v3(op.slice[4 * i], op.slice[4 * i + 1], op.slice[4 * i + 2]);
}
FN real isovalueOf(VOLUME v, uint i) { return v.isovalue[i]; }
FN UNIFORM bool holdsSamples(VOLUME v) { return v.samples != NULL; }
#undef PLACE
