// SPDX-License-Identifier: Apache-2.0
// Colour and extinction of a value. A map is a list of intervals over the value, each linear in extinction and colour;
// the first and the last are constant and reach to infinity, so nothing clamps. Extinction is per unit of t.
//
// Each dialect supplies, for its VOLUME type,
//   int  mapUniform(v)          > 0: inner intervals have equal length (its number), 0: bucket search
//   real mapOrigin(v), mapInverse(v)   first inner node, inverse bucket (or interval) length
//   int  mapBuckets(v), mapBucket(v, i)  interval that holds the start of bucket i
//   int  mapIntervals(v); real mapNode(v, k), mapInverseLength(v, k)   start of interval k
//   real mapSigma(v, k), mapSigmaStep(v, k); vec3 mapColor(v, k), mapColorStep(v, k)

struct MapPlace {
  int k;   // interval
  real f;  // fraction of it, 0 in the two that reach to infinity
};

FN MapPlace mapPlace(VOLUME v, real s) {
  MapPlace p;
  if (mapUniform(v) > 0) {
    // interval 0 lies below the first node, interval n + 1 above the last
    real q = (s - mapOrigin(v)) * mapInverse(v);
    real c = clamp1(floor(q), R(-1.0), toReal(mapUniform(v)));
    p.k = toInt(c) + 1;
    p.f = c < R(0.0) ? R(0.0) : q - c;
    if (p.k > mapUniform(v)) p.f = R(0.0);
  } else {
    real q = clamp1((s - mapOrigin(v)) * mapInverse(v), R(0.0), toReal(mapBuckets(v) - 1));
    int k = mapBucket(v, toInt(q));
    while (k + 1 < mapIntervals(v) && s >= mapNode(v, k + 1)) k += 1;
    p.k = k;
    p.f = (s - mapNode(v, k)) * mapInverseLength(v, k);
  }
  return p;
}

FN real sigmaAt(VOLUME v, MapPlace p) { return mapSigma(v, p.k) + p.f * mapSigmaStep(v, p.k); }
FN vec3 colorAt(VOLUME v, MapPlace p) {
  vec3 c = mapColor(v, p.k), s = mapColorStep(v, p.k);
  return make_v3(c.x + p.f * s.x, c.y + p.f * s.y, c.z + p.f * s.z);
}
