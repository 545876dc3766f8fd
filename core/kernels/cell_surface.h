// SPDX-License-Identifier: Apache-2.0
// Isosurfaces and slices of unstructured volumes: in each tetrahedron that one passes, a level that is linear and 0 on it, the value
// less the isovalue, or the distance to the plane. A ray goes through a cell from face to face as in mesh.h, and the level where it
// passes a face has the same bits in both cells of the face. So a surface has no cracks, and no hit is found twice.
//
// Each dialect supplies, for the OPERATOR type, of surface cell p,
//   vec4 levelCorner(op, p, k)   x, y, z of corner k, and the level there
//   vec4 levelValues(op, p)      the values of its four corners, all equal on an isosurface
//   uint surfaceOf(op, p)        the number of the surface: those of the slices, then those of the isosurfaces
//   bool hasGradients(op)        whether isosurfaces are smooth: their normals are means of gradients at the corners of cells
//   uint levelPoint(op, i)       the number of the gradient at corner i % 4 of surface cell i / 4
//   vec3 levelGradient(op, n)    the gradient of values of this number

FN real component4(vec4 v, int i) { return i < 2 ? (i == 0 ? v.x : v.y) : (i == 2 ? v.z : v.w); }

// How many faces of a tetrahedron have this sign and come before face `of`, by t and then by number.
FN int facesBefore(vec4 sign, vec4 t, real ofSign, int of) {
  int count = 0;
  real at = component4(t, of);
  for (UNIFORM int i = 0; i < 4; i++) {
    real ti = component4(t, i);
    bool before = ti < at || (ti == at && i < of);
    count += component4(sign, i) == ofSign && before ? 1 : 0;
  }
  return count;
}

// The face of a tetrahedron that is paired with face `from`. sign: of the four faces; t: where the ray passes them.
FN int pairedFace(vec4 sign, vec4 t, int from) {
  real own = component4(sign, from);
  int place = facesBefore(sign, t, own, from);
  int paired = -1;
  for (UNIFORM int i = 0; i < 4; i++) {
    bool is = component4(sign, i) == -own && facesBefore(sign, t, -own, i) == place;
    paired = is ? i : paired;
  }
  return paired;
}

// The t at which the level is 0 between faces i and j, NO_HIT if it is on one side of 0 at both.
FN real levelRoot(vec4 t, vec4 level, int i, int j) {
  real ti = component4(t, i), tj = component4(t, j), li = component4(level, i), lj = component4(level, j);
  bool crosses = (li > R(0.0)) != (lj > R(0.0));
  real u = crosses ? li / (li - lj) : R(0.0);
  real root = clamp1(ti + u * (tj - ti), min1(ti, tj), max1(ti, tj));
  return crosses ? root : NO_HIT;
}

// The hit with t > tAfter of the surface in a tetrahedron. w of the corners: their levels.
FN bool hitCell(FrameRay r, vec4 a, vec4 b, vec4 c, vec4 d, real tAfter, OUT(real) t) {
  vec3 pa = inFrame(r, placeOf(a)), pb = inFrame(r, placeOf(b)), pc = inFrame(r, placeOf(c)),
       pd = inFrame(r, placeOf(d));
  int ab = edgeCrossing(pa, pb), ac = edgeCrossing(pa, pc), ad = edgeCrossing(pa, pd);
  int bc = edgeCrossing(pb, pc), bd = edgeCrossing(pb, pd), cd = edgeCrossing(pc, pd);
  // The signs of the faces opposite the corners; they add up to 0.
  int signA = (bd - cd) - bc, signB = (cd - ad) + ac, signC = (ad - bd) - ab, signD = (ab + bc) - ac;
  int passed = (abs(signA) + abs(signB)) + (abs(signC) + abs(signD));
  t = NO_HIT;
  if (passed > 0) {
    real sideAB = sideOf(pa, pb), sideAC = sideOf(pa, pc), sideAD = sideOf(pa, pd);
    real sideBC = sideOf(pb, pc), sideBD = sideOf(pb, pd), sideCD = sideOf(pc, pd);
    vec4 depth, level;
    real x, y, z;
    triangleShares(pb, pc, pd, sideCD, sideBD, sideBC, x, y, z);
    depth.x = meanOf(x, y, z, pb.z, pc.z, pd.z);
    level.x = meanOf(x, y, z, b.w, c.w, d.w);
    triangleShares(pa, pc, pd, sideCD, sideAD, sideAC, x, y, z);
    depth.y = meanOf(x, y, z, pa.z, pc.z, pd.z);
    level.y = meanOf(x, y, z, a.w, c.w, d.w);
    triangleShares(pa, pb, pd, sideBD, sideAD, sideAB, x, y, z);
    depth.z = meanOf(x, y, z, pa.z, pb.z, pd.z);
    level.z = meanOf(x, y, z, a.w, b.w, d.w);
    triangleShares(pa, pb, pc, sideBC, sideAC, sideAB, x, y, z);
    depth.w = meanOf(x, y, z, pa.z, pb.z, pc.z);
    level.w = meanOf(x, y, z, a.w, b.w, c.w);
    real per = r.frame.perDepth;
    vec4 at = make_v4(depth.x * per, depth.y * per, depth.z * per, depth.w * per);
    if (passed == 2) {
      int first = signA != 0 ? 0 : (signB != 0 ? 1 : 2);
      int last = signD != 0 ? 3 : (signC != 0 ? 2 : 1);
      t = levelRoot(at, level, first, last);
      if (!(t > tAfter)) t = NO_HIT;
    } else {
      vec4 sign = make_v4(toReal(signA), toReal(signB), toReal(signC), toReal(signD));
      for (UNIFORM int i = 0; i < 4; i++) {
        if (component4(sign, i) > R(0.0)) {
          real root = levelRoot(at, level, i, pairedFace(sign, at, i));
          if (root > tAfter && root < t) t = root;
        }
      }
    }
  }
  return t < NO_HIT;
}

// Six times the volume of a tetrahedron, which may be negative, and six times the volume times the gradient of what is linear in it and
// has the values of w at the corners.
FN real cellGradient(vec4 a, vec4 b, vec4 c, vec4 d, OUT(vec3) gradient) {
  vec3 ab = make_v3(b.x - a.x, b.y - a.y, b.z - a.z), ac = make_v3(c.x - a.x, c.y - a.y, c.z - a.z),
       ad = make_v3(d.x - a.x, d.y - a.y, d.z - a.z);
  vec3 nb = cross3(ac, ad), nc = cross3(ad, ab), nd = cross3(ab, ac);
  real rb = b.w - a.w, rc = c.w - a.w, rd = d.w - a.w;
  gradient = make_v3((rb * nb.x + rc * nc.x) + rd * nd.x, (rb * nb.y + rc * nc.y) + rd * nd.y,
                     (rb * nb.z + rc * nc.z) + rd * nd.z);
  return dot3(ab, nb);
}

FN vec4 withValue(vec4 corner, real value) { return make_v4(corner.x, corner.y, corner.z, value); }

// The mean of the gradients at the corners of a surface cell, weighed by the volumes of the tetrahedra between a point in it and its sides;
// of any length.
FN vec3 meanGradient(OPERATOR op, uint p, vec4 a, vec4 b, vec4 c, vec4 d, vec3 point) {
  vec3 ab = make_v3(b.x - a.x, b.y - a.y, b.z - a.z), ac = make_v3(c.x - a.x, c.y - a.y, c.z - a.z),
       ad = make_v3(d.x - a.x, d.y - a.y, d.z - a.z),
       ap = make_v3(point.x - a.x, point.y - a.y, point.z - a.z);
  vec3 nb = cross3(ac, ad), nc = cross3(ad, ab), nd = cross3(ab, ac);
  real volume = dot3(ab, nb);
  real turn = volume < R(0.0) ? R(-1.0) : R(1.0);
  real wb = max1(turn * dot3(ap, nb), R(0.0)), wc = max1(turn * dot3(ap, nc), R(0.0)),
       wd = max1(turn * dot3(ap, nd), R(0.0));
  real wa = max1(turn * volume - ((wb + wc) + wd), R(0.0));
  vec3 ga = levelGradient(op, levelPoint(op, 4u * p)), gb = levelGradient(op, levelPoint(op, 4u * p + 1u)),
       gc = levelGradient(op, levelPoint(op, 4u * p + 2u)),
       gd = levelGradient(op, levelPoint(op, 4u * p + 3u));
  return make_v3((wa * ga.x + wb * gb.x) + (wc * gc.x + wd * gd.x),
                 (wa * ga.y + wb * gb.y) + (wc * gc.y + wd * gd.y),
                 (wa * ga.z + wb * gb.z) + (wc * gc.z + wd * gd.z));
}

// The normal of an isosurface where values have this gradient; `cell`, the normal of the cell, if it is 0.
FN vec3 smoothNormal(vec3 gradient, vec3 cell) {
  vec3 n = unit3(make_v3(-gradient.x, -gradient.y, -gradient.z));
  bool has = dot3(n, n) >= R(0.5);
  return make_v3(has ? n.x : cell.x, has ? n.y : cell.y, has ? n.z : cell.z);
}

// The surface in surface cell p, which the ray meets at t. The geometric normal is that of the cell; an isosurface's outside is where values
// are lower.
FN Surface cellSurface(OPERATOR op, uint p, vec3 o, vec3 d, real t) {
  Surface f;
  vec4 a = levelCorner(op, p, 0), b = levelCorner(op, p, 1), c = levelCorner(op, p, 2),
       e = levelCorner(op, p, 3);
  vec4 values = levelValues(op, p);
  f.point = make_v3(o.x + t * d.x, o.y + t * d.y, o.z + t * d.z);
  f.size =
      max(max(largest3(placeOf(a)), largest3(placeOf(b))), max(largest3(placeOf(c)), largest3(placeOf(e))));
  f.own = make_v3(R(0.0), R(0.0), R(0.0));
  f.start = 0u;
  vec3 gradient;
  real volume = cellGradient(a, b, c, e, gradient);
  uint surface = surfaceOf(op, p);
  if (surface < toUint(op.slices)) {
    f.normal = sliceNormal(op, surface);
  } else {
    real down = volume < R(0.0) ? R(1.0) : R(-1.0);
    f.normal = unit3(make_v3(down * gradient.x, down * gradient.y, down * gradient.z));
    if (!(dot3(f.normal, f.normal) >= R(0.5))) f.normal = unit3(make_v3(-d.x, -d.y, -d.z));
  }
  f.geometric = f.normal;
  if (hasGradients(op) && surface >= toUint(op.slices))
    f.normal = smoothNormal(meanGradient(op, p, a, b, c, e, f.point), f.geometric);
  cellGradient(withValue(a, values.x), withValue(b, values.y), withValue(c, values.z), withValue(e, values.w),
               gradient);
  real rise = dot3(gradient, make_v3(f.point.x - a.x, f.point.y - a.y, f.point.z - a.z));
  bool hasVolume = abs(volume) > R(1e-35);
  f.value = values.x + (hasVolume ? rise / volume : R(0.0));
  f.value = clamp1(f.value, min1(min1(values.x, values.y), min1(values.z, values.w)),
                   max1(max1(values.x, values.y), max1(values.z, values.w)));
  return f;
}
