// SPDX-License-Identifier: Apache-2.0
// A cell of a vector field as lines see it: what is asked of them, the cell's polynomial, and velocities on its
// faces. Velocities are in cells per unit of the kernel's time (core/rays/compiled_fields.h).

// The same for all heads of a call. The host fills it in; ISPC reads the same bytes.
struct FlowView {
  real scaleX, scaleY, scaleZ;  // velocity = scale * stored value + shift
  real shiftX, shiftY, shiftZ;
  real spacingX, spacingY, spacingZ;  // kernel lengths per cell
  real theta, kappa;                  // the most way of a step, in cells; the most |J| times its time
  real slowest;                       // lines end where |v| is less
  real timeLimit, timeLimitRest, lengthLimit, lengthLimitRest;  // pairs: the second is what rounding left
  real interval, intervalRest;                                  // of stored points
  real conditionLow, conditionHigh;                             // stored values between which lines end
  int stepsLimit;                                               // cells
  int points;                                                   // POINTS_*
  int flush;                                                    // denormal samples are to be taken as 0
  int rim;                     // the data end in the middle of the outermost cells
  int cellsX, cellsY, cellsZ;  // of the grid
  int firstX, firstY, firstZ;  // cells of the block: the first, and the one behind the last
  int endX, endY, endZ;
};

#define POINTS_CELLS 0
#define POINTS_TIME 1
#define POINTS_LENGTH 2
#define POINTS_ENDS 3

#if defined(ISPC)
#define FLOW const uniform FlowView&
#elif defined(GXY_GLSL)
#define FLOW FlowView
#else
#define FLOW const FlowView&
#endif

// Velocities at a cell's corners; digits: x, y, z.
struct CellVectors {
  vec3 v000, v100, v010, v110, v001, v101, v011, v111;
};

// Whether all are finite: a cell with a NaN or an infinity has no data. The sum cannot overflow by itself.
FN bool holdsVectors(CellVectors c) {
  vec3 s = ((c.v000 + c.v100) + (c.v010 + c.v110)) + ((c.v001 + c.v101) + (c.v011 + c.v111));
  real t = (s.x + s.y) + s.z;
  return t - t == R(0.0);
}

// The trilinear field of a cell as a polynomial, for all fractions, also outside the cell:
//   v = c + x cx + y cy + z cz + xy cxy + xz cxz + yz cyz + xyz cxyz.
struct CellFlow {
  vec3 c, cx, cy, cz, cxy, cxz, cyz, cxyz;
};

FN CellFlow cellFlow(CellVectors v) {
  CellFlow p;
  vec3 xUpper = v.v101 - v.v001;
  p.c = v.v000;
  p.cx = v.v100 - v.v000;
  p.cy = v.v010 - v.v000;
  p.cz = v.v001 - v.v000;
  p.cxy = (v.v110 - v.v010) - p.cx;
  p.cxz = xUpper - p.cx;
  p.cyz = (v.v011 - v.v001) - p.cy;
  p.cxyz = ((v.v111 - v.v011) - xUpper) - p.cxy;
  return p;
}

FN vec3 flowAt(CellFlow p, vec3 f) {
  vec3 withX = (p.cxyz * f.z + p.cxy) * f.y + (p.cxz * f.z + p.cx);
  vec3 without = (p.cyz * f.z + p.cy) * f.y + (p.cz * f.z + p.c);
  return withX * f.x + without;
}

FN vec3 abs3(vec3 v) { return make_v3(abs(v.x), abs(v.y), abs(v.z)); }
FN vec3 larger3(vec3 a, vec3 b) { return make_v3(max1(a.x, b.x), max1(a.y, b.y), max1(a.z, b.z)); }
FN real greatest3(vec3 v) { return max1(max1(v.x, v.y), v.z); }
FN real largestOf3(vec3 v) { return greatest3(abs3(v)); }

// |J|: the size of the field's derivative in the cell: the largest row of the matrix of the largest differences
// along its edges. Of a diagonal matrix and of a rotation it is the matrix's norm.
FN real flowDerivative(CellVectors v) {
  vec3 x = larger3(larger3(abs3(v.v100 - v.v000), abs3(v.v110 - v.v010)),
                   larger3(abs3(v.v101 - v.v001), abs3(v.v111 - v.v011)));
  vec3 y = larger3(larger3(abs3(v.v010 - v.v000), abs3(v.v110 - v.v100)),
                   larger3(abs3(v.v011 - v.v001), abs3(v.v111 - v.v101)));
  vec3 z = larger3(larger3(abs3(v.v001 - v.v000), abs3(v.v101 - v.v100)),
                   larger3(abs3(v.v011 - v.v010), abs3(v.v111 - v.v110)));
  vec3 squares = (x * x + y * y) + z * z;
  return sqrt(greatest3(squares));
}

// The velocity through a face, by one function of its four corners, so that both cells agree on its sign. What
// is so small that it may be denormal on the way counts as 0.
FN real faceVelocity(real v00, real v10, real v01, real v11, real f, real g) {
  real v = mix1(mix1(v00, v10, f), mix1(v01, v11, f), g);
  return abs(v) < R(1e-27) ? R(0.0) : v;
}

// The velocity at a place, where its components across the faces that the place lies on are those of the faces.
FN vec3 flowOnFaces(CellVectors c, vec3 f, vec3 v) {
  vec3 r = v;
  if (f.x == R(0.0) || f.x == R(1.0)) {
    bool up = f.x == R(1.0);
    real v00 = up ? c.v100.x : c.v000.x;
    real v10 = up ? c.v110.x : c.v010.x;
    real v01 = up ? c.v101.x : c.v001.x;
    real v11 = up ? c.v111.x : c.v011.x;
    r.x = faceVelocity(v00, v10, v01, v11, f.y, f.z);
  }
  if (f.y == R(0.0) || f.y == R(1.0)) {
    bool up = f.y == R(1.0);
    real v00 = up ? c.v010.y : c.v000.y;
    real v10 = up ? c.v110.y : c.v100.y;
    real v01 = up ? c.v011.y : c.v001.y;
    real v11 = up ? c.v111.y : c.v101.y;
    r.y = faceVelocity(v00, v10, v01, v11, f.x, f.z);
  }
  if (f.z == R(0.0) || f.z == R(1.0)) {
    bool up = f.z == R(1.0);
    real v00 = up ? c.v001.z : c.v000.z;
    real v10 = up ? c.v101.z : c.v100.z;
    real v01 = up ? c.v011.z : c.v010.z;
    real v11 = up ? c.v111.z : c.v110.z;
    r.z = faceVelocity(v00, v10, v01, v11, f.x, f.y);
  }
  return r;
}

// The speed in kernel lengths per kernel time; what may be denormal on the way counts as 0.
FN real flowSpeed(vec3 v, vec3 spacing) {
  real x = v.x * spacing.x;
  real y = v.y * spacing.y;
  real z = v.z * spacing.z;
  real square = (x * x + y * y) + z * z;
  return square < R(1e-35) ? R(0.0) : sqrt(square);
}
