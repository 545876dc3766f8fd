// SPDX-License-Identifier: Apache-2.0
// The kernels that read volumes, in the common dialect: fieldProbe(map, v, f, ...) is a number that they compute for a ray. C++ and
// ISPC read it after core/kernels/fields.h; their results have the same bits.

#define FIELD_PROBES 28

struct ProbeRay {
  vec3 o, d;
  real a, b;  // two values of the field
};

// Intervals, cells and the value along the ray.
FN real probeGrid(VOLUME v, int f, VolumeRay r) {
  real middle = R(0.5) * (r.t0 + r.t1);
  ivec3 n = gridCells(v);
  int x = locateCell(middle, r.g.po.x, r.g.pd.x, r.g.rpd.x, n.x);
  int y = locateCell(middle, r.g.po.y, r.g.pd.y, r.g.rpd.y, n.y);
  int z = locateCell(middle, r.g.po.z, r.g.pd.z, r.g.rpd.z, n.z);
  if (f == 0) return r.t0;
  if (f == 1) return r.t1;
  if (f == 2) return r.cells;
  if (f == 3) return toReal((z * n.y + y) * n.x + x);
  vec3 p = pointAt(r.g, middle);
  if (f == 4) return sampleAt(v, p);
  ivec3 c = cellAt(v, p);
  CellValues k = cellValues(v, c);
  vec3 from = fractionIn(c, p);
  if (f == 5) return trilinear(k, from);
  vec3 g = gradientAt(v, p);
  if (f == 6) return g.x;
  if (f == 7) return g.y;
  if (f == 8) return g.z;
  vec3 to = make_v3(R(1.0) - from.y, from.z, R(1.0));
  vec4 b = bernsteinAlong(cellValuesMinus(k, trilinear(k, make_v3(R(0.5), R(0.25), R(0.75)))), from, to);
  if (f == 9) return b.x + b.w;
  if (f == 10) return b.y + b.z;
  RootQuery q;
  q.tIn = R(0.0);
  q.tOut = R(1e30);
  q.tAfter = R(-1.0);
  q.entry = true;
  q.from = 0;
  q.start = false;
  Bracket found = firstBracket(b, R(0.25), R(0.0), q);
  real u = rootIn(b, found);
  return found.lo > found.hi ? R(-1.0) : rootTime(u, R(0.25), R(1.5));
}

// The map at a value, and between two.
FN real probeMap(MAP map, int f, ProbeRay r) {
  MapPlace p = mapPlace(map, r.a);
  MapPiece piece = mapPiece(map, p.k);
  vec3 c = colorAt(piece, p.f);
  if (f == 12) return toReal(p.k);
  if (f == 13) return sigmaAt(piece, p.f);
  if (f == 14) return c.x;
  if (f == 15) return c.z;
  MapMean m = meanAlong(map, r.a, r.b);
  if (f == 16) return m.sigma;
  return f == 17 ? m.color.x : m.color.y;
}

// The march: all of it, or the part that ends between two places.
FN real probeMarch(MAP map, VOLUME v, int f, VolumeRay r) {
  bool part = f >= 24;
  MarchRange m;
  m.tIn = part ? R(0.7) * r.t0 + R(0.3) * r.t1 : R(0.0);
  m.tOut = part ? R(0.2) * r.t0 + R(0.8) * r.t1 : R(1e30);
  m.tOwnershipEnd = m.tOut;
  m.tStart = R(-1.0);
  m.tStop = part ? R(0.4) * r.t0 + R(0.6) * r.t1 : R(1e30);
  m.tMin = part ? R(0.0) : R(1e-3);
  Radiance L;
  L.rgb = make_v3(R(0.0), R(0.0), R(0.0));
  L.A = R(0.0);
  MarchCount n = nothingMarched();
  real begun = R(-1.0);
  integrateVolume(map, v, r, m, begun, L, n);
  if (f == 19) return L.rgb.x;
  if (f == 20) return L.rgb.y;
  if (f == 21) return L.rgb.z;
  if (f == 23) return toReal(n.samples + 10000 * n.macrocells);
  return f == 25 ? L.rgb.x + L.rgb.y : L.A;
}

FN real fieldProbe(MAP map, VOLUME v, int f, ProbeRay ray) {
  VolumeRay r = volumeRay(v, ray.o, ray.d, R(0.0), R(1e30));
  if (f < 3) return probeGrid(v, f, r);
  if (!(r.t0 < r.t1)) return R(-1.0);
  if (f < 12) return probeGrid(v, f, r);
  if (f < 19) return probeMap(map, f, ray);
  if (f < 26) return probeMarch(map, v, f, r);
  IsoStart start;
  start.index = -1;
  start.from = 0;
  int cells = 0;
  int skipped = 0;
  IsoHit hit = firstIsosurface(v, r, R(0.0), R(1e30), R(-1.0), start, cells, skipped);
  return f == 26 ? hit.t : toReal(hit.index + 10 * cells);
}
