// SPDX-License-Identifier: Apache-2.0
// The reference renderer: pictures in double, written for truth and not for speed. The others are measured
// against it (`gxyrender --reference`).
//
// It shares no code with core/kernels. Volumes are integrated by adaptive quadrature split at cell faces and
// at the maps' control points. Isosurfaces are exact roots of the trilinear field. There is no early
// termination, no skipping and only one partition. Where the definitions leave a choice:
// - The magnitude of a volume with several components is taken at the samples, then interpolated.
// - A one-sided isosurface faces lower values.
// - Where cells of a mesh overlap, the one that the ray has entered first counts up to its exit.
// - An opacity that reaches 1 at single points of a ray leaves its optical depth finite (the logarithm can be
//   integrated). On a stretch of the ray it is opaque at once.
// - Colours of points are mixed as values are.
// - Geometry without values or colours takes its map's first colour. So does a value that is NaN, whose
//   radius is radius0. Without values the radius is that of value 0.
// - A tube's value at a hit is that of the ball between its ends that touches the surface there.
// - Both sides of a translucent sphere or tube are surfaces; those inside the next segment of a line are not.
// - A plateau at an isovalue is one hit, where the ray enters it. In a mesh a surface is the border of what is
//   higher than the isovalue, so a plateau has none on the side of lower values, and two where both sides are
//   higher; normals are those of the cells.
// - Secondary rays start on the side of the surface that the shading normal is on, off it by the rounding
//   error of the hit. They see every surface, both sides of translucent bodies included.
// - Depth is that of the first surface on the ray through the pixel's centre.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <variant>
#include <vector>

#include "core/data/geometry.h"
#include "core/data/volume.h"
#include "core/reference/mesh_field.h"
#include "core/reference/shade.h"
#include "core/scene/background.h"
#include "core/scene/scene.h"

namespace gxy::reference {

using ReferenceData = std::variant<std::shared_ptr<const Volume>, std::shared_ptr<const Geometry>,
                                   std::shared_ptr<const MeshField>>;

/// The scene to draw: a visualization and, for each of its operators, the data, whole in partition 0. A mesh is prepared, since
/// that takes long; Vis::component has no effect on it.
struct ReferenceScene {
  Visualization visualization;
  std::vector<ReferenceData> data;
  RenderSettings settings;  ///< only raysPerPixel and background are used
};

struct ReferenceOptions {
  double tolerance = 1e-6;       ///< error of every volume integral
  glm::dvec2 subpixelOffset{0};  ///< added to each ray's position, in pixels
  double perturbation = 0;       ///< ulps of float by which every ray is moved at random; see renderReference
  uint64_t seed = 0;             ///< seed of the perturbation
  int threads = 0;               ///< number of threads; 0: all
  glm::ivec2 first{0}, size{0};  ///< rectangle of pixels to render; size 0: the whole picture
  int aoDirections = 0;          ///< directions for ambient occlusion; 0: as many as the scene's aoCount
  AoDirections aoHook;           ///< gives the directions instead; called from several threads
  std::function<void(double)> progress;  ///< the fraction done, ascending; called from one thread at a time
};

/// A picture, or the rectangle of it that was asked for; rows bottom to top.
struct ReferencePicture {
  int width = 0, height = 0;
  std::vector<double> rgba;  ///< premultiplied, without background; 4 a pixel
  /// World distance from the ray's start to the first surface; 1e30 where there is none.
  std::vector<double> depth;

  const double* pixel(int x, int y) const { return &rgba[4 * (size_t(y) * width + x)]; }
};

/// Renders a scene. Throws Error when scene, data or camera do not fit together.
///
/// A perturbation of p adds errors of the size of float rounding, with u = 2^-24 of the longest side of the
/// data's box. Every ray's direction moves by up to p * 2^-24 per component, and the point where it enters
/// the box by up to p u. Secondary rays start up to 6 p u further off their surface, all by as much. This
/// covers, for p = 8, the 32 u by which backends start them off it, and half as much for errors of hits.
/// Hits are shaded up to p u aside, since a point in float is as far from its surface. Pixels that such a
/// move changes are flips.
ReferencePicture renderReference(const ReferenceScene& scene, const Camera& camera,
                                 const ReferenceOptions& options = {});

/// Puts the picture over a background (not premultiplied); its alpha becomes that of both.
void applyBackground(ReferencePicture& picture, const Background& background);

}  // namespace gxy::reference
