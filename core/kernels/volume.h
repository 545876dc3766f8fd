// SPDX-License-Identifier: Apache-2.0
// Emission and absorption along a ray through one structured volume (Max 1995; docs/numerics.md, "Methods").
//
// Segments follow each other along the ray, from where it enters the volume, comes out of macrocells in which
// nothing is seen, or has left a surface. Each is as long as the plan of the macrocell at its beginning says,
// or that at its end if that is finer, and counts as what is seen at its middle (midpoint rule): between
// segments of equal length errors cancel. Short segments go in pairs of equal length, and a pair counts as
// one in all that follows. Where each segment begins depends only on the ray and the plan. A partition
// evaluates the segments that *end* in (tIn, tOut], clipped at a hit. The beginning of a segment that ends
// later is handed on with the ray. So each segment is evaluated by exactly one partition, in the same order,
// with the same numbers.
//
// Each dialect supplies, for its VOLUME type,
//   vec3 gridOrigin(v), gridInverse(v); ivec3 gridCells(v)    the global grid in render space
//   CellValues cellValues(v, cell)                           samples of a cell of the local block
//   int  planAt(v, index)        0: skip; else the step and the method of a macrocell of the block, see below
//   bool anyCellwise(v)          whether any macrocell goes cell by cell

#define MACRO_BITS 3
// A plan has the length of a segment in units of 1 / PLAN_UNIT cells, above these bits. Plan 0: nothing is
// seen there.
#define PLAN_BITS 4
#define PLAN_CELLS \
  1  // cell by cell and pre-integrated, as cells lack data or the map is too steep; else midpoints
// Above that bit, for what goes cell by cell: log2 of how many times as long segments are in cells whose
// values lie within one interval of the map.
#define PLAN_LONGER_BIT 1
#define PLAN_MOST_LONGER 7
#define PLAN_UNIT 65536
// The most cells from the beginning of a segment to where the plan behind it is looked up.
#define PLAN_REACH 3.9f

struct VolumeRay {
  GridRay g;
  real t0, t1;  // where the ray is inside the grid's box and the clip planes; depends on the whole ray
  real cells;   // cells per unit of t, along the ray
};

FN VolumeRay volumeRay(VOLUME v, vec3 o, vec3 d, real clip0, real clip1) {
  VolumeRay r;
  r.g = gridRay(o, d, gridOrigin(v), gridInverse(v));
  real t0, t1;
  gridInterval(r.g, gridCells(v), t0, t1);
  r.t0 = max(t0, clip0);
  r.t1 = min(t1, clip1);
  r.cells = sqrt(dot3(r.g.pd, r.g.pd));
  return r;
}

FN real planStep(int plan) { return toReal(plan >> PLAN_BITS) * (R(1.0) / toReal(PLAN_UNIT)); }
// The same for cells whose values lie within one interval of the map.
FN real planStepWithin(int plan) {
  return planStep(plan) * toReal(1 << ((plan >> PLAN_LONGER_BIT) & PLAN_MOST_LONGER));
}
FN bool isMidpoint(int plan) { return plan != 0 && (plan & PLAN_CELLS) == 0; }

// The cell of the local block at p. Only rounding can put p outside the block, because its ghost layers reach
// as far as segments do.
FN ivec3 cellAt(VOLUME v, vec3 p) {
  return make_i3(toInt(clamp1(p.x, toReal(v.firstX), toReal(v.lastX - 1))),
                 toInt(clamp1(p.y, toReal(v.firstY), toReal(v.lastY - 1))),
                 toInt(clamp1(p.z, toReal(v.firstZ), toReal(v.lastZ - 1))));
}

// The position of p in cell c. p lies in the cell up to the rounding of its coordinates.
FN vec3 fractionOf(ivec3 c, vec3 p) {
  return make_v3(p.x - toReal(c.x), p.y - toReal(c.y), p.z - toReal(c.z));
}
// The same, clamped to the cell.
FN vec3 fractionIn(ivec3 c, vec3 p) {
  return make_v3(clamp1(p.x - toReal(c.x), R(0.0), R(1.0)), clamp1(p.y - toReal(c.y), R(0.0), R(1.0)),
                 clamp1(p.z - toReal(c.z), R(0.0), R(1.0)));
}

FN vec3 pointAt(GridRay g, real t) {
  return make_v3(g.po.x + t * g.pd.x, g.po.y + t * g.pd.y, g.po.z + t * g.pd.z);
}

// The value at fractions f of a cell with corners k.
FN real valueIn(CellValues k, vec3 f) {
  real a = lerp1(k.v000, k.v100, f.x), b = lerp1(k.v010, k.v110, f.x);
  real e = lerp1(k.v001, k.v101, f.x), g = lerp1(k.v011, k.v111, f.x);
  return lerp1(lerp1(a, b, f.y), lerp1(e, g, f.y), f.z);
}

// The trilinear value at p; NaN in a no-data cell.
FN real sampleAt(VOLUME v, vec3 p) {
  ivec3 c = cellAt(v, p);
  return valueIn(cellValues(v, c), fractionOf(c, p));
}

// The macrocell of the block at p.
FN int macroAt(VOLUME v, vec3 p) {
  ivec3 c = cellAt(v, p);
  return macroIndex(v, make_i3(c.x >> MACRO_BITS, c.y >> MACRO_BITS, c.z >> MACRO_BITS));
}

// A walk through the macrocells that a ray meets.
struct MacroWalk {
  int index;   // index of the macrocell in the block
  vec3 plane;  // its exit planes, in cells
  vec3 far;    // t at which the ray crosses them
  real t;      // where the ray enters it
};

FN MacroWalk startMacroWalk(VOLUME v, VolumeRay r, real t) {
  ivec3 n = gridCells(v);
  real s = R(0.125), b = R(8.0);
  ivec3 m = make_i3(locateCell(t, r.g.po.x * s, r.g.pd.x * s, r.g.rpd.x * b, ((n.x - 1) >> MACRO_BITS) + 1),
                    locateCell(t, r.g.po.y * s, r.g.pd.y * s, r.g.rpd.y * b, ((n.y - 1) >> MACRO_BITS) + 1),
                    locateCell(t, r.g.po.z * s, r.g.pd.z * s, r.g.rpd.z * b, ((n.z - 1) >> MACRO_BITS) + 1));
  MacroWalk w;
  w.index = macroIndex(v, m);
  w.plane =
      make_v3(toReal(farPlane(m.x, r.g.rpd.x) << MACRO_BITS), toReal(farPlane(m.y, r.g.rpd.y) << MACRO_BITS),
              toReal(farPlane(m.z, r.g.rpd.z) << MACRO_BITS));
  w.far = make_v3(crossingOf(w.plane.x, r.g.po.x, r.g.rpd.x), crossingOf(w.plane.y, r.g.po.y, r.g.rpd.y),
                  crossingOf(w.plane.z, r.g.po.z, r.g.rpd.z));
  real nx = planeCrossing(nearPlane(m.x, r.g.rpd.x) << MACRO_BITS, r.g.po.x, r.g.rpd.x);
  real ny = planeCrossing(nearPlane(m.y, r.g.rpd.y) << MACRO_BITS, r.g.po.y, r.g.rpd.y);
  real nz = planeCrossing(nearPlane(m.z, r.g.rpd.z) << MACRO_BITS, r.g.po.z, r.g.rpd.z);
  w.t = max(max(max(nx, ny), nz), r.t0);
  return w;
}

// Moves to the next macrocell, crossing every plane whose crossing is at the exit. It has no branches,
// because rays of a gang step at different times.
FN void stepMacroWalk(VOLUME v, VolumeRay r, INOUT(int) index, INOUT(vec3) plane, INOUT(vec3) far,
                      INOUT(real) t) {
  t = min3(far);
  bool x = far.x <= t, y = far.y <= t, z = far.z <= t;
  bool left = r.g.rpd.x < R(0.0), down = r.g.rpd.y < R(0.0), back = r.g.rpd.z < R(0.0);
  int row = macroRow(v), slice = macroSlice(v);
  plane.x += x ? (left ? R(-8.0) : R(8.0)) : R(0.0);
  plane.y += y ? (down ? R(-8.0) : R(8.0)) : R(0.0);
  plane.z += z ? (back ? R(-8.0) : R(8.0)) : R(0.0);
  index += x ? (left ? -1 : 1) : 0;
  index += y ? (down ? -row : row) : 0;
  index += z ? (back ? -slice : slice) : 0;
  far = make_v3(crossingOf(plane.x, r.g.po.x, r.g.rpd.x), crossingOf(plane.y, r.g.po.y, r.g.rpd.y),
                crossingOf(plane.z, r.g.po.z, r.g.rpd.z));
}

// The bounds of the work of one partition on one ray: segments that end in (tIn, tOut], from tStart (the
// ray's last event) to tStop (a hit before tOut, or NO_HIT). The march ends early when transmittance is below
// tMin.
//
// tOwnershipEnd is where the next partition begins in which anything is seen; NO_HIT: there is none. If that
// partition borders on this one, tOwnershipEnd is tOut. If nothing is seen in the partitions directly behind,
// rays pass them over. A segment that begins before tOut and ends there would then belong to a partition that
// no ray visits. So this partition evaluates it, too: it owns segments that begin before tOut and end at
// tOwnershipEnd or before.
struct MarchRange {
  real tIn, tOut, tOwnershipEnd, tStart, tStop, tMin;
};

// Counts of samples, of macrocells in which something was sampled, of macrocells that were skipped, and of
// segments in which the map shows nothing, in macrocells that were integrated cell by cell.
struct MarchCount {
  int samples, macrocells, skipped, segmentsSkipped;
};

FN MarchCount nothingMarched() {
  MarchCount n;
  n.samples = 0;
  n.macrocells = 0;
  n.skipped = 0;
  n.segmentsSkipped = 0;
  return n;
}
