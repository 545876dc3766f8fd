// SPDX-License-Identifier: Apache-2.0
// How a dialect with pointers, C++ or ISPC, reads a MapView and a ClipView: the part that both write alike. Each dialect's map_fetch
// includes this file after it has defined mapNode.

FN UNIFORM bool mapIsSmall(MAP map) { return map.intervals <= MAP_SMALL; }
FN UNIFORM bool mapIsUniform(MAP map) { return map.uniformIntervals > 0; }
FN int mapBucket(MAP map, int i) { return map.bucket[i]; }
FN int mapNodesUpTo(MAP map, real s) {
  int k = 0;
  if (map.intervals > 8) {
    k += s >= mapNode(map, 8) ? 8 : 0;
    k += s >= mapNode(map, k + 4) ? 4 : 0;
    k += s >= mapNode(map, k + 2) ? 2 : 0;
    k += s >= mapNode(map, k + 1) ? 1 : 0;
  } else {
    for (UNIFORM int i = 1; i < map.intervals; i++) k += s >= mapNode(map, i) ? 1 : 0;
  }
  return k;
}
FN int mapOpaque(MAP map, int k) { return map.opaque[k]; }
