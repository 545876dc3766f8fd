// SPDX-License-Identifier: Apache-2.0
// What macrocells.cpp needs of the rows of points of one row of macrocells: their values as float, and extremes over them.
#include "core/kernels/export.h"

// Reads a row of a block in bricks: 8 points stand together, the next 8 stand `step` points later.
#define READ_ROW(NAME, T)                                                                                        \
  EXPORT void NAME(const uniform T row[], uniform int step, uniform int points, uniform float to[]) {            \
    for (uniform int x = 0; x + 8 <= points; x += 8, row += step) {                                              \
      foreach (i = 0 ... 8) {                                                                                    \
        to[x + i] = (float)row[i];                                                                               \
      }                                                                                                          \
    }                                                                                                            \
    foreach (i = 0 ... points % 8) {                                                                             \
      to[points / 8 * 8 + i] = (float)row[i];                                                                    \
    }                                                                                                            \
  }
READ_ROW(readRowInt8, int8)
READ_ROW(readRowUInt8, uint8)
READ_ROW(readRowInt16, int16)
READ_ROW(readRowUInt16, uint16)
READ_ROW(readRowFloat, float)

// A difference of a NaN or an infinity is NaN or infinite, and so fails the comparisons.
static inline float wider(float most, float difference, const uniform bool finiteOnly) {
  float d = abs(difference);
  if (finiteOnly) return d > most && d < floatbits(0x7f800000) ? d : most;
  return d > most ? d : most;
}

static inline void summarize(const uniform float rows[], uniform int64 pitch, uniform int perLayer, uniform int ny, uniform int nz,
                             uniform int points, const uniform bool finiteOnly, uniform float extremes[]) {
  const float infinity = floatbits(0x7f800000);
  foreach (x = 0 ... points) {
    float lo = infinity, hi = -infinity, bad = 0;
    float steep = 0, bend = 0;          // of a point, and of rows that are neighbours along y or z
    float steepNext = 0, bendNext = 0;  // of it and the next point in x
    float bendBoth = 0;                 // of it and both its neighbours in x
    for (uniform int z = 0; z < nz; z++) {
      // The layers before this one. Where there is none, differences of a layer with itself are 0 and change nothing.
      const uniform float* uniform layer = rows + z * perLayer * pitch;
      const uniform float* uniform below = z > 0 ? layer - perLayer * pitch : layer;
      const uniform float* uniform below2 = z > 1 ? below - perLayer * pitch : below;
      float v1 = 0, b1 = 0, dx1 = 0, dy1 = 0;  // of the row before: value, value below, differences along x and y
      for (uniform int y = 0; y < ny; y++) {
        const uniform float* uniform row = layer + y * pitch;
        const uniform float* uniform under = below + y * pitch;
        float v = row[x], b = under[x];
        bool finite = v - v == 0;
        lo = min(lo, finite ? v : infinity);
        hi = max(hi, finite ? v : -infinity);
        bad = finite ? bad : 1.0f;
        float dx = row[x + 1] - v;
        steepNext = wider(steepNext, dx, finiteOnly);
        bendBoth = wider(bendBoth, dx - (v - row[x - 1]), finiteOnly);
        float dz = v - b;
        steep = wider(steep, dz, finiteOnly);
        bendNext = wider(bendNext, dx - (under[x + 1] - b), finiteOnly);
        if (z > 1) bend = wider(bend, (b - below2[y * pitch + x]) - dz, finiteOnly);
        if (y > 0) {
          float dy = v - v1;
          steep = wider(steep, dy, finiteOnly);
          bendNext = wider(bendNext, dx - dx1, finiteOnly);
          bend = wider(bend, (b - b1) - dy, finiteOnly);
          if (y > 1) bend = wider(bend, dy1 - dy, finiteOnly);
          dy1 = dy;
        }
        v1 = v;
        b1 = b;
        dx1 = dx;
      }
    }
    extremes[x] = lo;
    extremes[pitch + x] = hi;
    extremes[2 * pitch + x] = steep;
    extremes[3 * pitch + x] = bend;
    extremes[4 * pitch + x] = steepNext;
    extremes[5 * pitch + x] = bendNext;
    extremes[6 * pitch + x] = bendBoth;
    extremes[7 * pitch + x] = bad;
  }
}

// `rows`: ny x nz rows of `points` floats, `pitch` floats apart, `perLayer` rows in each of the nz layers; the floats before and
// after a row may be read. `extremes`: eight rows, also `pitch` apart, that are written: the least and the largest finite value; the
// largest |first difference| and |second difference| of a point and those before it along y and z; the same with the next point
// in x; the largest |second difference| along x; 1 where a value is not finite.
EXPORT void summarizeRows(const uniform float rows[], uniform int64 pitch, uniform int perLayer, uniform int ny, uniform int nz,
                          uniform int points, uniform bool finiteOnly, uniform float extremes[]) {
  if (finiteOnly)
    summarize(rows, pitch, perLayer, ny, nz, points, true, extremes);
  else
    summarize(rows, pitch, perLayer, ny, nz, points, false, extremes);
}
