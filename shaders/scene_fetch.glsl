// SPDX-License-Identifier: Apache-2.0
// How GLSL reads a SceneView, a FrameView and an OperatorView (core/kernels/scene_view.h).

#define SCENE SceneView
#define FRAME FrameView
#define OPERATOR OperatorView

layout(std430, set = SCENE_SET, binding = SCENE_BINDING) readonly buffer SceneBuffer {
  SceneView sceneBuffer;
};
layout(std430, set = SCENE_SET, binding = OPERATORS_BINDING) readonly buffer OperatorBuffer { OperatorView operators[]; };
layout(std430, set = SCENE_SET, binding = FIELDS_BINDING) readonly buffer FieldBuffer { VolumeView fields[]; };
layout(std430, set = FRAME_SET, binding = FRAME_BINDING) readonly buffer FrameBuffer {
  FrameView theFrame;
  float lightValues[];
};

// What all invocations read alike is read here and in main() before any of them returns. Mesa's software
// device then reads each word once, otherwise once for each invocation. Parts that a stage does not use are
// not read.
SceneView theScene = sceneBuffer;
#define READ_OPERATOR(k)                   \
  OperatorView operator##k = operators[k]; \
  VolumeView field##k = fields[k];
READ_OPERATOR(0)
READ_OPERATOR(1)
READ_OPERATOR(2)
READ_OPERATOR(3)

// Operator `op` of the scene, and its field.
OperatorView operatorOf(int op) {
  OperatorView view = operator0;
  if (OPERATORS == 0) view = operators[op];
  if (OPERATORS == FEW_OPERATORS && op == 1) view = operator1;
  if (OPERATORS == FEW_OPERATORS && op == 2) view = operator2;
  if (OPERATORS == FEW_OPERATORS && op == 3) view = operator3;
  return view;
}
VolumeView fieldOf(int op) {
  VolumeView view = field0;
  if (OPERATORS == 0) view = fields[op];
  if (OPERATORS == FEW_OPERATORS && op == 1) view = field1;
  if (OPERATORS == FEW_OPERATORS && op == 2) view = field2;
  if (OPERATORS == FEW_OPERATORS && op == 3) view = field3;
  return view;
}

#define VOLUMES uint
#define OPERATOR_AT(s, list, k) operatorOf(int(tableWord((list) + uint(k))))
#define VOLUME_AT(s, list, k) fieldOf(int(tableWord((list) + uint(k))))

real lightValue(FRAME f, int i) { return lightValues[i]; }

real latticeFace(SCENE s, int axis, int i) {
  uint faces = axis == 0 ? s.facesX : (axis == 1 ? s.facesY : s.facesZ);
  return tableReal(faces + uint(i));
}
int partitionOf(SCENE s, int cell) { return int(tableWord(s.cellPartition + uint(cell))); }
bool isVisible(SCENE s, int number) { return tableWord(s.visible + uint(number)) != 0u; }

bool hasNormals(OPERATOR op) { return op.normals != 0u; }
bool hasValues(OPERATOR op) { return op.values != 0u; }
bool hasColors(OPERATOR op) { return op.colors != 0u; }
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
vec3 ownColorOf(OPERATOR op, uint i) {
  uint k = op.colors + 3u * i;
  return vec3(geometryReal(k), geometryReal(k + 1u), geometryReal(k + 2u));
}
uint cornerOf(OPERATOR op, uint i) { return geometryWord(op.indices + i); }
uint neighbourOf(OPERATOR op, uint i) { return geometryWord(op.neighbours + i); }
// The offsets of a mesh's arrays are multiples of 4.
vec4 vertexOf(OPERATOR op, uint i) { return uintBitsToFloat(geometryQuad(op.points + 4u * i)); }
uint cellCorner(OPERATOR op, uint i) { return geometryWord(op.indices + i); }
uint cellNeighbour(OPERATOR op, uint i) { return geometryWord(op.neighbours + i); }
real cellValue(OPERATOR op, uint i) { return geometryReal(op.values + i); }
HexPoints hexPoints(OPERATOR op, uint i) {
  uvec4 a = geometryQuad(op.indices + 8u * i), b = geometryQuad(op.indices + 8u * i + 4u);
  return HexPoints(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w);
}
bool leavesOutBricks(OPERATOR op) { return op.unseen != 0u; }
uint unseenWord(OPERATOR op, uint i) { return geometryWord(op.unseen + i); }
uint hexPoint(OPERATOR op, uint i) { return geometryWord(op.indices + i); }
uint hexNeighbour(OPERATOR op, uint i) { return geometryWord(op.neighbours + i); }
uint hexOrders(OPERATOR op, uint i) { return geometryWord(op.orders + i); }
uint shellFace(OPERATOR op, uint i) { return geometryWord(op.shell + i); }
vec4 levelCorner(OPERATOR op, uint p, int k) { return uintBitsToFloat(geometryQuad(op.levelCorners + 16u * p + 4u * uint(k))); }
vec4 levelValues(OPERATOR op, uint p) { return uintBitsToFloat(geometryQuad(op.levelValues + 4u * p)); }
vec4 hexLevel(OPERATOR op, uint p, int k) { return uintBitsToFloat(geometryQuad(op.levelCorners + 32u * p + 4u * uint(k))); }
float hexValue(OPERATOR op, uint p, int k) { return geometryReal(op.levelValues + 8u * p + uint(k)); }
uint levelOrders(OPERATOR op, uint p) { return geometryWord(op.levelOrders + p); }
uint surfaceOf(OPERATOR op, uint p) { return geometryWord(op.surfaces + p); }
bool hasGradients(OPERATOR op) { return op.levelPoints != 0u; }
uint levelPoint(OPERATOR op, uint i) { return geometryWord(op.levelPoints + i); }
vec3 levelGradient(OPERATOR op, uint i) {
  uint k = op.levelGradients + 3u * i;
  return vec3(geometryReal(k), geometryReal(k + 1u), geometryReal(k + 2u));
}
vec3 sliceNormal(OPERATOR op, uint i) {
  uint k = op.slice + 4u * i;
  return vec3(tableReal(k), tableReal(k + 1u), tableReal(k + 2u));
}
real isovalueOf(VOLUME v, uint i) { return tableReal(v.isovalue + i); }
