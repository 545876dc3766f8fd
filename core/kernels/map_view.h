// SPDX-License-Identifier: Apache-2.0
// What an operator has besides its data, as the kernels see it: its map and its clip planes. view_types.h must come before. Each
// dialect fetches in a file of its own, named map_fetch: C++'s stands here, the others with their backends.

#if defined(GXY_GLSL) || defined(GXY_LAYOUT)
#define MAP MapView
#define CLIPS ClipView
#elif defined(ISPC)
#define MAP const uniform MapView&
#define CLIPS const uniform ClipView&
#else
#define MAP const MapView&
#define CLIPS const ClipView&
#endif

// Colour and extinction of a value, see map.h.
struct MapView {
  int intervals;
  int uniformIntervals;  // number of inner intervals if they have equal length, else 0
  int buckets;
  real origin;                     // first inner node
  real inverse;                    // 1 / length of a bucket (or, if uniform, of an interval)
  real nanRed, nanGreen, nanBlue;  // colour where there is no value
  PTR(int) bucket;                 // an interval at or before the start of each
  PTR(real) nodes;                 // start of each interval
  PTR(real) spans;                 // 4 per interval: its start, its inverse length, its end, and 0
  PTR(real) rows;    // of at most 16 intervals: 10 rows of 16, the nodes, lengths and pieces; else null
  PTR(real) pieces;  // 8 per interval: sigma, its step, then r, g, b each with its step
  PTR(real)
  sums;  // 8 per interval: integrals of sigma and sigma * rgb from the last opaque interval to its start,
         // and what rounding left of them, which counts where two that are large and alike are subtracted
  PTR(int) opaque;  // the last opaque interval before it, or -1
};

struct ClipView {
  int planes;
  PTR(real) plane;  // 4 per plane: keeps n . p >= offset, render space
};

#if !defined(GXY_LAYOUT)
#define MAP_SMALL \
  16  // intervals of maps that are searched by comparing; their nodes are filled up with infinities
struct MapSpan {
  real start, inverse, end;
};
struct MapPiece {
  real sigma, sigmaStep;
  vec3 color, colorStep;
};
struct MapSum {
  real sigma, sigmaRest;
  vec3 source, sourceRest;
};
#endif
