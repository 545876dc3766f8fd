// SPDX-License-Identifier: Apache-2.0
// From camera to rays (in double, then rebased to float where rays enter the visible domain), and from
// partition to partition.
#include "backends/embree/kernel.isph"
#include "core/kernels/export.h"

// Makes the rays of pixels [x0, x1) x [y0, y1) (at most 32 x 32) and one sample that meet a visible
// partition, with the first such partition in `next`. Rays are made in 4 x 4 blocks of pixels for coherence.
// Returns their number.
EXPORT uniform int spawnRays(const void* uniform scene, const void* uniform frame, uniform int x0, uniform int y0,
                             uniform int x1, uniform int y1, uniform int sample, void* uniform rays) {
  USE_SCENE(s, scene);
  USE_FRAME(f, frame);
  USE_RAYS(r, rays);
  uniform int n = 0;
  foreach (i = 0 ... 1024) {
    int x = x0 + tileColumn(i), y = y0 + tileRow(i);
    if (x < x1 && y < y1) {
      vec3 o, d;
      double tEnter;
      if (cameraRay(f, x, y, sample, o, d, tEnter)) {
        float tEnd = domainExit(s, o, d);
        int next = firstPartition(s, o, d, tEnd);
        if (next >= 0) {
          packed_store_active(r.pixel + n, (uint32)(y * f.width + x));
          packed_store_active(r.info + n, (uint32)sample);
          packed_store_active((uniform int* uniform)(r.ox + n), intbits(o.x));
          packed_store_active((uniform int* uniform)(r.oy + n), intbits(o.y));
          packed_store_active((uniform int* uniform)(r.oz + n), intbits(o.z));
          packed_store_active((uniform int* uniform)(r.dx + n), intbits(d.x));
          packed_store_active((uniform int* uniform)(r.dy + n), intbits(d.y));
          packed_store_active((uniform int* uniform)(r.dz + n), intbits(d.z));
          packed_store_active((uniform int* uniform)(r.tEnd + n), intbits(tEnd));
          n += packed_store_active(r.next + n, next);
        }
      }
    }
  }
  foreach (i = 0 ... n) {
    r.tLast[i] = -1.0f;
    r.tResume[i] = -1.0f;
    r.tMax[i] = NO_HIT;
    r.A[i] = 0.0f;
    r.r[i] = 0.0f;
    r.g[i] = 0.0f;
    r.b[i] = 0.0f;
  }
  return n;
}

// Regenerates origin and direction of primaries that came over the wire.
EXPORT void regenerateRays(const void* uniform frame, void* uniform rays, uniform int n) {
  USE_FRAME(f, frame);
  USE_RAYS(r, rays);
  foreach (i = 0 ... n) {
    vec3 o, d;
    double tEnter;
    cameraRay(f, r.pixel[i] % f.width, r.pixel[i] / f.width, RAY_SAMPLE_NUMBER(r.info[i]), o, d, tEnter);
    r.ox[i] = o.x; r.oy[i] = o.y; r.oz[i] = o.z;
    r.dx[i] = d.x; r.dy[i] = d.y; r.dz[i] = d.z;
    r.tMax[i] = NO_HIT;
  }
}

// Computes the distance (render space) from the eye to the hits of primaries.
EXPORT void eyeDistances(const void* uniform frame, void* uniform rays, const uniform int which[], uniform int n,
                         uniform double distance[]) {
  USE_FRAME(f, frame);
  USE_RAYS(r, rays);
  foreach (k = 0 ... n) {
    int i = which[k];
    vec3 o, d;
    double tEnter;
    cameraRay(f, r.pixel[i] % f.width, r.pixel[i] / f.width, RAY_SAMPLE_NUMBER(r.info[i]), o, d, tEnter);
    distance[k] = tEnter + (double)r.tHit[i];
  }
}

// Computes where each ray enters and leaves this partition, and sets its hit to none.
EXPORT void boundRays(const void* uniform scene, void* uniform rays, uniform int n) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  foreach (i = 0 ... n) {
    vec3 o = originOf(r, i), d = directionOf(r, i);
    float tIn, tOut;
    partitionSpan(s, o, d, tIn, tOut);
    r.tIn[i] = tIn;
    r.tOut[i] = tOut;
    r.tEnd[i] = min(domainExit(s, o, d), r.tMax[i]);
    r.tHit[i] = NO_HIT;
    r.hitKind[i] = HIT_NONE;
    r.next[i] = END_ACTIVE;
  }
}

// Finds where each ray that ended on no surface goes next. `start` is for secondary rays that begin, at t =
// 0.
EXPORT void routeRays(const void* uniform scene, void* uniform rays, uniform int n, uniform bool start) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  foreach (i = 0 ... n) {
    vec3 o = originOf(r, i), d = directionOf(r, i);
    if (start) {
      r.r[i] = 0.0f;  // secondaries gather no radiance
      r.g[i] = 0.0f;
      r.b[i] = 0.0f;
      r.next[i] = firstPartition(s, o, d, min(domainExit(s, o, d), r.tMax[i]));
    } else if (r.hitKind[i] != HIT_NONE) {
      r.next[i] = END_SURFACE;
    } else if (1.0f - r.A[i] < s.tMin || r.tOut[i] >= r.tEnd[i]) {
      r.next[i] = END_DONE;
    } else {
      float t = r.tOut[i];
      r.next[i] = nextPartition(s, o, d, t, r.tEnd[i]);
    }
  }
}

// The number of rays in a gang of the instruction set in use.
EXPORT uniform int gangWidth() { return programCount; }
