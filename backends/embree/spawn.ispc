// SPDX-License-Identifier: Apache-2.0
// From camera to rays (in double, re-based to float where they enter the visible domain), and from partition to
// partition.
#include "kernel.isph"

static inline float domainExit(SCENE s, vec3 o, vec3 d) {
  float t0, t1;
  boxSpan(make_v3(s.domainLoX, s.domainLoY, s.domainLoZ), make_v3(s.domainHiX, s.domainHiY, s.domainHiZ), o, d, 0.0f,
          1e30f, t0, t1);
  return t1;
}

static inline void slab(double o, double d, uniform double lo, uniform double hi, double& t0, double& t1) {
  if (d == 0.0d) {
    if (o < lo || o > hi) t1 = -1.0d;
  } else {
    double a = (lo - o) / d, b = (hi - o) / d;
    t0 = max(t0, min(a, b));
    t1 = min(t1, max(a, b));
  }
}

// The ray of a pixel and sample: false if it misses the visible domain. tEnter: from the eye, in render space.
static inline bool cameraRay(const uniform FrameView& f, int x, int y, int sample, vec3& o, vec3& d, double& tEnter) {
  // sub-pixel positions: the centre, then the R2 sequence around it
  double sx = 0.5d, sy = 0.5d;
  if (sample > 0) {
    sx = 0.5d + sample * 0.7548776662466927d;
    sy = 0.5d + sample * 0.5698402909980532d;
    sx = sx - floor(sx);
    sy = sy - floor(sy);
  }
  double u = x + sx, v = y + sy;
  double px = (f.cornerX + u * f.duX) + v * f.dvX;
  double py = (f.cornerY + u * f.duY) + v * f.dvY;
  double pz = (f.cornerZ + u * f.duZ) + v * f.dvZ;
  double ex = f.eyeX, ey = f.eyeY, ez = f.eyeZ, gx = px, gy = py, gz = pz;
  if (f.orthographic) {
    ex = px; ey = py; ez = pz;
    gx = f.viewX; gy = f.viewY; gz = f.viewZ;
  }
  double length = sqrt((gx * gx + gy * gy) + gz * gz);
  gx /= length;
  gy /= length;
  gz /= length;
  double t0 = 0.0d, t1 = 1e300d;
  slab(ex, gx, f.loX, f.hiX, t0, t1);
  slab(ey, gy, f.loY, f.hiY, t0, t1);
  slab(ez, gz, f.loZ, f.hiZ, t0, t1);
  tEnter = t0;
  o = make_v3((float)(ex + t0 * gx), (float)(ey + t0 * gy), (float)(ez + t0 * gz));
  d = make_v3((float)gx, (float)gy, (float)gz);
  return t0 < t1;
}

// The rays of pixels [x0, x1) x [y0, y1) (at most 32 x 32) and one sample that meet a visible partition, with the first
// such partition in `next`; in 4 x 4 blocks for coherence. Returns their number.
export uniform int spawnRays(const void* uniform scene, const void* uniform frame, uniform int x0, uniform int y0,
                             uniform int x1, uniform int y1, uniform int sample, void* uniform rays) {
  USE_SCENE(s, scene);
  USE_FRAME(f, frame);
  USE_RAYS(r, rays);
  uniform int n = 0;
  foreach (i = 0 ... 1024) {
    int x = x0 + ((i & 3) | ((i >> 2) & 28)), y = y0 + (((i >> 2) & 3) | ((i >> 5) & 28));
    if (x < x1 && y < y1) {
      vec3 o, d;
      double tEnter;
      if (cameraRay(f, x, y, sample, o, d, tEnter)) {
        float tEnd = domainExit(s, o, d);
        float t = 0.0f;
        int next = nextPartition(s, o, d, t, tEnd);
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
    r.tBegun[i] = -1.0f;
    r.tMax[i] = NO_HIT;
    r.A[i] = 0.0f;
    r.r[i] = 0.0f;
    r.g[i] = 0.0f;
    r.b[i] = 0.0f;
  }
  return n;
}

// Origin and direction of primaries that came over the wire.
export void regenerateRays(const void* uniform frame, void* uniform rays, uniform int n) {
  USE_FRAME(f, frame);
  USE_RAYS(r, rays);
  foreach (i = 0 ... n) {
    vec3 o, d;
    double tEnter;
    cameraRay(f, r.pixel[i] % f.width, r.pixel[i] / f.width, RAY_SAMPLE(r.info[i]), o, d, tEnter);
    r.ox[i] = o.x; r.oy[i] = o.y; r.oz[i] = o.z;
    r.dx[i] = d.x; r.dy[i] = d.y; r.dz[i] = d.z;
    r.tMax[i] = NO_HIT;
  }
}

// Distance from the eye (render space) of the hits of primaries.
export void eyeDistances(const void* uniform frame, void* uniform rays, const uniform int which[], uniform int n,
                         uniform double distance[]) {
  USE_FRAME(f, frame);
  USE_RAYS(r, rays);
  foreach (k = 0 ... n) {
    int i = which[k];
    vec3 o, d;
    double tEnter;
    cameraRay(f, r.pixel[i] % f.width, r.pixel[i] / f.width, RAY_SAMPLE(r.info[i]), o, d, tEnter);
    distance[k] = tEnter + (double)r.tHit[i];
  }
}

// Where each ray enters and leaves this partition; no hit yet.
export void boundRays(const void* uniform scene, void* uniform rays, uniform int n) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  foreach (i = 0 ... n) {
    vec3 o = originOf(r, i), d = directionOf(r, i);
    float ax = faceBefore(o.x, d.x, d.x > 0.0f ? s.boxLoX : s.boxHiX), bx = faceAfter(o.x, d.x, d.x > 0.0f ? s.boxHiX : s.boxLoX);
    float ay = faceBefore(o.y, d.y, d.y > 0.0f ? s.boxLoY : s.boxHiY), by = faceAfter(o.y, d.y, d.y > 0.0f ? s.boxHiY : s.boxLoY);
    float az = faceBefore(o.z, d.z, d.z > 0.0f ? s.boxLoZ : s.boxHiZ), bz = faceAfter(o.z, d.z, d.z > 0.0f ? s.boxHiZ : s.boxLoZ);
    r.tIn[i] = max(max(ax, ay), max(az, 0.0f));
    r.tOut[i] = min(min(bx, by), bz);
    r.tEnd[i] = min(domainExit(s, o, d), r.tMax[i]);
    r.tHit[i] = NO_HIT;
    r.hitKind[i] = HIT_NONE;
    r.next[i] = END_ACTIVE;
  }
}

// Where each ray that ended in no surface goes next; start: rays that begin (secondaries), at t = 0.
export void routeRays(const void* uniform scene, void* uniform rays, uniform int n, uniform bool start) {
  USE_SCENE(s, scene);
  USE_RAYS(r, rays);
  foreach (i = 0 ... n) {
    vec3 o = originOf(r, i), d = directionOf(r, i);
    if (start) {
      r.r[i] = 0.0f;  // secondaries gather no radiance
      r.g[i] = 0.0f;
      r.b[i] = 0.0f;
      float t = 0.0f;
      r.next[i] = nextPartition(s, o, d, t, min(domainExit(s, o, d), r.tMax[i]));
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

// Rays per gang of the instruction set in use.
export uniform int gangWidth() { return programCount; }
