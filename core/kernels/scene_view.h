// SPDX-License-Identifier: Apache-2.0
// The structures through which kernels see a scene and a frame. A backend's host side fills them in.
// map_view.h and volume_view.h must come before. Each dialect reads these structures in its own scene_fetch.

#define KIND_VOLUME 0
#define KIND_PARTICLES 1
#define KIND_PATHLINES 2
#define KIND_TRIANGLES 3
#define KIND_MESH 4   // an unstructured volume; its primitives are the cells of its isosurfaces and slices
#define KIND_SHELL 5  // the faces of its shell, in hierarchies
// The same where not all of its cells are tetrahedra: then all are hexahedra to the kernels (hexahedron.h).
#define KIND_HEX_MESH 6
#define KIND_HEX_SHELL 7

// Cells of a mesh whose numbers follow each other are near to each other. A brick has 2^9 tetrahedra or 2^6 hexahedra with such numbers.
#define TETRAHEDRA_IN_BRICK 9
#define HEXAHEDRA_IN_BRICK 6

// The most volumes that one march integrates together (multi_volume.h).
#define MANY_VOLUMES 8

struct OperatorView {
  int kind;
  int rendered;  // whether it is a volume that is volume rendered
  MapView map;
  ClipView clips;
  real occludingExtinction;  // CompiledOperator::occludingExtinction
  real opacity;              // of its surfaces
  int twoSided;
  int slices;
  PTR(real) slice;    // 4 per plane: n . p = offset
  real every;         // distance between the places that rays of a sampling meet; 0: none
  uint primitives;    // of a mesh: the faces of its shell
  int wide;           // 1: an array of a mesh has 2^31 bytes or more, and needs 64-bit offsets
  PTR(real) points;   // x y z radius; of a mesh: x y z value
  PTR(real) normals;  // x y z per point, or null
  PTR(real)
  values;  // per point, or null; of a mesh: per cell, or null, and cells whose value is not finite are not seen
  int constantCells;  // 1: a cell of a mesh has its value everywhere
  PTR(real) colors;   // r g b per point, or null
  PTR(uint) indices;  // 2 or 3 per primitive; of a mesh: 4 per tetrahedron, which ascend, or 8 per hexahedron
  // Of segments: the points before and after; the segment's own end if there is none. Of a mesh: 4 per tetrahedron (mesh.h) or 6 per
  // hexahedron (hex_walk.h).
  PTR(uint) neighbours;
  PTR(uint) orders;  // of a mesh of hexahedra: one per cell (hexahedron.h)
  PTR(uint) shell;   // of a mesh: one per primitive (mesh.h)
  PTR(uint) unseen;  // of a mesh: a bit per brick of cells that rays leave out (mesh.h), or null
  // Of a mesh: per cell that an isosurface or a slice passes, in which it is the one of cell_surface.h or hex_surface.h, 4 or 8 corners of
  // x y z level, the values there, the orders of the sides of a hexahedron, and the number of the surface. If isosurfaces are smooth, also for
  // each corner the number of a gradient of values, x y z; else null.
  uint surfaceCells;
  PTR(real) levelCorners;
  PTR(real) levelValues;
  PTR(real) levelGradients;
  PTR(uint) levelPoints;
  PTR(uint) levelOrders;
  PTR(uint) surfaces;
  RAW shellHierarchy;  // over the shell of a mesh, in the backend's own form
};

#define LIGHT_DIRECTIONAL 0
#define LIGHT_POINT 1

struct SceneView {
  // The partition: t in [tIn, tOut) between these faces belongs to it.
  real boxLoX, boxLoY, boxLoZ, boxHiX, boxHiY, boxHiZ;
  real domainLoX, domainLoY, domainLoZ, domainHiX, domainHiY, domainHiZ;
  // The lattice of all partitions.
  int cellsX, cellsY, cellsZ;
  PTR(real) facesX;
  PTR(real) facesY;
  PTR(real) facesZ;
  PTR(int) cellPartition;
  PTR(BYTE) visible;

  int operators;
  PTR(OperatorView) operator_;
  PTR(VolumeView) field;  // one per operator; empty for geometry
  // Hierarchy over this partition's geometry, in the backend's own form; null if there is none.
  RAW hierarchy;
  int opaqueSurfaces;
  real tMin;

  real ambient, diffuse, specular, shininess;  // diffuse and specular: per light
  int shadows, occlusionRays;
  real occlusionRadius;
};

#if !defined(GXY_LAYOUT)
// The numbers of the corners of a hexahedron.
struct HexPoints {
  uint p0, p1, p2, p3, p4, p5, p6, p7;
};
#endif

struct FrameView {
  double eyeX, eyeY, eyeZ, cornerX, cornerY, cornerZ, duX, duY, duZ, dvX, dvY, dvZ, viewX, viewY, viewZ;
  double loX, loY, loZ, hiX, hiY, hiZ;  // the visible domain
  int orthographic;
  int width, height;
  uint frame;  // number in the sequence of ambient-occlusion directions
  int lights;
  PTR(real) light;  // 4 per light: type, then direction of travel or position
};
