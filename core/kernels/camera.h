// SPDX-License-Identifier: Apache-2.0
// From pixels to rays: in double, then rebased to float where rays enter the visible domain.

#if defined(GXY_GLSL)
#define R2_X 0.7548776662466927lf
#define R2_Y 0.5698402909980532lf
#define FARTHEST 1e300lf
#elif defined(ISPC)
#define R2_X 0.7548776662466927d
#define R2_Y 0.5698402909980532d
#define FARTHEST 1e300d
#else
#define R2_X 0.7548776662466927
#define R2_Y 0.5698402909980532
#define FARTHEST 1e300
#endif

// Cuts [t0, t1] to the slab lo <= o + t d <= hi; empty if the ray misses it.
FN void cutToSlab(double o, double d, double lo, double hi, INOUT(double) t0, INOUT(double) t1) {
  if (d == 0) {
    if (o < lo || o > hi) t1 = -1;
  } else {
    double a = (lo - o) / d, b = (hi - o) / d;
    t0 = max(t0, min(a, b));
    t1 = min(t1, max(a, b));
  }
}

// Computes the ray of a pixel and sample. Returns false if it misses the visible domain. tEnter: the distance
// from the eye, in render space.
FN bool cameraRay(FRAME f, int x, int y, int sampleIndex, OUT(vec3) o, OUT(vec3) d, OUT(double) tEnter) {
  // Sub-pixel positions are the centre, then the R2 sequence around it.
  double half1 = 0.5f;
  double sx = half1, sy = half1;
  if (sampleIndex > 0) {
    sx = half1 + sampleIndex * R2_X;
    sy = half1 + sampleIndex * R2_Y;
    sx = sx - floor(sx);
    sy = sy - floor(sy);
  }
  double u = x + sx, v = y + sy;
  double px = (f.cornerX + u * f.duX) + v * f.dvX;
  double py = (f.cornerY + u * f.duY) + v * f.dvY;
  double pz = (f.cornerZ + u * f.duZ) + v * f.dvZ;
  double ex = f.eyeX, ey = f.eyeY, ez = f.eyeZ, gx = px, gy = py, gz = pz;
  if (f.orthographic != 0) {
    ex = px;
    ey = py;
    ez = pz;
    gx = f.viewX;
    gy = f.viewY;
    gz = f.viewZ;
  }
  double length1 = sqrt((gx * gx + gy * gy) + gz * gz);
  gx /= length1;
  gy /= length1;
  gz /= length1;
  double t0 = 0, t1 = FARTHEST;
  cutToSlab(ex, gx, f.loX, f.hiX, t0, t1);
  cutToSlab(ey, gy, f.loY, f.hiY, t0, t1);
  cutToSlab(ez, gz, f.loZ, f.hiZ, t0, t1);
  tEnter = t0;
  o = make_v3(floatOf(ex + t0 * gx), floatOf(ey + t0 * gy), floatOf(ez + t0 * gz));
  d = make_v3(floatOf(gx), floatOf(gy), floatOf(gz));
  return t0 < t1;
}

// The column and row of ray i of a tile of 32 x 32 pixels, in 4 x 4 blocks for coherence.
FN int tileColumn(int i) { return (i & 3) | ((i >> 2) & 28); }
FN int tileRow(int i) { return ((i >> 2) & 3) | ((i >> 5) & 28); }
