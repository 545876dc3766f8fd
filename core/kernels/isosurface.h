// SPDX-License-Identifier: Apache-2.0
// The first isosurface along a ray: cell by cell, the first root of each cell's cubic (cubic.h), in macrocells and cells
// whose range holds the isovalue and in no others (Parker 1998). Fractions on a face that a ray crosses are exactly 0 or
// 1, so the two cells that share the face compute the same value there, and no sign change is lost between them.

struct IsoHit {
  real t;     // NO_HIT if none
  int index;  // of the isovalue
};

// What the start of a secondary ray knows: it left isosurface `index` (-1: none) on the side of sign `from`.
struct IsoStart {
  int index, from;
};

// The cell of one axis, of those of a macrocell, that the ray is in at t, where it is inside this macrocell: the estimate is
// off by one at most.
FN int cellInside(real t, real po, real pd, real rpd, int first, int last) {
  real q = floor(po + t * pd);
  int i = toInt(clamp1(q, toReal(first), toReal(last)));
  bool backward = rpd < R(0.0);
  real below = planeCrossing(i, po, rpd), above = planeCrossing(i + 1, po, rpd);
  bool down = backward ? below <= t : below > t, up = backward ? above > t : above <= t;
  if (down && i > first)
    i -= 1;
  else if (up && i < last)
    i += 1;
  return i;
}

// The cell of one axis after macrocell m is left at t: across the exit plane if t is its crossing, else still inside.
FN int cellBehind(real t, real far, int m, int up, real po, real pd, real rpd) {
  int first = m << MACRO_BITS;
  int i = cellInside(t, po, pd, rpd, first, first + 7);
  if (far <= t) i = up > 0 ? first + 8 : first - 1;
  return i;
}

// The fraction of a cell at which a segment begins or ends on one axis: exact on a plane that is crossed there.
FN real crossedFraction(bool crossed, int side, real p, int cell) {
  real f = p - toReal(cell);
  return crossed ? toReal(side) : clamp1(f, R(0.0), R(1.0));
}

// Whether the block holds the cell, and all its corners are finite.
FN bool cellHoldsData(VOLUME v, ivec3 c) {
  bool inside = c.x >= v.firstX && c.y >= v.firstY && c.z >= v.firstZ && c.x < v.lastX && c.y < v.lastY &&
                c.z < v.lastZ;
  bool holds = false;
  if (inside) holds = holdsData(cellCorners(v, c));
  return holds;
}

FN IsoHit firstIsosurface(VOLUME v, VolumeRay r, real tIn, real tOut, real tAfter, IsoStart start,
                          INOUT(int) cellsVisited, INOUT(int) macrocellsSkipped) {
  IsoHit hit;
  hit.t = NO_HIT;
  hit.index = -1;
  // The cell before a partition's face is walked too: its cubic may end in a root exactly on the face.
  real t = max(max(tIn * R(0.9999998), tAfter), r.t0);
  real end = min(r.t1, tOut);
  if (!(t <= end)) return hit;
  ivec3 n = gridCells(v);
  ivec3 c = make_i3(locateCell(t, r.g.po.x, r.g.pd.x, r.g.rpd.x, n.x),
                    locateCell(t, r.g.po.y, r.g.pd.y, r.g.rpd.y, n.y),
                    locateCell(t, r.g.po.z, r.g.pd.z, r.g.rpd.z, n.z));
  ivec3 up = make_i3(r.g.rpd.x < R(0.0) ? 0 : 1, r.g.rpd.y < R(0.0) ? 0 : 1, r.g.rpd.z < R(0.0) ? 0 : 1);
  vec3 first = make_v3(planeCrossing(c.x + 1 - up.x, r.g.po.x, r.g.rpd.x),
                       planeCrossing(c.y + 1 - up.y, r.g.po.y, r.g.rpd.y),
                       planeCrossing(c.z + 1 - up.z, r.g.po.z, r.g.rpd.z));
  real ta = max(max3(first), r.t0);
  bool go = true;
  bool mayHold = straddles(v, make_i3(c.x >> MACRO_BITS, c.y >> MACRO_BITS, c.z >> MACRO_BITS));
  while (go) {
    ivec3 was = make_i3(c.x >> MACRO_BITS, c.y >> MACRO_BITS, c.z >> MACRO_BITS);
    real exit;
    if (!mayHold) {
      macrocellsSkipped += 1;
      vec3 far = make_v3(planeCrossing((was.x + up.x) << MACRO_BITS, r.g.po.x, r.g.rpd.x),
                         planeCrossing((was.y + up.y) << MACRO_BITS, r.g.po.y, r.g.rpd.y),
                         planeCrossing((was.z + up.z) << MACRO_BITS, r.g.po.z, r.g.rpd.z));
      exit = min3(far);
      c = make_i3(cellBehind(exit, far.x, was.x, up.x, r.g.po.x, r.g.pd.x, r.g.rpd.x),
                  cellBehind(exit, far.y, was.y, up.y, r.g.po.y, r.g.pd.y, r.g.rpd.y),
                  cellBehind(exit, far.z, was.z, up.z, r.g.po.z, r.g.pd.z, r.g.rpd.z));
    } else {
      cellsVisited += 1;
      Corners k = cellCorners(v, c);
      vec3 far = make_v3(planeCrossing(c.x + up.x, r.g.po.x, r.g.rpd.x),
                         planeCrossing(c.y + up.y, r.g.po.y, r.g.rpd.y),
                         planeCrossing(c.z + up.z, r.g.po.z, r.g.rpd.z));
      exit = min3(far);
      real tb = min(exit, r.t1);
      real lo = minCorner(k), hi = maxCorner(k);
      for (UNIFORM int i = 0; i < v.isovalues; i++) {
        real iso = v.isovalue[i];
        if (lo <= iso && hi >= iso && tb >= ta && holdsData(k)) {
          vec3 near = make_v3(planeCrossing(c.x + 1 - up.x, r.g.po.x, r.g.rpd.x),
                              planeCrossing(c.y + 1 - up.y, r.g.po.y, r.g.rpd.y),
                              planeCrossing(c.z + 1 - up.z, r.g.po.z, r.g.rpd.z));
          vec3 from = pointAt(r.g, ta), to = pointAt(r.g, tb);
          vec3 p = make_v3(crossedFraction(near.x >= ta, 1 - up.x, from.x, c.x),
                           crossedFraction(near.y >= ta, 1 - up.y, from.y, c.y),
                           crossedFraction(near.z >= ta, 1 - up.z, from.z, c.z));
          vec3 q = make_v3(crossedFraction(far.x <= tb, up.x, to.x, c.x),
                           crossedFraction(far.y <= tb, up.y, to.y, c.y),
                           crossedFraction(far.z <= tb, up.z, to.z, c.z));
          RootQuery query;
          query.tIn = tIn;
          query.tOut = min(tOut, hit.t);
          query.tAfter = tAfter;
          query.from = start.index == i && tAfter < R(0.0) ? start.from : 0;  // until it has met a surface
          query.start = (ta - r.t0) * r.cells <= R(1e-3);
          Bernstein b = bernsteinAlong(k, p, q, iso);
          query.entry = ta <= r.t0;
          if (!query.entry && b.b0 == R(0.0)) {
            query.entry = !cellHoldsData(v, make_i3(near.x >= ta ? c.x + 1 - up.x - up.x : c.x,
                                                    near.y >= ta ? c.y + 1 - up.y - up.y : c.y,
                                                    near.z >= ta ? c.z + 1 - up.z - up.z : c.z));
          }
          real th = firstRoot(b, ta, tb, query);
          if (th < hit.t) {
            hit.t = th;
            hit.index = i;
          }
        }
      }
      if (far.x <= exit) c.x += up.x + up.x - 1;
      if (far.y <= exit) c.y += up.y + up.y - 1;
      if (far.z <= exit) c.z += up.z + up.z - 1;
    }
    ta = exit;
    go = hit.t >= NO_HIT && exit < end;
    ivec3 m = make_i3(c.x >> MACRO_BITS, c.y >> MACRO_BITS, c.z >> MACRO_BITS);
    if (go && (m.x != was.x || m.y != was.y || m.z != was.z)) mayHold = straddles(v, m);
  }
  return hit;
}

FN real centralDifference(real before, real here, real after, bool hasBefore, bool hasAfter) {
  bool b = hasBefore && before - before == R(0.0), a = hasAfter && after - after == R(0.0);
  if (b && a) return R(0.5) * (after - before);
  if (a) return after - here;
  if (b) return here - before;
  return R(0.0);
}

// The gradient at a grid point, per cell: central differences, one-sided on the domain's boundary or beside no data.
FN vec3 pointGradient(VOLUME v, ivec3 p) {
  real s = pointValue(v, p);
  bool x0 = p.x > 0, x1 = p.x<v.cellsX, y0 = p.y> 0, y1 = p.y<v.cellsY, z0 = p.z> 0, z1 = p.z < v.cellsZ;
  real ax = s, bx = s, ay = s, by = s, az = s, bz = s;
  if (x0) ax = pointValue(v, make_i3(p.x - 1, p.y, p.z));
  if (x1) bx = pointValue(v, make_i3(p.x + 1, p.y, p.z));
  if (y0) ay = pointValue(v, make_i3(p.x, p.y - 1, p.z));
  if (y1) by = pointValue(v, make_i3(p.x, p.y + 1, p.z));
  if (z0) az = pointValue(v, make_i3(p.x, p.y, p.z - 1));
  if (z1) bz = pointValue(v, make_i3(p.x, p.y, p.z + 1));
  return make_v3(centralDifference(ax, s, bx, x0, x1), centralDifference(ay, s, by, y0, y1),
                 centralDifference(az, s, bz, z0, z1));
}

// The shading gradient at p (index space), per unit of render space: trilinear in the gradients of the cell's points, so
// that it is continuous across cells.
FN vec3 gradientAt(VOLUME v, vec3 p) {
  ivec3 c = cellAt(v, p);
  vec3 f = fractionIn(c, p);
  vec3 g = make_v3(R(0.0), R(0.0), R(0.0));
  for (UNIFORM int i = 0; i < 8; i++) {
    UNIFORM int x = i & 1, y = (i >> 1) & 1, z = i >> 2;
    vec3 d = pointGradient(v, make_i3(c.x + x, c.y + y, c.z + z));
    real w = ((x == 1 ? f.x : R(1.0) - f.x) * (y == 1 ? f.y : R(1.0) - f.y)) * (z == 1 ? f.z : R(1.0) - f.z);
    g.x += w * d.x;
    g.y += w * d.y;
    g.z += w * d.z;
  }
  return make_v3(g.x * v.inverseX, g.y * v.inverseY, g.z * v.inverseZ);
}
