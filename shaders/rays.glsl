// SPDX-License-Identifier: Apache-2.0
// The lists of rays that a packet becomes, and what it counts. Ray i of a list is in block i / BLOCK_RAYS.

#define uint32 uint
#define int32 int
#define GXY_FIELD(type, name, primary, secondary) type name[BLOCK_RAYS];
struct RayBlock {
  GXY_RAY_FIELDS(GXY_FIELD)
};
#undef GXY_FIELD

layout(std430, set = LANE_SET, binding = RAYS_BINDING) buffer Rays { RayBlock rays[]; };
layout(std430, set = LANE_SET, binding = ACTIVE_BINDING) buffer ActiveRays { RayBlock activeRays[]; };
layout(std430, set = LANE_SET, binding = MADE_BINDING) buffer MadeRays { RayBlock madeRays[]; };
layout(std430, set = LANE_SET, binding = LEAVING_BINDING) buffer LeavingRays { RayBlock leavingRays[]; };
layout(std430, set = LANE_SET, binding = RECORDS_BINDING) buffer Records { int records[]; };
layout(std430, set = LANE_SET, binding = DEPTHS_BINDING) buffer Depths { uint depths[]; };
layout(std430, set = LANE_SET, binding = COUNTS_BINDING) buffer Counts { uint counts[COUNT_WORDS]; };

// Field `name` of this invocation's ray, and of ray i of a list.
#define RAY(name) rays[gl_WorkGroupID.x].name[gl_LocalInvocationIndex]
#define RAY_OF(list, i, name) list[(i) / BLOCK_RAYS].name[(i) % BLOCK_RAYS]

// Whether this invocation has a ray.
bool hasRay() { return int(gl_GlobalInvocationID.x) < push[PUSH_RAYS]; }

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

MarchRange marchRange() {
  MarchRange m;
  m.tIn = RAY(tIn);
  m.tOut = RAY(tOut);
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

// Mesa's software device ends all loops of an invocation, without a word, when they have gone round 65535 times together;
// the next loop then goes round once. Called last by stages that may come to that, so that the host hears of it.
void countIfCut() {
  int rounds = 0;
  for (int i = 0; i < push[PUSH_ROUNDS]; i++) rounds += push[PUSH_ONE];
  if (rounds < push[PUSH_ROUNDS]) atomicAdd(counts[COUNT_CUT], 1u);
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
