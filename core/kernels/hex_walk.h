// SPDX-License-Identifier: Apache-2.0
// The march through an unstructured volume of hexahedra: as that through tetrahedra (mesh.h), but for cells of hexahedron.h.
//
// Each dialect supplies, for the OPERATOR type,
//   uint hexPoint(op, i)        corner i % 8 of hexahedron i / 8
//   uint hexNeighbour(op, i)    what lies behind side i % 6 of hexahedron i / 6: a side (cell << 3 | side) of another cell, or NO_FACE
//   uint hexOrders(op, i)       the orders (hexahedron.h) of the sides of hexahedron i

FN vec4 framed(FrameRay r, vec4 corner) {
  vec3 p = inFrame(r, placeOf(corner));
  return make_v4(p.x, p.y, p.z, corner.w);
}

FN Hexahedron hexahedronIn(OPERATOR op, FrameRay r, uint cell) {
  HexPoints at = hexPoints(op, cell);
  Hexahedron h;
  h.c0 = framed(r, vertexOf(op, at.p0));
  h.c1 = framed(r, vertexOf(op, at.p1));
  h.c2 = framed(r, vertexOf(op, at.p2));
  h.c3 = framed(r, vertexOf(op, at.p3));
  h.c4 = framed(r, vertexOf(op, at.p4));
  h.c5 = framed(r, vertexOf(op, at.p5));
  h.c6 = framed(r, vertexOf(op, at.p6));
  h.c7 = framed(r, vertexOf(op, at.p7));
  return h;
}

// Whether the ray passes the side of these corners, and at which t. The corners are in order (hexahedron.h).
FN bool passesSide(FrameRay r, vec3 a, vec3 b, vec3 c, vec3 d, bool triangle, OUT(real) t) {
  vec3 pa = inFrame(r, a), pb = inFrame(r, b), pc = inFrame(r, c), pd = inFrame(r, d);
  vec4 qa = make_v4(pa.x, pa.y, pa.z, R(0.0)), qb = make_v4(pb.x, pb.y, pb.z, R(0.0)),
       qc = make_v4(pc.x, pc.y, pc.z, R(0.0)), qd = make_v4(pd.x, pd.y, pd.z, R(0.0));
  int sign = (edgeCrossing(pa, pb) + edgeCrossing(pb, pc)) + (edgeCrossing(pc, pd) + edgeCrossing(pd, pa));
  t = NO_HIT;
  if (sign != 0) {
    SidePoint p;
    if (triangle)
      p = trianglePoint(qa, qb, qc);
    else
      p = patchPoint(qa, qb, qc, qd);
    t = p.z * r.frame.perDepth;
  }
  return sign != 0;
}

// The largest error that the value may have on a step of this length whose values are from low to high. Where the value is wrong by a part of
// how far it goes, the optical depth of what the map shows there is wrong by about twice that part: the slope is too steep in one half of
// the step and too flat in the other, and some of that cancels.
FN real errorAllowed(MAP map, real low, real high, real length, real range, real tMin) {
  MapMean m = meanAlong(map, low, high);
  real tau = min(m.sigma * length, R(1.0));
  real allowed = R(0.5) * tMin * (high - low) / max(tau, R(1e-30));
  real rounding = max(R(1e-6) * range, R(2.5e-7) * max(abs(low), abs(high)));
  return max(min(allowed, R(0.05) * range), rounding);
}

// Integrates the part from uFrom to uTo of the way through a hexahedron, from p to q, whose reference coordinates are `at` and `last`.
// `constant`: the cell has one value everywhere. Returns whether the map shows something.
FN bool integrateInHexahedron(MAP map, Hexahedron h, UNIFORM bool constant, real value, SidePoint p, vec3 at,
                              SidePoint q, vec3 last, real uFrom, real uTo, real span, real tMin,
                              INOUT(vec3) rgb, INOUT(real) A) {
  real low = value, high = value;
  CellCurve curve = linearCurve(value, value);
  if (!constant) {
    low = lowestOf(h);
    high = highestOf(h);
    curve.cubic = cubicBetween(h, p, at, q, last, q.z - p.z, low, high);
    curve.low = low;
    curve.high = high;
  }
  CurveInMap lies = curveInMap(map, curve);
  if (lies.seen) {
    SidePoint from = p, to = q;
    vec3 place = at, then = last;
    real u = R(0.0), step = R(1.0);
    while (u < uTo) {
      vec3 halfway = then;
      SidePoint middle = to;
      real error = R(0.0), allowed = R(0.0);
      if (!constant) {
        curve.cubic = cubicBetween(h, from, place, to, then, to.z - from.z, low, high);
        halfway = middleOf(place, then, R(0.5));
        middle = pointAtDepth(h, lerp1(from.z, to.z, R(0.5)), halfway);
        error = errorInMiddle(curve.cubic, middle.value);
        curve.low = min(min(curve.cubic.x, curve.cubic.y), min(curve.cubic.z, curve.cubic.w));
        curve.high = max(max(curve.cubic.x, curve.cubic.y), max(curve.cubic.z, curve.cubic.w));
        allowed = errorAllowed(map, curve.low - error, curve.high + error, span * step, high - low, tMin);
      }
      if (error > allowed && step > HEX_STEP_LEAST) {
        step *= R(0.5);
        to = middle;
        then = halfway;
      } else {
        lies = curveInMap(map, curve);
        real a = clamp1((uFrom - u) / step, R(0.0), R(1.0)), b = clamp1((uTo - u) / step, R(0.0), R(1.0));
        if (lies.seen && b > a) addPart(map, curve, !constant, lies, a, b, span * step, tMin, rgb, A);
        u += step;
        from = to;
        place = then;
        if (u < uTo) to = nextStep(h, p, q, last, u, error, allowed, step, then);
      }
    }
    lies.seen = true;
  }
  return lies.seen;
}

// Whether a cell is seen at all: it has a value of its own, or values at its corners, or both, as the operator shows it.
FN bool hexHoldsData(OPERATOR op, Hexahedron h, uint cell) {
  bool holds = true;
  if (op.constantCells == 0) holds = isFinite(h);
  if (hasValues(op)) {
    real value = cellValue(op, cell);
    holds = holds && value - value == R(0.0);
  }
  return holds;
}

// As walkMesh().
FN uint walkHexahedra(OPERATOR op, FrameRay r, MarchRange m, uint from, INOUT(MeshMarch) w, INOUT(Radiance) L,
                      INOUT(int) samples, INOUT(int) cells) {
  uint face = from, passed = from;
  int turn = 0;
  uint orders = hexOrders(op, from >> 3);
  Hexahedron h = hexahedronIn(op, r, from >> 3);
  SidePoint p = sidePoint(h, from & 7u, orders);
  vec3 rgb = L.rgb;
  real A = L.A, largest = max(w.largest, p.z * r.frame.perDepth), begin = max(w.t0, m.tStart);
  int evaluated = 0, crossed = 0;
  bool goes = true;
  UNIFORM bool constant = op.constantCells != 0;
  while (goes && face != NO_FACE) {
    uint cell = face >> 3, side = face & 7u;
    if (crossed > 0) {
      orders = hexOrders(op, cell);
      h = hexahedronIn(op, r, cell);
    }
    uint signs = sideSigns(h);
    uint next = sideOfSign(signs, -signOf(signs, side));
    if (timesPassed(signs) != 2) next = pairedSide(h, orders, signs, side, turn);
    passed = (cell << 3) | next;
    face = seenNeighbour(op, hexNeighbour(op, cell * 6u + next), HEXAHEDRA_IN_BRICK);
    SidePoint q = sidePoint(h, next, orders);
    // Where a ray goes through an edge, the sides there differ by a rounding. What a cell counts must not depend on those before it.
    real own = p.z * r.frame.perDepth;
    real before = largest - own <= R(1e-6) * abs(own) ? own : largest;
    largest = max(largest, q.z * r.frame.perDepth);
    crossed += 1;
    real ends = min(largest, w.t1);
    real to = min(ends, m.tStop);
    if (ends > m.tIn) {
      real start = max(before, begin);
      if (to > m.tOut) {
        goes = false;  // the cell belongs to the next partition
      } else if (to > start && hexHoldsData(op, h, cell)) {
        // The two cells of a triangle have different coordinates in it.
        if (isTriangle(side, orders)) p = sidePoint(h, side, orders);
        real span = largest - before;
        vec3 at = referencePlace(orderedCorners(side, orders), p.u, p.v);
        vec3 last = referencePlace(orderedCorners(next, orders), q.u, q.v);
        real value = R(0.0);
        if (constant) value = cellValue(op, cell);
        bool seen = integrateInHexahedron(op.map, h, constant, value, p, at, q, last, (start - before) / span,
                                          to < largest ? (to - before) / span : R(1.0), span, m.tMin, rgb, A);
        evaluated += seen ? 1 : 0;
      }
      if (to >= w.end || to >= m.tOut || R(1.0) - A < m.tMin) goes = false;
    }
    p = q;
  }
  L.rgb = rgb;
  L.A = A;
  w.largest = largest;
  w.goes = goes;
  samples += evaluated;
  cells += crossed;
  return passed;
}
