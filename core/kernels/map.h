// SPDX-License-Identifier: Apache-2.0
// The colour and extinction of a value. A map is a list of intervals over the value, each linear in
// extinction and colour. The first and the last are constant and reach to infinity, so nothing clamps.
// Extinction is per unit of t.
//
// Each dialect supplies, for its VOLUME type,
//   bool mapIsSmall(v)             whether it has at most MAP_SMALL intervals
//   bool mapIsUniform(v)           if not: whether its inner intervals have equal length
//   int  mapIntervals(v)           number of intervals
//   real mapNode(v, k)             start of interval k
//   real mapInverseLength(v, k)    1 / length of interval k
//   MapPiece mapPiece(v, k)        extinction and colour of interval k
//   int  mapNodesUpTo(v, s)        if it is small: how many intervals begin at s or below, without the first
//   int  mapUniform(v)             number of inner intervals if they have equal length, else 0
//   real mapOrigin(v)              first inner node
//   real mapInverse(v)             1 / length of a bucket (or, if uniform, of an interval)
//   int  mapBuckets(v)             number of buckets
//   int  mapBucket(v, i)           an interval at or before the start of bucket i

struct MapPlace {
  int k;   // interval
  real f;  // fraction of the interval; 0 in the two that reach to infinity
};

FN MapPlace mapPlace(VOLUME v, real s) {
  MapPlace p;
  if (mapIsSmall(v)) {
    p.k = mapNodesUpTo(v, s);
    p.f = (s - mapNode(v, p.k)) * mapInverseLength(v, p.k);
  } else if (mapIsUniform(v)) {
    // Interval 0 lies below the first node, interval n + 1 above the last.
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
