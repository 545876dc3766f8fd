// SPDX-License-Identifier: Apache-2.0
// How C++ reads a MapView and a ClipView (map_view.h).

FN real clipValue(CLIPS clips, int i) { return clips.plane[i]; }
FN real mapNode(MAP map, int k) { return map.nodes[k]; }
FN real mapInverseLength(MAP map, int k) { return map.lengths[k]; }
FN MapPiece mapPiece(MAP map, int k) {
  PTR(real) p = map.pieces + 8 * k;
  return {p[0], p[1], make_v3(p[2], p[4], p[6]), make_v3(p[3], p[5], p[7])};
}

#include "core/kernels/map_pointers.h"
