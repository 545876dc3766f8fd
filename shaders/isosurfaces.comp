// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Finds each ray's nearest hit with the isosurfaces of one operator. With ANY_HIT, rays that meet one just become opaque.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"

void main() {
  if (!hasRay()) return;
  int op = push[PUSH_OPERATOR];
  ClipView clips = operatorOf(op).clips;
  VolumeView v = fieldOf(op);
  IsoStart start;
  start.index = -1;
  start.from = 0;
  if ((SURFACES & SURFACE_STARTS) != 0 && RAY_START(GIVEN(info)) == START_ISOSURFACE && int(GIVEN(start) >> 16) == op) {
    start.index = int(GIVEN(start) & 0xffffu);
    start.from = RAY_SIDE(GIVEN(info)) != 0 ? 1 : -1;
  }
  int cells = 0, skipped = 0;
  RaySlice slice = marchSlice();
  NearestHit nearest = givenHit();
  // A blocked ray has nothing to find.
  bool blocked = GIVEN(A) >= 1.0 || (ANY_HIT && nearest.t < NO_HIT);
  float tLast = behindLast(lastHit(), op, ISOSURFACES);
  IsoHit hit = hitIsosurface(clips, v, rayOrigin(), rayDirection(), slice.from, blocked ? -1.0 : slice.to, tLast, nearest.t, start,
                             ANY_HIT, cells, skipped);
  if (!endSlice(slice, blocked || hit.t < NO_HIT)) return;
  if (hit.t < NO_HIT) {
    if (ANY_HIT)
      RAY(A) = 1.0;
    else
      takeHit(nearest, hit.t, HIT_ISOSURFACE, op, uint(hit.index));
  }
  countUp(COUNT_CELLS, uint(cells));
  countUp(COUNT_ISO_SKIPPED, uint(skipped));
}
