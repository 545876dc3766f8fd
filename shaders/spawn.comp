// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// Makes the primary rays of tiles. Rays that start in this partition go to the list that is traced next; rays
// that start in another partition of this rank go to the list of rays that leave. The tiles (x0, y0, x1, y1,
// sample of each) lie where contributions are written later.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"

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
  RAY_OF(list, i, tResume) = -1.0;                  \
  RAY_OF(list, i, tMax) = NO_HIT;                  \
  RAY_OF(list, i, A) = 0.0;                        \
  RAY_OF(list, i, r) = 0.0;                        \
  RAY_OF(list, i, g) = 0.0;                        \
  RAY_OF(list, i, b) = 0.0;                        \
  RAY_OF(list, i, packet) = tile;

int tileWord(uint i) { return int(texelFetch(tiles, int(i)).x); }

void main() {
  SceneView s = theScene;
  FrameView f = theFrame;
  uint place = rayBlock * BLOCK_RAYS + gl_LocalInvocationIndex;
  uint tile = place / TILE_RAYS, k = RECORD_WORDS * tile;
  if (tile >= uint(push[PUSH_TILES])) return;
  int x = tileWord(k) + tileColumn(int(place % TILE_RAYS)), y = tileWord(k + 1u) + tileRow(int(place % TILE_RAYS));
  int sampleIndex = tileWord(k + 4u);
  if (x >= tileWord(k + 2u) || y >= tileWord(k + 3u)) return;
  vec3 o, d;
  double tEnter;
  if (!cameraRay(f, x, y, sampleIndex, o, d, tEnter)) return;
  int next = firstPartition(s, o, d, domainExit(s, o, d));
  endStage();
  if (next < 0) return;
  if (next == push[PUSH_PARTITION]) {
    uint i = takePlace(COUNT_SPAWNED);
    SET_PRIMARY(rays)
    RAY_OF(rays, i, step) = 0;
  } else if (LEAVES && tableWord(uint(push[PUSH_MINE] + next)) != 0u) {
    uint i = takePlace(COUNT_LEAVING);
    if (staysHere(next)) {
      SET_PRIMARY(stayingRays)
      RAY_OF(leavingRays, i, info) = uint(sampleIndex);
      RAY_OF(leavingRays, i, packet) = tile;
    } else {
      SET_PRIMARY(leavingRays)
    }
    RAY_OF(leavingRays, i, next) = next;
  }
}
