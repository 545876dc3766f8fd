// SPDX-License-Identifier: Apache-2.0
// The errors of a picture against the truth.
#pragma once
#include <vector>

#include "core/render/framebuffer.h"
#include "tools/gxybench/table.h"

namespace gxy::bench {

/// The reference renderer's picture of a state's first visualization and camera, in front of the background.
/// For scenes with surfaces it also has the range that each pixel takes while the rays are moved by some ulps
/// of float. Pixels with a wide range are flips (docs/architecture.md, promise 3). In scenes without surfaces
/// no pixel is a flip.
struct Truth {
  int width = 0, height = 0;
  std::vector<float> rgb;        ///< 3 a pixel, rows bottom to top
  std::vector<float> low, high;  ///< of rgb; empty without surfaces
  /// World units, 1e30 for a miss. `nearest` and `farthest` are the range of `depth`, empty without surfaces.
  std::vector<double> depth, nearest, farthest;
  double cell = 0;  ///< smallest spacing of the first volume, world units; 0 where there is none
  bool operator==(const Truth&) const = default;
};

/// Fills in the row's errors, flips and, for a scene of isosurfaces alone, its hits. A pixel that is further
/// from the truth than row.tolerance (or, in depth, than half a cell) is a flip where the truth changes under
/// perturbation and the picture lies within its range.
void compareWith(const Truth& truth, const Picture& picture, bool isosurfacesAlone, Row& row);

}  // namespace gxy::bench
