// SPDX-License-Identifier: Apache-2.0
// What the host side and the shaders of the Vulkan backend agree on. Read by C++ and GLSL: only macros here.
#ifndef GXY_SHADER_LAYOUT
#define GXY_SHADER_LAYOUT

// Rays of a workgroup, and of a block of a list (RayBlock: an array of this length for each field).
#define BLOCK_RAYS 64

// Specialization constants.
#define SPEC_ADDRESSED \
  0  // bits ADDRESSED_*: which buffers are read by address, being larger than a binding may be
#define SPEC_SAMPLE_KIND 1  // SAMPLE_* of all volumes, -1: of each its own
#define SPEC_SCALARS 2      // all volumes have one component
#define SPEC_SURFACES 3     // bits SURFACE_*: what there is to shade, or of what geometry there is
#define SPEC_ANY_HIT 4      // rays only ask whether geometry is in their way
#define SPEC_BY_CELLS 5     // some plans go cell by cell

#define ADDRESSED_TABLES 1
#define ADDRESSED_SAMPLES 2
#define ADDRESSED_GEOMETRY 4

#define SURFACE_PARTICLES 1
#define SURFACE_PATHLINES 2
#define SURFACE_TRIANGLES 4
#define SURFACE_FIELDS 8  // slices and isosurfaces

#define SCENE_SET 0
#define SCENE_BINDING 0
#define OPERATORS_BINDING 1
#define FIELDS_BINDING 2
#define TABLES_BINDING 3
#define SAMPLES_BINDING 4
#define GEOMETRY_BINDING 5
#define ADDRESSES_BINDING 6  // of tables, samples and geometry
#define SCENE_BINDINGS 7

#define FRAME_SET 1
#define FRAME_BINDING 0
#define FRAME_BINDINGS 1

#define LANE_SET 2
#define RAYS_BINDING 0
#define ACTIVE_BINDING 1   // rays that go on behind a translucent surface
#define MADE_BINDING 2     // secondary rays
#define LEAVING_BINDING 3  // rays for other partitions
#define RECORDS_BINDING 4  // contributions: pixel, r, g, b, a
#define DEPTHS_BINDING 5   // pixel, and a double in two words, low first
#define COUNTS_BINDING 6
#define LANE_BINDINGS 7

#define RECORD_WORDS 5
#define DEPTH_WORDS 3

// Words of the buffer of counts.
#define COUNT_ACTIVE 0
#define COUNT_MADE 1
#define COUNT_LEAVING 2
#define COUNT_RECORDS 3
#define COUNT_DEPTHS 4
#define COUNT_SHADED 5
#define COUNT_SAMPLES 6
#define COUNT_MACROCELLS 7
#define COUNT_SKIPPED 8
#define COUNT_CELLS 9
#define COUNT_ISO_SKIPPED 10
#define COUNT_CUT 11  // rays whose loops the device has ended
#define COUNT_WORDS 16

// Push constants: word i is called so in the stage that reads it.
#define PUSH_RAYS 0      // number of rays of the list
#define PUSH_OPERATOR 1  // of a field; or of several volumes: where the list of them is in the tables
#define PUSH_COUNT 2     // length of that list
#define PUSH_TILE 1      // x0, y0, x1, y1, sample
#define PUSH_ONE 6       // the number 1, which no compiler knows
#define PUSH_ROUNDS 7    // another number
#define PUSH_WORDS 8

// A node of the hierarchy over geometry has four children: 6 x 4 bounds (low x of all, low y, ..., high z), and a word for
// each: a leaf's is NODE_LEAF, its number of primitives and its first entry in the list of primitives; another's is its
// node. Absent children are NODE_NONE. An entry is two words: operator, primitive.
#define NODE_WORDS 28
#define NODE_NONE 0xffffffffu
#define NODE_LEAF 0x80000000u
#define NODE_COUNT_SHIFT 28  // 3 bits: the number, less 1
#define NODE_FIRST 0x0fffffffu
#define STACK_ENTRIES 96
#endif
