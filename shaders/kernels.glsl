// SPDX-License-Identifier: Apache-2.0
// Included by every stage: core/kernels, and the buffers that a stage reads.
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#define GXY_GLSL
#include "shaders/layout.h"
#include "core/kernels/dialect.h"
#include "core/kernels/all.h"
#include "core/rays/ray_fields.h"

layout(local_size_x = BLOCK_RAYS) in;

layout(constant_id = SPEC_ADDRESSED) const int ADDRESSED = 0;
layout(constant_id = SPEC_SAMPLE_KIND) const int SAMPLE_KIND = -1;
layout(constant_id = SPEC_SCALARS) const bool SCALARS = false;
layout(constant_id = SPEC_SURFACES) const int SURFACES = 127;
layout(constant_id = SPEC_ANY_HIT) const bool ANY_HIT = false;

layout(constant_id = SPEC_BY_CELLS) const bool BY_CELLS = true;
layout(constant_id = SPEC_LIMITED) const bool LIMITED = false;
layout(constant_id = SPEC_MAP_KIND) const int MAP_KIND = -1;
layout(constant_id = SPEC_OPERATORS) const int OPERATORS = 0;
layout(constant_id = SPEC_ROUTES) const int ROUTES = ROUTE_ON | ROUTE_LEAVES;
layout(constant_id = SPEC_MAP_AHEAD) const int MAP_AHEAD = 0;
layout(constant_id = SPEC_ROUNDS_RIGHT) const bool ROUNDS_RIGHT = false;  // for cmake/MakeShader.cmake
#define GOES_ON ((ROUTES & ROUTE_ON) != 0)
#define LEAVES ((ROUTES & ROUTE_LEAVES) != 0)

layout(push_constant) uniform Push { int push[PUSH_WORDS]; };

// Words of the scene, from a binding of words or of quads, or by address.
layout(set = SCENE_SET, binding = TABLES_BINDING) uniform usamplerBuffer tables;
layout(set = SCENE_SET, binding = SAMPLES_BINDING) uniform usamplerBuffer samples;
layout(set = SCENE_SET, binding = GEOMETRY_BINDING) uniform usamplerBuffer geometry;
layout(set = SCENE_SET, binding = TABLE_QUADS_BINDING) uniform usamplerBuffer tableQuads;
layout(set = SCENE_SET, binding = GEOMETRY_QUADS_BINDING) uniform usamplerBuffer geometryQuads;
layout(set = SCENE_SET, binding = SAMPLE_QUADS_BINDING) uniform usamplerBuffer sampleQuads;
layout(std430, set = SCENE_SET, binding = TABLES_AHEAD_BINDING) readonly buffer TablesAhead { vec4 tablesAhead[]; };
layout(std430, set = SCENE_SET, binding = ADDRESSES_BINDING) readonly buffer Addresses {
  uint64_t tablesAddress, samplesAddress, geometryAddress;
};
layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer Words { uint word[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Quads { uvec4 quad[]; };

// Word i of an array of quads (four words each), of which `quad` is the one that has it.
uint wordOf(uvec4 quad, uint i) {
  bool odd = (i & 1u) != 0u;
  return (i & 2u) != 0u ? (odd ? quad.w : quad.z) : (odd ? quad.y : quad.x);
}

uint tableWord(uint i) {
  uint value;
  if ((ADDRESSED & ADDRESSED_TABLES) != 0)
    value = Words(tablesAddress).word[i];
  else if ((ADDRESSED & QUADS_TABLES) != 0)
    value = wordOf(texelFetch(tableQuads, int(i >> 2)), i);
  else
    value = texelFetch(tables, int(i)).x;
  return value;
}
float tableReal(uint i) { return uintBitsToFloat(tableWord(i)); }
// Words i to i + 3, where i is a multiple of 4.
uvec4 tableQuad(uint i) {
  uvec4 value;
  if ((ADDRESSED & ADDRESSED_TABLES) != 0)
    value = Quads(tablesAddress).quad[i >> 2];
  else
    value = texelFetch(tableQuads, int(i >> 2));
  return value;
}
// Word i of the samples that begin at `place`, in units of 16 bytes.
uint sampleWord(uint place, uint i) {
  uint value;
  if ((ADDRESSED & ADDRESSED_SAMPLES) != 0)
    value = Words(samplesAddress + 16ul * uint64_t(place) + 4ul * uint64_t(i)).word[0];
  else if ((ADDRESSED & QUADS_SAMPLES) != 0)
    value = wordOf(texelFetch(sampleQuads, int(place + (i >> 2))), i);
  else
    value = texelFetch(samples, int(4u * place + i)).x;
  return value;
}
uint geometryWord(uint i) {
  uint value;
  if ((ADDRESSED & ADDRESSED_GEOMETRY) != 0)
    value = Words(geometryAddress).word[i];
  else if ((ADDRESSED & QUADS_GEOMETRY) != 0)
    value = wordOf(texelFetch(geometryQuads, int(i >> 2)), i);
  else
    value = texelFetch(geometry, int(i)).x;
  return value;
}
uvec4 geometryQuad(uint i) {
  uvec4 value;
  if ((ADDRESSED & ADDRESSED_GEOMETRY) != 0)
    value = Quads(geometryAddress).quad[i >> 2];
  else
    value = texelFetch(geometryQuads, int(i >> 2));
  return value;
}
float geometryReal(uint i) { return uintBitsToFloat(geometryWord(i)); }

#define locateCell locateCellByLoops  // renames grid.h's; volume_fetch.glsl has one without loops
#include "core/kernels/cells.h"
#include "shaders/map_fetch.glsl"
#include "shaders/volume_fetch.glsl"
#include "core/kernels/fields.h"
#include "core/kernels/scene_view.h"
#include "shaders/scene_fetch.glsl"
#include "core/kernels/scene.h"
