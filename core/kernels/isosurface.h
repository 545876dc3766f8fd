// SPDX-License-Identifier: Apache-2.0
// The first isosurface along a ray: a walk cell by cell to the first root of a cell's cubic (cell_curve.h). Only
// macrocells and cells whose range holds the isovalue are looked at (Parker 1998). Fractions on a face that a
// ray crosses are exactly 0 or 1, so the two cells that share the face compute the same value there, and no
// sign change is lost between them.
//
// isoMask (core/rays/iso_mask.h) says where an isovalue may pass, in one word per macrocell and one bit per
// cell. Each dialect supplies isoWord(v, index) to read its words. Samples are read only in such cells.

// The cell (bits 0) or macrocell (bits MACRO_BITS) of one axis, between first and last, that the ray is in at
// t, for a ray that is inside these. The estimate is off by one at most.
FN int cellInside(real t, real po, real pd, real rpd, int first, int last, UNIFORM int bits) {
  real p = po + t * pd;
  UNIFORM real size = bits == 0 ? R(1.0) : R(0.125);
  real q = floor(p * size);
  int i = toInt(clamp1(q, toReal(first), toReal(last)));
  bool backward = rpd < R(0.0);
  real below = planeCrossing(i << bits, po, rpd), above = planeCrossing((i + 1) << bits, po, rpd);
  bool down = backward ? below <= t : below > t, up = backward ? above > t : above <= t;
  if (down && i > first)
    i -= 1;
  else if (up && i < last)
    i += 1;
  return i;
}

// The cell of one axis in which the ray enters macrocell m at t: the outermost one if the ray crosses the
// near plane there.
FN int cellEntered(real t, int m, int up, real po, real pd, real rpd) {
  int first = m << MACRO_BITS;
  real near = planeCrossing(first + 8 - (up << MACRO_BITS), po, rpd);
  int i = up > 0 ? first : first + 7;
  if (near < t) i = cellInside(t, po, pd, rpd, first, first + 7, 0);
  return i;
}

// The macrocell of one axis in which the ray is after it has left an aligned cube of 2^level macrocells a
// side at t (`cube` counts in cubes): across the exit plane if the ray crosses that at t, otherwise still
// within the range of the cube on this axis.
FN int macrocellBehind(real t, real far, int cube, int level, int up, real po, real pd, real rpd) {
  int first = cube << level;
  int last = first + (1 << level) - 1;
  int m = up > 0 ? last + 1 : first - 1;
  if (far > t) {
    m = cube;
    if (level > 0) m = cellInside(t, po, pd, rpd, first, last, MACRO_BITS);
  }
  return m;
}

// The fraction of a cell at which a segment begins or ends on one axis. It is exact on a plane that the ray
// crosses there.
FN real crossedFraction(bool crossed, int side, real p, int cell) {
  real f = p - toReal(cell);
  return crossed ? toReal(side) : clamp1(f, R(0.0), R(1.0));
}

// Whether the block holds the cell, with finite values at all corners.
FN bool cellHoldsData(VOLUME v, ivec3 c) {
  bool inside = c.x >= v.firstX && c.y >= v.firstY && c.z >= v.firstZ && c.x < v.lastX && c.y < v.lastY &&
                c.z < v.lastZ;
  bool holds = false;
  if (inside) holds = holdsData(cellValues(v, c));
  return holds;
}

#define ISO_END 1  // instead of the place of a macrocell's bits: the walk is over

// The word of isoMask for macrocell m. > 0: isovalues pass, and the bits of its cells start at this word.
// Otherwise no isovalue passes, neither in m nor in the aligned cube of 2^-isoBlock macrocells a side around
// it.
FN int isoBlock(VOLUME v, ivec3 m) { return isoWord(v, macroIndex(v, m)); }

// The place of a cell in its macrocell, or one step outside of it: x + 8, y + 8 and z + 8 in 5 bits each. So
// a walk adds what it steps on all axes at once, and no axis borrows from another.
#define PLACE_Y 5
#define PLACE_Z 10
#define PLACE_INSIDE 0x2108  // what all places in the macrocell have in PLACE_OUTER
#define PLACE_OUTER 0x6318
#define PLACE_INNER 0x1ce7
FN int placeIn(int x, int y, int z) { return PLACE_INSIDE + (x + (y << PLACE_Y) + (z << PLACE_Z)); }
FN bool isOutside(int place) { return (place & PLACE_OUTER) != PLACE_INSIDE; }
// The cell of an axis in its macrocell, and by how many macrocells the place is outside; its part of the place
// begins at bit `bits`.
FN int cellOnAxis(int place, UNIFORM int bits) { return (place >> bits) & 7; }
FN int macrocellsOff(int place, UNIFORM int bits) { return ((place >> (bits + 3)) & 3) - 1; }
FN int placeBack(int place) { return (place & PLACE_INNER) | PLACE_INSIDE; }
// 1 if an isovalue may pass through the cell at a place in a macrocell, by its bit, otherwise 0.
FN int isoCell(VOLUME v, int block, int place) {
  int bits = isoWord(v, block + (((place >> 9) & 14) | ((place >> 7) & 1)));
  return (bits >> ((place & 7) | ((place >> 2) & 24))) & 1;
}

// The first isosurface in one cell, which the ray crosses between ta and tb. Of the isovalues from `first` on
// it is the first whose cubic has a crossing, for isovalue `first` at or behind `done`. The result has the
// cubic and the crossing's bracket; index = v.isovalues if there is none. With `anyHit`, the bracket may be the
// whole of the cell, because any crossing will do.
FN IsoCrossing cellCrossing(VOLUME v, VolumeRay r, ivec3 c, ivec3 up, real ta, real tb, int first, real done,
                            real tIn, real tOut, real tAfter, IsoStart start, bool anyHit) {
  CellValues k = cellValues(v, c);
  real lo = minCorner(k), hi = maxCorner(k);
  vec3 near = make_v3(planeCrossing(c.x + 1 - up.x, r.g.po.x, r.g.rpd.x),
                      planeCrossing(c.y + 1 - up.y, r.g.po.y, r.g.rpd.y),
                      planeCrossing(c.z + 1 - up.z, r.g.po.z, r.g.rpd.z));
  vec3 far =
      make_v3(planeCrossing(c.x + up.x, r.g.po.x, r.g.rpd.x), planeCrossing(c.y + up.y, r.g.po.y, r.g.rpd.y),
              planeCrossing(c.z + up.z, r.g.po.z, r.g.rpd.z));
  vec3 from = pointAt(r.g, ta), to = pointAt(r.g, tb);
  vec3 f = make_v3(crossedFraction(near.x >= ta, 1 - up.x, from.x, c.x),
                   crossedFraction(near.y >= ta, 1 - up.y, from.y, c.y),
                   crossedFraction(near.z >= ta, 1 - up.z, from.z, c.z));
  vec3 g =
      make_v3(crossedFraction(far.x <= tb, up.x, to.x, c.x), crossedFraction(far.y <= tb, up.y, to.y, c.y),
              crossedFraction(far.z <= tb, up.z, to.z, c.z));
  bool holds = tb >= ta && holdsData(k);
  real along = (ta - r.t0) * r.cells;
  // The results of the loop are not members of structures (decision 0012).
  vec4 cubic = make_v4(R(0.0), R(0.0), R(0.0), R(0.0));
  vec4 bracket = cubic;
  int index = v.isovalues;
  for (UNIFORM int i = 0; i < v.isovalues; i++) {
    real iso = isovalueAt(v, i);
    if (holds && i >= first && index == v.isovalues && lo <= iso && hi >= iso) {
      cubic = bernsteinAlong(cellValuesMinus(k, iso), f, g);
      bool starts = startsInCell(along), entry = ta <= r.t0;
      int side = sideInCell(start, i, along, tAfter);
      if (!entry && dependsOnCellBefore(cubic, side, starts)) {
        entry = !cellHoldsData(
            v, make_i3(near.x >= ta ? c.x + 1 - up.x - up.x : c.x, near.y >= ta ? c.y + 1 - up.y - up.y : c.y,
                       near.z >= ta ? c.z + 1 - up.z - up.z : c.z));
        if (entry && !starts) side = 0;
      }
      bracket = make_v4(R(0.0), R(1.0), cubic.x, cubic.w);
      if (!(anyHit && side == 0 && changesSign(cubic))) {
        Bracket at =
            crossingInCell(cubic, ta, i == first ? done : R(0.0), entry, side, starts, tIn, tOut, tAfter);
        bracket = make_v4(at.lo, at.hi, at.fLo, at.fHi);
      }
      if (bracket.x <= bracket.y) index = i;
    }
  }
  IsoCrossing x;
  x.cubic = cubic;
  x.at.lo = bracket.x;
  x.at.hi = bracket.y;
  x.at.fLo = bracket.z;
  x.at.fHi = bracket.w;
  x.index = index;
  return x;
}

// The first isosurface along a ray. With `anyHit` it only matters whether there is one: it may be any that the
// ray meets, at any t in its cell. No root is computed then, except in cells in which not every root counts.
FN IsoHit isosurfaceAlong(VOLUME v, VolumeRay r, real tIn, real tOut, real tAfter, IsoStart start,
                          UNIFORM bool anyHit, INOUT(int) cellsVisited, INOUT(int) macrocellsSkipped) {
  IsoHit hit;
  hit.t = NO_HIT;
  hit.index = -1;
  // The cell before a partition's face is walked, too: its cubic may end in a root exactly on the face.
  real t = max(max(tIn * R(0.9999998), tAfter), r.t0);
  real end = min(r.t1, tOut);
  if (!(t <= end)) return hit;
  ivec3 n = gridCells(v);
  ivec3 up = make_i3(r.g.rpd.x < R(0.0) ? 0 : 1, r.g.rpd.y < R(0.0) ? 0 : 1, r.g.rpd.z < R(0.0) ? 0 : 1);
  ivec3 c = make_i3(locateCell(t, r.g.po.x, r.g.pd.x, r.g.rpd.x, n.x),
                    locateCell(t, r.g.po.y, r.g.pd.y, r.g.rpd.y, n.y),
                    locateCell(t, r.g.po.z, r.g.pd.z, r.g.rpd.z, n.z));
  vec3 first = make_v3(planeCrossing(c.x + 1 - up.x, r.g.po.x, r.g.rpd.x),
                       planeCrossing(c.y + 1 - up.y, r.g.po.y, r.g.rpd.y),
                       planeCrossing(c.z + 1 - up.z, r.g.po.z, r.g.rpd.z));
  real ta = max(max3(first), r.t0);
  int stepX = up.x + up.x - 1, stepY = up.y + up.y - 1, stepZ = up.z + up.z - 1;
  real strideX = toReal(stepX), strideY = toReal(stepY), strideZ = toReal(stepZ);
  int mx = c.x >> MACRO_BITS, my = c.y >> MACRO_BITS, mz = c.z >> MACRO_BITS;
  int place = placeIn(c.x & 7, c.y & 7, c.z & 7);
  int placeX = stepX, placeY = stepY << PLACE_Y, placeZ = stepZ << PLACE_Z;
  int block = isoBlock(v, make_i3(mx, my, mz));
  real tMet = NO_HIT, tLimit = tOut;
  int met = -1;
  vec4 cubic = make_v4(R(0.0), R(0.0), R(0.0), R(0.0));  // the cubic of the crossing
  vec4 bracket = cubic;
  int index = 0;
  real done = R(0.0);
  bool go = true;
  while (go) {
    // Rays of a gang wait for each other at cells that an isovalue may pass through, and again when they have
    // bracketed a crossing.
    bool bracketed = false, whole = false;
    real tb = ta;
    while (go && !bracketed) {
      int found = 0;
      while (found == 0) {
        if (block <= 0) {
          while (block <= 0) {
            int level = -block;
            int cubeX = mx >> level, cubeY = my >> level, cubeZ = mz >> level;
            int bits = level + MACRO_BITS;
            real farX = planeCrossing((cubeX + up.x) << bits, r.g.po.x, r.g.rpd.x);
            real farY = planeCrossing((cubeY + up.y) << bits, r.g.po.y, r.g.rpd.y);
            real farZ = planeCrossing((cubeZ + up.z) << bits, r.g.po.z, r.g.rpd.z);
            ta = min(min(farX, farY), farZ);
            mx = macrocellBehind(ta, farX, cubeX, level, up.x, r.g.po.x, r.g.pd.x, r.g.rpd.x);
            my = macrocellBehind(ta, farY, cubeY, level, up.y, r.g.po.y, r.g.pd.y, r.g.rpd.y);
            mz = macrocellBehind(ta, farZ, cubeZ, level, up.z, r.g.po.z, r.g.pd.z, r.g.rpd.z);
            macrocellsSkipped += 1;
            block = ISO_END;
            if (ta < end) block = isoBlock(v, make_i3(mx, my, mz));
          }
          place = placeIn(cellEntered(ta, mx, up.x, r.g.po.x, r.g.pd.x, r.g.rpd.x) - (mx << MACRO_BITS),
                          cellEntered(ta, my, up.y, r.g.po.y, r.g.pd.y, r.g.rpd.y) - (my << MACRO_BITS),
                          cellEntered(ta, mz, up.z, r.g.po.z, r.g.pd.z, r.g.rpd.z) - (mz << MACRO_BITS));
        }
        if (block != ISO_END) {
          real planeX = toReal((mx << MACRO_BITS) + cellOnAxis(place, 0) + up.x);
          real planeY = toReal((my << MACRO_BITS) + cellOnAxis(place, PLACE_Y) + up.y);
          real planeZ = toReal((mz << MACRO_BITS) + cellOnAxis(place, PLACE_Z) + up.z);
          int walk = 1 - isoCell(v, block, place);
          // The cell that comes next. Rays that have found theirs go on to it, too, so that no step waits for
          // the result of the step before. Rays look up no macrocell any more where no isovalue passes, and
          // none at all that take no part here: theirs may be outside of the grid.
          int next, macroX, macroY, macroZ, nextBlock;
          real nextT, last;
          UNMASKED {
            next = PLACE_INSIDE;
            macroX = 0;
            macroY = 0;
            macroZ = 0;
            nextBlock = ISO_END;
            nextT = R(0.0);
            last = R(0.0);
          }
          next = place;
          macroX = mx;
          macroY = my;
          macroZ = mz;
          blendInto(nextBlock, block);
          last = end;
          while (walk != 0) {
            int holds = 0;
            UNMASKED {
              real farX = (planeX - r.g.po.x) * r.g.rpd.x;
              real farY = (planeY - r.g.po.y) * r.g.rpd.y;
              real farZ = (planeZ - r.g.po.z) * r.g.rpd.z;
              nextT = min(min(farX, farY), farZ);
              next += farX <= nextT ? placeX : 0;
              next += farY <= nextT ? placeY : 0;
              next += farZ <= nextT ? placeZ : 0;
              planeX += farX <= nextT ? strideX : R(0.0);
              planeY += farY <= nextT ? strideY : R(0.0);
              planeZ += farZ <= nextT ? strideZ : R(0.0);
              if (isOutside(next)) {
                macroX += macrocellsOff(next, 0);
                macroY += macrocellsOff(next, PLACE_Y);
                macroZ += macrocellsOff(next, PLACE_Z);
                next = placeBack(next);
                if (nextBlock > ISO_END) {
                  nextBlock = ISO_END;
                  if (nextT < last) nextBlock = isoBlock(v, make_i3(macroX, macroY, macroZ));
                }
              }
              if (nextBlock > ISO_END) holds = isoCell(v, nextBlock, next);
            }
            place = next;
            mx = macroX;
            my = macroY;
            mz = macroZ;
            block = nextBlock;
            ta = nextT;
            walk = block > ISO_END && holds == 0 ? 1 : 0;
          }
        }
        found = block > 0 ? 1 : 0;
      }
      go = block != ISO_END;
      if (go) {
        cellsVisited += 1;
        c = make_i3((mx << MACRO_BITS) + cellOnAxis(place, 0),
                    (my << MACRO_BITS) + cellOnAxis(place, PLACE_Y),
                    (mz << MACRO_BITS) + cellOnAxis(place, PLACE_Z));
        real farX = planeCrossing(c.x + up.x, r.g.po.x, r.g.rpd.x);
        real farY = planeCrossing(c.y + up.y, r.g.po.y, r.g.rpd.y);
        real farZ = planeCrossing(c.z + up.z, r.g.po.z, r.g.rpd.z);
        real exit = min(min(farX, farY), farZ);
        tb = min(exit, r.t1);
        whole = anyHit && acceptsRoot(ta, tIn, tLimit, tAfter) && tb < tLimit;
        IsoCrossing x = cellCrossing(v, r, c, up, ta, tb, index, done, tIn, tLimit, tAfter, start, whole);
        cubic = x.cubic;
        bracket = make_v4(x.at.lo, x.at.hi, x.at.fLo, x.at.fHi);
        index = x.index;
        bracketed = index < v.isovalues;
        if (!bracketed) {
          go = tMet >= NO_HIT && exit < end;
          index = 0;
          done = R(0.0);
          ta = exit;
          place += farX <= exit ? placeX : 0;
          place += farY <= exit ? placeY : 0;
          place += farZ <= exit ? placeZ : 0;
          if (isOutside(place)) {
            mx += macrocellsOff(place, 0);
            my += macrocellsOff(place, PLACE_Y);
            mz += macrocellsOff(place, PLACE_Z);
            place = placeBack(place);
            if (go) block = isoBlock(v, make_i3(mx, my, mz));
          }
        }
      }
    }
    if (bracketed) {
      Bracket at;
      at.lo = bracket.x;
      at.hi = bracket.y;
      at.fLo = bracket.z;
      at.fHi = bracket.w;
      real th = ta;
      if (!whole) th = crossingTime(cubic, at, ta, tb);
      bool accepted = whole || acceptsRoot(th, tIn, tLimit, tAfter);
      if (accepted) {
        tMet = th;
        met = index;
        tLimit = min(tOut, th);
      }
      // The rest of this cell.
      bool more = !accepted && bracket.y < R(1.0);
      done = more ? bracket.y : R(0.0);
      index += more ? 0 : 1;
      go = !accepted || (!anyHit && index < v.isovalues);
    }
  }
  hit.t = tMet;
  hit.index = met;
  return hit;
}

FN IsoHit firstIsosurface(VOLUME v, VolumeRay r, real tIn, real tOut, real tAfter, IsoStart start,
                          INOUT(int) cellsVisited, INOUT(int) macrocellsSkipped) {
  return isosurfaceAlong(v, r, tIn, tOut, tAfter, start, false, cellsVisited, macrocellsSkipped);
}

FN real centralDifference(real before, real here, real after, bool hasBefore, bool hasAfter) {
  bool b = hasBefore && before - before == R(0.0), a = hasAfter && after - after == R(0.0);
  bool h = here - here == R(0.0);
  if (b && a) return R(0.5) * (after - before);
  if (a && h) return after - here;
  if (b && h) return here - before;
  return R(0.0);
}

// The cells on the six sides of a cell. A block has them except on the domain's boundary; missing ones do not
// count.
struct CellNeighbours {
  CellValues lowX, highX, lowY, highY, lowZ, highZ;
  bool hasLowX, hasHighX, hasLowY, hasHighY, hasLowZ, hasHighZ;
};
FN CellNeighbours neighboursOf(VOLUME v, ivec3 c) {
  CellNeighbours n;
  n.hasLowX = c.x > v.firstX;
  n.hasHighX = c.x + 1 < v.lastX;
  n.hasLowY = c.y > v.firstY;
  n.hasHighY = c.y + 1 < v.lastY;
  n.hasLowZ = c.z > v.firstZ;
  n.hasHighZ = c.z + 1 < v.lastZ;
  n.lowX = cellValues(v, make_i3(n.hasLowX ? c.x - 1 : c.x, c.y, c.z));
  n.highX = cellValues(v, make_i3(n.hasHighX ? c.x + 1 : c.x, c.y, c.z));
  n.lowY = cellValues(v, make_i3(c.x, n.hasLowY ? c.y - 1 : c.y, c.z));
  n.highY = cellValues(v, make_i3(c.x, n.hasHighY ? c.y + 1 : c.y, c.z));
  n.lowZ = cellValues(v, make_i3(c.x, c.y, n.hasLowZ ? c.z - 1 : c.z));
  n.highZ = cellValues(v, make_i3(c.x, c.y, n.hasHighZ ? c.z + 1 : c.z));
  return n;
}

FN real differenceAlong(bool hasBefore, real before, real low, real high, real after, bool hasAfter,
                        bool atHigh) {
  real b = before, h = low, a = high;
  if (atHigh) {
    b = low;
    h = high;
    a = after;
  }
  return centralDifference(b, h, a, hasBefore || atHigh, hasAfter || !atHigh);
}
// The gradient, per cell, at point (x, y, z), each 0 or 1, of the cell with corners k and these neighbours.
// It has central differences, one-sided on the domain's boundary or beside missing data, and 0 where there
// are none.
FN vec3 cornerGradient(CellValues k, CellNeighbours n, UNIFORM int x, UNIFORM int y, UNIFORM int z) {
  vec3 g;
#define ALONG(axis, atHigh, a, b) \
  differenceAlong(n.hasLow##axis, n.low##axis.a, k.a, k.b, n.high##axis.b, n.hasHigh##axis, atHigh)
  bool x1 = x == 1, y1 = y == 1, z1 = z == 1;
  if (y == 0 && z == 0) g.x = ALONG(X, x1, v000, v100);
  if (y == 1 && z == 0) g.x = ALONG(X, x1, v010, v110);
  if (y == 0 && z == 1) g.x = ALONG(X, x1, v001, v101);
  if (y == 1 && z == 1) g.x = ALONG(X, x1, v011, v111);
  if (x == 0 && z == 0) g.y = ALONG(Y, y1, v000, v010);
  if (x == 1 && z == 0) g.y = ALONG(Y, y1, v100, v110);
  if (x == 0 && z == 1) g.y = ALONG(Y, y1, v001, v011);
  if (x == 1 && z == 1) g.y = ALONG(Y, y1, v101, v111);
  if (x == 0 && y == 0) g.z = ALONG(Z, z1, v000, v001);
  if (x == 1 && y == 0) g.z = ALONG(Z, z1, v100, v101);
  if (x == 0 && y == 1) g.z = ALONG(Z, z1, v010, v011);
  if (x == 1 && y == 1) g.z = ALONG(Z, z1, v110, v111);
#undef ALONG
  return g;
}

// The cell of one axis, between first and last, in which the ray is just before t or, if `behind`, just after
// it. `i` is off by one at most.
FN int cellBeside(real t, int i, real po, real rpd, int first, int last, bool behind) {
  int forward = rpd < R(0.0) ? -1 : 1;
  real near = planeCrossing(nearPlane(i, rpd), po, rpd), far = planeCrossing(farPlane(i, rpd), po, rpd);
  int c = i;
  if (near > t || (near == t && !behind))
    c = i - forward;
  else if (far < t || (far == t && behind))
    c = i + forward;
  return max(min(c, last), first);
}

// The cell in which the ray met an isosurface at t, whatever rounding makes of the point there: the one that
// the ray leaves at t or later (rootBehind) or, if that holds no data, the one behind.
FN ivec3 cellMet(VOLUME v, GridRay g, real t) {
  ivec3 i = cellAt(v, pointAt(g, t));
  bool behind = false;
  ivec3 c = make_i3(cellBeside(t, i.x, g.po.x, g.rpd.x, v.firstX, v.lastX - 1, behind),
                    cellBeside(t, i.y, g.po.y, g.rpd.y, v.firstY, v.lastY - 1, behind),
                    cellBeside(t, i.z, g.po.z, g.rpd.z, v.firstZ, v.lastZ - 1, behind));
  if (!holdsData(cellValues(v, c))) {
    behind = true;
    c = make_i3(cellBeside(t, i.x, g.po.x, g.rpd.x, v.firstX, v.lastX - 1, behind),
                cellBeside(t, i.y, g.po.y, g.rpd.y, v.firstY, v.lastY - 1, behind),
                cellBeside(t, i.z, g.po.z, g.rpd.z, v.firstZ, v.lastZ - 1, behind));
  }
  return c;
}

// Adds the gradient d at point (x, y, z) of a cell, by its weight at fractions f, and updates the largest.
FN void addGradient(vec3 d, vec3 f, UNIFORM int x, UNIFORM int y, UNIFORM int z, INOUT(vec3) g,
                    INOUT(vec3) most) {
  real w = ((x == 1 ? f.x : R(1.0) - f.x) * (y == 1 ? f.y : R(1.0) - f.y)) * (z == 1 ? f.z : R(1.0) - f.z);
  g.x += w * d.x;
  g.y += w * d.y;
  g.z += w * d.z;
  most = make_v3(max(most.x, abs(d.x)), max(most.y, abs(d.y)), max(most.z, abs(d.z)));
}

#define FLAT_GRADIENT R(1e-5)  // gradients below this part of the largest at the cell's points count as none

// The shading gradient at p (index space), which is in cell c, per unit of render space. It is trilinear in
// the gradients of the cell's points, so that it is continuous across cells. It is 0 where those cancel, or
// end at the border of a plateau, because what is left is a rounding error in any direction.
FN vec3 gradientIn(VOLUME v, ivec3 c, vec3 p) {
  vec3 f = fractionIn(c, p);
  vec3 g = make_v3(R(0.0), R(0.0), R(0.0)), most = make_v3(R(0.0), R(0.0), R(0.0));
  CellValues k = cellValues(v, c);
  CellNeighbours n = neighboursOf(v, c);
  for (UNIFORM int i = 0; i < 8; i++) {
    UNIFORM int x = i & 1, y = (i >> 1) & 1, z = i >> 2;
    addGradient(cornerGradient(k, n, x, y, z), f, x, y, z, g, most);
  }
  vec3 gradient = make_v3(g.x * v.inverseX, g.y * v.inverseY, g.z * v.inverseZ);
  real least = FLAT_GRADIENT * max(max(most.x * v.inverseX, most.y * v.inverseY), most.z * v.inverseZ);
  if (max(max(abs(gradient.x), abs(gradient.y)), abs(gradient.z)) <= least)
    gradient = make_v3(R(0.0), R(0.0), R(0.0));
  return gradient;
}

FN vec3 gradientAt(VOLUME v, vec3 p) { return gradientIn(v, cellAt(v, p), p); }

// The gradient of the trilinear interpolant itself at p in cell c, per unit of render space.
FN vec3 cellGradientIn(VOLUME v, ivec3 c, vec3 p) {
  CellValues k = cellValues(v, c);
  vec3 f = fractionIn(c, p);
  real x =
      lerp1(lerp1(k.v100 - k.v000, k.v110 - k.v010, f.y), lerp1(k.v101 - k.v001, k.v111 - k.v011, f.y), f.z);
  real y =
      lerp1(lerp1(k.v010 - k.v000, k.v110 - k.v100, f.x), lerp1(k.v011 - k.v001, k.v111 - k.v101, f.x), f.z);
  real z =
      lerp1(lerp1(k.v001 - k.v000, k.v101 - k.v100, f.x), lerp1(k.v011 - k.v010, k.v111 - k.v110, f.x), f.y);
  return make_v3(x * v.inverseX, y * v.inverseY, z * v.inverseZ);
}
