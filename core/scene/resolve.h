// SPDX-License-Identifier: Apache-2.0
// What a state asks of the data instead of saying it: ranges of maps, radii, the viewpoint.
#pragma once
#include <span>
#include <vector>

#include "core/data/box.h"
#include "core/scene/scene.h"

namespace gxy {

/// What is known of a dataset before it is looked at. The same on any number of ranks.
struct DataFacts {
  Box box;     ///< of all of it, world
  Box middle;  ///< the same without outliers (points only); the box where there are none
  std::vector<Range>
      ranges;          ///< of a volume: per component, then of the magnitude if there are several; else one
  double spacing = 0;  ///< mean distance between neighbouring points of geometry, world; 0: unknown
};

/// What pictures of a visualization have shown so far: later steps of the data widen it and never narrow it, so that colours
/// do not flicker and the camera does not jump back.
struct ShownSoFar {
  std::vector<Range> ranges;  ///< by operator
  Box box;                    ///< of all operators, with their radii
};

/// The visualization with numbers in place of "data" and "auto"; `facts` are those of each operator's dataset. A range
/// without finite values leaves the maps as they are.
Visualization resolved(Visualization visualization, std::span<const DataFacts> facts, ShownSoFar& shown);

/// The part of the spacing of points that "auto" makes their radius.
inline constexpr double kRadiusOfSpacing = 0.3;

/// The part of the picture's width or height that a fitted box spans.
inline constexpr double kFittedPart = 0.88;

/// The camera that `fit` asks for: moved, its direction kept, to where `box` lies centred in the picture and spans
/// kFittedPart of its width or its height; an orthographic one also gets that height. Without `fit`: the camera itself. An
/// empty box counts as the unit box about the origin.
Camera fitted(Camera camera, const Box& box);

/// The camera of a state that has none: fitted, looking at the data from the front, somewhat from the right and above.
Camera defaultCamera();

}  // namespace gxy
