// SPDX-License-Identifier: Apache-2.0
// The part of a ray in one cell, of whatever kind of field. A walk finds the cells that the ray meets, each with the bounds of t between
// which the ray is in it, and gives the value between them as a cubic. From that come emission and absorption through a map, and the
// first root, which is where an isosurface is met. Nothing here knows a grid.

struct Radiance {
  vec3 rgb;  // accumulated, premultiplied
  real A;    // opacity, 1 - transmittance; a transmittance near 1 would lose what thin segments take away
};

// Adds a segment of optical depth tau and colour c. If less than tMin would be left behind it, it counts as
// opaque: what is behind is taken to look the same, not to be black.
FN void addSegment(INOUT(vec3) rgb, INOUT(real) A, real tau, vec3 c, real tMin) {
  real T = R(1.0) - A;
  real w = T * oneMinusExp(tau);
  w = T - w < tMin ? T : w;
  rgb.x += w * c.x;
  rgb.y += w * c.y;
  rgb.z += w * c.z;
  A += w;
}

// A map along a segment on which the value goes linearly from s0 to s1.
struct MapMean {
  real sigma;                  // mean extinction
  vec3 color;                  // mean colour, weighted by extinction
  real sigmaFront, sigmaBack;  // extinctions at s0 and s1
  vec3 front, back;            // colours there
};

// Adds the contribution of an interval, along which extinction and colour are linear, to means over a
// segment. `part`: the fraction of the segment that the interval takes.
FN void addMean(real s0, real s1, vec3 c0, vec3 c1, real part, INOUT(real) sigma, INOUT(vec3) source) {
  real h = R(0.5) * (s0 + s1), u = (s1 - s0) * R(0.083333333333333333);
  sigma += h * part;
  source.x += (h * (R(0.5) * (c0.x + c1.x)) + u * (c1.x - c0.x)) * part;
  source.y += (h * (R(0.5) * (c0.y + c1.y)) + u * (c1.y - c0.y)) * part;
  source.z += (h * (R(0.5) * (c0.z + c1.z)) + u * (c1.z - c0.z)) * part;
}

// Means over values spread evenly over [s0, s1]. They are exact for the map, whatever nodes it has between
// them (pre-integration by antiderivatives; Engel 2001, Williams & Max 1992).
FN MapMean meanAlong(MAP map, real s0, real s1) {
  real lo = min(s0, s1), hi = max(s0, s1);
  MapPlace p = mapPlace(map, lo), q = mapPlace(map, hi);
  MapPiece first = mapPiece(map, p.k), last = mapPiece(map, q.k);
  real a0 = sigmaAt(first, p.f), b1 = sigmaAt(last, q.f);
  vec3 c0 = colorAt(first, p.f), d1 = colorAt(last, q.f);
  bool rising = s0 <= s1;
  MapMean m;
  m.sigmaFront = rising ? a0 : b1;
  m.sigmaBack = rising ? b1 : a0;
  m.front = rising ? c0 : d1;
  m.back = rising ? d1 : c0;
  real sigma = R(0.0);
  vec3 source = make_v3(R(0.0), R(0.0), R(0.0));
  if (p.k == q.k || !(hi - lo > R(1e-35))) {
    // One linear piece: its mean is that of a product of linear functions.
    addMean(a0, b1, c0, d1, R(1.0), sigma, source);
  } else {
    // From lo to the end of its interval, the whole intervals between, and from the start of the last
    // interval to hi.
    real inverse = R(1.0) / (hi - lo);
    real partP = (mapNode(map, p.k + 1) - lo) * inverse, partQ = (hi - mapNode(map, q.k)) * inverse;
    real a1 = sigmaAt(first, R(1.0)), b0 = last.sigma;
    vec3 c1 = colorAt(first, R(1.0)), d0 = last.color;
    addMean(a0, a1, c0, c1, partP, sigma, source);
    addMean(b0, b1, d0, d1, partQ, sigma, source);
    if (q.k > p.k + 1) {
      MapSum y = mapSum(map, q.k);
      int from = p.k + 1;
      int opaque = mapOpaque(map, q.k);
      if (opaque > p.k) {  // sums begin anew behind it, so it and what is before it are added by themselves
        MapPiece o = mapPiece(map, opaque);
        addMean(o.sigma, sigmaAt(o, R(1.0)), o.color, colorAt(o, R(1.0)),
                (mapNode(map, opaque + 1) - mapNode(map, opaque)) * inverse, sigma, source);
        MapSum z = mapSum(map, opaque);
        y.sigma += z.sigma;
        y.source = make_v3(y.source.x + z.source.x, y.source.y + z.source.y, y.source.z + z.source.z);
        if (mapOpaque(map, opaque) > p.k)
          from = 0;  // hidden by two opaque intervals, so nothing is subtracted
      }
      MapSum x = mapSum(map, from);
      sigma += ((y.sigma - x.sigma) + (y.sigmaRest - x.sigmaRest)) * inverse;
      source.x += ((y.source.x - x.source.x) + (y.sourceRest.x - x.sourceRest.x)) * inverse;
      source.y += ((y.source.y - x.source.y) + (y.sourceRest.y - x.sourceRest.y)) * inverse;
      source.z += ((y.source.z - x.source.z) + (y.sourceRest.z - x.sourceRest.z)) * inverse;
    }
  }
  m.sigma = sigma;
  real perSigma = m.sigma > R(0.0) ? R(1.0) / m.sigma : R(0.0);
  m.color = make_v3(source.x * perSigma, source.y * perSigma, source.z * perSigma);
  return m;
}

// The distance of a channel's mean colour from the mean of colours that are linear in optical depth.
FN real curvature(real mean, real front, real back) { return abs(mean - R(0.5) * (front + back)); }

// Adds a piece of optical depth tau, given its mean colour and the colours of its front and back, as if
// colours were linear in optical depth; the front of a dense piece hides its back. If colours are not linear,
// and that matters against tMin, nothing is added and true is returned: the piece must be halved, unless it
// is the `smallest`. `curvatureError`: lower bound on the colour error from assuming that colour is linear in optical
// depth. `positionError`: fraction of the piece's opacity that may be shown at the wrong depth.
FN bool addPiece(real tau, vec3 mean, vec3 front, vec3 back, real curvatureError, real positionError,
                 bool smallest, real tMin, INOUT(vec3) rgb, INOUT(real) A) {
  real T = R(1.0) - A;
  real w = oneMinusExp(tau);
  real curved = max(max(curvature(mean.x, front.x, back.x), curvature(mean.y, front.y, back.y)),
                    max(curvature(mean.z, front.z, back.z), curvatureError));
  bool halve = T * (w * max(min(tau, R(1.0)) * curved, positionError)) > tMin + R(1e-5) && !smallest;
  if (!halve && tau > R(0.0)) {
    // The mean of 1/2 - y / tau over what is seen, where y is the optical depth to it.
    real lead = tau < R(0.3) ? tau * R(0.083333333333333333) : (R(0.5) - R(1.0) / tau) + (R(1.0) - w) / w;
    if (smallest) lead = R(0.0);  // at a step of the map only the dense side is seen
    addSegment(rgb, A, tau,
               make_v3(mean.x + lead * (front.x - back.x), mean.y + lead * (front.y - back.y),
                       mean.z + lead * (front.z - back.z)),
               tMin);
  }
  return halve;
}

// The curvature of colours where extinction goes linearly from front to mean to back. It is about right, too,
// for extinction that rises and falls symmetrically, which means do not show.
FN real mapCurvatureError(MapMean m) {
  real change = max(max(abs(m.front.x - m.back.x), abs(m.front.y - m.back.y)), abs(m.front.z - m.back.z));
  real extinctionSpread = max(abs(m.sigma - m.sigmaFront), abs(m.sigma - m.sigmaBack));
  return m.sigma > R(0.0) ? change * R(0.16666666666666667) * min(extinctionSpread / m.sigma, R(2.0))
                          : R(0.0);
}

// The value along a ray through a cell: a cubic over [0, 1], the part of the ray that is in the cell, and the
// bounds of the value there.
struct CellCurve {
  vec4 cubic;
  real low, high;
};

FN real valueOn(CellCurve c, real u) { return clamp1(bernsteinValue(c.cubic, u), c.low, c.high); }

// Upper bound on the fraction of a piece's opacity that is shown at the wrong depth. The value is taken to go
// linearly from s0 to s1, but is `middle` in the middle. Only the difference between the piece's ends can be
// at a wrong depth.
FN real stepPositionError(MapMean m, real s0, real middle, real s1) {
  real rise = abs(s1 - s0), bow = abs(middle - R(0.5) * (s0 + s1));
  real change = max(max(abs(m.front.x - m.back.x), abs(m.front.y - m.back.y)), abs(m.front.z - m.back.z));
  if (m.sigma > R(0.0)) change = max(change, min(abs(m.sigmaFront - m.sigmaBack) / m.sigma, R(1.0)));
  return bow < rise ? change * (bow / rise) : change;
}

// Turns the means along a line from s0 to s1 into those along a parabola that is `middle` in the middle, and returns an upper bound on the
// fraction of opacity that is wrong then. The parabola dwells longer on the side where it is flatter, so extinction and colour that are
// linear in the value count more there. How far they are from linear, as at a spike, means do not tell; that part is not changed, and is
// wrong by up to twice the bow.
FN real bendMean(INOUT(MapMean) m, real s0, real middle, real s1) {
  real rise = s1 - s0, bow = middle - R(0.5) * (s0 + s1);
  real error = max(max(abs(m.front.x - m.back.x), abs(m.front.y - m.back.y)), abs(m.front.z - m.back.z));
  if (m.sigma > R(0.0)) {
    real perSigma = R(1.0) / m.sigma;
    real change = max(error, min(abs(m.sigmaFront - m.sigmaBack) * perSigma, R(1.0)));
    if (R(4.0) * abs(bow) < abs(rise)) {
      real part = bow / rise;
      real spread = min(abs(m.sigma - R(0.5) * (m.sigmaFront + m.sigmaBack)) * perSigma, R(1.0));
      real shift = R(0.66666666666666667) * part * (R(1.0) - spread);
      real shade =
          max(max(curvature(m.color.x, m.front.x, m.back.x), curvature(m.color.y, m.front.y, m.back.y)),
              curvature(m.color.z, m.front.z, m.back.z));
      real front = shift * m.sigmaFront, back = shift * m.sigmaBack;
      real sigma = max(m.sigma + (back - front), R(0.0));
      real one = sigma > R(0.0) ? R(1.0) / sigma : R(0.0);
      m.color.x = max(one * (m.sigma * m.color.x + (back * m.back.x - front * m.front.x)), R(0.0));
      m.color.y = max(one * (m.sigma * m.color.y + (back * m.back.y - front * m.front.y)), R(0.0));
      m.color.z = max(one * (m.sigma * m.color.z + (back * m.back.z - front * m.front.z)), R(0.0));
      m.sigma = sigma;
      error = R(2.0) * abs(part) * (spread + shade) + change * (part * part);
    } else {
      error =
          max(change, min(max(abs(m.sigma - m.sigmaFront), abs(m.sigma - m.sigmaBack)) * perSigma, R(1.0)));
    }
  }
  return error;
}

// The smallest part of a cell, which is not halved. It is large enough to move u where u is 1.
FN real smallestPiece(real uFrom, real uTo) { return max(R(0.0005) * (uTo - uFrom), R(1e-6)); }

// Adds the pieces from uFrom to uTo of a cell, `span` long, whose value has extrema at turns0 and turns1 (1:
// none). The value is taken as linear along each piece, or if `bows`, since it may be far from linear, as a parabola.
FN void addPieces(MAP map, CellCurve c, UNIFORM bool bows, real turns0, real turns1, real uFrom, real uTo,
                  real span, real tMin, INOUT(vec3) rgb, INOUT(real) A) {
  real from = uFrom, s = valueOn(c, uFrom), most = R(1.0), smallest = smallestPiece(uFrom, uTo);
  bool more = true;
  while (more) {
    real upTo = min(from < turns0 ? turns0 : (from < turns1 ? turns1 : R(1.0)), uTo);
    bool whole = upTo - from <= most;
    real to = whole ? upTo : from + most;
    real part = to - from, s1 = valueOn(c, to);
    MapMean m = meanAlong(map, s, s1);
    real middle = valueOn(c, from + R(0.5) * part), positionError;
    if (bows)
      positionError = bendMean(m, s, middle, s1);
    else
      positionError = stepPositionError(m, s, middle, s1);
    more = addPiece(m.sigma * (part * span), m.color, m.front, m.back, mapCurvatureError(m), positionError,
                    part <= smallest, tMin, rgb, A);
    if (more) {
      most = R(0.5) * part;
    } else {
      from = to;
      s = s1;
      most = whole ? R(1.0) : R(2.0) * part;
      more = from < uTo && R(1.0) - A >= tMin;
    }
  }
}

// The same through a map of few intervals, without sums. A piece also ends where the value leaves its
// interval, at a root of the cubic. So steps of the map are where they should be, however long segments are.
// `bows`: the value may be far from linear. Then a piece has the means of extinction and colour, which are linear
// in an interval, along the cubic.
FN void addPiecesOfFew(MAP map, CellCurve c, UNIFORM bool bows, real turns0, real turns1, real uFrom,
                       real uTo, real span, real tMin, INOUT(vec3) rgb, INOUT(real) A) {
  real from = uFrom, s = valueOn(c, uFrom);
  MapPlace place = mapPlace(map, s);
  int k = place.k;
  real f0 = place.f;
  real most = R(1.0), smallest = smallestPiece(uFrom, uTo);
  bool more = true;
  while (more) {
    real to = min(from < turns0 ? turns0 : (from < turns1 ? turns1 : R(1.0)), uTo);
    real s1 = valueOn(c, to);
    bool rising = s1 > s;
    int behind = rising ? k + 1 : k;  // the node through which the value leaves
    bool leaves = false;
    if (abs(s1 - s) > R(1e-35) && behind > 0 && behind < map.intervals)
      leaves = rising == (s1 >= mapNode(map, behind));
    if (leaves) {
      real node = mapNode(map, behind);
      vec4 b = make_v4(c.cubic.x - node, c.cubic.y - node, c.cubic.z - node, c.cubic.w - node);
      real before = flushSmall(s - node), after = flushSmall(s1 - node);
      if (after != R(0.0)) to = refineRoot(b, from, to, before, after, R(1e-4));
      s1 = node;
    }
    bool whole = to - from <= most;
    if (!whole) {
      to = from + most;
      s1 = valueOn(c, to);
      leaves = false;
    }
    real f1 = clamp1((s1 - mapNode(map, k)) * mapInverseLength(map, k), R(0.0), R(1.0));
    if (leaves) f1 = rising ? R(1.0) : R(0.0);
    real part = to - from;
    MapPiece m = mapPiece(map, k);
    vec3 front = colorAt(m, f0), back = colorAt(m, f1);
    real sigma = R(0.0);
    vec3 source = make_v3(R(0.0), R(0.0), R(0.0));
    addMean(sigmaAt(m, f0), sigmaAt(m, f1), front, back, R(1.0), sigma, source);
    real perSigma = sigma > R(0.0) ? R(1.0) / sigma : R(0.0);
    vec3 color = make_v3(source.x * perSigma, source.y * perSigma, source.z * perSigma);
    real positionError = R(0.0);
    if (bows) {  // Simpson's rule is exact for the mean of a cubic
      real middle = clamp1((valueOn(c, from + R(0.5) * part) - mapNode(map, k)) * mapInverseLength(map, k),
                           R(0.0), R(1.0));
      real off = R(0.66666666666666667) * (middle - R(0.5) * (f0 + f1));
      vec3 low = colorAt(m, R(0.0)), high = colorAt(m, R(1.0));
      vec3 step = make_v3(abs(high.x - low.x), abs(high.y - low.y), abs(high.z - low.z));
      positionError = abs(off) * max(max(step.x, step.y), step.z);
      sigma = max(sigma + off * (sigmaAt(m, R(1.0)) - sigmaAt(m, R(0.0))), R(0.0));
      color = make_v3(color.x + off * (high.x - low.x), color.y + off * (high.y - low.y),
                      color.z + off * (high.z - low.z));
    }
    more = addPiece(sigma * (part * span), color, front, back, R(0.0), positionError, part <= smallest, tMin,
                    rgb, A);
    if (more) {
      most = R(0.5) * part;
    } else {
      from = to;
      most = whole ? R(1.0) : R(2.0) * part;
      s = s1;
      f0 = f1;
      if (leaves) {
        k += rising ? 1 : -1;
        f0 = rising ? R(0.0) : R(1.0);
      }
      more = from < uTo && R(1.0) - A >= tMin;
    }
  }
}

// How a curve lies in a map.
struct CurveInMap {
  bool even;            // the value stays within one interval of the map, or does not change
  bool seen;            // the map shows something of it
  real turns0, turns1;  // where the value has extrema; 1: none, or `even`
};

FN CurveInMap curveInMap(MAP map, CellCurve c) {
  bool even = c.low == c.high, seen = true;
  real turns0 = R(1.0), turns1 = R(1.0);
  if (mapIsSmall(map)) {
    MapPlace p = mapPlace(map, c.low), q = mapPlace(map, c.high);
    MapPiece piece = mapPiece(map, p.k);
    even = p.k == q.k;
    seen = !even || piece.sigma != R(0.0) || piece.sigmaStep != R(0.0);
  }
  if (!even) extremaOf(c.cubic, turns0, turns1);
  CurveInMap lies;
  lies.even = even;
  lies.seen = seen;
  lies.turns0 = turns0;
  lies.turns1 = turns1;
  return lies;
}

// The value along a way on which it is linear.
FN CellCurve linearCurve(real s0, real s1) {
  CellCurve c;
  real third = (s1 - s0) * R(0.33333333333333333);
  c.cubic = make_v4(s0, s0 + third, s1 - third, s1);
  c.low = min(s0, s1);
  c.high = max(s0, s1);
  return c;
}

// Adds a part of a ray on which the value goes linearly from s0 to s1. Returns whether the map shows something there.
FN bool addLinear(MAP map, real s0, real s1, real span, real tMin, INOUT(vec3) rgb, INOUT(real) A) {
  bool seen = false;
  if (mapIsSmall(map)) {
    CellCurve c = linearCurve(s0, s1);
    CurveInMap lies = curveInMap(map, c);
    seen = lies.seen;
    if (seen) addPiecesOfFew(map, c, false, R(1.0), R(1.0), R(0.0), R(1.0), span, tMin, rgb, A);
  } else {
    real from = R(0.0), s = s0, most = R(1.0), smallest = smallestPiece(R(0.0), R(1.0));
    bool more = true;
    while (more) {
      bool whole = R(1.0) - from <= most;
      real to = whole ? R(1.0) : from + most;
      real part = to - from, next = whole ? s1 : lerp1(s0, s1, to);
      MapMean m = meanAlong(map, s, next);
      seen = seen || m.sigma > R(0.0);
      more = addPiece(m.sigma * (part * span), m.color, m.front, m.back, mapCurvatureError(m), R(0.0),
                      part <= smallest, tMin, rgb, A);
      if (more) {
        most = R(0.5) * part;
      } else {
        from = to;
        s = next;
        most = R(2.0) * part;
        more = !whole && R(1.0) - A >= tMin;
      }
    }
  }
  return seen;
}

// Adds the part from uFrom to uTo of a curve, which is `span` long in all. `bows`: the value may be far from linear.
FN void addPart(MAP map, CellCurve c, UNIFORM bool bows, CurveInMap lies, real uFrom, real uTo, real span,
                real tMin, INOUT(vec3) rgb, INOUT(real) A) {
  if (mapIsSmall(map))
    addPiecesOfFew(map, c, bows, lies.turns0, lies.turns1, uFrom, uTo, span, tMin, rgb, A);
  else
    addPieces(map, c, bows, lies.turns0, lies.turns1, uFrom, uTo, span, tMin, rgb, A);
}

// Where a ray meets an isosurface.
struct IsoHit {
  real t;     // NO_HIT if there is none
  int index;  // index of the isovalue
};

// The start of a secondary ray: on isosurface `index` (-1: none), on the side of sign `from`.
struct IsoStart {
  int index, from;
};

// The crossing of an isosurface in a cell: the cubic of the value less the isovalue, and the bracket of its root.
struct IsoCrossing {
  vec4 cubic;
  Bracket at;
  int index;  // index of the isovalue; the number of isovalues if there is no crossing
};

// Whether a ray starts in the cell that it enters `along` cells behind its start, or so little before it that rounding may have
// put it there.
FN bool startsInCell(real along) { return along <= R(1e-3); }

// The side of isosurface `index` on which a ray is where it enters a cell; 0 if that does not count any more. It counts until the ray
// has met a surface, or may have changed sides in a gap without data. The latter means behind such a gap, which the walk knows, or a
// quarter of a cell off the start, where rounding no longer puts a ray on the wrong side.
FN int sideInCell(IsoStart start, int index, real along, real tAfter) {
  return start.index == index && tAfter < R(0.0) && along <= R(0.25) ? start.from : 0;
}

// Whether the crossing in a cell depends on whether the ray comes from a cell with data.
FN bool dependsOnCellBefore(vec4 cubic, int side, bool starts) {
  return cubic.x == R(0.0) || (side != 0 && !starts);
}

// Whether a cubic passes 0 between its ends, neither of which is a touch.
FN bool changesSign(vec4 cubic) {
  return (cubic.x < R(0.0) && cubic.w >= R(0.0)) || (cubic.x > R(0.0) && cubic.w <= R(0.0));
}

// The bracket of the first crossing of a cubic over [ta, tb] at or after parameter `done` (firstBracket), for a ray that comes from no
// cell with data (`entry`) or from one, on the given side.
FN Bracket crossingInCell(vec4 cubic, real ta, real done, bool entry, int side, bool starts, real tIn,
                          real tOut, real tAfter) {
  RootQuery q;
  q.tIn = tIn;
  q.tOut = tOut;
  q.tAfter = tAfter;
  q.entry = entry;
  q.from = side;
  q.start = starts;
  return firstBracket(cubic, ta, done, q);
}

// The t of the crossing in a bracket, in a cell that the ray enters at ta and leaves at tb.
FN real crossingTime(vec4 cubic, Bracket at, real ta, real tb) {
  real u = rootIn(cubic, at);
  return rootBehind(rootTime(u, ta, tb), u, ta, tb);
}
