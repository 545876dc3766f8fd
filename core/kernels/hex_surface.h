// SPDX-License-Identifier: Apache-2.0
// Isosurfaces and slices of unstructured volumes of hexahedra, as those of tetrahedra (cell_surface.h): cells in which a level is 0 on the
// surface. The level where a ray passes a side has the same bits in both cells of the side, so a surface has no cracks. Between two sides
// it is taken as a cubic (hexahedron.h), whose root then moves to where the trilinear level is 0.
//
// Each dialect supplies, for the OPERATOR type, of surface cell p,
//   vec4 hexLevel(op, p, k)    x, y, z of corner k of 8, and the level there
//   real hexValue(op, p, k)    the value there
//   uint levelOrders(op, p)    the orders (hexahedron.h) of its sides
// and surfaceOf(op, p), hasGradients(op), levelPoint(op, i) of corner i % 8 of surface cell i / 8, and levelGradient(op, n).

// One step of Newton's method towards the reference coordinates at which the ray meets the surface.
FN vec3 towardsSurface(Hexahedron h, vec3 at) {
  vec4 p = trilinearIn(h, at), dx = derivativeX(h, at), dy = derivativeY(h, at), dz = derivativeZ(h, at);
  vec3 by = solved(make_v3(dx.x, dx.y, dx.w), make_v3(dy.x, dy.y, dy.w), make_v3(dz.x, dz.y, dz.w),
                   make_v3(p.x, p.y, p.w));
  return inCell(make_v3(at.x - by.x, at.y - by.y, at.z - by.z));
}

// The first t > tAfter at which the level is 0 on a step of a ray's way, from p to q, whose reference coordinates are `at` and `last`, and
// where the level is this cubic; NO_HIT if there is none.
FN real levelRootOn(FrameRay r, Hexahedron h, vec4 cubic, SidePoint p, vec3 at, SidePoint q, vec3 last,
                    real tAfter) {
  real tp = p.z * r.frame.perDepth, tq = q.z * r.frame.perDepth, t = NO_HIT;
  real e0, e1;
  extremaOf(cubic, e0, e1);
  real a = R(0.0), fa = cubic.x;
  for (UNIFORM int k = 0; k < 3; k++) {
    real z = k == 0 ? e0 : (k == 1 ? e1 : R(1.0));
    real fz = z < R(1.0) ? bernsteinValue(cubic, z) : cubic.w;
    real begin = lerp1(tp, tq, a), end = z < R(1.0) ? lerp1(tp, tq, z) : tq;
    if (!(t < NO_HIT) && z > a && (fa > R(0.0)) != (fz > R(0.0)) && end > tAfter) {
      Bracket bracket;
      bracket.lo = a, bracket.hi = z, bracket.fLo = fa, bracket.fHi = fz;
      real u = rootIn(cubic, bracket);
      vec3 met = middleOf(at, last, u);
      for (UNIFORM int step = 0; step < 3; step++) met = towardsSurface(h, met);
      vec4 there = trilinearIn(h, met);
      real exact = there.z * r.frame.perDepth;
      real root = clamp1(lerp1(tp, tq, u), begin, end);
      if (exact >= begin && exact <= end) root = exact;
      // Near the surface that a ray has left the cubic may cross the level where the surface does not: the level before it tells. This must
      // not depend on tAfter, which differs between partitions.
      bool crosses = true;
      if (begin < R(0.0) && root > R(0.0)) {
        real before = R(0.5) * root;
        vec3 place = middleOf(at, last, clamp1((before - tp) / (tq - tp), R(0.0), R(1.0)));
        SidePoint point = pointAtDepth(h, before / r.frame.perDepth, place);
        crosses = (point.value > R(0.0)) != (fz > R(0.0));
      }
      if (root > tAfter && crosses) t = root;
    }
    if (z > a) fa = fz;
    a = max1(a, z);
  }
  return t;
}

// The same between two sides of a hexahedron in the frame of the ray.
FN real levelRootBetween(FrameRay r, Hexahedron h, uint orders, uint from, uint to, real tAfter) {
  SidePoint p = sidePoint(h, from, orders), q = sidePoint(h, to, orders);
  vec3 at = referencePlace(orderedCorners(from, orders), p.u, p.v);
  vec3 last = referencePlace(orderedCorners(to, orders), q.u, q.v);
  if (q.z * r.frame.perDepth < p.z * r.frame.perDepth) {
    SidePoint side = p;
    vec3 place = at;
    p = q, q = side;
    at = last, last = place;
  }
  real tp = p.z * r.frame.perDepth, tq = q.z * r.frame.perDepth, t = NO_HIT;
  // A ray that starts on the surface does not meet it there, though roundings may put it on the wrong side.
  real after = max1(tAfter, R(1e-4) * (tq - tp));
  if (tq > after) {
    real low = lowestOf(h), high = highestOf(h);
    real allowed = R(1e-3) * (high - low), u = R(0.0), step = R(1.0);
    SidePoint begin = p, end = q;
    vec3 place = at, then = last;
    while (u < R(1.0) && !(t < NO_HIT)) {
      vec4 cubic = cubicBetween(h, begin, place, end, then, end.z - begin.z, low, high);
      vec3 halfway = middleOf(place, then, R(0.5));
      SidePoint middle = pointAtDepth(h, lerp1(begin.z, end.z, R(0.5)), halfway);
      real error = errorInMiddle(cubic, middle.value);
      if (error > allowed && step > HEX_STEP_LEAST) {
        step *= R(0.5);
        end = middle;
        then = halfway;
      } else {
        t = levelRootOn(r, h, cubic, begin, place, end, then, after);
        u += step;
        begin = end;
        place = then;
        if (u < R(1.0)) end = nextStep(h, p, q, last, u, error, allowed, step, then);
      }
    }
  }
  return t;
}

// The hit with t > tAfter of the surface in a hexahedron. w of the corners: their levels.
FN_OUTLINE bool hitHexahedron(FrameRay r, Hexahedron cell, uint orders, real tAfter, OUT(real) t) {
  Hexahedron h;
  h.c0 = framed(r, cell.c0), h.c1 = framed(r, cell.c1), h.c2 = framed(r, cell.c2), h.c3 = framed(r, cell.c3);
  h.c4 = framed(r, cell.c4), h.c5 = framed(r, cell.c5), h.c6 = framed(r, cell.c6), h.c7 = framed(r, cell.c7);
  uint signs = sideSigns(h);
  t = NO_HIT;
  if (signs != NO_SIDES) {
    bool two = timesPassed(signs) == 2;
    // Where the ray passes more than two sides, each that it enters is one of a pair.
    for (UNIFORM int k = 0; k < HEX_SIDES; k++) {
      uint from = two ? sideOfSign(signs, 1) : toUint(k);
      bool enters = two ? k == 0 : signOf(signs, from) > 0;
      if (enters) {
        uint to = sideOfSign(signs, -1);
        int turn = 0;
        if (!two) to = pairedSide(h, orders, signs, from, turn);
        t = min1(t, levelRootBetween(r, h, orders, from, to, tAfter));
      }
    }
  }
  return t < NO_HIT;
}

FN vec4 from4(vec4 corner, vec3 point, real number) {
  return make_v4(corner.x - point.x, corner.y - point.y, corner.z - point.z, number);
}

// The gradient of values at corner k of surface cell p, and the value there.
FN vec4 gradientAndValue(OPERATOR op, uint p, int k) {
  vec3 g = make_v3(R(0.0), R(0.0), R(0.0));
  if (hasGradients(op)) g = levelGradient(op, levelPoint(op, 8u * p + toUint(k)));
  return make_v4(g.x, g.y, g.z, hexValue(op, p, k));
}

// The surface in surface cell p, which the ray meets at t. The geometric normal is that of the level there; an isosurface's outside is where
// values are lower.
FN Surface hexSurface(OPERATOR op, uint p, vec3 o, vec3 d, real t) {
  Surface f;
  f.point = make_v3(o.x + t * d.x, o.y + t * d.y, o.z + t * d.z);
  f.own = make_v3(R(0.0), R(0.0), R(0.0));
  f.start = 0u;
  vec4 c0 = hexLevel(op, p, 0), c1 = hexLevel(op, p, 1), c2 = hexLevel(op, p, 2), c3 = hexLevel(op, p, 3);
  vec4 c4 = hexLevel(op, p, 4), c5 = hexLevel(op, p, 5), c6 = hexLevel(op, p, 6), c7 = hexLevel(op, p, 7);
  f.size = max1(max1(max1(largest3(placeOf(c0)), largest3(placeOf(c1))),
                     max1(largest3(placeOf(c2)), largest3(placeOf(c3)))),
                max1(max1(largest3(placeOf(c4)), largest3(placeOf(c5))),
                     max1(largest3(placeOf(c6)), largest3(placeOf(c7)))));
  Hexahedron h;
  h.c0 = from4(c0, f.point, c0.w), h.c1 = from4(c1, f.point, c1.w), h.c2 = from4(c2, f.point, c2.w);
  h.c3 = from4(c3, f.point, c3.w), h.c4 = from4(c4, f.point, c4.w), h.c5 = from4(c5, f.point, c5.w);
  h.c6 = from4(c6, f.point, c6.w), h.c7 = from4(c7, f.point, c7.w);
  vec3 at = coordinatesOfOrigin(h);
  uint surface = surfaceOf(op, p);
  if (surface < toUint(op.slices)) {
    f.normal = sliceNormal(op, surface);
  } else {
    real volume;
    vec3 gradient = scaledGradient(h, at, volume);
    real down = volume < R(0.0) ? R(1.0) : R(-1.0);
    f.normal = unit3(make_v3(down * gradient.x, down * gradient.y, down * gradient.z));
    if (!(dot3(f.normal, f.normal) >= R(0.5))) f.normal = unit3(make_v3(-d.x, -d.y, -d.z));
  }
  f.geometric = f.normal;
  h.c0 = gradientAndValue(op, p, 0), h.c1 = gradientAndValue(op, p, 1), h.c2 = gradientAndValue(op, p, 2);
  h.c3 = gradientAndValue(op, p, 3), h.c4 = gradientAndValue(op, p, 4), h.c5 = gradientAndValue(op, p, 5);
  h.c6 = gradientAndValue(op, p, 6), h.c7 = gradientAndValue(op, p, 7);
  vec4 there = trilinearIn(h, at);
  if (hasGradients(op) && surface >= toUint(op.slices)) f.normal = smoothNormal(placeOf(there), f.geometric);
  f.value = there.w;
  return f;
}
