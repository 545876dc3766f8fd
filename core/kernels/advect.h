// SPDX-License-Identifier: Apache-2.0
// A head of a line goes through one cell of a trilinear vector field.
//
// Inside a cell the field is a polynomial, so the classical method of Runge and Kutta has its order 4 there, and
// a step reads no samples. The head stops on every face, where the field has kinks. The way of a step is the
// cubic of Hermite through its ends, with the velocities there (Hairer, Norsett & Wanner, Solving Ordinary
// Differential Equations I, II.6); where it first meets a face the head leaves the cell. Everything that a head
// needs to go on is in its state at any step's end, so its bits do not depend on who computes.

// What a trial step came to.
#define STEP_AGAIN 0   // it did not count: to be tried again with another h
#define STEP_INSIDE 1  // the head has moved on in the cell
#define STEP_FACE 2    // it has moved on, and is on a face: faces are to be looked at before the next step
#define STEP_EXIT 3    // it has moved to the face `face`, through which it leaves
#define STEP_ENDS 4    // it has moved, and its line ends: `reason`

// Why a line has ended: EndReason (core/rays/path_points.h) + 1. 0: it goes on.
#define LINE_GOES_ON 0
#define LINE_LEFT 1
#define LINE_TIME 2
#define LINE_LENGTH 3
#define LINE_STEPS 4
#define LINE_SLOW 5
#define LINE_NO_DATA 6
#define LINE_CONDITION 7
#define LINE_CLOSED 8
#define LINE_STUCK 9
#define LINE_LEAVES 100  // the head leaves the block, and goes on elsewhere

// How far, in cells, a step may reach over a face within itself: as far as rounding would take it.
#define STEP_SLACK R(9.5367431640625e-07)
// Of the time to the face on a straight line: the step that is to meet it goes a little further.
#define STEP_OVER R(1.0625)
// Cells of way that count as moving on; crossings without it, and trial steps in one cell, after which a line is stuck.
#define STEP_WAY R(1.52587890625e-05)
#define MOST_CROSSINGS 8
#define MOST_TRIALS 65536
#define TRIAL 16  // HeadView::stalled counts crossings below this, and trials in the cell in multiples of it
#define MOST_POINTS 16777216

// Adds x to a pair, whose second number is what rounding left of the first.
FN void addToPair(INOUT(real) sum, INOUT(real) rest, real x) {
  real s;
  real lost;
  twoSum(sum, x, s, lost);
  real all;
  real left;
  twoSum(s, rest + lost, all, left);
  sum = all;
  rest = left;
}

// How far b lies outside [lo, hi].
FN real outside1(real b, real lo, real hi) { return max1(b - hi, lo - b); }

FN real component3(vec3 v, int axis) { return axis == 0 ? v.x : (axis == 1 ? v.y : v.z); }

// The most time of the next step.
FN real stepTime(FLOW v, real bend, vec3 lo, vec3 hi, vec3 f, vec3 k) {
  vec3 a = abs3(k);
  real x = (k.x > R(0.0) ? hi.x - f.x : f.x - lo.x) / max1(a.x, R(1e-30));
  real y = (k.y > R(0.0) ? hi.y - f.y : f.y - lo.y) / max1(a.y, R(1e-30));
  real z = (k.z > R(0.0) ? hi.z - f.z : f.z - lo.z) / max1(a.z, R(1e-30));
  // A component that is 0 on a face does not lead to it.
  x = a.x > R(0.0) ? x : R(1e30);
  y = a.y > R(0.0) ? y : R(1e30);
  z = a.z > R(0.0) ? z : R(1e30);
  real h = min1(v.theta / greatest3(a), bend);
  return min1(min1(h, STEP_OVER * min1(min1(x, y), z)), R(1e12));
}

// The distances of a step's control points from the face of one axis beyond which the step ends; positive
// inside.
FN vec4 faceDistances(vec3 b0, vec3 b1, vec3 b2, vec3 b3, vec3 lo, vec3 hi, int axis) {
  real p3 = component3(b3, axis);
  real upper = component3(hi, axis);
  bool up = p3 > upper;
  real face = up ? upper : component3(lo, axis);
  real sign = up ? R(1.0) : R(-1.0);
  return make_v4((face - component3(b0, axis)) * sign, (face - component3(b1, axis)) * sign,
                 (face - component3(b2, axis)) * sign, (face - p3) * sign);
}

// The part of the step after which it meets a face for the first time; d.w < 0. A head that stands on the face
// (d.x = 0) is not meeting it: the root at 0 is divided out.
FN real exitPart(vec4 d) {
  vec4 q = d;
  if (d.x == R(0.0)) {
    real middle = R(1.5) * d.z;
    q.x = R(3.0) * d.y;
    q.y = (q.x + R(2.0) * middle) * R(0.33333333333333333);
    q.z = (R(2.0) * middle + d.w) * R(0.33333333333333333);
  }
  real s = R(0.0);
  if (q.x > R(0.0)) s = refineRoot(q, R(0.0), R(1.0), q.x, q.w, ROOT_TOLERANCE);
  return s;
}

// Judges a step with control points b0 to b3: STEP_INSIDE; or STEP_EXIT with the part `s` of it after which it
// is on `face` (twice the axis, and 1 if it is the upper one); or STEP_AGAIN, s times as long.
FN int judgeStep(vec3 b0, vec3 b1, vec3 b2, vec3 b3, vec3 lo, vec3 hi, OUT(real) s, OUT(int) face) {
  vec3 end = make_v3(outside1(b3.x, lo.x, hi.x), outside1(b3.y, lo.y, hi.y), outside1(b3.z, lo.z, hi.z));
  vec3 middle = make_v3(max1(outside1(b1.x, lo.x, hi.x), outside1(b2.x, lo.x, hi.x)),
                        max1(outside1(b1.y, lo.y, hi.y), outside1(b2.y, lo.y, hi.y)),
                        max1(outside1(b1.z, lo.z, hi.z), outside1(b2.z, lo.z, hi.z)));
  // A head that slides along a face is inside as long as rounding could have moved it.
  vec3 start = make_v3(outside1(b0.x, lo.x, hi.x), outside1(b0.y, lo.y, hi.y), outside1(b0.z, lo.z, hi.z));
  bool outX = end.x > (start.x == R(0.0) && middle.x <= STEP_SLACK ? STEP_SLACK : R(0.0));
  bool outY = end.y > (start.y == R(0.0) && middle.y <= STEP_SLACK ? STEP_SLACK : R(0.0));
  bool outZ = end.z > (start.z == R(0.0) && middle.z <= STEP_SLACK ? STEP_SLACK : R(0.0));
  int result = STEP_INSIDE;
  s = R(1.0);
  face = -1;
  if (outX || outY || outZ) {
    // The first guess is the axis whose face a straight step meets first.
    real tx = outX ? start.x / (start.x - end.x) : R(2.0);
    real ty = outY ? start.y / (start.y - end.y) : R(2.0);
    real tz = outZ ? start.z / (start.z - end.z) : R(2.0);
    int axis = tx <= ty && tx <= tz ? 0 : (ty <= tz ? 1 : 2);
    vec4 d = faceDistances(b0, b1, b2, b3, lo, hi, axis);
    s = exitPart(d);
    bool done = false;
    for (UNIFORM int turn = 0; turn < 2; turn++) {
      // Another axis may be outside by then.
      int other = -1;
      if (!done && axis != 0 && outX && bernsteinValue(faceDistances(b0, b1, b2, b3, lo, hi, 0), s) < R(0.0))
        other = 0;
      if (!done && axis != 1 && outY && bernsteinValue(faceDistances(b0, b1, b2, b3, lo, hi, 1), s) < R(0.0))
        other = 1;
      if (!done && axis != 2 && outZ && bernsteinValue(faceDistances(b0, b1, b2, b3, lo, hi, 2), s) < R(0.0))
        other = 2;
      done = other < 0;
      if (!done) {
        axis = other;
        d = faceDistances(b0, b1, b2, b3, lo, hi, axis);
        s = exitPart(d);
      }
    }
    face = 2 * axis + (component3(b3, axis) > component3(hi, axis) ? 1 : 0);
    bool several = d.x > R(0.0) && d.y < R(0.0) && d.z > R(0.0);
    result = STEP_EXIT;
    if (several) {
      result = STEP_AGAIN;
      s = R(0.5);
    } else if (d.x == R(0.0) && s < R(0.0625)) {
      result = STEP_AGAIN;
      s = R(0.125);
    } else if (s < R(0.5)) {
      result = STEP_AGAIN;
      s = STEP_OVER * s;
    }
  } else if (greatest3(middle) > STEP_SLACK) {
    result = STEP_AGAIN;
    s = R(0.5);
  }
  return result;
}

// A step's way: its control points, its time, and the length along it, likewise as a cubic that begins at 0.
struct StepShape {
  vec3 b0, b1, b2, b3;
  real h;
  real l1, l2, l3;
};

FN vec3 stepPoint(StepShape s, real u) {
  return make_v3(bernsteinValue(make_v4(s.b0.x, s.b1.x, s.b2.x, s.b3.x), u),
                 bernsteinValue(make_v4(s.b0.y, s.b1.y, s.b2.y, s.b3.y), u),
                 bernsteinValue(make_v4(s.b0.z, s.b1.z, s.b2.z, s.b3.z), u));
}
FN real stepLength(StepShape s, real u) { return bernsteinValue(make_v4(R(0.0), s.l1, s.l2, s.l3), u); }

// The part of a step, at most `most`, at which the length along it is `target`.
FN real partOfLength(StepShape s, real most, real target) {
  vec4 b = make_v4(R(0.0), s.l1, s.l2, s.l3);
  real u = target / s.l3;
  for (UNIFORM int k = 0; k < 4; k++) {
    u = min1(max1(u, R(0.0)), most);
    real slope = bernsteinSlope(b, u);
    u -= slope > R(0.0) ? (bernsteinValue(b, u) - target) / slope : R(0.0);
  }
  return min1(max1(u, R(0.0)), most);
}

// The classical Runge-Kutta step of time h from f, where the velocity is k and its size `speed`.
FN StepShape flowStep(CellFlow p, vec3 spacing, vec3 f, vec3 k, real speed, real h, OUT(vec3) kEnd,
                      OUT(real) speedEnd) {
  real middle = R(0.5) * h;
  real third = h * R(0.33333333333333333);
  vec3 k2 = flowAt(p, f + k * middle);
  vec3 k3 = flowAt(p, f + k2 * middle);
  vec3 k4 = flowAt(p, f + k3 * h);
  vec3 way = ((k + k4) + (k2 + k3) * R(2.0)) * (h * R(0.16666666666666667));
  StepShape s;
  s.b0 = f;
  s.b3 = f + way;
  vec3 last = flowAt(p, s.b3);
  s.b1 = f + k * third;
  s.b2 = s.b3 - last * third;
  s.h = h;
  // Length by Simpson's rule; the velocity in the middle is that of the cubic, which has order 4 there.
  real ends = flowSpeed(last, spacing);
  real between = flowSpeed(way * R(1.5) - (k + last) * (R(0.25) * h), spacing);
  s.l1 = third * speed;
  s.l3 = (h * (speed + ends) + R(4.0) * between) * R(0.16666666666666667);
  s.l2 = s.l3 - third * ends;
  kEnd = last;
  speedEnd = ends;
  return s;
}

// x in [lo, hi]; on lo, if it is so near that its digits would count for nothing.
FN real intoCell(real x, real lo, real hi) {
  real y = x < lo + R(1e-9) ? lo : x;
  return min1(y, hi);
}

FN bool onFace(real x, real lo, real hi) { return x == lo || x == hi; }

// The face through which the head leaves at once, because it is on it and its velocity across leads out; -1:
// none.
FN int faceAtOnce(vec3 f, vec3 k, vec3 lo, vec3 hi) {
  int face = -1;
  if ((f.z == hi.z && k.z > R(0.0)) || (f.z == lo.z && k.z < R(0.0))) face = k.z > R(0.0) ? 5 : 4;
  if ((f.y == hi.y && k.y > R(0.0)) || (f.y == lo.y && k.y < R(0.0))) face = k.y > R(0.0) ? 3 : 2;
  if ((f.x == hi.x && k.x > R(0.0)) || (f.x == lo.x && k.x < R(0.0))) face = k.x > R(0.0) ? 1 : 0;
  return face;
}

// Where the data begin and end in a cell.
FN vec3 cellLow(FLOW v, ivec3 c) {
  bool rim = v.rim != 0;
  return make_v3(rim && c.x == 0 ? R(0.5) : R(0.0), rim && c.y == 0 ? R(0.5) : R(0.0),
                 rim && c.z == 0 ? R(0.5) : R(0.0));
}
FN vec3 cellHigh(FLOW v, ivec3 c) {
  bool rim = v.rim != 0;
  return make_v3(rim && c.x == v.cellsX - 1 ? R(0.5) : R(1.0), rim && c.y == v.cellsY - 1 ? R(0.5) : R(1.0),
                 rim && c.z == v.cellsZ - 1 ? R(0.5) : R(1.0));
}

// Moves the head into the next cell. Returns LINE_LEFT if that is outside the grid, and then moves nothing;
// LINE_LEAVES if it is outside the block.
FN int crossFace(FLOW v, int face, INOUT(ivec3) cell, INOUT(vec3) f) {
  int step = (face & 1) != 0 ? 1 : -1;
  real entry = step > 0 ? R(0.0) : R(1.0);
  int x = cell.x + (face < 2 ? step : 0);
  int y = cell.y + (face >= 2 && face < 4 ? step : 0);
  int z = cell.z + (face >= 4 ? step : 0);
  bool left = x < 0 || y < 0 || z < 0 || x >= v.cellsX || y >= v.cellsY || z >= v.cellsZ;
  bool leaves = x < v.firstX || y < v.firstY || z < v.firstZ || x >= v.endX || y >= v.endY || z >= v.endZ;
  if (!left) {
    cell = make_i3(x, y, z);
    f = make_v3(face < 2 ? entry : f.x, face >= 2 && face < 4 ? entry : f.y, face >= 4 ? entry : f.z);
  }
  return left ? LINE_LEFT : (leaves ? LINE_LEAVES : LINE_GOES_ON);
}

// Whether a velocity is so small that the head does not move on: 0, or within 2^-20 cells of a zero of the field,
// or slower than asked for.
FN bool isSlow(FLOW v, vec3 k, real speed, real derivative) {
  return largestOf3(k) <= max1(R(8.673617379884035e-19), R(9.5367431640625e-07) * derivative) ||
         speed < v.slowest;
}

// What is left up to a limit, which is a pair.
FN real leftOf(real limit, real limitRest, real x, real rest) { return (limit - x) + (limitRest - rest); }

// Tries one step in the cell. `k` and `speed` are those at f; h is 0 for a new step, or what STEP_AGAIN left.
// Moves the head unless it returns STEP_AGAIN; `shape` is then the step, and `part` how much of it counts.
FN int tryStep(FLOW v, CellFlow p, real derivative, vec3 lo, vec3 hi, INOUT(vec3) f, INOUT(vec3) k,
               INOUT(real) speed, INOUT(real) h, INOUT(real) time, INOUT(real) timeRest, INOUT(real) length,
               INOUT(real) lengthRest, INOUT(int) stalled, INOUT(real) way, OUT(StepShape) shape,
               OUT(real) part, OUT(int) face, OUT(int) reason) {
  real timeLeft = leftOf(v.timeLimit, v.timeLimitRest, time, timeRest);
  real lengthLeft = leftOf(v.lengthLimit, v.lengthLimitRest, length, lengthRest);
  real most = h > R(0.0) ? h : stepTime(v, v.kappa / max1(derivative, R(1e-30)), lo, hi, f, k);
  real now = min1(most, timeLeft);
  vec3 kEnd;
  real speedEnd;
  shape = flowStep(p, make_v3(v.spacingX, v.spacingY, v.spacingZ), f, k, speed, now, kEnd, speedEnd);
  real s;
  int result = judgeStep(shape.b0, shape.b1, shape.b2, shape.b3, lo, hi, s, face);
  real gone = result == STEP_EXIT ? stepLength(shape, s) : shape.l3;
  // The limit of length is met on the step's way, as faces are.
  bool ends = result != STEP_AGAIN && gone >= lengthLeft;
  if (ends) {
    s = partOfLength(shape, s, lengthLeft);
    if (s < R(0.5)) result = STEP_AGAIN;
    if (s < R(0.5)) s = STEP_OVER * s;
    ends = result != STEP_AGAIN;
  }
  reason = LINE_GOES_ON;
  part = s;
  stalled += TRIAL;
  if (result == STEP_AGAIN) {
    h = now * s;
  } else {
    bool exits = result == STEP_EXIT && !ends;
    vec3 point = s < R(1.0) ? stepPoint(shape, s) : shape.b3;
    vec3 g =
        make_v3(intoCell(point.x, lo.x, hi.x), intoCell(point.y, lo.y, hi.y), intoCell(point.z, lo.z, hi.z));
    if (exits) {
      bool up = (face & 1) != 0;
      g = make_v3(face < 2 ? (up ? hi.x : lo.x) : g.x, face >= 2 && face < 4 ? (up ? hi.y : lo.y) : g.y,
                  face >= 4 ? (up ? hi.z : lo.z) : g.z);
    }
    way += largestOf3(g - f);
    bool moved = way > STEP_WAY;
    // On a face, unless the head slides along it.
    bool at = (onFace(g.x, lo.x, hi.x) && !(g.x == f.x && kEnd.x == R(0.0) && k.x == R(0.0))) ||
              (onFace(g.y, lo.y, hi.y) && !(g.y == f.y && kEnd.y == R(0.0) && k.y == R(0.0))) ||
              (onFace(g.z, lo.z, hi.z) && !(g.z == f.z && kEnd.z == R(0.0) && k.z == R(0.0)));
    if (!exits && at) result = STEP_FACE;
    stalled = moved ? stalled & ~(TRIAL - 1) : stalled;
    way = moved ? R(0.0) : way;
    addToPair(time, timeRest, now * s);
    addToPair(length, lengthRest, gone);
    if (!exits && !ends && now == timeLeft) {
      reason = LINE_TIME;
      time = v.timeLimit;
      timeRest = v.timeLimitRest;
    } else if (ends) {
      reason = LINE_LENGTH;
      length = v.lengthLimit;
      lengthRest = v.lengthLimitRest;
    }
    f = g;
    k = kEnd;
    speed = speedEnd;
    h = R(0.0);
    if (reason != LINE_GOES_ON) result = STEP_ENDS;
  }
  return result;
}

// What ends a line that has not reached a limit of its own: the limit of steps, or too many trials.
FN int endOfPatience(int stalled, real way) {
  int reason = LINE_GOES_ON;
  if ((stalled & (TRIAL - 1)) > MOST_CROSSINGS) reason = LINE_STUCK;
  if (stalled / TRIAL >= MOST_TRIALS) reason = way > R(0.0) ? LINE_STUCK : LINE_CLOSED;
  return reason;
}

// Whether a head has reached a limit before its next step.
FN int limitReached(FLOW v, real time, real timeRest, real length, real lengthRest, int steps) {
  int reason = LINE_GOES_ON;
  if (steps >= v.stepsLimit) reason = LINE_STEPS;
  if (!(leftOf(v.lengthLimit, v.lengthLimitRest, length, lengthRest) > R(0.0))) reason = LINE_LENGTH;
  if (!(leftOf(v.timeLimit, v.timeLimitRest, time, timeRest) > R(0.0))) reason = LINE_TIME;
  return reason;
}

// The multiple of v.interval with this number, as a pair, less another pair.
FN real multipleAfter(FLOW v, int number, real x, real rest) {
  real n = toReal(number);
  real product = n * v.interval;
  real lost = productError(n, v.interval, product) + n * v.intervalRest;
  return (product - x) + (lost - rest);
}

// How many multiples of v.interval, from number `next` on, are at or before a pair; up to rounding of the pair,
// so that a multiple at the end of a line counts.
FN int multiplesUntil(FLOW v, int next, real x, real rest) {
  int number = next;
  bool more = true;
  while (more) {
    real ahead = -multipleAfter(v, number, x, rest);
    more = ahead >= x * R(-1.4551915228366852e-11) && number < MOST_POINTS;
    real jump = min1(max1(floor(ahead / v.interval * R(0.999)) - R(1.0), R(0.0)), R(1000000.0));
    number += more ? 1 + toInt(jump) : 0;
  }
  return number - next;
}

// The part of a step at which the time, or the length, is the multiple with this number. `x` and `rest` are the
// time or length where the step begins.
FN real partAtTime(FLOW v, StepShape s, real part, int number, real x, real rest) {
  real u = multipleAfter(v, number, x, rest) / s.h;
  return min1(max1(u, R(0.0)), part);
}
FN real partAtLength(FLOW v, StepShape s, real part, int number, real x, real rest) {
  return partOfLength(s, part, multipleAfter(v, number, x, rest));
}
