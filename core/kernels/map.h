// SPDX-License-Identifier: Apache-2.0
// The colour and extinction of a value. A map is a list of intervals over the value, each linear in
// extinction and colour. The first and the last are constant and reach to infinity, so nothing clamps.
// Extinction is per unit of t.
//
// Each dialect supplies, for a MAP map,
//   bool mapIsSmall(map)           whether it has at most MAP_SMALL intervals
//   bool mapIsUniform(map)         if not: whether its inner intervals have equal length
//   real mapNode(map, k)           start of interval k
//   real mapInverseLength(map, k)  1 / length of interval k
//   MapSpan mapSpan(map, k)        both, and where it ends
//   MapPiece mapPiece(map, k)      extinction and colour of interval k
//   MapSum mapSum(map, k)          integrals up to its start
//   int  mapOpaque(map, k)         the last opaque interval before it, or -1
//   int  mapNodesUpTo(map, s)      if it is small: how many intervals begin at s or below, without the first
//   int  mapBucket(map, i)         an interval at or before the start of bucket i

struct MapPlace {
  int k;   // interval
  real f;  // fraction of the interval; 0 in the two that reach to infinity
};

FN MapPlace mapPlace(MAP map, real s) {
  MapPlace p;
  if (mapIsSmall(map)) {
    p.k = mapNodesUpTo(map, s);
    p.f = (s - mapNode(map, p.k)) * mapInverseLength(map, p.k);
  } else if (mapIsUniform(map)) {
    // Interval 0 lies below the first node, interval n + 1 above the last.
    real q = (s - map.origin) * map.inverse;
    real c = clamp1(floor(q), R(-1.0), toReal(map.uniformIntervals));
    p.k = toInt(c) + 1;
    p.f = c < R(0.0) ? R(0.0) : q - c;
    if (p.k > map.uniformIntervals) p.f = R(0.0);
  } else {
    real q = clamp1((s - map.origin) * map.inverse, R(0.0), toReal(map.buckets - 1));
    p.k = mapBucket(map, toInt(q));
    MapSpan span = mapSpan(map, p.k);
    real end = span.end;  // a loop's variables are not members of structures (decision 0012)
    while (p.k + 1 < map.intervals && s >= end) {
      p.k += 1;
      span = mapSpan(map, p.k);
      end = span.end;
    }
    p.f = (s - span.start) * span.inverse;
  }
  return p;
}

FN real sigmaAt(MapPiece m, real f) { return m.sigma + f * m.sigmaStep; }
FN vec3 colorAt(MapPiece m, real f) {
  return make_v3(m.color.x + f * m.colorStep.x, m.color.y + f * m.colorStep.y, m.color.z + f * m.colorStep.z);
}
// The colour of a value, NaN included.
FN vec3 colorOf(MAP map, real s) {
  vec3 color = make_v3(map.nanRed, map.nanGreen, map.nanBlue);
  if (s == s) {
    MapPlace p = mapPlace(map, s);
    color = colorAt(mapPiece(map, p.k), p.f);
  }
  return color;
}
