// SPDX-License-Identifier: Apache-2.0
// Ends with 0 if publishing is off, as asked for.
#include "insitu/api/galaxy_insitu.hpp"

int main() {
  float values[8] = {};
  gxy::Simulation sim("installed", 0, 1);
  sim.grid({{2, 2, 2}}, {{0, 0, 0}}, {{2, 2, 2}}, {{0, 0, 0}}, {{1, 1, 1}});
  sim.field("value", gxy::values(values, {{2, 2, 2}}));
  return sim.publish(1, 0.5) == GXY_OFF ? 0 : 1;
}
