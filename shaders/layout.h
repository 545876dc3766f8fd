// SPDX-License-Identifier: Apache-2.0
// The data layout that the host side and the shaders of the Vulkan backend share. C++ and GLSL read this
// file, so it holds only macros.
#ifndef GXY_SHADER_LAYOUT
#define GXY_SHADER_LAYOUT

// The rays of a workgroup, and of a block of a list (RayBlock: an array of this length for each field).
#define BLOCK_RAYS 64
#define GROUP_ROWS 8u  // the number of workgroups of a list is a multiple of this

// Specialization constants.
#define SPEC_ADDRESSED \
  0  // bits ADDRESSED_*, QUADS_*: which buffers are too large for a binding of words, and how they are read
#define SPEC_SAMPLE_KIND 1  // SAMPLE_* of all volumes; -1: they differ
#define SPEC_SCALARS 2      // whether all volumes have one component
#define SPEC_SURFACES 3     // bits SURFACE_*: surfaces to shade, or to hit
#define SPEC_ANY_HIT 4      // whether rays only ask if a surface is in their way
#define SPEC_BY_CELLS 5     // whether some plans go cell by cell
#define SPEC_LIMITED 6     // whether the device ends an invocation's loops after some rounds (resumable.glsl)
#define SPEC_MAP_KIND 7    // MAP_KIND_* of all maps; -1: they differ
#define SPEC_OPERATORS 8   // number of operators: 1, FEW_OPERATORS (that or fewer), or 0 (any number)
#define SPEC_ROUTES 9      // bits ROUTE_*: where rays may go besides ending in their pixels
#define SPEC_MAP_AHEAD 10  // 4 or 8: the only map has at most this many intervals and is read ahead; else 0
// Whether the device rounds quotients and roots of floats right by itself. cmake/MakeShader.cmake adds what reads it.
#define SPEC_ROUNDS_RIGHT 11

#define FEW_OPERATORS 4

#define MAP_KIND_SMALL 0
#define MAP_KIND_UNIFORM 1
#define MAP_KIND_BUCKETS 2

#define ROUTE_ON 1      // they may go on behind a translucent surface
#define ROUTE_LEAVES 2  // they may go to other partitions

#define ADDRESSED_TABLES 1
#define ADDRESSED_SAMPLES 2
#define ADDRESSED_GEOMETRY 4
#define QUADS_TABLES 8  // words of the tables are picked from texels of four words
#define QUADS_SAMPLES 16
#define QUADS_GEOMETRY 32

#define SURFACE_PARTICLES 1
#define SURFACE_PATHLINES 2
#define SURFACE_TRIANGLES 4
#define SURFACE_FIELDS 8     // slices and isosurfaces
#define SURFACE_CLIPPED 16   // some surfaces are clipped by planes
#define SURFACE_CASTS 32     // surfaces make secondary rays
#define SURFACE_STARTS 64    // rays may start on an isosurface
#define SURFACE_COUNTS 128   // nodes and primitives of geometry are counted
#define SURFACE_SAMPLED 256  // rays sample surfaces, and give nothing to pixels
#define SURFACE_CELLS 512    // isosurfaces and slices of meshes of tetrahedra
#define SURFACE_HEXES 1024   // those of meshes of hexahedra; or the march through one

#define SCENE_SET 0
#define SCENE_BINDING 0
#define OPERATORS_BINDING 1
#define FIELDS_BINDING 2
#define TABLES_BINDING 3
#define SAMPLES_BINDING 4
#define GEOMETRY_BINDING 5
#define ADDRESSES_BINDING 6    // addresses of tables, samples and geometry
#define TABLE_QUADS_BINDING 7  // the tables as texels of four words
#define GEOMETRY_QUADS_BINDING 8
// The tables as a storage buffer, for what all invocations read alike (scene_fetch.glsl).
#define TABLES_AHEAD_BINDING 9
#define SAMPLE_QUADS_BINDING 10
#define SCENE_BINDINGS 11

#define FRAME_SET 1
#define FRAME_BINDING 0  // of a frame, or of a sampling
#define FRAME_BINDINGS 1

#define LANE_SET 2
#define RAYS_BINDING 0
#define ACTIVE_BINDING 1   // rays that go on behind a translucent surface
#define HERE_BINDING 2     // secondary rays that start in this partition
#define LEAVING_BINDING 3  // rays for other partitions; of those that stay on the device, only where they go
#define RECORDS_BINDING 4  // contributions: pixel, r, g, b, a; of a sampling: samples
#define DEPTHS_BINDING 5   // pixel, and a double in two words, low first
#define COUNTS_BINDING 6
#define RAY_WORDS_BINDING 7  // the words of RAYS_BINDING as texels
#define TILES_BINDING 8      // the words of RECORDS_BINDING as texels
#define LANE_BINDINGS 9

#define RECORD_WORDS 5
#define TILE_RAYS 1024u
#define DEPTH_WORDS 3
// A sample: number of the ray (low, high), of its hit, of its ancestors, operator, t, origin and direction of the ray, kind and number of
// what it has met; then the stored values of all fields of the sampling, and the gradient if it is asked for.
#define SAMPLE_WORDS 14
#define MOST_SAMPLED_FIELDS 16

// The fields of a ray on the device besides those of ray_fields.h: F(type, name).
//   packet    the packet of the batch that it came with
//   step      the number of the stage that it has to do next; ~step if it has begun that and not ended it
//   from, to  if it has begun the stage: the range of its work that comes next (resumable.glsl)
//   shaded    not a field of this ray: element i of the list is the number of the i-th primary of the list
//             that has hit a surface
#define GXY_DEVICE_FIELDS(F) F(uint32, packet) F(int32, step) F(float, from) F(float, to) F(uint32, shaded)

// Words of the buffer of counts.
#define COUNT_SPAWNED 0           // rays in the list of primaries, if the device has spawned them
#define COUNT_ACTIVE_PRIMARIES 1  // rays in the list of rays that go on, by their kind
#define COUNT_ACTIVE_SECONDARIES 2
#define COUNT_HERE 3
#define COUNT_LEAVING 4
#define COUNT_RECORDS 5
#define COUNT_DEPTHS 6
#define COUNT_MADE 7    // secondary rays, wherever they go
#define COUNT_SHADED 8  // primaries that have hit a surface
#define COUNT_SAMPLES 9
#define COUNT_MACROCELLS 10
#define COUNT_SKIPPED 11
#define COUNT_CELLS 12
#define COUNT_ISO_SKIPPED 13
#define COUNT_STUCK 14   // rays for which the device cannot do a stage, even in parts
#define COUNT_CUT 15     // ~step of the first stage that some rays have not ended; 0: none
#define COUNT_GROUPS 16  // x, y, z: number of workgroups of an indirect dispatch
#define COUNT_ENDED 19   // rays that ended early because nothing behind could be seen
#define COUNT_SEGMENTS_SKIPPED 20
#define COUNT_NODES 21  // with SURFACE_COUNTS: nodes that rays came to, and primitives of their leaves
#define COUNT_PRIMITIVES 22
#define COUNT_MESH_CELLS 23
#define COUNT_MESH_WALKS 24
#define COUNT_WORDS 25

// Push constants. The names are those of the words in the stages that read them.
#define PUSH_RAYS 0       // number of rays in the list; ~k: it is counts[k]
#define PUSH_STEP 1       // number of this stage among the submitted steps
#define PUSH_OPERATOR 2   // operator; for several volumes: the place of their list in the tables
#define PUSH_COUNT 3      // length of that list
#define PUSH_PARTITION 4  // partition in which rays are traced; -1: none
#define PUSH_TILES 5      // number of tiles
#define PUSH_MINE 6       // place in the tables: per partition, whether it is this rank's and visible
#define PUSH_ONE 7        // the number 1, which no compiler can know
#define PUSH_ROUNDS 8     // another number that no compiler can know
#define PUSH_STAYING 9    // two words, low first: address of the list of rays that stay here; 0: none stay
#define PUSH_TAKEN 11     // two words: address of such a list, from which rays are taken
#define PUSH_PLACES 13    // two words: address of the numbers of these rays in that list
#define PUSH_FIRST 15     // place of the first of them in the list that is traced
#define PUSH_PACKET 16    // the packet of the batch that they come with
#define PUSH_WORDS 17

// A hierarchy over geometry begins with two words: the place of its list of primitives, and the number of its
// nodes as a float, rounded up. Its nodes begin at word 4. A node has four children: 6 x 4 bounds (low x of
// all, low y, ..., high z), and a word for each child. The word of a leaf is NODE_LEAF, its number of
// primitives and its first entry in the list of primitives. The word of another node is its number; that of
// an absent child is NODE_NONE. Nodes are numbered depth first, children in their order. An entry of the list
// is two words: operator, primitive.
#define NODE_WORDS 28
#define NODE_NONE 0xffffffffu
#define NODE_LEAF 0x80000000u
#define NODE_COUNT_SHIFT 28  // 3 bits: the number of primitives less 1
#define NODE_FIRST 0x0fffffffu
#define STACK_ENTRIES 96
#endif
