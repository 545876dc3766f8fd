/* SPDX-License-Identifier: Apache-2.0
 * Ends with 0 if publishing is off, as asked for. */
#include "insitu/api/galaxy_insitu.h"

int main(void) {
  float values[8] = {0};
  const int64_t size[3] = {2, 2, 2}, first[3] = {0, 0, 0};
  const double origin[3] = {0, 0, 0}, spacing[3] = {1, 1, 1};
  const gxy_array array = {values, GXY_FLOAT32, 1, {4, 8, 16}, 0, 0};
  gxy_sim* sim = gxy_open("installed", 0, 1, 0);
  gxy_grid(sim, "grid", 0, GXY_OF_POINTS, size, first, size, origin, spacing);
  gxy_field(sim, "grid", 0, "value", GXY_OF_POINTS, array);
  const int result = gxy_publish(sim, 1, 0.5);
  gxy_close(sim, 0);
  return result == GXY_OFF ? 0 : 1;
}
