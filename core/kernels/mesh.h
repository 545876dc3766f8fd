// SPDX-License-Identifier: Apache-2.0
// The march through an unstructured volume: a walk from face to face (face.h) that integrates the cells which belong to this
// partition.
//
// The shell of a partition's cells are the faces that have no neighbour there: the boundary of the mesh, and faces behind which all
// cells are those of other partitions. Where rays leave out bricks of cells, the faces between these and other cells are shell, too.
// A walk begins at a face of the shell and ends at another one. A ray takes the faces of the shell
// that it passes in the order of t and of their numbers, and begins a walk at each of them, except where the walk before has ended. The
// t of the march never goes back: a cell counts from the largest t so far to its own end. So a walk that begins at the wrong end of its
// way adds nothing, and it does not matter which way round the points of a cell are. A cell belongs to the partition in which the
// largest t behind it lies. Cells come with every partition that they touch. So each partition finds the cells of its part of the ray
// between the same bounds of t, to the bit (docs/numerics.md, "Methods").
//
// Each dialect supplies, for the OPERATOR type,
//   vec4 vertexOf(op, i)        x, y, z and the stored value of point i
//   uint cellCorner(op, i)      corner i % 4 of tetrahedron i / 4; the corners of a tetrahedron ascend
//   uint cellNeighbour(op, i)   what lies behind the face opposite that corner: the face (cell << 3 | corner) of another cell, or NO_FACE
//   uint shellFace(op, i)       face i of the shell (cell << 3 | corner)
//   bool leavesOutBricks(op)    whether rays leave out bricks of cells, of which the map shows nothing
//   uint unseenWord(op, i)      a bit for each of the bricks 32 i to 32 i + 31, set where rays leave the brick out
//   bool hasValues(op)          whether cells have values of their own. Those whose value is not finite are not seen
//   real cellValue(op, i)       the value of cell i

#define NO_FACE 0xffffffffu

// A ray in the frame of triangle.h.
struct FrameRay {
  RayFrame frame;
  vec3 origin;  // turned
};

FN FrameRay frameRay(vec3 o, vec3 d) {
  FrameRay r;
  r.frame = frameOf(d);
  r.origin = turned(o, r.frame.last);
  return r;
}

// A point in the frame of a ray.
FN vec3 inFrame(FrameRay r, vec3 p) {
  vec3 q = turned(p, r.frame.last);
  real z = q.z - r.origin.z;
  return make_v3(sheared(q.x - r.origin.x, r.frame.shearX, z), sheared(q.y - r.origin.y, r.frame.shearY, z),
                 z);
}

// The number of corner k of the three of a face (cell << 3 | corner).
FN uint cornerOfFace(OPERATOR op, uint face, int k) {
  int opposite = asInt(face & 7u);
  return cellCorner(op, (face >> 3) * 4u + toUint(k < opposite ? k : k + 1));
}

// The faces of the shell at which the last walk has begun, (t, number), and ended (cell << 3 | corner, or NO_FACE).
struct ShellPlace {
  real t;
  uint number, ended;
};

FN ShellPlace beforeShell() {
  ShellPlace p;
  p.t = -infinity();
  p.number = 0u;
  p.ended = NO_FACE;
  return p;
}

// Whether a walk begins at a face of the shell, of this number, which the ray passes at t. `face` is the same as cell << 3 | corner.
FN bool beginsBehind(ShellPlace last, real t, uint number, uint face) {
  return (t > last.t || (t == last.t && number > last.number)) && face != last.ended;
}

// Returns `face`, the face of a neighbour, or NO_FACE if that neighbour is in a brick that rays leave out. `bits`: a brick has 2^bits cells.
FN uint seenNeighbour(OPERATOR op, uint face, uint bits) {
  uint seen = face;
  if (leavesOutBricks(op) && face != NO_FACE) {
    uint brick = face >> (bits + 3u);
    if (((unseenWord(op, brick >> 5) >> (brick & 31u)) & 1u) != 0u) seen = NO_FACE;
  }
  return seen;
}

// Whether the ray passes the face of these three points, and at which t.
FN bool passesFace(FrameRay r, vec3 a, vec3 b, vec3 c, OUT(real) t) {
  vec3 pa = inFrame(r, a), pb = inFrame(r, b), pc = inFrame(r, c);
  real shareA, shareB, shareC;
  triangleShares(pa, pb, pc, sideOf(pb, pc), sideOf(pc, pa), sideOf(pa, pb), shareA, shareB, shareC);
  t = meanOf(shareA, shareB, shareC, pa.z, pb.z, pc.z) * r.frame.perDepth;
  return triangleSign(pa, pb, pc) != 0;
}

// What the march of a ray carries from walk to walk.
struct MeshMarch {
  real t0, t1;   // the interval that the clip planes leave of the ray
  real end;      // of what is integrated
  real largest;  // t of the faces so far
  bool goes;     // whether there may be more
};

FN MeshMarch startMesh(CLIPS clips, vec3 o, vec3 d, MarchRange m, real A) {
  MeshMarch w;
  clipInterval(clips, o, d, w.t0, w.t1);
  w.end = min(w.t1, m.tStop);
  w.largest = -infinity();
  // A hit exactly at tIn may end a cell that began before it.
  w.goes = m.tIn <= m.tStop && m.tIn < w.t1 && w.t0 <= min(w.end, m.tOut) && m.tStart <= w.end &&
           R(1.0) - A >= m.tMin;
  return w;
}

// Walks from a face of the shell to another one, which it returns (cell << 3 | corner), and integrates the cells on the way. Where the
// rest of the ray belongs to other partitions or is not seen, it ends earlier and clears w.goes.
FN uint walkMesh(OPERATOR op, FrameRay r, MarchRange m, uint from, INOUT(MeshMarch) w, INOUT(Radiance) L,
                 INOUT(int) samples, INOUT(int) cells) {
  // The loop's variables are not members of structures (decision 0012). The face that the ray passes has the corners a, b and c.
  uint face = from, passed = from;
  uint a = cornerOfFace(op, from, 0), b = cornerOfFace(op, from, 1), c = cornerOfFace(op, from, 2);
  vec4 va = vertexOf(op, a), vb = vertexOf(op, b), vc = vertexOf(op, c);
  vec3 pa = inFrame(r, placeOf(va)), pb = inFrame(r, placeOf(vb)), pc = inFrame(r, placeOf(vc));
  real sa = va.w, sb = vb.w, sc = vc.w;
  real sideA = sideOf(pb, pc), sideB = sideOf(pc, pa), sideC = sideOf(pa, pb);  // of the opposite edges
  int crossA = edgeCrossing(pb, pc), crossB = edgeCrossing(pc, pa), crossC = edgeCrossing(pa, pb);
  real shareA, shareB, shareC;
  triangleShares(pa, pb, pc, sideA, sideB, sideC, shareA, shareB, shareC);
  real t = meanOf(shareA, shareB, shareC, pa.z, pb.z, pc.z) * r.frame.perDepth;
  real s = meanOf(shareA, shareB, shareC, sa, sb, sc);
  vec3 rgb = L.rgb;
  real A = L.A, largest = max(w.largest, t), begin = max(w.t0, m.tStart);
  int evaluated = 0, crossed = 0;
  bool goes = true;
  while (goes && face != NO_FACE) {
    uint cell = (face >> 3) * 4u;
    uint d = cellCorner(op, cell + (face & 7u));
    vec4 vd = vertexOf(op, d);
    vec3 pd = inFrame(r, placeOf(vd));
    real sideAD = sideOf(pa, pd), sideBD = sideOf(pb, pd), sideCD = sideOf(pc, pd);
    int crossAD = edgeCrossing(pa, pd), crossBD = edgeCrossing(pb, pd), crossCD = edgeCrossing(pc, pd);
    // The signs of the face by which the ray comes, and of those opposite a and b. All four add up to 0.
    int came = (crossA + crossB) + crossC;
    int signA = (crossBD - crossCD) - crossA, signB = (crossCD - crossAD) - crossB;
    // The corner that is not one of the face by which the ray goes on.
    int left = signA == -came ? 0 : (signB == -came ? 1 : 2);
    if (signA != 0 && signB != 0) {  // the ray passes all four faces
      triangleShares(pd, pc, pb, sideA, sideBD, sideCD, shareA, shareB, shareC);
      real tA = meanOf(shareA, shareB, shareC, pd.z, pc.z, pb.z) * r.frame.perDepth;
      triangleShares(pc, pd, pa, sideAD, sideB, sideCD, shareA, shareB, shareC);
      real tB = meanOf(shareA, shareB, shareC, pc.z, pd.z, pa.z) * r.frame.perDepth;
      triangleShares(pb, pa, pd, sideAD, sideBD, sideC, shareA, shareB, shareC);
      real tC = meanOf(shareA, shareB, shareC, pb.z, pa.z, pd.z) * r.frame.perDepth;
      left = cornerLeft(came, signA, signB, t, tA, tB, tC, a, b, c, d);
    }
    uint number = left == 0 ? a : (left == 1 ? b : c);
    uint place = (toUint(a < number ? 1 : 0) + toUint(b < number ? 1 : 0)) +
                 (toUint(c < number ? 1 : 0) + toUint(d < number ? 1 : 0));
    passed = (face & ~7u) | place;
    face = seenNeighbour(op, cellNeighbour(op, cell + place), TETRAHEDRA_IN_BRICK);
    // d takes the place of that corner.
    if (left == 0) {
      a = d, pa = pd, sa = vd.w;
      sideB = sideCD, sideC = -sideBD;
      crossB = crossCD, crossC = -crossBD;
    } else if (left == 1) {
      b = d, pb = pd, sb = vd.w;
      sideA = -sideCD, sideC = sideAD;
      crossA = -crossCD, crossC = crossAD;
    } else {
      c = d, pc = pd, sc = vd.w;
      sideA = sideBD, sideB = -sideAD;
      crossA = crossBD, crossB = -crossAD;
    }
    triangleShares(pa, pb, pc, sideA, sideB, sideC, shareA, shareB, shareC);
    real own = t;
    t = meanOf(shareA, shareB, shareC, pa.z, pb.z, pc.z) * r.frame.perDepth;
    real s0 = s;
    // Where a ray goes through an edge, the faces there differ by a rounding. What a cell counts must not depend on those before it.
    real before = largest - own <= R(1e-6) * abs(own) ? own : largest;
    s = meanOf(shareA, shareB, shareC, sa, sb, sc);
    largest = max(largest, t);
    crossed += 1;
    real ends = min(largest, w.t1);
    real to = min(ends, m.tStop);
    if (ends > m.tIn) {
      real start = max(before, begin);
      if (to > m.tOut) {
        goes = false;  // the cell belongs to the next partition
      } else if (to > start) {
        real front = s0, back = s;
        bool holds = (s - s) + (s0 - s0) == R(0.0);
        if (hasValues(op)) {
          real value = cellValue(op, cell >> 2);
          bool constant = op.constantCells != 0;
          front = constant ? value : s0;
          back = constant ? value : s;
          holds = (constant || holds) && value - value == R(0.0);
        }
        if (holds) {
          real span = largest - before;
          real sFrom = start > before ? lerp1(front, back, (start - before) / span) : front;
          real sTo = to < largest ? lerp1(front, back, (to - before) / span) : back;
          evaluated += addLinear(op.map, sFrom, sTo, to - start, m.tMin, rgb, A) ? 1 : 0;
        }
      }
      if (to >= w.end || to >= m.tOut || R(1.0) - A < m.tMin) goes = false;
    }
  }
  L.rgb = rgb;
  L.A = A;
  w.largest = largest;
  w.goes = goes;
  samples += evaluated;
  cells += crossed;
  return passed;
}
