// SPDX-License-Identifier: Apache-2.0
// Colour and extinction of a value. A map is a list of intervals over the value, each linear in extinction and colour;
// the first and the last are constant and reach to infinity, so nothing clamps. Extinction is per unit of t.
//
// Each dialect supplies, for its VOLUME type,
//   bool mapIsSmall(v), mapIsUniform(v)  at most MAP_SMALL intervals; else, whether inner ones have equal length
//   int  mapIntervals(v); real mapNode(v, k), mapInverseLength(v, k)   start of interval k
//   MapPiece mapPiece(v, k)            what interval k holds
//   int  mapNodesUpTo(v, s)            of a map of at most MAP_SMALL intervals, how many begin at s or below, but the first
//   int  mapUniform(v)                 their number
//   real mapOrigin(v), mapInverse(v)   first inner node, inverse bucket (or interval) length
//   int  mapBuckets(v), mapBucket(v, i)  an interval at or before the start of bucket i

struct MapPlace {
  int k;   // interval
  real f;  // fraction of it, 0 in the two that reach to infinity
};

FN MapPlace mapPlace(VOLUME v, real s) {
  MapPlace p;
  if (mapIsSmall(v)) {
    p.k = mapNodesUpTo(v, s);
    p.f = (s - mapNode(v, p.k)) * mapInverseLength(v, p.k);
  } else if (mapIsUniform(v)) {
    // interval 0 lies below the first node, interval n + 1 above the last
    real q = (s - mapOrigin(v)) * mapInverse(v);
    real c = clamp1(floor(q), R(-1.0), toReal(mapUniform(v)));
    p.k = toInt(c) + 1;
    p.f = c < R(0.0) ? R(0.0) : q - c;
    if (p.k > mapUniform(v)) p.f = R(0.0);
  } else {
    real q = clamp1((s - mapOrigin(v)) * mapInverse(v), R(0.0), toReal(mapBuckets(v) - 1));
    p.k = mapBucket(v, toInt(q));
    while (p.k + 1 < mapIntervals(v) && s >= mapNode(v, p.k + 1)) p.k += 1;
    p.f = (s - mapNode(v, p.k)) * mapInverseLength(v, p.k);
  }
  return p;
}

FN real sigmaAt(MapPiece m, real f) { return m.sigma + f * m.sigmaStep; }
FN vec3 colorAt(MapPiece m, real f) {
  return make_v3(m.color.x + f * m.colorStep.x, m.color.y + f * m.colorStep.y, m.color.z + f * m.colorStep.z);
}
// The colour of a value, NaN included.
FN vec3 colorOf(VOLUME v, real s) {
  vec3 color = make_v3(v.nanRed, v.nanGreen, v.nanBlue);
  if (s == s) {
    MapPlace p = mapPlace(v, s);
    color = colorAt(mapPiece(v, p.k), p.f);
  }
  return color;
}
