// SPDX-License-Identifier: Apache-2.0
// Watertight ray against triangle: Woop, Benthin, Wald, JCGT 2(1), 2013.
//
// The vertices are sheared into a frame in which the ray is the z axis. Which side of an edge the ray passes
// is then the sign of a 2-D cross product of two vertices, the same numbers for both triangles that share the
// edge. Where rounding makes it 0 the paper goes on in double. Here the sign comes from the exact rounding
// errors of the two products (exact.h), so that the answer is that of exact arithmetic in every dialect: a
// nonzero rounded difference of rounded products already has the exact sign, because rounding is monotone. A
// ray that meets an edge or a vertex exactly is taken to pass beside it, always on the same side
// (Edelsbrunner and Mucke, Simulation of simplicity, 1990). So it hits as many of the triangles that share it
// as a ray there does: one, where they continue each other. Both sides of a triangle are hit. Vertex
// distances from the origin are within 1e12.

// ax by - ay bx, rounded, with the exact sign.
FN real edgeSide(real ax, real ay, real bx, real by) {
  real p = ax * by;
  real q = ay * bx;
  real d = p - q;
  if (d == R(0.0)) d = productError(ax, by, p) - productError(ay, bx, q);
  return d;
}

// Replaces an edgeSide of 0 by that of a ray at (e, e^2), for e as small as need be. 0 for an edge without
// length.
FN real sideBeside(real ax, real ay, real bx, real by) { return ay != by ? ay - by : bx - ax; }

// The components in cyclic order, with that of index `last` at the end.
FN vec3 turned(vec3 v, int last) {
  real x = last == 0 ? v.y : (last == 1 ? v.z : v.x);
  real y = last == 0 ? v.z : (last == 1 ? v.x : v.y);
  real z = last == 0 ? v.x : (last == 1 ? v.y : v.z);
  return make_v3(x, y, z);
}

// A sheared coordinate. Values so small that the products below could underflow count as 0. This depends only
// on the vertex and the ray, so it opens no edge.
FN real sheared(real along, real shear, real depth) {
  real s = along - shear * depth;
  return abs(s) < R(1e-12) ? R(0.0) : s;
}

// The frame in which a ray is the z axis, which component `last` becomes.
struct RayFrame {
  int last;
  real perDepth;
  real shearX;
  real shearY;
};

FN RayFrame frameOf(vec3 direction) {
  vec3 size = make_v3(abs(direction.x), abs(direction.y), abs(direction.z));
  RayFrame f;
  f.last = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
  vec3 d = turned(direction, f.last);
  f.perDepth = R(1.0) / d.z;
  f.shearX = flushSmall(flushSmall(d.x) * f.perDepth);
  f.shearY = flushSmall(flushSmall(d.y) * f.perDepth);
  return f;
}

// hitTriangle with the corners relative to the origin, and turned.
FN bool hitTurned(RayFrame f, vec3 pa, vec3 pb, vec3 pc, real tMin, OUT(real) t, OUT(real) weightB,
                  OUT(real) weightC) {
  real ax = sheared(pa.x, f.shearX, pa.z);
  real ay = sheared(pa.y, f.shearY, pa.z);
  real bx = sheared(pb.x, f.shearX, pb.z);
  real by = sheared(pb.y, f.shearY, pb.z);
  real cx = sheared(pc.x, f.shearX, pc.z);
  real cy = sheared(pc.y, f.shearY, pc.z);
  real sideA = edgeSide(bx, by, cx, cy);
  real sideB = edgeSide(cx, cy, ax, ay);
  real sideC = edgeSide(ax, ay, bx, by);
  real least = min1(min1(sideA, sideB), sideC);
  real most = max1(max1(sideA, sideB), sideC);
  real sum = (sideA + sideB) + sideC;
  bool crossed = least > R(0.0) || most < R(0.0);
  if (least == R(0.0) || most == R(0.0)) {
    real besideA = sideA != R(0.0) ? sideA : sideBeside(bx, by, cx, cy);
    real besideB = sideB != R(0.0) ? sideB : sideBeside(cx, cy, ax, ay);
    real besideC = sideC != R(0.0) ? sideC : sideBeside(ax, ay, bx, by);
    least = min1(min1(besideA, besideB), besideC);
    most = max1(max1(besideA, besideB), besideC);
    crossed = least > R(0.0) || most < R(0.0);
  }
  real share = R(1.0) / (crossed ? sum : R(1.0));
  weightB = sideB * share;
  weightC = sideC * share;
  real depth = ((sideA * share) * pa.z + weightB * pb.z) + weightC * pc.z;
  t = depth * f.perDepth;
  return crossed && t > tMin;
}

// The hit with t > tMin. weightB, weightC: barycentric coordinates of b and c, so the point is
// (1 - weightB - weightC) a + weightB b + weightC c.
FN bool hitTriangle(vec3 origin, vec3 direction, vec3 a, vec3 b, vec3 c, real tMin, OUT(real) t,
                    OUT(real) weightB, OUT(real) weightC) {
  RayFrame f = frameOf(direction);
  vec3 pa = turned(make_v3(a.x - origin.x, a.y - origin.y, a.z - origin.z), f.last);
  vec3 pb = turned(make_v3(b.x - origin.x, b.y - origin.y, b.z - origin.z), f.last);
  vec3 pc = turned(make_v3(c.x - origin.x, c.y - origin.y, c.z - origin.z), f.last);
  return hitTurned(f, pa, pb, pc, tMin, t, weightB, weightC);
}

// Unit normal of the plane, on the side from which a, b, c turn counter-clockwise; (0, 0, 0) for no area.
FN vec3 triangleNormal(vec3 a, vec3 b, vec3 c) {
  vec3 ab = make_v3(b.x - a.x, b.y - a.y, b.z - a.z);
  vec3 ac = make_v3(c.x - a.x, c.y - a.y, c.z - a.z);
  return unit3(cross3(unit3(ab), unit3(ac)));
}
