// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Emission and absorption through several volumes at once.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"

void main() {
  if (!hasRay()) return;
  SceneView s = theScene;
  RaySlice slice = marchSlice();
  MarchCount count = nothingMarched();
  Radiance L = rayRadiance();
  integrateVolumes(s, uint(push[PUSH_OPERATOR]), push[PUSH_COUNT], rayOrigin(), rayDirection(), marchRange(slice),
                L, count);
  if (!endSlice(slice, false)) return;
  setRadiance(L);
  countUp(COUNT_SAMPLES, uint(count.samples));
  countUp(COUNT_MACROCELLS, uint(count.macrocells));
  countUp(COUNT_SKIPPED, uint(count.skipped));
}
