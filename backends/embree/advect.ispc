// SPDX-License-Identifier: Apache-2.0
// Heads of lines go through vector fields, a head in each lane. A lane whose head has ended takes the next.
// clang-format off
#include "core/kernels/dialect.h"
#include "core/kernels/all.h"
#include "core/kernels/cells.h"
#include "backends/embree/volume_fetch.isph"
#include "core/kernels/lines.h"
#include "core/rays/head_fields.h"
#include "core/rays/stored_fields.h"
#include "core/kernels/export.h"
// clang-format on

struct HeadView {
#define GXY_FIELD(type, name, sent) uniform type* uniform name;
  GXY_HEAD_FIELDS(GXY_FIELD)
#undef GXY_FIELD
};

struct StoredView {
#define GXY_FIELD(type, name) uniform type* uniform name;
  GXY_STORED_FIELDS(GXY_FIELD)
#undef GXY_FIELD
};

// What a call writes besides heads: stored points, and counts.
struct Output {
  const uniform StoredView* uniform stored;
  uniform int count, capacity;
  uniform int64 cells, steps;
};
#define OUTPUT uniform Output&
#define STEPS_A_CELL 8  // so many trial steps count as a cell, where a call is to end

static inline vec3 spacingOf(FLOW v) { return make_v3(v.spacingX, v.spacingY, v.spacingZ); }

static inline float velocityOf(FLOW v, float stored, float scale, float shift) {
  float x = stored;
  if (v.flush != 0) x = flushSmall(stored);
  return x * scale + shift;
}

// The velocities at a cell's corners, from three components that stand together.
static inline CellVectors cellVectors(FLOW v, const uniform VolumeView* uniform vectors, ivec3 cell, float sign) {
  CellVectors c;
  vec3 scale = make_v3(v.scaleX * sign, v.scaleY * sign, v.scaleZ * sign);
  vec3 shift = make_v3(v.shiftX * sign, v.shiftY * sign, v.shiftZ * sign);
#define AT(corner)                                                                                     \
  c.corner = make_v3(velocityOf(v, x.corner, scale.x, shift.x), velocityOf(v, y.corner, scale.y, shift.y), \
                     velocityOf(v, z.corner, scale.z, shift.z))
  CellValues x = cellValues(vectors[0], cell);
  CellValues y = cellValues(vectors[1], cell);
  CellValues z = cellValues(vectors[2], cell);
  AT(v000);
  AT(v100);
  AT(v010);
  AT(v110);
  AT(v001);
  AT(v101);
  AT(v011);
  AT(v111);
#undef AT
  return c;
}

// Masked: for the rays that take part.
static inline void setHead(int& to, int head) { to = head; }

// Stores a point of each active head, in a row of which the idle lanes have no head (-1): to compress each array
// takes longer than to leave gaps. A speed that is not finite is NaN, always with the same bits.
static inline void store(OUTPUT out, int head, int number, ivec3 cell, vec3 f, float time, float timeRest,
                         float length, float lengthRest, float speed) {
  const uniform StoredView& s = *out.stored;
  uniform int at = out.count;
  int owner;
  unmasked { owner = -1; }
  setHead(owner, head);
  unmasked {
    s.head[at + programIndex] = owner;
    s.number[at + programIndex] = number;
    s.cellX[at + programIndex] = cell.x;
    s.cellY[at + programIndex] = cell.y;
    s.cellZ[at + programIndex] = cell.z;
    s.fx[at + programIndex] = f.x;
    s.fy[at + programIndex] = f.y;
    s.fz[at + programIndex] = f.z;
    s.time[at + programIndex] = time;
    s.timeRest[at + programIndex] = timeRest;
    s.length[at + programIndex] = length;
    s.lengthRest[at + programIndex] = lengthRest;
    s.speed[at + programIndex] = speed - speed == 0.0f ? speed : floatbits(0x7fc00000u);
  }
  out.count = at + programCount;
}

// Whether the head may be in the condition that ends its line. `field` may be null.
static inline bool meets(FLOW v, const uniform VolumeView* uniform field, ivec3 cell, vec3 f) {
  bool met = false;
  if (field != NULL) {
    CellValues c = cellValues(*field, cell);
    float x = trilinear(c, f);
    met = holdsData(c) && x >= v.conditionLow && x <= v.conditionHigh;
  }
  return met;
}

// Advances the heads `which`, in turn. Those whose `reason` is then LINE_GOES_ON go on in another call: because
// there was no room for more stored points (the result is true), or because heads have been in `most` cells, or have made as
// many steps as these take.
EXPORT uniform bool advanceHeads(const void* uniform flowPointer, const void* uniform vectorsPointer,
                                 const void* uniform fieldPointer, void* uniform headsPointer,
                                 const uniform int which[], uniform int n, uniform int64 most,
                                 void* uniform storedPointer, uniform int capacity, uniform int& stored,
                                 uniform int64 counts[]) {
  const uniform FlowView* uniform flowView = (const uniform FlowView* uniform)flowPointer;
  FLOW v = *flowView;
  const uniform VolumeView* uniform vectors = (const uniform VolumeView* uniform)vectorsPointer;
  const uniform VolumeView* uniform field = (const uniform VolumeView* uniform)fieldPointer;
  uniform HeadView* uniform headView = (uniform HeadView* uniform)headsPointer;
  uniform HeadView& heads = *headView;
  uniform Output out;
  out.stored = (const uniform StoredView* uniform)storedPointer;
  out.count = stored;
  out.capacity = capacity;
  out.cells = 0;
  out.steps = 0;
  const uniform bool byCells = v.points == POINTS_CELLS;
  const uniform bool byTime = v.points == POINTS_TIME;
  const uniform bool multiples = byTime || v.points == POINTS_LENGTH;
  uniform int next = 0;
  uniform bool full = false;

  int head = -1;
  ivec3 cell = make_i3(0, 0, 0);
  vec3 f = make_v3(0.0f, 0.0f, 0.0f);
  float sign = 1.0f;
  float time = 0.0f, timeRest = 0.0f, length = 0.0f, lengthRest = 0.0f, way = 0.0f;
  int steps = 0, points = 0, stalled = 0, reason = LINE_GOES_ON;
  bool fresh = false;
  bool again = false;  // the head is in the cell that it was in before

  while (true) {
    uniform bool stops = full || out.cells + out.steps / STEPS_A_CELL >= most;
    // Heads that have ended, or that wait for another call, are put down.
    bool down = head >= 0 && (reason != LINE_GOES_ON || full || (stops && !(byCells && fresh)));
    if (down) {
      bool ended = reason != LINE_GOES_ON && reason != LINE_LEAVES;
      bool stores = byCells ? fresh : v.points == POINTS_ENDS && length > 0.0f;
      if (ended && stores) {
        CellFlow p = cellFlow(cellVectors(v, vectors, cell, sign));
        store(out, head, points, cell, f, time, timeRest, length, lengthRest, flowSpeed(flowAt(p, f), spacingOf(v)));
        points += 1;
        fresh = false;
      }
      heads.cellX[head] = cell.x;
      heads.cellY[head] = cell.y;
      heads.cellZ[head] = cell.z;
      heads.fx[head] = f.x;
      heads.fy[head] = f.y;
      heads.fz[head] = f.z;
      heads.time[head] = time;
      heads.timeRest[head] = timeRest;
      heads.length[head] = length;
      heads.lengthRest[head] = lengthRest;
      heads.steps[head] = steps;
      heads.points[head] = points;
      heads.stalled[head] = stalled;
      heads.way[head] = way;
      heads.fresh[head] = fresh ? 1 : 0;
      heads.reason[head] = reason;
      head = -1;
    }
    // Idle lanes take the next heads.
    bool idle = head < 0;
    uniform int wanted = reduce_add(idle ? 1 : 0);
    if (!stops && wanted > 0 && next < n) {
      int place = next + exclusive_scan_add(idle ? 1 : 0);
      if (idle && place < n) {
        head = which[place];
        cell = make_i3(heads.cellX[head], heads.cellY[head], heads.cellZ[head]);
        f = make_v3(heads.fx[head], heads.fy[head], heads.fz[head]);
        sign = (heads.info[head] & HEAD_BACKWARD) != 0 ? -1.0f : 1.0f;
        time = heads.time[head];
        timeRest = heads.timeRest[head];
        length = heads.length[head];
        lengthRest = heads.lengthRest[head];
        steps = heads.steps[head];
        points = heads.points[head];
        stalled = heads.stalled[head];
        way = heads.way[head];
        fresh = heads.fresh[head] != 0;
        again = false;
        reason = LINE_GOES_ON;
      }
      next = min(next + wanted, n);
    }
    if (none(head >= 0)) break;
    // Each lane may store its seed, where it leaves the cell, and its end.
    if (out.count + 4 * programCount > out.capacity) {
      full = true;
      continue;
    }

    if (head >= 0) {
      out.cells += reduce_add(again ? 0 : 1);
      again = false;
      CellVectors c = cellVectors(v, vectors, cell, sign);
      bool data = holdsVectors(c);
      CellFlow p = cellFlow(c);
      if (points == 0) {
        store(out, head, 0, cell, f, time, timeRest, length, lengthRest, flowSpeed(flowAt(p, f), spacingOf(v)));
        points = 1;
        fresh = false;
      }
      vec3 lo = cellLow(v, cell);
      vec3 hi = cellHigh(v, cell);
      vec3 k = flowOnFaces(c, f, flowAt(p, f));
      float derivative = flowDerivative(c);
      float speed = flowSpeed(k, spacingOf(v));
      reason = endOfPatience(stalled, way);
      if (!data) reason = LINE_NO_DATA;
      if (reason == LINE_GOES_ON) reason = limitReached(v, time, timeRest, length, lengthRest, steps);
      if (field != NULL) {
        if (reason == LINE_GOES_ON && meets(v, field, cell, f)) reason = LINE_CONDITION;
      }
      int face = faceAtOnce(f, k, lo, hi);
      bool exits = reason == LINE_GOES_ON && face >= 0;
      if (reason == LINE_GOES_ON && !exits && isSlow(v, k, speed, derivative)) reason = LINE_SLOW;
      float h = 0.0f;
      int trials = stalled;
      bool goes = reason == LINE_GOES_ON && !exits;
      uniform int began = reduce_add(goes ? 1 : 0);
      while (goes) {
        out.steps += reduce_add(1);
        vec3 fBefore = f;
        float timeBefore = time;
        float timeRestBefore = timeRest;
        float lengthBefore = length;
        float lengthRestBefore = lengthRest;
        float wayBefore = way;
        StepShape shape;
        float part;
        int ends;
        int result = tryStep(v, p, derivative, lo, hi, f, k, speed, h, time, timeRest, length, lengthRest, stalled, way,
                             shape, part, face, ends);
        if (result == STEP_AGAIN) {
          reason = endOfPatience(stalled, way);
        } else {
          fresh = true;
          reason = ends;
          bool unstored = false;
          if (multiples) {
            int number = byTime ? multiplesUntil(v, points, time, timeRest) : multiplesUntil(v, points, length, lengthRest);
            while (number > 0) {
              if (out.count + 2 * programCount > out.capacity) {
                full = true;
                unstored = true;
                number = 0;
              } else {
                float u = byTime ? partAtTime(v, shape, part, points, timeBefore, timeRestBefore)
                                 : partAtLength(v, shape, part, points, lengthBefore, lengthRestBefore);
                vec3 at = stepPoint(shape, u);
                vec3 g = make_v3(intoCell(at.x, lo.x, hi.x), intoCell(at.y, lo.y, hi.y), intoCell(at.z, lo.z, hi.z));
                float t = timeBefore;
                float tRest = timeRestBefore;
                float l = lengthBefore;
                float lRest = lengthRestBefore;
                addToPair(t, tRest, shape.h * u);
                addToPair(l, lRest, stepLength(shape, u));
                store(out, head, points, cell, g, t, tRest, l, lRest, flowSpeed(flowAt(p, g), spacingOf(v)));
                points += 1;
                number -= 1;
              }
            }
          }
          if (unstored) {
            // The step is done again by the next call, which stores the rest of its points.
            f = fBefore;
            time = timeBefore;
            timeRest = timeRestBefore;
            length = lengthBefore;
            lengthRest = lengthRestBefore;
            way = wayBefore;
            stalled = trials;
            reason = LINE_GOES_ON;
            goes = false;
          } else {
            trials = stalled;
            if (reason == LINE_GOES_ON && points >= MOST_POINTS) reason = LINE_STUCK;
            if (field != NULL) {
              if (reason == LINE_GOES_ON && meets(v, field, cell, f)) reason = LINE_CONDITION;
            }
            if (reason == LINE_GOES_ON && result == STEP_INSIDE && isSlow(v, k, speed, derivative)) reason = LINE_SLOW;
            exits = reason == LINE_GOES_ON && result == STEP_EXIT;
            goes = result == STEP_INSIDE;
            if (goes && reason == LINE_GOES_ON) {
              reason = limitReached(v, time, timeRest, length, lengthRest, steps);
              if (reason == LINE_GOES_ON) reason = endOfPatience(stalled, way);
            }
          }
        }
        goes = goes && reason == LINE_GOES_ON;
        // Where few lanes are left, they come back with the others' next cells. That changes no bit: between steps,
        // and off the faces, the velocity is that which the cell gives anew.
        uniform int going = reduce_add(goes ? 1 : 0);
        if (going * 3 < began) {
          bool onAny = onFace(f.x, lo.x, hi.x) || onFace(f.y, lo.y, hi.y) || onFace(f.z, lo.z, hi.z);
          again = goes && result == STEP_INSIDE && !onAny;
          goes = goes && !again;
        }
      }
      if (exits) {
        if (byCells && fresh) {
          store(out, head, points, cell, f, time, timeRest, length, lengthRest, flowSpeed(flowAt(p, f), spacingOf(v)));
          points += 1;
          fresh = false;
        }
        stalled = (stalled & (TRIAL - 1)) + 1;
        reason = crossFace(v, face, cell, f);
        steps += 1;
      }
    }
  }
  stored = out.count;
  counts[0] += out.cells;
  counts[1] += out.steps;
  return full;
}

// Stored values of a component at stored points; NaN without data. Nothing at places without a head.
EXPORT void recordValues(const void* uniform viewPointer, const void* uniform storedPointer, uniform int n,
                         uniform float values[]) {
  const uniform VolumeView* uniform view = (const uniform VolumeView* uniform)viewPointer;
  const uniform StoredView* uniform s = (const uniform StoredView* uniform)storedPointer;
  foreach (i = 0 ... n) {
    if (s->head[i] >= 0) {
      CellValues c = cellValues(*view, make_i3(s->cellX[i], s->cellY[i], s->cellZ[i]));
      float x = trilinear(c, make_v3(s->fx[i], s->fy[i], s->fz[i]));
      values[i] = holdsData(c) ? x : floatbits(0x7fc00000u);
    }
  }
}
