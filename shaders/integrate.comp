// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Emission and absorption through the only volume that a scene renders.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"

void main() {
  OperatorView op = operatorOf(push[PUSH_OPERATOR]);
  VolumeView v = fieldOf(push[PUSH_OPERATOR]);
  readMapAhead(op.map);
  if (!hasRay()) return;
  SceneView s = theScene;
  vec3 o = rayOrigin(), d = rayDirection();
  RaySlice slice = marchSlice();
  MarchRange m = marchRange(slice);
  if (!(slice.to < slice.end)) m.tOwnershipEnd = LEAVES ? nextBegin(s, o, d, m.tOut, GIVEN(tEnd)) : NO_HIT;
  MarchCount count = nothingMarched();
  Radiance L = rayRadiance();
  float begun = GIVEN(tResume);
  integrateVolume(op.map, v, clippedRay(op.clips, v, o, d), m, begun, L, count);
  if (!endSlice(slice, false)) return;
  RAY(tResume) = begun;
  setRadiance(L);
  countUp(COUNT_SAMPLES, uint(count.samples));
  countUp(COUNT_MACROCELLS, uint(count.macrocells));
  countUp(COUNT_SKIPPED, uint(count.skipped));
  if (BY_CELLS) countUp(COUNT_SEGMENTS_SKIPPED, uint(count.segmentsSkipped));
}
