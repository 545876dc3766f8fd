// SPDX-License-Identifier: Apache-2.0
// How GLSL reads a SceneView, a FrameView and an OperatorView (core/kernels/scene_view.h).

layout(std430, set = SCENE_SET, binding = SCENE_BINDING) readonly buffer SceneBuffer {
  SceneView theScene;
};
layout(std430, set = SCENE_SET, binding = OPERATORS_BINDING) readonly buffer OperatorBuffer { OperatorView operators[]; };
layout(std430, set = SCENE_SET, binding = FIELDS_BINDING) readonly buffer FieldBuffer { VolumeView fields[]; };
layout(std430, set = FRAME_SET, binding = FRAME_BINDING) readonly buffer FrameBuffer {
  FrameView theFrame;
  float lightValues[];
};

#define VOLUMES uint
#define VOLUME_AT(s, list, k) fields[tableWord((list) + uint(k))]

real lightValue(FRAME f, int i) { return lightValues[i]; }

real latticeFace(SCENE s, int axis, int i) {
  uint faces = axis == 0 ? s.facesX : (axis == 1 ? s.facesY : s.facesZ);
  return tableReal(faces + uint(i));
}
int partitionOf(SCENE s, int cell) { return int(tableWord(s.cellPartition + uint(cell))); }
bool isVisible(SCENE s, int number) { return tableWord(s.visible + uint(number)) != 0u; }

bool hasNormals(OPERATOR op) { return op.normals != 0u; }
bool hasValues(OPERATOR op) { return op.values != 0u; }
bool hasNeighbours(OPERATOR op) { return op.neighbours != 0u; }
vec3 pointOf(OPERATOR op, uint i) {
  return uintBitsToFloat(geometryQuad(op.points + 4u * i).xyz);
}
real radiusOf(OPERATOR op, uint i) { return uintBitsToFloat(geometryQuad(op.points + 4u * i).w); }
vec3 normalOf(OPERATOR op, uint i) {
  uint k = op.normals + 3u * i;
  return vec3(geometryReal(k), geometryReal(k + 1u), geometryReal(k + 2u));
}
real valueOf(OPERATOR op, uint i) { return geometryReal(op.values + i); }
uint cornerOf(OPERATOR op, uint i) { return geometryWord(op.indices + i); }
uint neighbourOf(OPERATOR op, uint i) { return geometryWord(op.neighbours + i); }
vec3 sliceNormal(OPERATOR op, uint i) {
  uint k = op.slice + 4u * i;
  return vec3(tableReal(k), tableReal(k + 1u), tableReal(k + 2u));
}
real isovalueOf(VOLUME v, uint i) { return tableReal(v.isovalue + i); }
