// SPDX-License-Identifier: Apache-2.0
// The way of a ray from partition to partition, through the lattice of all partitions' faces.

// The lattice cell at t on one axis, of `cells` cells. A ray that crosses a face exactly at t is behind it. A
// ray that runs in a face is in the upper cell.
FN int latticeCell(SCENE s, UNIFORM int axis, UNIFORM int cells, real t, real o, real d) {
  bool runsAlong = parallelTo(d);
  bool up = runsAlong || d > R(0.0);
  int low = 0, high = cells - 1;
  while (low < high) {  // binary search: crossings are in the order of faces (box.h)
    int middle = (low + high + 1) / 2;
    real face = latticeFace(s, axis, middle);
    bool crossed = runsAlong ? o >= face : faceCrossing(o, d, face) <= t;
    if (crossed == up)
      low = middle;
    else
      high = middle - 1;
  }
  return low;
}

// The same, starting from the cell at an earlier t.
FN int latticeCellAfter(SCENE s, UNIFORM int axis, UNIFORM int cells, int cell, real t, real o, real d) {
  int i = cell;
  if (!parallelTo(d)) {
    bool up = d > R(0.0);
    while ((up ? i < cells - 1 : i > 0) && faceCrossing(o, d, latticeFace(s, axis, up ? i + 1 : i)) <= t)
      i += up ? 1 : -1;
  }
  return i;
}

// Returns the first partition at or after t that may change the ray, and moves t to where it begins; END_DONE
// if there is none before tEnd.
FN int nextPartition(SCENE s, vec3 o, vec3 d, INOUT(real) t, real tEnd) {
  int next = END_DONE;
  int x = latticeCell(s, 0, s.cellsX, t, o.x, d.x);
  int y = latticeCell(s, 1, s.cellsY, t, o.y, d.y);
  int z = latticeCell(s, 2, s.cellsZ, t, o.z, d.z);
  bool go = t < tEnd;
  while (go) {
    int p = partitionOf(s, (z * s.cellsY + y) * s.cellsX + x);
    if (isVisible(s, p)) {
      next = p;
      go = false;
    } else {
      real fx = faceAfter(o.x, d.x, latticeFace(s, 0, d.x > R(0.0) ? x + 1 : x));
      real fy = faceAfter(o.y, d.y, latticeFace(s, 1, d.y > R(0.0) ? y + 1 : y));
      real fz = faceAfter(o.z, d.z, latticeFace(s, 2, d.z > R(0.0) ? z + 1 : z));
      t = min(min(fx, fy), fz);
      x = latticeCellAfter(s, 0, s.cellsX, x, t, o.x, d.x);
      y = latticeCellAfter(s, 1, s.cellsY, y, t, o.y, d.y);
      z = latticeCellAfter(s, 2, s.cellsZ, z, t, o.z, d.z);
      go = t < tEnd;
    }
  }
  return next;
}

// The t at which the ray leaves the visible domain.
FN real domainExit(SCENE s, vec3 o, vec3 d) {
  real t0, t1;
  boxSpan(make_v3(s.domainLoX, s.domainLoY, s.domainLoZ), make_v3(s.domainHiX, s.domainHiY, s.domainHiZ), o,
          d, R(0.0), R(1e30), t0, t1);
  return t1;
}

// The t at which the ray enters and leaves the partition.
FN void partitionSpan(SCENE s, vec3 o, vec3 d, OUT(real) tIn, OUT(real) tOut) {
  bool right = d.x > R(0.0), up = d.y > R(0.0), on = d.z > R(0.0);
  real ax = faceBefore(o.x, d.x, right ? s.boxLoX : s.boxHiX);
  real ay = faceBefore(o.y, d.y, up ? s.boxLoY : s.boxHiY);
  real az = faceBefore(o.z, d.z, on ? s.boxLoZ : s.boxHiZ);
  real bx = faceAfter(o.x, d.x, right ? s.boxHiX : s.boxLoX);
  real by = faceAfter(o.y, d.y, up ? s.boxHiY : s.boxLoY);
  real bz = faceAfter(o.z, d.z, on ? s.boxHiZ : s.boxLoZ);
  tIn = max(max(ax, ay), max(az, R(0.0)));
  tOut = min(min(bx, by), bz);
}

// The t at which the next partition begins in which anything is seen (MarchRange::tOwnershipEnd in volume.h); NO_HIT
// if there is none.
FN real nextBegin(SCENE s, vec3 o, vec3 d, real tOut, real tEnd) {
  real t = tOut;
  return nextPartition(s, o, d, t, tEnd) == END_DONE ? NO_HIT : t;
}

// The first partition that may change a ray that begins at t = 0; END_DONE if there is none.
FN int firstPartition(SCENE s, vec3 o, vec3 d, real tEnd) {
  real t = R(0.0);
  return nextPartition(s, o, d, t, tEnd);
}
