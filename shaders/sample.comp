// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require
// The act of a sampling on the hits of its rays (the list that finish.comp makes): appends what is recorded of a hit that
// counts, and lists the rays that go on behind the surface. A ray has one hit at a time, so there is always a place for it.
#include "shaders/kernels.glsl"
#include "shaders/rays.glsl"
#include "core/kernels/sampling_view.h"

// The arrays of the view are places in the words behind it; `field` is the number of the first field among `fields`.
layout(std430, set = FRAME_SET, binding = FRAME_BINDING) readonly buffer SamplingBuffer {
  SamplingView samplingBuffer;
  int samplingWords[];
};
SamplingView theSampling = samplingBuffer;

// The value of field f where the ray has met operator `op`.
float fieldMet(int f, int op, vec3 o, vec3 d) {
  float value = asReal(0x7fc00000u);
  if (samplingWords[theSampling.isovalueOf + uint(op * theSampling.fields + f)] != 0 && GIVEN(hitKind) == HIT_ISOSURFACE) {
    value = isovalueOf(fieldOf(op), GIVEN(hitPrimitive));
  } else {
    VolumeView v = fieldOf(int(theSampling.field) + f);
    if (holdsSamples(v)) value = valueMet(v, o, d, GIVEN(tHit));
  }
  return value;
}

vec3 gradientOf(int op, vec3 o, vec3 d) {
  float none = asReal(0x7fc00000u);
  vec3 gradient = vec3(none, none, none);
  if (operatorOf(op).kind == KIND_VOLUME) gradient = gradientMet(fieldOf(op), o, d, GIVEN(tHit));
  return gradient;
}

#define COPY_FIELD(type, name, primary, secondary) \
  if (primary + secondary > 0) RAY_OF(activeRays, i, name) = GIVEN(name);

void main() {
  int fields = theSampling.fields;
  if (!hasRay()) return;
  givenPlace = placeOf(GIVEN(shaded));
  int op = GIVEN(hitOperator);
  vec3 o = rayOrigin(), d = rayDirection();
  float value[MOST_SAMPLED_FIELDS];
  for (int f = 0; f < fields; f++) value[f] = fieldMet(f, op, o, d);
  bool holds = true;
  for (int c = 0; c < theSampling.conditions; c++) {
    if (samplingWords[theSampling.conditionOperator + uint(c)] == op) {
      uint range = theSampling.conditionRange + 2u * uint(c);
      float x = value[samplingWords[theSampling.conditionField + uint(c)]];
      holds = holds && inRange(x, intBitsToFloat(samplingWords[range]), intBitsToFloat(samplingWords[range + 1u]));
    }
  }
  uint hits = RAY_HITS(GIVEN(info));
  if (holds) {
    int words = SAMPLE_WORDS + fields + (theSampling.gradient != 0 ? 3 : 0);
    uint at = uint(words) * takePlace(COUNT_RECORDS);
    records[at] = int(GIVEN(pixel));
    records[at + 1u] = GIVEN(sr);
    records[at + 2u] = int(hits);
    records[at + 3u] = GIVEN(sg);
    records[at + 4u] = op;
    records[at + 5u] = floatBitsToInt(GIVEN(tHit));
    records[at + 6u] = floatBitsToInt(o.x);
    records[at + 7u] = floatBitsToInt(o.y);
    records[at + 8u] = floatBitsToInt(o.z);
    records[at + 9u] = floatBitsToInt(d.x);
    records[at + 10u] = floatBitsToInt(d.y);
    records[at + 11u] = floatBitsToInt(d.z);
    records[at + 12u] = GIVEN(hitKind);
    records[at + 13u] = int(GIVEN(hitPrimitive));
    at += uint(SAMPLE_WORDS);
    for (int f = 0; f < fields; f++) records[at + uint(f)] = floatBitsToInt(value[f]);
    if (theSampling.gradient != 0) {
      vec3 gradient = gradientOf(op, o, d);
      at += uint(fields);
      records[at] = floatBitsToInt(gradient.x);
      records[at + 1u] = floatBitsToInt(gradient.y);
      records[at + 2u] = floatBitsToInt(gradient.z);
    }
    hits++;
  }
  if (!holds || int(hits) < samplingWords[theSampling.hits + uint(op)]) {
    uint i = takePlace(COUNT_ACTIVE_SECONDARIES);
    GXY_RAY_FIELDS(COPY_FIELD)
    RAY_OF(activeRays, i, info) = (GIVEN(info) & ~0xffffu) | hits;
    RAY_OF(activeRays, i, tLast) = GIVEN(tHit);
    RAY_OF(activeRays, i, lastOperator) = op;
    RAY_OF(activeRays, i, lastPrimitive) = numberOf(GIVEN(hitKind), GIVEN(hitPrimitive));
    RAY_OF(activeRays, i, tResume) = -1.0;
    RAY_OF(activeRays, i, packet) = GIVEN(packet);
    RAY_OF(activeRays, i, step) = 0;
  }
  endStage();
}
