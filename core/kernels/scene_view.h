// SPDX-License-Identifier: Apache-2.0
// What kernels see of a scene and a frame: the structures that a backend's host side fills. PTR is volume_view.h's. Each
// dialect reads them in its own scene_fetch.

#define KIND_VOLUME 0
#define KIND_PARTICLES 1
#define KIND_PATHLINES 2
#define KIND_TRIANGLES 3

struct OperatorView {
  int kind;
  int rendered;  // a volume that is volume rendered
  real opacity;  // of its surfaces
  int twoSided;
  int slices;
  PTR(real) slice;  // 4 per plane: n . p = offset
  uint primitives;
  PTR(real) points;      // x y z radius
  PTR(real) normals;     // x y z per point, or null
  PTR(real) values;      // per point, or null
  PTR(real) colors;      // r g b per point, or null
  PTR(uint) indices;     // 2 or 3 per primitive
  PTR(uint) neighbours;  // of segments: the points before and after, own ends where there is none
};

#define LIGHT_DIRECTIONAL 0
#define LIGHT_POINT 1

struct SceneView {
  // the partition: t in [tIn, tOut) between these faces is its own
  real boxLoX, boxLoY, boxLoZ, boxHiX, boxHiY, boxHiZ;
  real domainLoX, domainLoY, domainLoZ, domainHiX, domainHiY, domainHiZ;
  // the lattice of all partitions
  int cellsX, cellsY, cellsZ;
  PTR(real) facesX;
  PTR(real) facesY;
  PTR(real) facesZ;
  PTR(int) cellPartition;
  PTR(BYTE) visible;

  int operators;
  PTR(OperatorView) operator_;
  PTR(VolumeView) field;  // one per operator; geometry uses its map only
  RAW hierarchy;          // over this partition's geometry, in the backend's own form; null if there is none
  int opaqueSurfaces;
  real tMin;

  real ambient, diffuse, specular, shininess;  // diffuse and specular: per light
  int shadows, occlusionRays;
  real occlusionRadius;
};

struct FrameView {
  double eyeX, eyeY, eyeZ, cornerX, cornerY, cornerZ, duX, duY, duZ, dvX, dvY, dvZ, viewX, viewY, viewZ;
  double loX, loY, loZ, hiX, hiY, hiZ;  // the visible domain
  int orthographic;
  int width, height;
  uint frame;  // continues the ambient-occlusion sequence
  int lights;
  PTR(real) light;  // 4 per light: type, direction of travel or position
};
