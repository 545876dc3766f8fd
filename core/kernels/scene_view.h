// SPDX-License-Identifier: Apache-2.0
// What kernels see of a scene and a frame: the structures that a backend's host side fills, and, as for volumes
// (volume_view.h), how ISPC fetches from them. In GLSL see shaders/fetch_scene.glsl.

#define KIND_VOLUME 0
#define KIND_PARTICLES 1
#define KIND_PATHLINES 2
#define KIND_TRIANGLES 3

struct OperatorView {
  int kind;
  int rendered;  // a volume that is volume rendered
  real opacity;  // of its surfaces
  int twoSided;
  int slices;
  PTR(real) slice;  // 4 per plane: n . p = offset
  uint primitives;
  PTR(real) points;      // x y z radius
  PTR(real) normals;     // x y z per point, or null
  PTR(real) values;      // per point, or null
  PTR(uint) indices;     // 2 or 3 per primitive
  PTR(uint) neighbours;  // of segments: the points before and after, own ends where there is none
};

#define LIGHT_DIRECTIONAL 0
#define LIGHT_POINT 1

struct SceneView {
  // the partition: t in [tIn, tOut) between these faces is its own
  real boxLoX, boxLoY, boxLoZ, boxHiX, boxHiY, boxHiZ;
  real domainLoX, domainLoY, domainLoZ, domainHiX, domainHiY, domainHiZ;
  // the lattice of all partitions
  int cellsX, cellsY, cellsZ;
  PTR(real) facesX;
  PTR(real) facesY;
  PTR(real) facesZ;
  PTR(int) cellPartition;
  PTR(BYTE) visible;

  int operators;
  PTR(OperatorView) operator_;
  PTR(VolumeView) field;  // one per operator; geometry uses its map only
  RAW hierarchy;          // over this partition's geometry, in the backend's own form; null if there is none
  int opaqueSurfaces;
  real tMin;

  real ambient, diffuse, specular, shininess;  // diffuse and specular: per light
  int shadows, occlusionRays;
  real occlusionRadius;
};

struct FrameView {
  double eyeX, eyeY, eyeZ, cornerX, cornerY, cornerZ, duX, duY, duZ, dvX, dvY, dvZ, viewX, viewY, viewZ;
  double loX, loY, loZ, hiX, hiY, hiZ;  // the visible domain
  int orthographic;
  int width, height;
  uint frame;  // continues the ambient-occlusion sequence
  int lights;
  PTR(real) light;  // 4 per light: type, direction of travel or position
};

#if !defined(GXY_LAYOUT)
#if defined(GXY_GLSL)
#define SCENE SceneView
#define FRAME FrameView
#define OPERATOR OperatorView
#include "fetch_scene.glsl"
#elif defined(ISPC)
#define SCENE const uniform SceneView&
#define FRAME const uniform FrameView&
#define OPERATOR const uniform OperatorView&
// Face i of an axis of the lattice.
FN real latticeFace(SCENE s, uniform int axis, int i) {
  if (axis == 0) return s.facesX[i];
  if (axis == 1) return s.facesY[i];
  return s.facesZ[i];
}
FN int partitionOf(SCENE s, int cell) { return s.cellPartition[cell]; }
FN bool isVisible(SCENE s, int partition) { return s.visible[partition] != 0; }
static inline uniform float lightValue(FRAME f, uniform int i) { return f.light[i]; }

FN UNIFORM bool hasNormals(OPERATOR op) { return op.normals != NULL; }
FN UNIFORM bool hasValues(OPERATOR op) { return op.values != NULL; }
FN UNIFORM bool hasNeighbours(OPERATOR op) { return op.neighbours != NULL; }
FN vec3 pointOf(OPERATOR op, uint i) {
  int64 k = 4 * (int64)i;
  return make_v3(op.points[k], op.points[k + 1], op.points[k + 2]);
}
FN real radiusOf(OPERATOR op, uint i) { return op.points[4 * (int64)i + 3]; }
FN vec3 normalOf(OPERATOR op, uint i) {
  int64 k = 3 * (int64)i;
  return make_v3(op.normals[k], op.normals[k + 1], op.normals[k + 2]);
}
FN real valueOf(OPERATOR op, uint i) { return op.values[i]; }
FN uint cornerOf(OPERATOR op, uint i) { return op.indices[i]; }
FN uint neighbourOf(OPERATOR op, uint i) { return op.neighbours[i]; }
FN vec3 sliceNormal(OPERATOR op, uint i) {
  return make_v3(op.slice[4 * i], op.slice[4 * i + 1], op.slice[4 * i + 2]);
}
FN real isovalueOf(VOLUME v, uint i) { return v.isovalue[i]; }
#define VOLUMES const uniform int* uniform
#define VOLUME_AT(s, list, k) (s).field[(list)[k]]
FN UNIFORM bool holdsSamples(VOLUME v) { return v.samples != NULL; }
#endif
#endif
