// SPDX-License-Identifier: Apache-2.0
// The kernels that read scenes, in the common dialect: sceneProbe(..., p, i) is a number that they compute of operator `op`,
// whose field is v, from seeded input i. C++, ISPC and GLSL read it after core/kernels/scene.h; their results have the same
// bits.

#define SCENE_PROBES 48

// In [lo, hi).
FN real drawIn(uint i, uint salt, real lo, real hi) { return lo + (hi - lo) * unitReal(hash2(i, salt)); }
FN vec3 drawPoint(uint i, uint salt, real size) {
  real x = drawIn(i, salt, -size, size);
  real y = drawIn(i, salt + 1u, -size, size);
  real z = drawIn(i, salt + 2u, -size, size);
  return make_v3(x, y, z);
}

FN real probeCamera(FRAME f, int p, uint i) {
  int tile = asInt(i & 1023u);
  int k = asInt(i) * 7 % (f.width * f.height);
  vec3 o, d;
  double enter;
  bool meets = cameraRay(f, k % f.width, k / f.width, asInt(i & 3u), o, d, enter);
  if (p == 0) return toReal(tileColumn(tile) + 32 * tileRow(tile));
  if (!meets) return R(-1.0);
  if (p == 1) return o.x;
  if (p == 2) return o.z;
  if (p == 3) return d.x;
  if (p == 4) return d.y;
  return floatOf(enter);
}

FN real probeLattice(SCENE s, int p, vec3 o, vec3 d, uint i) {
  real tIn, tOut, t = drawIn(i, 10u, R(0.0), R(1.0)), end = domainExit(s, o, d);
  partitionSpan(s, o, d, tIn, tOut);
  if (p == 6) return end;
  if (p == 7) return tIn;
  if (p == 8) return tOut;
  if (p == 9) return nextBegin(s, o, d, t, end);
  if (p == 10) return toReal(firstPartition(s, o, d, end));
  int next = nextPartition(s, o, d, t, end);
  return p == 11 ? toReal(next) : t;
}

FN real probeCuts(SCENE s, OPERATOR op, VOLUME v, VOLUMES list, UNIFORM int count, int p, vec3 o, vec3 d,
                  uint i) {
  real clip0, clip1, tLast = drawIn(i, 11u, R(-1.0), R(0.5));
  clipInterval(op.clips, o, d, clip0, clip1);
  if (p == 13) return clip0;
  if (p == 14) return clip1;
  LastHit last;
  last.t = tLast;
  last.op = asInt(i & 3u);
  last.number = numberOf((i & 4u) == 0u ? HIT_SLICE : HIT_ISOSURFACE, (i >> 3u) & 7u);
  tLast = behindLast(last, 1, (i >> 6u) & 7u);
  if (p == 15) return boundBehind(op.clips, strictBound(drawIn(i, 12u, R(-1.0), R(1.0)), tLast), clip0);
  real scale = meetsGeometry(make_v3(o.x * R(3e18), o.y, o.z)) ? R(1.0) : R(2.0);
  if (p == 16) return scale * largest3(o);
  if (p < 22) {
    MarchRange m;
    m.tIn = drawIn(i, 13u, R(0.0), R(0.3));
    m.tOut = R(1e30);
    m.tOwnershipEnd = R(1e30);
    m.tStart = R(-1.0);
    m.tStop = drawIn(i, 14u, R(0.5), R(5.0));
    m.tMin = s.tMin;
    Radiance L;
    L.rgb = make_v3(R(0.0), R(0.0), R(0.0));
    L.A = R(0.0);
    MarchCount n = nothingMarched();
    integrateVolumes(s, list, count, o, d, m, L, n);
    if (p == 17) return L.rgb.x;
    if (p == 18) return L.rgb.y;
    if (p == 19) return L.rgb.z;
    return p == 20 ? L.A : toReal(n.samples + 100 * n.macrocells + 10000 * n.skipped);
  }
  if (op.kind != KIND_VOLUME) return R(-1.0);
  if (p == 22) {
    if (op.slices == 0) return R(-2.0);
    return hitSlice(v, clippedRay(op.clips, v, o, d), o, d, sliceNormal(op, 0u),
                    drawIn(i, 15u, R(-0.5), R(0.5)), R(0.0), R(1e30), tLast);
  }
  if (v.isovalues == 0) return R(-2.0);
  IsoStart start;
  start.index = -1;
  start.from = 0;
  int cells = 0, skipped = 0;
  IsoHit hit =
      hitIsosurface(op.clips, v, o, d, R(0.0), R(1e30), tLast, R(1e30), start, false, cells, skipped);
  return p == 23 ? hit.t : toReal(hit.index + 10 * cells);
}

// A ray towards primitive k, or through the volume, and what it hits there.
FN bool surfaceAt(OPERATOR op, VOLUME v, uint k, vec3 o, vec3 way, uint i, OUT(vec3) d, OUT(Surface) found) {
  d = way;
  bool hit = false;
  real t;
  Surface f;
  f.point = o;
  f.normal = way;
  f.geometric = way;
  f.own = make_v3(R(0.0), R(0.0), R(0.0));
  f.value = R(0.0);
  f.size = R(1.0);
  f.start = 0u;
  if (op.kind == KIND_PARTICLES) {
    vec3 c = pointOf(op, k), n;
    real r = radiusOf(op, k);
    d = unit3(make_v3((c.x - o.x) + r * way.y, (c.y - o.y) + r * way.z, (c.z - o.z) + r * way.x));
    hit = hitSphere(o, d, c, r, R(0.0), t, n);
    if (hit) f = sphereSurface(op, k, o, d, R(0.0));
  } else if (op.kind == KIND_PATHLINES) {
    Tube tube = tubeOf(op, k);
    TubeHit h;
    real u = drawIn(i, 20u, R(0.0), R(1.0)), r = tube.radiusA;
    d = unit3(make_v3(lerp1(tube.a.x, tube.b.x, u) - o.x + r * way.y,
                      lerp1(tube.a.y, tube.b.y, u) - o.y + r * way.z, lerp1(tube.a.z, tube.b.z, u) - o.z));
    hit = hitTube(tube, o, d, R(0.0),
                  metSegment(op, (k + 1u) % op.primitives, drawIn(i, 24u, R(0.0), R(1.0))), h);
    if (hit) f = tubeSurface(op, k, o, d, R(0.0));
  } else if (op.kind == KIND_TRIANGLES) {
    vec3 a = pointOf(op, cornerOf(op, 3u * k)), b = pointOf(op, cornerOf(op, 3u * k + 1u)),
         c = pointOf(op, cornerOf(op, 3u * k + 2u));
    real wb, wc;
    d = unit3(make_v3(R(0.5) * a.x + R(0.25) * (b.x + c.x) - o.x, R(0.5) * a.y + R(0.25) * (b.y + c.y) - o.y,
                      R(0.5) * a.z + R(0.25) * (b.z + c.z) - o.z));
    hit = hitTriangle(o, d, a, b, c, R(0.0), t, wb, wc);
    if (hit) f = triangleSurface(op, k, o, d, R(0.0));
  } else if (op.kind == KIND_MESH) {
    if (op.surfaceCells > 0u) {
      uint p = hash2(i, 25u) % op.surfaceCells;
      vec4 a = levelCorner(op, p, 0), b = levelCorner(op, p, 1), c = levelCorner(op, p, 2),
           e = levelCorner(op, p, 3);
      d = unit3(make_v3(R(0.25) * ((a.x + b.x) + (c.x + e.x)) - o.x,
                        R(0.25) * ((a.y + b.y) + (c.y + e.y)) - o.y,
                        R(0.25) * ((a.z + b.z) + (c.z + e.z)) - o.z));
      hit = hitCell(frameRay(o, d), a, b, c, e, R(0.0), t);
      if (hit) f = cellSurface(op, p, o, d, t);
    }
  } else if (op.kind == KIND_HEX_MESH) {
    if (op.surfaceCells > 0u) {
      uint p = hash2(i, 25u) % op.surfaceCells;
      Hexahedron h;
      h.c0 = hexLevel(op, p, 0), h.c1 = hexLevel(op, p, 1), h.c2 = hexLevel(op, p, 2),
      h.c3 = hexLevel(op, p, 3);
      h.c4 = hexLevel(op, p, 4), h.c5 = hexLevel(op, p, 5), h.c6 = hexLevel(op, p, 6),
      h.c7 = hexLevel(op, p, 7);
      vec4 middle = trilinearIn(h, make_v3(R(0.5), R(0.4), R(0.6)));
      d = unit3(make_v3(middle.x - o.x, middle.y - o.y, middle.z - o.z));
      hit = hitHexahedron(frameRay(o, d), h, levelOrders(op, p), R(0.0), t);
      if (hit) f = hexSurface(op, p, o, d, t);
    }
  } else if (v.isovalues > 0) {
    IsoStart start;
    start.index = -1;
    start.from = 0;
    int cells = 0, skipped = 0;
    IsoHit met =
        hitIsosurface(op.clips, v, o, d, R(0.0), R(1e30), R(-1.0), R(1e30), start, false, cells, skipped);
    hit = met.t < NO_HIT;
    if (hit) f = fieldSurface(op, v, HIT_ISOSURFACE, toUint(met.index), o, d, met.t);
  } else if (op.slices > 0) {
    VolumeRay r = clippedRay(op.clips, v, o, d);
    hit = r.t0 < r.t1;
    if (hit) f = fieldSurface(op, v, HIT_SLICE, 0u, o, d, lerp1(r.t0, r.t1, R(0.4)));
  }
  found = f;
  return hit;
}

FN real probeSurface(SCENE s, FRAME f, OPERATOR op, VOLUME v, int p, vec3 o, vec3 way, uint i) {
  vec3 d;
  Surface found;
  uint k = op.primitives > 0u ? hash2(i, 21u) % op.primitives : 0u;
  if (!surfaceAt(op, v, k, o, way, i, d, found)) return R(-3.0);
  Surface seen = surfaceSeen(found, d, op.twoSided != 0);
  vec3 color = surfaceColor(op, seen);
  if (p == 25) return seen.normal.x;
  if (p == 26) return seen.normal.z;
  if (p == 27) return seen.geometric.y;
  if (p == 28) return seen.point.x;
  if (p == 29) return seen.value + color.y;
  if (p == 30) return seen.size + toReal(asInt(seen.start >> 16u));
  vec3 from = offsetOrigin(seen.point, seen.geometric, seen.size), toEye = make_v3(-d.x, -d.y, -d.z);
  real weight = drawIn(i, 22u, R(0.0), R(40.0));
  int r = 0, g = 0, b = 0;
  vec3 toward = toEye;
  real reach = R(0.0);
  for (UNIFORM int q = 0; q < f.lights + max(s.occlusionRays, 1); q++) {
    LightTerm term = lightTermOf(s, f, q, seen, from, toEye, color, op.opacity, weight, i, i & 7u);
    limitLightTerm(term, r, g, b);
    r += term.r;
    g += term.g;
    b += term.b;
    vec3 origin = startOf(term, seen, from);
    toward = make_v3(toward.x + origin.y + toReal(term.behind ? 1 : 0) +
                         toReal(asInt(startBitsOf(term, seen) >> 16u)) + term.toward.x,
                     toward.y + term.toward.y, toward.z + term.toward.z);
    reach = term.wanted ? term.reach : reach;
  }
  if (p == 31) return toReal(r);
  if (p == 32) return toReal(g);
  if (p == 33) return toReal(b);
  if (p == 34) return toward.x;
  if (p == 35) return toward.z;
  if (p == 36) return reach;
  real A = drawIn(i, 23u, R(-0.1), R(1.0));
  if (p == 37) return toReal(lossOf(r, A, s.tMin));
  if (p == 38) return opacityBehind(A, op.opacity);
  return toReal(units(A * weight));
}

FN real probeSample(OPERATOR op, VOLUME v, int p, vec3 o, vec3 d, uint i) {
  real t = drawIn(i, 26u, R(0.0), R(1.5));
  if (p == 42) return inRange(t, R(0.25), R(0.75)) ? R(1.0) : R(0.0);
  if (op.kind != KIND_VOLUME) return R(-1.0);
  if (p == 43)
    return hitStep(v, clippedRay(op.clips, v, o, d), drawIn(i, 27u, R(0.002), R(0.3)),
                   drawIn(i, 28u, R(0.0), R(0.3)), t, drawIn(i, 29u, R(-1.0), R(0.4)));
  real x = valueMet(v, o, d, t);
  if (p == 41) {
    vec3 gradient = gradientMet(v, o, d, t);
    x = gradient.y;
  }
  return x == x ? x : R(-2.0);
}

// The walks of a ray through a mesh; the faces of its shell are tried one after the other.
FN real probeMesh(SCENE s, OPERATOR op, int p, vec3 o, vec3 way, uint i) {
  if (op.kind != KIND_MESH && op.kind != KIND_HEX_MESH) return R(-1.0);
  bool hexes = op.kind == KIND_HEX_MESH;
  uint some = shellFace(op, hash2(i, 30u) % op.primitives), point = hash2(i, 35u) & 3u;
  vec3 to = placeOf(vertexOf(op, hexes ? hexPoint(op, (some >> 3) * 8u + point) : cornerOfFace(op, some, 1)));
  vec3 d = (i & 1u) == 0u ? unit3(make_v3(to.x - o.x, to.y - o.y, to.z - o.z)) : way;
  MarchRange m;
  m.tIn = drawIn(i, 31u, R(-0.2), R(0.3));
  m.tOut = drawIn(i, 32u, R(0.5), R(2.0));
  m.tOwnershipEnd = m.tOut;
  m.tStart = drawIn(i, 33u, R(-1.0), R(0.3));
  m.tStop = drawIn(i, 34u, R(0.5), R(2.0));
  m.tMin = s.tMin;
  Radiance L;
  L.rgb = make_v3(R(0.0), R(0.0), R(0.0));
  L.A = R(0.0);
  FrameRay f = frameRay(o, d);
  MeshMarch w = startMesh(op.clips, o, d, m, L.A);
  ShellPlace last = beforeShell();
  int samples = 0, cells = 0;
  bool goes = w.goes;
  while (goes) {
    real t, nearest = R(1e30);
    uint next = NO_FACE;
    for (uint k = 0u; k < op.primitives; k++) {
      uint face = shellFace(op, k);
      bool passes;
      if (hexes) {
        uint orders = hexOrders(op, face >> 3);
        uint corners = orderedCorners(face & 7u, orders), at = (face >> 3) * 8u;
        passes = passesSide(f, placeOf(vertexOf(op, hexPoint(op, at + (corners & 7u)))),
                            placeOf(vertexOf(op, hexPoint(op, at + ((corners >> 4) & 7u)))),
                            placeOf(vertexOf(op, hexPoint(op, at + ((corners >> 8) & 7u)))),
                            placeOf(vertexOf(op, hexPoint(op, at + (corners >> 12)))),
                            isTriangle(face & 7u, orders), t);
      } else {
        passes = passesFace(f, placeOf(vertexOf(op, cornerOfFace(op, face, 0))),
                            placeOf(vertexOf(op, cornerOfFace(op, face, 1))),
                            placeOf(vertexOf(op, cornerOfFace(op, face, 2))), t);
      }
      if (passes) {
        if (t < nearest && beginsBehind(last, t, k, face)) {
          nearest = t;
          next = k;
        }
      }
    }
    goes = next != NO_FACE;
    if (goes) {
      last.t = nearest;
      last.number = next;
      if (hexes)
        last.ended = walkHexahedra(op, f, m, shellFace(op, next), w, L, samples, cells);
      else
        last.ended = walkMesh(op, f, m, shellFace(op, next), w, L, samples, cells);
      goes = w.goes;
    }
  }
  if (p == 44) return L.A;
  if (p == 45) return (L.rgb.x + L.rgb.y) + L.rgb.z;
  if (p == 46) return toReal(samples + 1000 * cells) + (last.t > R(-1e30) ? last.t : R(0.0));
  return w.largest > R(-1e30) ? w.largest : R(0.0);
}

FN real sceneProbe(SCENE s, FRAME f, OPERATOR op, VOLUME v, VOLUMES list, UNIFORM int count, int p, uint i) {
  vec3 o = drawPoint(i, 1u, R(0.7)), d = unit3(drawPoint(i, 4u, R(1.0)));
  if (p < 6) return probeCamera(f, p, i);
  if (p >= 44) return probeMesh(s, op, p, o, d, i);
  if (p >= 40) return probeSample(op, v, p, o, d, i);
  if (p < 13) return probeLattice(s, p, o, d, i);
  if (p < 25) return probeCuts(s, op, v, list, count, p, o, d, i);
  return probeSurface(s, f, op, v, p, o, d, i);
}
