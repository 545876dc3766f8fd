// SPDX-License-Identifier: Apache-2.0
// core/kernels/scene.h in C++ float, which nothing but the test of the dialects needs, and sceneProbe.
#pragma once
#include "gxy/kernels/single_views.h"
#include "gxy/rays/ray_fields.h"

#define R(x) real(x)
#define FN inline
#define FN_OUTLINE inline
#define INOUT(T) T&
#define OUT(T) T&
#define UNIFORM
#define NO_HIT R(1e30)
#define VOLUME const VolumeView&
#define SCENE const SceneView&
#define FRAME const FrameView&
#define OPERATOR const OperatorView&
#define VOLUMES const int*
#define VOLUME_AT(s, list, k) (s).field[(list)[k]]
namespace gxy::single {
FN real latticeFace(SCENE s, int axis, int i) {
  return axis == 0 ? s.facesX[i] : axis == 1 ? s.facesY[i] : s.facesZ[i];
}
FN int partitionOf(SCENE s, int cell) { return s.cellPartition[cell]; }
FN bool isVisible(SCENE s, int partition) { return s.visible[partition] != 0; }
FN real lightValue(FRAME f, int i) { return f.light[i]; }
FN bool hasNormals(OPERATOR op) { return op.normals != nullptr; }
FN bool hasValues(OPERATOR op) { return op.values != nullptr; }
FN bool hasNeighbours(OPERATOR op) { return op.neighbours != nullptr; }
FN vec3 pointOf(OPERATOR op, uint i) {
  return vec3(op.points[4 * i], op.points[4 * i + 1], op.points[4 * i + 2]);
}
FN real radiusOf(OPERATOR op, uint i) { return op.points[4 * i + 3]; }
FN vec3 normalOf(OPERATOR op, uint i) {
  return vec3(op.normals[3 * i], op.normals[3 * i + 1], op.normals[3 * i + 2]);
}
FN real valueOf(OPERATOR op, uint i) { return op.values[i]; }
FN uint cornerOf(OPERATOR op, uint i) { return op.indices[i]; }
FN uint neighbourOf(OPERATOR op, uint i) { return op.neighbours[i]; }
FN vec3 sliceNormal(OPERATOR op, uint i) {
  return vec3(op.slice[4 * i], op.slice[4 * i + 1], op.slice[4 * i + 2]);
}
FN real isovalueOf(VOLUME v, uint i) { return v.isovalue[i]; }
FN bool holdsSamples(VOLUME v) { return v.samples != nullptr; }
// clang-format off
#include "gxy/kernels/clip.h"
#include "gxy/kernels/cuts.h"
#include "gxy/kernels/many.h"
#include "gxy/kernels/camera.h"
#include "gxy/kernels/lattice.h"
#include "gxy/kernels/primitives.h"
#include "gxy/kernels/surface.h"
#include "gxy/kernels/shares.h"
#include "scene_probe.h"
// clang-format on
}  // namespace gxy::single
#undef R
#undef FN
#undef FN_OUTLINE
#undef INOUT
#undef OUT
#undef UNIFORM
#undef NO_HIT
#undef VOLUME
#undef SCENE
#undef FRAME
#undef OPERATOR
#undef VOLUMES
#undef VOLUME_AT
