// SPDX-License-Identifier: Apache-2.0
// Fills the structures that kernels read (core/kernels/map_view.h, volume_view.h, scene_view.h) from compiled scenes, for
// all backends alike. The backend passes `put`: put(array) says where an array is for the kernels, as the
// type that the structure has for it, and gives null or 0 for an empty array. put.samples(block) does so for
// a volume's samples.
#pragma once
#include <algorithm>
#include <cstddef>
#include <limits>

#include "core/data/bricks.h"
#include "core/kernels/single_views.h"
#include "core/rays/compiled_frame.h"
#include "core/rays/compiled_scene.h"

namespace gxy {

inline int sampleKindOf(ScalarType type) {
  switch (type) {
    case ScalarType::UInt8:
      return SAMPLE_U8;
    case ScalarType::Int8:
      return SAMPLE_I8;
    case ScalarType::UInt16:
      return SAMPLE_U16;
    case ScalarType::Int16:
      return SAMPLE_I16;
    default:
      return SAMPLE_F32;
  }
}

inline int viewKindOf(const CompiledOperator& op) {
  switch (op.vis.type) {
    case VisType::Particles:
      return KIND_PARTICLES;
    case VisType::PathLines:
      return KIND_PATHLINES;
    case VisType::Triangles:
      return KIND_TRIANGLES;
    default:
      if (!op.data.mesh) return KIND_VOLUME;
      return hasOnlyTetrahedra(*op.data.mesh) ? KIND_MESH : KIND_HEX_MESH;
  }
}

template <class View, class Put>
void fillMapView(View& v, const CompiledMap& map, Put& put) {
  v.intervals = map.intervals();
  v.uniformIntervals = map.uniform;
  v.buckets = int(map.buckets.size());
  v.origin = map.origin;
  v.inverse = map.inverse;
  v.nanRed = map.nan.r, v.nanGreen = map.nan.g, v.nanBlue = map.nan.b;
  v.bucket = put(map.buckets);
  v.nodes = put(map.nodes);
  v.spans = put(map.spans);
  v.rows = put(map.rows);
  v.pieces = put(map.pieces);
  v.sums = put(map.sums);
  v.opaque = put(map.opaque);
}

/// Fills in the volume of an operator; nothing if it shows something else. `part` is null if the operator has nothing in the
/// partition.
template <class View, class Put>
void fillVolumeView(View& v, const CompiledOperator& op, const OperatorInPartition* part, Put& put) {
  if (!op.data.volume) return;
  const Volume& volume = *op.data.volume;
  const Index3 cells = volume.grid.cells();
  v.cellsX = int(cells[0]), v.cellsY = int(cells[1]), v.cellsZ = int(cells[2]);
  v.originX = op.gridOrigin[0], v.originY = op.gridOrigin[1], v.originZ = op.gridOrigin[2];
  v.inverseX = op.gridInverse[0], v.inverseY = op.gridInverse[1], v.inverseZ = op.gridInverse[2];
  v.isovalues = int(op.isovalues.size());
  v.isovalue = put(op.isovalues);
  v.kind = sampleKindOf(volume.stored);
  v.stride = volume.components;
  v.component = volume.components == 1 ? 0 : op.vis.component.value_or(-1);
  if (!part || !part->block) return;
  const VolumeBlock& block = *part->block;
  v.samples = put.samples(block);
  v.wide = block.samples.size() >= size_t(1) << 31;
  const Bricks bricks(block.extent.points);
  v.brickRow = int(bricks.row()), v.brickLayer = int(bricks.layer());
  v.firstX = int(block.extent.first[0]), v.firstY = int(block.extent.first[1]),
  v.firstZ = int(block.extent.first[2]);
  v.lastX = v.firstX + int(block.extent.points[0]) - 1;
  v.lastY = v.firstY + int(block.extent.points[1]) - 1;
  v.lastZ = v.firstZ + int(block.extent.points[2]) - 1;
  v.plan = put(part->plan);
  v.byCells =
      std::any_of(part->plan.begin(), part->plan.end(), [](int32_t p) { return (p & PLAN_CELLS) != 0; });
  v.isoMask = put(part->isoMask);
  v.macroX = int(block.macrocells[0]), v.macroY = int(block.macrocells[1]);
  v.macroFirstX = int(block.firstMacrocell[0]), v.macroFirstY = int(block.firstMacrocell[1]);
  v.macroFirstZ = int(block.firstMacrocell[2]);
}

/// Fills in an operator's primitives in the partition.
template <class View, class Put>
void fillPrimitives(View& v, const GeometryInPartition& whole, Put& put) {
  const GeometryInPartition& part = whole.arrays();
  v.primitives = whole.primitives;
  const size_t largest = std::max({part.points.size(), part.indices.size(), part.neighbours.size()});
  v.wide = largest * sizeof(uint32_t) >= size_t(1) << 31;
  v.points = put(part.points);
  v.normals = put(part.normals);
  v.values = put(part.values);
  v.colors = put(part.colors);
  v.indices = put(part.indices);
  v.neighbours = put(part.neighbours);
  v.orders = put(part.orders);
  v.shell = put(whole.shell);
  v.unseen = put(whole.unseen);
}

/// Fills in the cells that isosurfaces and slices of a mesh pass in the partition (OperatorInPartition::surfaces).
template <class View, class Put>
void fillSurfaces(View& v, const GeometryInPartition& cells, Put& put) {
  v.surfaceCells = cells.primitives;
  v.levelCorners = put(cells.points);
  v.levelValues = put(cells.values);
  v.levelOrders = put(cells.orders);
  v.levelGradients = put(cells.normals);
  v.levelPoints = put(cells.corners);
  v.surfaces = put(cells.indices);
}

/// Fills in all of an operator but its primitives.
template <class View, class Put>
void fillOperatorView(View& v, const CompiledOperator& op, Put& put) {
  v.kind = viewKindOf(op);
  v.rendered = op.vis.volumeRendering;
  fillMapView(v.map, op.map, put);
  v.clips.planes = int(op.clips.size());
  v.clips.plane = put(op.clips);
  v.occludingExtinction = op.occludingExtinction;
  v.opacity = float(op.vis.opacity);
  v.twoSided = op.vis.twoSided;
  v.constantCells = showsConstantCells(op);
  v.slices = int(op.slices.size());
  v.slice = put(op.slices);
  v.every = op.every;
}

/// Fills in all but the operators and the hierarchy. `partition` < 0: the view has no partition of its own.
template <class View, class Put>
void fillSceneView(View& v, const CompiledScene& s, int partition, Put& put) {
  constexpr auto kInfinity = std::numeric_limits<float>::infinity();
  float lo[3] = {-kInfinity, -kInfinity, -kInfinity}, hi[3] = {kInfinity, kInfinity, kInfinity};
  if (partition >= 0) {
    // These are the same floats as in the lattice of faces, so that crossings are the same numbers.
    const Box& box = s.partitioning->box(partition);
    for (int a = 0; a < 3; a++) {
      const auto faces = s.partitioning->faces(a);
      lo[a] = s.faces[a][std::lower_bound(faces.begin(), faces.end(), box.lo[a]) - faces.begin()];
      hi[a] = s.faces[a][std::lower_bound(faces.begin(), faces.end(), box.hi[a]) - faces.begin()];
    }
  }
  v.boxLoX = lo[0], v.boxLoY = lo[1], v.boxLoZ = lo[2];
  v.boxHiX = hi[0], v.boxHiY = hi[1], v.boxHiZ = hi[2];
  v.domainLoX = float(s.lo.x), v.domainLoY = float(s.lo.y), v.domainLoZ = float(s.lo.z);
  v.domainHiX = float(s.hi.x), v.domainHiY = float(s.hi.y), v.domainHiZ = float(s.hi.z);
  v.cellsX = int(s.faces[0].size()) - 1, v.cellsY = int(s.faces[1].size()) - 1,
  v.cellsZ = int(s.faces[2].size()) - 1;
  v.facesX = put(s.faces[0]), v.facesY = put(s.faces[1]), v.facesZ = put(s.faces[2]);
  v.cellPartition = put(s.cellPartition);
  v.visible = put(s.visible);
  v.opaqueSurfaces = s.opaqueSurfaces;
  v.tMin = s.tMin;
  const Lighting& l = s.visualization.lighting;
  const auto lights = std::max<size_t>(l.sources.size(), 1);
  v.ambient = float(l.Ka), v.diffuse = float(l.Kd / double(lights)),
  v.specular = float(l.Ks / double(lights));
  v.shininess = float(l.shininess);
  v.shadows = l.shadows;
  v.occlusionRays = l.aoCount;
  v.occlusionRadius = float(std::min(l.aoRadius * s.space.scale, 1e29));
}

/// Fills in all but the lights' positions.
template <class View>
void fillFrameView(View& v, const CompiledScene& scene, const CompiledFrame& f) {
  const CameraBasis& b = f.basis;
  v.eyeX = b.eye.x, v.eyeY = b.eye.y, v.eyeZ = b.eye.z;
  v.cornerX = b.corner.x, v.cornerY = b.corner.y, v.cornerZ = b.corner.z;
  v.duX = b.du.x, v.duY = b.du.y, v.duZ = b.du.z;
  v.dvX = b.dv.x, v.dvY = b.dv.y, v.dvZ = b.dv.z;
  v.viewX = b.view.x, v.viewY = b.view.y, v.viewZ = b.view.z;
  v.loX = scene.lo.x, v.loY = scene.lo.y, v.loZ = scene.lo.z;
  v.hiX = scene.hi.x, v.hiY = scene.hi.y, v.hiZ = scene.hi.z;
  v.orthographic = b.orthographic;
  v.width = f.width, v.height = f.height;
  v.frame = f.number;
  v.lights = int(f.lights.size());
}

}  // namespace gxy
