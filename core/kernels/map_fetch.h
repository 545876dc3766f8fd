// SPDX-License-Identifier: Apache-2.0
// How C++ reads a MapView and a ClipView (map_view.h).

FN real clipValue(CLIPS clips, int i) { return clips.plane[i]; }
FN real mapNode(MAP map, int k) { return map.nodes[k]; }
FN real mapInverseLength(MAP map, int k) { return map.spans[4 * k + 1]; }
FN MapSpan mapSpan(MAP map, int k) {
  PTR(real) p = map.spans + 4 * k;
  return {p[0], p[1], p[2]};
}
FN MapPiece mapPiece(MAP map, int k) {
  PTR(real) p = map.pieces + 8 * k;
  return {p[0], p[1], make_v3(p[2], p[4], p[6]), make_v3(p[3], p[5], p[7])};
}

FN MapSum mapSum(MAP map, int k) {
  MapSum s;
  s.sigma = map.sums[8 * k];
  s.source = make_v3(map.sums[8 * k + 1], map.sums[8 * k + 2], map.sums[8 * k + 3]);
  s.sigmaRest = map.sums[8 * k + 4];
  s.sourceRest = make_v3(map.sums[8 * k + 5], map.sums[8 * k + 6], map.sums[8 * k + 7]);
  return s;
}

#include "core/kernels/map_pointers.h"
