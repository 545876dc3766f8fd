// SPDX-License-Identifier: Apache-2.0
// The lists of rays that a packet becomes, and what it counts. Ray i of a list is in block i / BLOCK_RAYS.

#define uint32 uint
#define int32 int
#define GXY_FIELD(type, name, primary, secondary) type name[BLOCK_RAYS];
#define GXY_DEVICE_FIELD(type, name) type name[BLOCK_RAYS];
struct RayBlock {
  GXY_RAY_FIELDS(GXY_FIELD)
  GXY_DEVICE_FIELDS(GXY_DEVICE_FIELD)
};
#undef GXY_FIELD
#undef GXY_DEVICE_FIELD

layout(std430, set = LANE_SET, binding = RAYS_BINDING) buffer Rays { RayBlock rays[]; };
layout(std430, set = LANE_SET, binding = ACTIVE_BINDING) buffer ActiveRays { RayBlock activeRays[]; };
layout(std430, set = LANE_SET, binding = HERE_BINDING) buffer HereRays { RayBlock hereRays[]; };
layout(std430, set = LANE_SET, binding = LEAVING_BINDING) buffer LeavingRays { RayBlock leavingRays[]; };
layout(std430, set = LANE_SET, binding = RECORDS_BINDING) buffer Records { int records[]; };
layout(std430, set = LANE_SET, binding = DEPTHS_BINDING) buffer Depths { uint depths[]; };
layout(std430, set = LANE_SET, binding = COUNTS_BINDING) buffer Counts { uint counts[COUNT_WORDS]; };

// The block of this workgroup. Mesa's software device gives each core a run of workgroups, and waits for the last: there,
// neighbouring blocks, whose rays take alike, go to different cores (GROUP_ROWS divides the number of workgroups).
uint rayBlock = LIMITED ? gl_WorkGroupID.x % (gl_NumWorkGroups.x / GROUP_ROWS) * GROUP_ROWS +
                              gl_WorkGroupID.x / (gl_NumWorkGroups.x / GROUP_ROWS)
                        : gl_WorkGroupID.x;

// Field `name` of this invocation's ray, and of ray i of a list.
#define RAY(name) rays[rayBlock].name[gl_LocalInvocationIndex]
#define RAY_OF(list, i, name) list[(i) / BLOCK_RAYS].name[(i) % BLOCK_RAYS]

// Whether this invocation has a ray to do. Where a step has not been ended by all rays, those behind it do nothing.
bool hasRay() {
  int n = push[PUSH_RAYS];
  if (n < 0) n = int(counts[~n]);
  bool mine = int(rayBlock * BLOCK_RAYS + gl_LocalInvocationIndex) < n;
  if (LIMITED && mine) {
    bool cutBefore = counts[COUNT_CUT] > ~uint(push[PUSH_STEP]);
    mine = !cutBefore && RAY(step) <= push[PUSH_STEP];
  }
  return mine;
}

vec3 rayOrigin() { return vec3(RAY(ox), RAY(oy), RAY(oz)); }
vec3 rayDirection() { return vec3(RAY(dx), RAY(dy), RAY(dz)); }

void takeHit(float t, int kind, int op, uint primitive) {
  if (t < RAY(tHit) || (t == RAY(tHit) && op < RAY(hitOperator))) {
    RAY(tHit) = t;
    RAY(hitKind) = kind;
    RAY(hitOperator) = op;
    RAY(hitPrimitive) = primitive;
  }
}

// Mesa's software device ends all loops of an invocation, without a word, when they have gone round 65535 times together;
// the next loop then goes round once. On such a device (LIMITED) a stage that may come to that does a range of its work, asks
// at its end whether it was cut short, and if so forgets what it has done, and does half of the range when the host
// dispatches it again; if not, the range behind it. Ranges are of t, cut like partitions, of whose cuts nothing depends.
struct Part {
  float from, to, end;  // does [from, to) of what ends at `end`
};

Part partOf(float begin, float end) {
  Part p;
  p.from = begin;
  p.to = end;
  p.end = end;
  if (LIMITED && RAY(step) == ~push[PUSH_STEP]) {
    p.from = RAY(from);
    p.to = min(RAY(to), end);
  }
  return p;
}

bool wasCut() {
  int rounds = 0;
  for (int i = 0; i < push[PUSH_ROUNDS]; i++) rounds += push[PUSH_ONE];
  return rounds < push[PUSH_ROUNDS];
}

// Called last, in all invocations alike: whether the part was done. `over`: nothing is to be done behind it. `middle` is between
// its ends, or one of them where it cannot be halved.
bool endPart(Part p, float middle, float next, bool over) {
  if (!LIMITED) return true;
  bool cut = wasCut();
  bool ended = !cut && (over || !(p.to < p.end));
  if (cut && !(middle > p.from && middle < p.to)) {
    atomicAdd(counts[COUNT_STUCK], 1u);
    ended = true;
  }
  RAY(step) = ended ? push[PUSH_STEP] + 1 : ~push[PUSH_STEP];
  if (!ended) {
    RAY(from) = cut ? p.from : p.to;
    RAY(to) = cut ? middle : next;
    atomicMax(counts[COUNT_CUT], ~uint(push[PUSH_STEP]));
  }
  return !cut;
}
bool endPart(Part p, bool over) { return endPart(p, 0.5 * (p.from + p.to), p.to + (p.to - p.from), over); }

// All that a march does of the ray's part in this partition.
Part marchPart() { return partOf(RAY(tIn), min(RAY(tOut), RAY(tEnd))); }

MarchRange marchRange(Part p) {
  MarchRange m;
  m.tIn = p.from;
  m.tOut = p.to < p.end ? p.to : RAY(tOut);
  m.tOwn = m.tOut;
  m.tStart = RAY(tLast);
  m.tStop = min(RAY(tHit), RAY(tMax));
  m.tMin = theScene.tMin;
  return m;
}

Radiance rayRadiance() {
  Radiance L;
  L.rgb = vec3(RAY(r), RAY(g), RAY(b));
  L.A = RAY(A);
  return L;
}

void setRadiance(Radiance L) {
  RAY(r) = L.rgb.x;
  RAY(g) = L.rgb.y;
  RAY(b) = L.rgb.z;
  RAY(A) = L.A;
  if (1.0 - L.A < theScene.tMin) RAY(hitKind) = HIT_NONE;  // nothing behind is seen
}

// What a ray gives to its pixel.
void deposit(uint pixel, ivec4 sum) {
  if ((sum.x | sum.y | sum.z | sum.w) != 0) {
    uint at = RECORD_WORDS * atomicAdd(counts[COUNT_RECORDS], 1u);
    records[at] = int(pixel);
    records[at + 1u] = sum.x;
    records[at + 2u] = sum.y;
    records[at + 3u] = sum.z;
    records[at + 4u] = sum.w;
  }
}
