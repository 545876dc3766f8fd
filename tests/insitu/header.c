/* SPDX-License-Identifier: Apache-2.0
   A simulation in C99 compiles against the header, and links. */
#include "insitu/api/galaxy_insitu.h"

int publish_from_c(void) {
  const int64_t size[3] = {4, 4, 4}, first[3] = {0, 0, 0};
  const double origin[3] = {0, 0, 0}, spacing[3] = {1, 1, 1};
  static float values[64];
  gxy_array array = {values, GXY_FLOAT32, 1, {4, 16, 64}, 0, 0};
  gxy_sim* sim = gxy_open("heat", 0, 1, NULL);
  int results = gxy_grid(sim, "grid", 0, GXY_OF_POINTS, size, first, size, origin, spacing);
  results |= gxy_field(sim, "grid", 0, "temperature", GXY_OF_POINTS, array);
  if (gxy_publish(sim, 1, 0.5) != GXY_OFF) results = GXY_WRONG;
  gxy_close(sim, 0);
  return results;
}
