// SPDX-License-Identifier: Apache-2.0
// Every function of core/kernels/lines.h on seeded inputs, in the common dialect: lineProbe(f, i) is a number that function f
// computes from input i. C++, ISPC and GLSL read it after that file; their results have the same bits.

#define LINE_PROBES 45

// In [lo, hi).
FN real drawn(uint i, uint salt, real lo, real hi) { return lo + (hi - lo) * unitReal(hash2(i, salt)); }

// Velocities of very different sizes: a base, and differences of it.
FN vec3 drawnVector(uint i, uint salt) {
  uint kind = hash2(i, 7u) & 7u;
  real size = kind == 0u ? R(1e-25) : (kind == 1u ? R(1e20) : (kind == 2u ? R(0.01) : R(1.0)));
  real x = drawn(i, salt, R(-1.0), R(1.0));
  real y = drawn(i, salt + 1u, R(-1.0), R(1.0));
  real z = kind == 3u ? R(0.0) : drawn(i, salt + 2u, R(-1.0), R(1.0));
  vec3 base = make_v3(drawn(i, 8u, R(-2.0), R(2.0)), drawn(i, 9u, R(-2.0), R(2.0)), R(0.0));
  return (make_v3(x, y, z) + base) * size;
}

FN CellVectors drawnVectors(uint i) {
  CellVectors c;
  c.v000 = drawnVector(i, 10u);
  c.v100 = drawnVector(i, 20u);
  c.v010 = drawnVector(i, 30u);
  c.v110 = drawnVector(i, 40u);
  c.v001 = drawnVector(i, 50u);
  c.v101 = drawnVector(i, 60u);
  c.v011 = drawnVector(i, 70u);
  c.v111 = drawnVector(i, 80u);
  uint spoilt = hash2(i, 90u) & 31u;
  real none = spoilt == 1u ? infinity() : -infinity();
  if (spoilt == 1u || spoilt == 2u) c.v101 = make_v3(c.v101.x, none, c.v101.z);
  return c;
}

// In [0, 1]: a third of them on an end.
FN real drawnFraction(uint i, uint salt) {
  uint kind = hash2(i, salt + 500u) % 6u;
  real x = drawn(i, salt, R(0.0), R(1.0));
  return kind == 0u ? R(0.0) : (kind == 1u ? R(1.0) : x);
}

FN uint oneOfFour(uint which, uint a, uint b, uint c, uint d) {
  return which == 0u ? a : (which == 1u ? b : (which == 2u ? c : d));
}

// Word f % 4 of what is drawn for input i.
FN uint drawnWord(int f, uint i) {
  uint a = i;
  uint b = hash1(i);
  uint c = f < 4 ? 0u : 1u;
  uint d = 0xffffffffu;
  philox4x32(i * 3u, 0x80000000u ^ i, a, b, c, d);
  return oneOfFour(toUint(f) & 3u, a, b, c, d);
}

FN real probePhilox(int f, uint i) { return unitReal(drawnWord(f, i)); }

// unitReal() leaves out these bits.
FN real probeLowBits(int f, uint i) { return toReal(asInt(drawnWord(f, i) & 255u)); }

// The first 24 inputs are the authors' known answers (Random123, kat_vectors), by halves of words: the upper before the lower, four words,
// three answers.
FN real probeKnownAnswers(uint i) {
  uint answer = i / 8u;
  uint ones = answer == 1u ? 0xffffffffu : (answer == 0u ? 0u : i);
  bool digits = answer == 2u;  // of pi
  uint a = digits ? 0x243f6a88u : ones;
  uint b = digits ? 0x85a308d3u : ones;
  uint c = digits ? 0x13198a2eu : ones;
  uint d = digits ? 0x03707344u : ones;
  philox4x32(digits ? 0xa4093822u : ones, digits ? 0x299f31d0u : ones, a, b, c, d);
  uint word = oneOfFour((i / 2u) & 3u, a, b, c, d);
  return toReal(asInt((i & 1u) == 0u ? word >> 16u : word & 0xffffu));
}

FN real probeFlow(int f, uint i) {
  CellVectors c = drawnVectors(i);
  CellFlow p = cellFlow(c);
  vec3 at = make_v3(drawnFraction(i, 100u), drawnFraction(i, 101u), drawnFraction(i, 102u));
  bool data = holdsVectors(c);
  if (f == 5) return data ? R(1.0) + at.x : R(0.0);
  vec3 v = data ? flowAt(p, at) : at;
  if (f == 6) return v.x;
  if (f == 7) return v.y + v.z;
  if (f == 8) return data ? flowDerivative(c) : R(-1.0);
  vec3 k = data ? flowOnFaces(c, at, v) : at;
  if (f == 9) return k.x;
  if (f == 10) return k.y;
  if (f == 11) return k.z;
  if (f == 12) return flowSpeed(k, make_v3(R(0.7), R(1.0), R(1e-4)));
  vec3 lo = make_v3(R(0.0), R(0.5), R(0.0));
  return toReal(faceAtOnce(at, k, lo, make_v3(R(1.0), R(1.0), R(0.5)))) + at.z;
}

// A head that makes up to twelve trials in a cell.
FN real probeStep(int f, uint i) {
  CellVectors c = drawnVectors(i);
  if (!holdsVectors(c)) return R(-1.0);
  UNIFORM FlowView v;
  v.spacingX = R(0.5);
  v.spacingY = R(1.0);
  v.spacingZ = R(0.125);
  v.theta = R(0.5);
  v.kappa = R(0.1);
  v.slowest = R(1e-3);
  v.timeLimit = R(1.7);
  v.timeLimitRest = R(1e-8);
  v.lengthLimit = R(0.9);
  v.lengthLimitRest = R(-1e-9);
  v.interval = R(0.01);
  v.intervalRest = R(2e-10);
  v.stepsLimit = 3;
  v.rim = 1;
  v.cellsX = 3;
  v.cellsY = 2;
  v.cellsZ = 2;
  v.firstX = 0;
  v.firstY = 0;
  v.firstZ = 0;
  v.endX = 2;
  v.endY = 2;
  v.endZ = 1;
  CellFlow p = cellFlow(c);
  int x = asInt(hash2(i, 200u) % 3u);
  int y = asInt(hash2(i, 201u) & 1u);
  ivec3 cell = make_i3(x, y, 0);
  vec3 lo = cellLow(v, cell);
  vec3 hi = cellHigh(v, cell);
  vec3 at = make_v3(clamp1(drawnFraction(i, 100u), lo.x, hi.x), clamp1(drawnFraction(i, 101u), lo.y, hi.y),
                    clamp1(drawnFraction(i, 102u), lo.z, hi.z));
  vec3 k = flowOnFaces(c, at, flowAt(p, at));
  real derivative = flowDerivative(c);
  real speed = flowSpeed(k, make_v3(v.spacingX, v.spacingY, v.spacingZ));
  if (isSlow(v, k, speed, derivative)) return R(-2.0);
  int face = faceAtOnce(at, k, lo, hi);
  if (face >= 0) return R(-3.0) - toReal(face);
  if (f == 14) return stepTime(v, R(3.0), lo, hi, at, k);
  real h = R(0.0);
  real time = R(0.3);
  real timeRest = R(-3e-9);
  real len = R(0.2);
  real lenRest = R(1e-9);
  real way = R(0.0);
  int stalled = 0;
  real t0 = time;
  real t0Rest = timeRest;
  real l0 = len;
  real l0Rest = lenRest;
  int reason = LINE_GOES_ON;
  int result = STEP_AGAIN;
  real part = R(1.0);
  real sums = R(0.0);
  real middle = R(0.0);
  real byTime = R(0.0);
  real byLength = R(0.0);
  int multiples = 0;
  for (UNIFORM int turn = 0; turn < 12; turn++) {
    if (result == STEP_AGAIN || result == STEP_INSIDE) {
      StepShape shape;
      t0 = time;
      t0Rest = timeRest;
      l0 = len;
      l0Rest = lenRest;
      result = tryStep(v, p, derivative, lo, hi, at, k, speed, h, time, timeRest, len, lenRest, stalled, way,
                       shape, part, face, reason);
      vec3 between = stepPoint(shape, R(0.3));
      middle = (between.x + between.y) + between.z;
      sums = stepLength(shape, R(0.6));
      if (result != STEP_AGAIN) {
        multiples = multiplesUntil(v, 30, time, timeRest);
        byTime = partAtTime(v, shape, part, 33, t0, t0Rest);
        byLength = partAtLength(v, shape, part, 23, l0, l0Rest);
      }
    }
  }
  if (f == 15) return at.x;
  if (f == 16) return at.y;
  if (f == 17) return at.z;
  if (f == 18) return k.x;
  if (f == 19) return k.y + k.z;
  if (f == 20) return speed;
  if (f == 21) return h + at.x;
  if (f == 22) return time;
  if (f == 23) return timeRest;
  if (f == 24) return len;
  if (f == 25) return lenRest;
  if (f == 26) return way + at.y;
  if (f == 27) return part;
  if (f == 28) return middle;
  if (f == 29) return sums;
  if (f == 30) return toReal(multiples) + time;
  if (f == 31) return byTime;
  if (f == 32) return byLength;
  if (f == 33) return toReal(result * 100 + reason * 10 + face) + at.x;
  if (f == 34) return toReal(limitReached(v, time, timeRest, len, lenRest, asInt(i & 3u))) + at.x;
  if (f == 35)
    return toReal(endOfPatience(stalled, way)) + leftOf(v.timeLimit, v.timeLimitRest, time, timeRest);
  int went = crossFace(v, asInt(hash2(i, 300u) % 6u), cell, at);
  if (f == 36) return toReal(went + 1000 * ((cell.z * 2 + cell.y) * 3 + cell.x)) + at.y;
  if (f == 37) return at.x + at.y;
  return f == 38 ? toReal(stalled) + at.z : component3(at, asInt(i % 3u));
}

FN real lineProbe(int f, uint i) {
  if (f < 5) return probePhilox(f, i);
  if (f == 44) return probeKnownAnswers(i);
  if (f >= 40) return probeLowBits(f, i);
  return f < 14 ? probeFlow(f, i) : probeStep(f, i);
}
