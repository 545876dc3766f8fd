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

// The place of each field in a block.
#define GXY_NUMBER(type, name, primary, secondary) uint name;
#define GXY_DEVICE_NUMBER(type, name) uint name;
struct FieldNumbers {
  GXY_RAY_FIELDS(GXY_NUMBER)
  GXY_DEVICE_FIELDS(GXY_DEVICE_NUMBER)
};
#undef GXY_NUMBER
#undef GXY_DEVICE_NUMBER
const FieldNumbers FIELD = FieldNumbers(0u, 1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u, 9u, 10u, 11u, 12u, 13u, 14u, 15u, 16u, 17u, 18u, 19u,
                                        20u, 21u, 22u, 23u, 24u, 25u, 26u, 27u, 28u, 29u, 30u, 31u, 32u, 33u);
#define BLOCK_WORDS ((FIELD.shaded + 1u) * BLOCK_RAYS)

layout(set = LANE_SET, binding = RAY_WORDS_BINDING) uniform usamplerBuffer rayWords;  // of `rays`
layout(set = LANE_SET, binding = TILES_BINDING) uniform usamplerBuffer tiles;
layout(std430, set = LANE_SET, binding = RAYS_BINDING) buffer Rays { RayBlock rays[]; };
layout(std430, set = LANE_SET, binding = ACTIVE_BINDING) buffer ActiveRays { RayBlock activeRays[]; };
layout(std430, set = LANE_SET, binding = HERE_BINDING) buffer HereRays { RayBlock hereRays[]; };
layout(std430, set = LANE_SET, binding = LEAVING_BINDING) buffer LeavingRays { RayBlock leavingRays[]; };
layout(std430, set = LANE_SET, binding = RECORDS_BINDING) buffer Records { int records[]; };
layout(std430, set = LANE_SET, binding = DEPTHS_BINDING) buffer Depths { uint depths[]; };
layout(std430, set = LANE_SET, binding = COUNTS_BINDING) buffer Counts { uint counts[COUNT_WORDS]; };

layout(buffer_reference, std430, buffer_reference_align = 16) buffer RaysAt { RayBlock block[]; };
uint64_t pushedAddress(int word) { return uint64_t(uint(push[word])) | (uint64_t(uint(push[word + 1])) << 32); }

// Rays for partition `next`, of this rank, stay on the device; the host reads no more of them than where they go.
#define stayingRays RaysAt(pushedAddress(PUSH_STAYING)).block
bool staysHere(int next) {
  return (push[PUSH_STAYING] | push[PUSH_STAYING + 1]) != 0 && tableWord(uint(push[PUSH_MINE] + next)) != 0u;
}

// Adds n to a count, and takes a place in the list of which it is the length: one atomic operation for a whole subgroup.
void countUp(int count, uint n) {
  uint sum = subgroupAdd(n);
  if (subgroupElect()) atomicAdd(counts[count], sum);
}
uint takePlace(int count) {
  uvec4 taking = subgroupBallot(true);
  uint first = 0u;
  if (subgroupElect()) first = atomicAdd(counts[count], subgroupBallotBitCount(taking));
  return subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(taking);
}

// The block of this workgroup. Mesa's software device gives each core a run of workgroups, and waits for the last: there,
// neighbouring blocks, whose rays take alike, go to different cores (GROUP_ROWS divides the number of workgroups).
uint rayBlock = LIMITED ? gl_WorkGroupID.x % (gl_NumWorkGroups.x / GROUP_ROWS) * GROUP_ROWS +
                              gl_WorkGroupID.x / (gl_NumWorkGroups.x / GROUP_ROWS)
                        : gl_WorkGroupID.x;

// Field `name` of this invocation's ray, to be written, and of ray i of a list.
#define RAY(name) rays[rayBlock].name[gl_LocalInvocationIndex]
#define RAY_OF(list, i, name) list[(i) / BLOCK_RAYS].name[(i) % BLOCK_RAYS]

// The same as the stage has found it, of this invocation's ray or of another one of the list, at givenPlace. By texels, since
// Mesa's software device gathers these, and reads storage buffers one invocation after the other. A stage that writes a field,
// too, reads it before.
uint givenPlace = rayBlock * BLOCK_WORDS + gl_LocalInvocationIndex;
uint placeOf(uint i) { return i / BLOCK_RAYS * BLOCK_WORDS + i % BLOCK_RAYS; }
#define GIVEN(name) given_##name()
void setBits(out float x, uint bits) { x = uintBitsToFloat(bits); }
void setBits(out uint x, uint bits) { x = bits; }
void setBits(out int x, uint bits) { x = int(bits); }
uint givenWord(uint field) { return texelFetch(rayWords, int(givenPlace + field * BLOCK_RAYS)).x; }
#define GXY_DEVICE_GIVEN(type, name)       \
  type given_##name() {                    \
    type value;                            \
    setBits(value, givenWord(FIELD.name)); \
    return value;                          \
  }
#define GXY_GIVEN(type, name, primary, secondary) GXY_DEVICE_GIVEN(type, name)
GXY_RAY_FIELDS(GXY_GIVEN)
GXY_DEVICE_FIELDS(GXY_DEVICE_GIVEN)
#undef GXY_GIVEN
#undef GXY_DEVICE_GIVEN

#include "shaders/resumable.glsl"

// Whether this invocation has a ray to work on.
bool hasRay() {
  int n = push[PUSH_RAYS];
  if (n < 0) n = int(counts[~n]);
  bool mine = int(rayBlock * BLOCK_RAYS + gl_LocalInvocationIndex) < n;
  if (mine) mine = stepIsDue();
  return mine;
}

vec3 rayOrigin() { return vec3(GIVEN(ox), GIVEN(oy), GIVEN(oz)); }
vec3 rayDirection() { return vec3(GIVEN(dx), GIVEN(dy), GIVEN(dz)); }

// What it has met last.
LastHit lastHit() { return LastHit(GIVEN(tLast), GIVEN(lastOperator), GIVEN(lastPrimitive)); }

// The nearest hit so far.
struct NearestHit {
  float t;
  int op;
};
NearestHit givenHit() { return NearestHit(GIVEN(tHit), GIVEN(hitOperator)); }

void takeHit(inout NearestHit nearest, float t, int kind, int op, uint primitive) {
  if (t < nearest.t || (t == nearest.t && op < nearest.op)) {
    nearest = NearestHit(t, op);
    RAY(tHit) = t;
    RAY(hitKind) = kind;
    RAY(hitOperator) = op;
    RAY(hitPrimitive) = primitive;
  }
}

// The whole of the ray that a march passes in this partition, or the slice of it that is due.
RaySlice marchSlice() { return sliceOf(GIVEN(tIn), min(GIVEN(tOut), GIVEN(tEnd))); }

MarchRange marchRange(RaySlice slice) {
  MarchRange m;
  m.tIn = slice.from;
  m.tOut = slice.to < slice.end ? slice.to : GIVEN(tOut);
  m.tOwnershipEnd = m.tOut;
  m.tStart = GIVEN(tLast);
  m.tStop = min(GIVEN(tHit), GIVEN(tMax));
  m.tMin = theScene.tMin;
  return m;
}

Radiance rayRadiance() {
  Radiance L;
  L.rgb = vec3(GIVEN(r), GIVEN(g), GIVEN(b));
  L.A = GIVEN(A);
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
    uint at = RECORD_WORDS * takePlace(COUNT_RECORDS);
    records[at] = int(pixel);
    records[at + 1u] = sum.x;
    records[at + 2u] = sum.y;
    records[at + 3u] = sum.z;
    records[at + 4u] = sum.w;
  }
}
