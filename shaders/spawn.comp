// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// The primary rays of a tile: to the list that is traced next where they start in this partition, else, where they start in
// another of this rank, to that of rays that leave.
#include "kernels.glsl"
#include "rays.glsl"

#define SET_PRIMARY(list)                          \
  RAY_OF(list, i, pixel) = uint(y * f.width + x);  \
  RAY_OF(list, i, info) = uint(sampleIndex);       \
  RAY_OF(list, i, start) = 0u;                     \
  RAY_OF(list, i, ox) = o.x;                       \
  RAY_OF(list, i, oy) = o.y;                       \
  RAY_OF(list, i, oz) = o.z;                       \
  RAY_OF(list, i, dx) = d.x;                       \
  RAY_OF(list, i, dy) = d.y;                       \
  RAY_OF(list, i, dz) = d.z;                       \
  RAY_OF(list, i, tLast) = -1.0;                   \
  RAY_OF(list, i, tBegun) = -1.0;                  \
  RAY_OF(list, i, tMax) = NO_HIT;                  \
  RAY_OF(list, i, A) = 0.0;                        \
  RAY_OF(list, i, r) = 0.0;                        \
  RAY_OF(list, i, g) = 0.0;                        \
  RAY_OF(list, i, b) = 0.0;                        \
  RAY_OF(list, i, packet) = uint(push[PUSH_PACKET]); \
  RAY_OF(list, i, next) = next;

void main() {
  int at = int(gl_GlobalInvocationID.x);
  int x = push[PUSH_TILE] + tileColumn(at), y = push[PUSH_TILE + 1] + tileRow(at), sampleIndex = push[PUSH_TILE + 4];
  if (x >= push[PUSH_TILE + 2] || y >= push[PUSH_TILE + 3]) return;
  SceneView s = theScene;
  FrameView f = theFrame;
  vec3 o, d;
  double tEnter;
  if (!cameraRay(f, x, y, sampleIndex, o, d, tEnter)) return;
  int next = firstPartition(s, o, d, domainExit(s, o, d));
  if (next < 0) return;
  if (next == push[PUSH_PARTITION]) {
    uint i = atomicAdd(counts[COUNT_SPAWNED], 1u);
    SET_PRIMARY(rays)
    RAY_OF(rays, i, step) = 0;
  } else if (tableWord(uint(push[PUSH_MINE] + next)) != 0u) {
    uint i = atomicAdd(counts[COUNT_LEAVING], 1u);
    SET_PRIMARY(leavingRays)
  }
}
