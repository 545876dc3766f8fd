/* SPDX-License-Identifier: Apache-2.0
 *
 * The interface by which a simulation publishes its steps to Galaxy while it runs. docs/insitu.md is the guide. It is C99 and
 * needs no other library: neither MPI nor VTK.
 *
 * Every rank of the simulation opens one gxy_sim, says which part of a grid or which particles or cells it has and where its fields lie in memory,
 * and calls gxy_publish() after each step. The ranks never communicate with each other for Galaxy's sake. What gxy_publish()
 * does with a step, and where it goes, is decided when the program runs (gxy_open); by default it does nothing.
 *
 * Results: functions that return int return one of gxy_result. It is safe to ignore all of them. gxy_message() says
 * more about the last one.
 *
 * Threads: two threads must not use one gxy_sim at the same time. Where calls wait (policy "wait", gxy_close() after
 * gxy_publish_last()), they wait for all ranks: a process with several gxy_sims then needs a thread for each. The library has one thread of its own for each gxy_sim that
 * publishes to a server. Nothing is printed, no signal handler is changed, and no function throws or exits.
 */
#ifndef GALAXY_INSITU_H
#define GALAXY_INSITU_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define GXY_API __attribute__((visibility("default")))
#else
#define GXY_API
#endif

/* The version of this interface. A program built with this header runs with every later library of the same soname. */
#define GXY_INSITU_VERSION 1
GXY_API int gxy_version(void);

enum gxy_result {
  GXY_TAKEN = 0,     /* the step was taken, or what was said is remembered */
  GXY_NOT_TAKEN = 1, /* nobody needs this step, or the time to wait for it was out */
  GXY_OFF = 2,       /* publishing is off */
  GXY_LOST = 3,      /* there is no connection to the server; the library tries again if it may */
  /* wrong use: gxy_message() says what, and nothing was changed; such a publish does not count */
  GXY_WRONG = -1
};

/* Types of values. */
enum gxy_type {
  GXY_INT8 = 0,
  GXY_UINT8 = 1,
  GXY_INT16 = 2,
  GXY_UINT16 = 3,
  GXY_INT32 = 4,
  GXY_UINT32 = 5,
  GXY_INT64 = 6,
  GXY_UINT64 = 7,
  GXY_FLOAT32 = 8,
  GXY_FLOAT64 = 9
};

/* What a decomposition counts and what a field has values of. */
enum gxy_of { GXY_OF_POINTS = 0, GXY_OF_CELLS = 1 };

/* Types of the cells that gxy_cells() takes. The numbers are those of VTK. */
enum gxy_cell {
  GXY_LINE = 3,
  GXY_POLY_LINE = 4, /* points along a line, any number */
  GXY_TRIANGLE = 5,
  GXY_TRIANGLE_STRIP = 6,
  GXY_POLYGON = 7, /* corners in order around it, any number; it need not be convex */
  GXY_PIXEL = 8,   /* a quad whose last two points are swapped */
  GXY_QUAD = 9,
  GXY_TETRAHEDRON = 10,
  GXY_VOXEL = 11, /* a box whose points run through x, then y, then z */
  GXY_HEXAHEDRON = 12,
  GXY_WEDGE = 13,
  GXY_PYRAMID = 14
};

/* Where the values of a field lie. The value of component c at (i, j, k), counted from the first owned point or cell, is at
 * data + i * stride[0] + j * stride[1] + k * stride[2] + c * component_stride. Strides are in bytes and may be negative, but not 0.
 * So ghost layers, padding, Fortran's order and structures are all told by strides, and `data` points to the first OWNED value.
 * With a component_stride of 0 the components of a point stand together. */
typedef struct gxy_array {
  const void* data;
  int type;       /* gxy_type */
  int components; /* 1 to 16 */
  int64_t stride[3];
  int64_t component_stride;
  int memory; /* 0: the memory of the host. Others are reserved, and wrong so far. */
} gxy_array;

typedef struct gxy_sim gxy_sim;

/* Begins a stream of steps called `name` on rank `rank` of `ranks`. All ranks give the same name, ranks and options. Returns
 * at once and connects in the background. Never returns NULL.
 *
 * `options` is a JSON object, or NULL. The environment variable GALAXY_INSITU stands in for "to", and the JSON file that
 * GALAXY_INSITU_OPTIONS names for all others.
 *   "to"          "off", "HOST:PORT" of a server, or "here", the server in the simulation's own processes (galaxy_insitu_mpi.h).
 *                 The default is "off", and "here" in a simulation that gxyserver has loaded
 *   "here"        options of that server, an object: "bind" (127.0.0.1), "port" (5001), "port-file", "data", "backend", "threads" (1), "niceness" (5)
 *   "token-file"  file with the server's token, "-" for none; default: where a server on this machine leaves it
 *   "tenant"      for servers without tokens (default: "user")
 *   "scope"       "private" (the default) or "shared": who sees the data
 *   "partition"   how the server cuts the data: "even" (the default), "simulation" (the default with "here"), by the blocks of the first
 *                 grid, or {"like": DATASET}
 *   "policy"      "skip" (the default): gxy_publish() never waits, and steps may be left out; or "wait": it waits until its step is taken
 *   "time-out"    with "wait": at most so many seconds; null: for ever. It must be given
 *   "every"       only the first of so many publishes is offered (default: 1)
 *   "between"     [FIRST, LAST]: only steps with these times are offered
 *   "triggers"    what the server does with steps: a list, or the name of a file that has it (docs/insitu.md). Rank 0 reads it
 *   "steerable"   the parameters that clients may change: a list of {"name", "least", "largest"} (gxy_steered)
 *   "checksum"    true, false, or null (the default): whether samples are sent with checksums. null: to all addresses but loopback's
 *   "reconnect"   seconds between attempts to connect (default: 5); 0: none after the first */
GXY_API gxy_sim* gxy_open(const char* name, int rank, int ranks, const char* options);

/* Says what this rank owns of a uniform grid. `of` says whether size, first and count are in points or in cells. `size` is that of the
 * whole grid, the same on all ranks: at least 2 points or 1 cell by axis. The block with number `block` (0, 1, ... on this rank)
 * owns `count` points or cells from `first` on. Blocks of all ranks must not overlap, and together they must have all of them.
 * A rank may have any number of blocks; a rank without blocks calls this once with a count of 0. Point (i, j, k) lies at
 * origin + spacing * (i, j, k), and cell (i, j, k) lies between it and the next one; spacing is positive. Size,
 * origin and spacing are the same in all calls for a mesh. A stream may have several grids: the first by name is that whose domain the
 * server cuts for its ranks, and the others lie inside it.
 *
 * Called again, it changes what a block owns, from the next publish on, and gxy_field() has to be called again for a block that has changed. A
 * block that is no longer there gets a count of 0. After the first step the size, origin and spacing of a grid may change as well, on all ranks
 * before the same publish: a call with another grid than the one before removes all blocks of the mesh on its rank. A call that
 * changes nothing costs nothing, but with the policy "wait". There all ranks call this before the publish from which on some have other
 * blocks, also those whose blocks stay; else that step may be left out. With "skip" no step is taken until the server knows what all ranks
 * have, so a grid that changes with each step is seen with "wait" only. Between gxy_wanted() and its publish nothing may change. */
GXY_API int gxy_grid(gxy_sim* sim, const char* mesh, int block, int of, const int64_t size[3],
                     const int64_t first[3], const int64_t count[3], const double origin[3],
                     const double spacing[3]);

/* Says which particles this rank has now: `count` points, any number, on any rank, wherever they lie. It is called before each publish
 * that has other ones, or has them elsewhere in memory; then gxy_field() is called again for their fields, with block 0 and GXY_OF_POINTS.
 * Of arrays of particles, stride[0] is the bytes from one to the next; the other strides are not used.
 *   `positions`  3 components, of GXY_FLOAT32 or GXY_FLOAT64
 *   `ids`        one integer of 32 or 64 bits, from 0 up, for each particle, each number once on all ranks; with components 0 there are
 *                none, and particles are numbered by rank. Pictures do not depend on which rank has a particle if there are ids.
 *   `box`        the least x, y, z, and the largest, of the domain that the server cuts for its ranks; NULL: that of the particles of the first
 *                step, a tenth larger. Particles may be outside. It is not used where the stream has a grid.
 * Each field becomes the dataset NAME.FIELD, with the particles and its values; of several components, their magnitude; or colours, where files
 * would have them: bytes, or any type with the name RGB, of 3 or 4 components. Particles without fields become NAME.MESH. Types, ids and box are the same on all ranks and in all steps, so also a rank without particles calls this and
 * gxy_field(), where `data` may be NULL. */
GXY_API int gxy_points(gxy_sim* sim, const char* mesh, int64_t count, gxy_array positions, gxy_array ids,
                       const double box[6]);

/* Says which lines, triangles or cells with a volume this rank has now: points, and cells between them. It is called before each publish that has other ones, or has them
 * elsewhere in memory; then gxy_field() is called again for their fields, with block 0. Any rank may have any number of points and cells, none included.
 * Of the arrays, stride[0] is the bytes from one entry to the next; the other strides are not used.
 *   `positions`     of `points` points: 3 components, of GXY_FLOAT32 or GXY_FLOAT64
 *   `types`         of each cell, an integer of any type, one of gxy_cell. With stride[0] = 0 all cells are of the type that `data` points to now
 *   `offsets`       cells + 1 integers of 32 or 64 bits, as in VTK: the points of cell c are `connectivity` from entry offsets[c] up to and without
 *                   entry offsets[c + 1]. They never descend. The first is 0; if it is not, the entries before are not used. With components 0
 *                   there are none, and the cells follow each other; then all are of one type with a fixed number of points: any but
 *                   GXY_POLY_LINE, GXY_TRIANGLE_STRIP and GXY_POLYGON
 *   `connectivity`  integers of 32 or 64 bits: the points of each cell, by their number on this rank, from 0
 * Cells of a mesh are of lines (GXY_LINE, GXY_POLY_LINE), which become path lines, of faces (GXY_TRIANGLE to GXY_QUAD), which are cut into
 * triangles as those of files are, or have a volume (GXY_TETRAHEDRON to GXY_PYRAMID, in any mixture), and become an unstructured volume; a mesh
 * has one of these kinds on all ranks. If no rank has a cell in the first step, and `types` does not say of which type they
 * will be, they are triangles. Quadratic cells and polyhedra are not supported. Poly-lines, strips and polygons of too few
 * points are left out; so are triangles without area and what is repeated along a line, as in files.
 *
 * Cells with a volume have their points in VTK's order. Each cell is on one rank; cells with the same points as another one are left out and
 * counted. Points at exactly the same place become one, on whichever ranks they are, with the values of that of the lowest rank: so
 * cells of neighbouring ranks meet. They have one or more fields of points or cells, and each becomes a
 * volume NAME.FIELD with all its components. A field vtkGhostType of cells, one GXY_UINT8 each, is none of them: it marks, with VTK's bits, cells that are left
 * out, as in files: duplicates of another rank's cells (1), which serve fields of cells at the border of the rank's own, and refined and hidden ones (8, 32).
 * One of points marks those without data (2). Cells stay inside the domain that the server cuts, else the step is left out. If points
 * and cells of a step are those of the step before, bit for bit, on all ranks, the server only makes the values anew.
 *
 * gxy_field() gives points or cells a field. Of lines and triangles, each becomes the dataset NAME.FIELD, with the mesh and its values; of several components,
 * their magnitude; or colours, where files would have them: bytes, or any type with the name RGB, of 3 or 4 components. A cell has one
 * value. The field Normals of points, with 3 components, has the normals of all datasets of the mesh instead. A mesh without (other) fields
 * becomes NAME.MESH. The domain that the server cuts for its ranks is that of the first step's points, a tenth larger, unless the stream has a
 * grid; points may be outside. The type of positions, and the fields with their types, are the same on all ranks and in all steps,
 * so also a rank without points calls this and gxy_field(), where `data` may be NULL.
 *
 * The cells are read in gxy_publish(). Those that are wrong (another type, offsets that descend, a point that there is not or that is not
 * finite) make the first publish wrong; later, a step with such cells is left out on all ranks, and the server's `insitu.streams` says why. */
GXY_API int gxy_cells(gxy_sim* sim, const char* mesh, int64_t points, gxy_array positions, int64_t cells,
                      gxy_array types, gxy_array offsets, gxy_array connectivity);

/* Says where the values of a field lie for a block that gxy_grid() has described, or for block 0 of particles or cells. Type and components of
 * a field are the same in all blocks of all ranks, and all blocks have the same fields: also one without points, whose `data` may be NULL. It
 * may be called before each step, for instance with another pointer. The values are read within gxy_publish() only. The field becomes the
 * dataset NAME.FIELD, so meshes have fields of different names. `of` must be that of the grid so far, GXY_OF_POINTS for particles, and either
 * for cells. A value of a cell of a grid stands at the centre of the cell, and those of the outermost cells hold up to the domain's end, as in
 * files with values of cells. */
GXY_API int gxy_field(gxy_sim* sim, const char* mesh, int block, const char* field, int of, gxy_array values);

/* Offers a step. All ranks offer the same steps in the same order; `step` ascends. `time` is in the simulation's own unit. If
 * Galaxy wants this step, its values are copied, and a thread of the library sends the copy. Otherwise this takes less
 * than a microsecond. It never waits, unless the policy is "wait". Then it waits until the server takes the step, and so for the
 * step before to be published; but not where this rank's connection is lost or could not be made: it returns GXY_LOST at once. A
 * step is left out all the same if the time is out on one rank, if one rank comes to it a minute later than another, or if
 * the server cannot publish it. */
GXY_API int gxy_publish(gxy_sim* sim, int64_t step, double time);

/* Counts a step that this rank cannot publish, so that all ranks go on counting alike. It is left out on all of them. It may come before
 * the first gxy_publish(). */
GXY_API int gxy_skip(gxy_sim* sim, int64_t step, double time);

/* Whether the next gxy_publish(), which is of this step and time, will be taken: 1, or 0; below 0: wrong use. So a simulation need not compute
 * what nobody looks at. It waits where gxy_publish() would, which then does not. After 0, this rank does not take the step.
 *
 * Ranks may get different answers, as they are told at different times. Where they compute together what is published, they
 * agree on the largest of their answers, and tell it to gxy_wanted_settle() on all ranks: after 1, gxy_publish() takes the step if
 * the server has asked this rank for it by then. A step that one rank does not take is left out on all. */
GXY_API int gxy_wanted(gxy_sim* sim, int64_t step, double time);
GXY_API int gxy_wanted_settle(gxy_sim* sim, int64_t step, int any);

/* Whether somebody has given a parameter another value since the last call: 1, and *value is that; 0; below 0: wrong use. Only the
 * parameters of the option "steerable" can be steered. A value arrives with a step that this rank takes, so it may have changed after gxy_publish()
 * only. With the policy "wait" and no time-out, all ranks have it after the same step. Otherwise a rank may have it some steps before
 * another: then one rank asks, and tells the others. */
GXY_API int gxy_steered(gxy_sim* sim, const char* parameter, double* value);

/* Offers the last step, on all ranks, instead of gxy_publish(). It copies all values of this rank, whether or not anybody wants them, and
 * returns at once. gxy_close() waits until the step is published, also for a lost connection to come back, at most its
 * seconds. The step is offered whatever "every" and "between" say. After this, only gxy_close() may follow. */
GXY_API int gxy_publish_last(gxy_sim* sim, int64_t step, double time);

typedef struct gxy_stat {
  int64_t offered;        /* calls of gxy_publish() and gxy_publish_last() */
  int64_t taken;          /* steps that were copied */
  int64_t published;      /* taken steps that the server has published */
  int64_t bytes;          /* copied */
  double publish_seconds; /* in gxy_publish(), all calls together */
  double longest_seconds; /* the longest call */
} gxy_stat;
GXY_API int gxy_statistics(gxy_sim* sim, gxy_stat* statistics);

/* The text about the last result, or about why there is no connection. It is valid until the next call. Never NULL. */
GXY_API const char* gxy_message(gxy_sim* sim);

/* Ends the stream on this rank, and so for the whole simulation. Waits at most `seconds` for a step that was taken, and that of
 * gxy_publish_last(), to be published, half a second for the connections to end, and as long as the system takes where it is looking for the server's host.
 * Frees `sim`, which may be NULL. */
GXY_API void gxy_close(gxy_sim* sim, double seconds);

/* The next three are for galaxy_insitu_mpi.h and gxyserver, which simulations use instead. */

/* The server of this process, or of its MPI job, listens at `address`, HOST:PORT, and asks for `token`. Streams whose "to" is "here", or says
 * nothing, go there. An empty address: it could not be started. */
GXY_API void gxy_set_here(const char* address, const char* token);
/* 1: these options say "here", and a server can be started in this process; 0: they do not; -1: it cannot be. `mpi`: what
 * MPI_Get_library_version() says. */
GXY_API int gxy_prepare_here(const char* options, const char* mpi);
/* As gxy_open(); `comm` points to an MPI_Comm of a server to be started, or is NULL where one of its ranks cannot. */
GXY_API gxy_sim* gxy_open_here(const char* name, int rank, int ranks, const char* options, const void* comm);
/* The same with the communicator as Fortran has it; `comm` points to one, or is NULL. */
GXY_API gxy_sim* gxy_open_here_fortran(const char* name, int rank, int ranks, const char* options,
                                       const int* comm);

#ifdef __cplusplus
}
#endif

#endif
