// SPDX-License-Identifier: Apache-2.0
// World: a scene prepared for tracing. It holds fields, maps and trees, and finds what a ray meets in them.
#pragma once
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "core/data/geometry.h"
#include "core/reference/bvh.h"
#include "core/reference/field.h"
#include "core/reference/integrate.h"
#include "core/reference/mesh_field.h"
#include "core/reference/primitives.h"
#include "core/reference/transfer.h"

namespace gxy::reference {

struct ReferenceScene;

/// A hit of a ray on a surface.
struct SurfaceHit {
  double t = kInfinity;
  int vis = 0;             ///< index of the operator
  uint64_t primitive = 0;  ///< volumes: index of slices, then isovalues; geometry: the global id
  uint32_t item = 0;  ///< index into the block's points, segments or triangles, or of a MeshSurface's cell
  glm::dvec3 position{0};
  glm::dvec3 normal{0};     ///< for shading: unit, towards the viewer where the Vis is two-sided
  glm::dvec3 geometric{0};  ///< normal of the surface itself: unit, on the side of `normal`
  glm::dvec3 colour{0};
  double opacity = 1;
  double slack = 0;  ///< world length by which a secondary ray must start off the surface along `geometric`
};

/// The surface that a ray has met last. Surfaces at a larger t are behind it. So are surfaces at the same t
/// of a higher (vis, primitive) or, of a mesh, (vis, primitive, item), except other isosurfaces of the same
/// field on a grid and the next segment of the same line.
struct Behind {
  double t = -1;
  int vis = 0;
  uint64_t primitive = 0;
  uint32_t item = 0;
  /// All surfaces at a larger t are behind it.
  Behind(double after = -1) : t(after), vis(std::numeric_limits<int>::max()) {}
  Behind(const SurfaceHit& hit) : t(hit.t), vis(hit.vis), primitive(hit.primitive), item(hit.item) {}
};

/// A scene prepared for tracing. Immutable; safe to use from any thread; keeps the data alive.
class World {
 public:
  /// Throws Error when an operator has no data or data of another kind.
  explicit World(const ReferenceScene& scene);

  /// Returns the first surface behind `last`, at t >= 0 and t < limit: of isosurfaces, slices and primitives,
  /// ties by the lowest (vis, primitive). Its normals and colour are those at `aside` from the hit, to
  /// imitate the error of a point that is not computed in double.
  std::optional<SurfaceHit> firstHit(const Ray& ray, const Behind& last = {}, double limit = kInfinity,
                                     glm::dvec3 aside = glm::dvec3(0)) const;

  /// The volumes along a ray.
  VolumeRay volumes(const Ray& ray, Interval range = {}) const;

  /// The fraction of light that passes along the ray up to `limit`: surfaces let 1 - opacity pass, volumes
  /// exp(-optical depth).
  double transmittance(const Ray& ray, double limit, double tolerance) const;

  /// The box of all data.
  const Box& box() const { return box_; }

 private:
  struct ShownOperator {
    const Vis* vis;
    Transfer transfer;
    std::optional<Field> field;             ///< of a volume on a grid
    std::shared_ptr<const MeshField> mesh;  ///< of an unstructured volume
    std::vector<MeshSurface> surfaces;      ///< of it: its slices, then its isosurfaces
    std::shared_ptr<const Geometry> geometry;
    std::optional<Bvh> tree;
  };
  ShownOperator makeVolume(const ReferenceScene& scene, size_t index);
  ShownOperator makeMesh(std::shared_ptr<const MeshField> mesh, size_t index);
  ShownOperator makeGeometry(const ReferenceScene& scene, size_t index);

  /// Finds the nearest surface of operator `index` behind `last`, if it is nearer than `best`.
  void nearestVolumeSurface(int index, const Ray& ray, Interval range, const Behind& last,
                            SurfaceHit& best) const;
  void nearestMeshSurface(int index, const Ray& ray, Interval range, const Behind& last,
                          SurfaceHit& best) const;
  void nearestPrimitive(int index, const Ray& ray, Interval range, const Behind& last,
                        SurfaceHit& best) const;
  static void describeVolumeSurface(const ShownOperator& part, const Ray& ray, SurfaceHit& hit);
  static void describeMeshSurface(const ShownOperator& part, const Ray& ray, SurfaceHit& hit);
  static void describePrimitive(const ShownOperator& part, const Ray& ray, SurfaceHit& hit);

  std::shared_ptr<const ReferenceScene> scene_;
  std::vector<ShownOperator> parts_;
  Box box_;
};

}  // namespace gxy::reference
