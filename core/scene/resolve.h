// SPDX-License-Identifier: Apache-2.0
// Replaces what a state leaves to the data (ranges of maps, radii, the viewpoint) by numbers.
#pragma once
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/data/box.h"
#include "core/scene/scene.h"

namespace gxy {

/// Facts about a dataset that visualizations need. They are the same on any number of ranks.
struct DataFacts {
  Box box;     ///< bounding box of the data, world coordinates
  Box middle;  ///< bounding box without outlying points; equals `box` if there are none
  /// Ranges of values. A volume has one for each component, then one for the magnitude if there are several
  /// components. Geometry has one.
  std::vector<Range> ranges;
  double spacing = 0;  ///< mean distance between neighbouring points of geometry, world units; 0: unknown
  /// Ranges of the further fields of geometry by name, each as those of a volume.
  std::map<std::string, std::vector<Range>> fields = {};
};

/// The ranges and the box that pictures of a visualization have shown so far. Later time steps widen them and
/// never narrow them, so that colours do not flicker and the camera does not jump back.
struct ShownSoFar {
  std::vector<Range> ranges;  ///< by operator
  Box box;                    ///< bounding box of the data of all operators, with their radii
};

/// Returns the visualization with numbers in place of "data" and "auto", and extends `shown`. `facts` has the
/// facts of each operator's dataset, in the order of the operators. A range without finite values leaves the
/// maps as they are.
Visualization resolved(Visualization visualization, std::span<const DataFacts> facts, ShownSoFar& shown);

/// The radius "auto" is this fraction of the spacing of points.
inline constexpr double kRadiusOfSpacing = 0.3;

/// A fitted box spans this fraction of the picture's width or height.
inline constexpr double kFittedPart = 0.88;

/// If the camera has `fit`, returns it moved without change of direction, so that `box` is centred in the
/// picture and spans kFittedPart of its width or height; an orthographic camera also gets the height for
/// that. Otherwise returns the camera unchanged. An empty box counts as the unit box around the origin.
Camera fitted(Camera camera, const Box& box);

/// Returns the camera for a state without cameras. It has `fit` and looks at the data from the front,
/// somewhat from the right and above.
Camera defaultCamera();

}  // namespace gxy
