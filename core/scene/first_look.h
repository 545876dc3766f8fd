// SPDX-License-Identifier: Apache-2.0
// Makes a state for data without a state file, so that the first picture is a good one.
//
// Volumes are shown by volume rendering. If the values are spread over their range, colour and opacity follow
// the value. Otherwise they follow the quantiles of the values, and rare values are more opaque, so that a
// nearly empty field shows its content. Geometry is shown as it is: points as spheres and lines as tubes,
// with a radius that is a fraction of the points' spacing. One light moves with the camera, which sees all
// data from somewhat above.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/scene/resolve.h"

namespace gxy {

/// The facts about a dataset that a first look needs.
struct LookFacts {
  DatasetSpec dataset;
  DataFacts data;
  /// A sample of the values that colours show, ascending and finite. Empty: there are no such values.
  std::vector<float> values;
  /// The only axis along which a volume is one cell thick; such a volume is an image.
  std::optional<int> thin = {};
};

struct LookOptions {
  std::vector<double> isovalues;  ///< show isosurfaces of volumes at these values instead
  bool autoIsovalue = false;      ///< show the isosurface at firstIsovalue() instead
  bool slice = false;             ///< show the three slices through the middle instead

  /// Whether surfaces inside of volumes are to be shown.
  bool looksInside() const { return !isovalues.empty() || autoIsovalue || slice; }
};

/// Returns a state with the datasets, one visualization and one camera. Equal facts give equal states.
State firstLook(std::span<const LookFacts> data, const LookOptions& options = {});

/// Adds the ends of the whole range, which the sample may have missed, and sorts the sample.
void completeSample(LookFacts& facts);

/// Returns the value at `fraction`, 0 to 1, of an ascending sample that is not empty.
double quantile(std::span<const float> ascending, double fraction);

/// The maps of a first look at `values`. `extent` is the length of a ray through the volume in world units.
struct FirstMaps {
  ColorMap colors;
  OpacityMap opacities;
  double referenceLength = 1;
};
FirstMaps firstMaps(std::span<const float> values, double extent);

/// Returns the colours for surfaces, points and lines. None is as dark as the background. If all values are
/// equal, or there are none, the colour is nearly white.
ColorMap firstSurfaceColors(std::span<const float> values);

/// Returns an isovalue that divides the sample: the middle of values that are spread over their range, and
/// otherwise the value that one in twenty exceeds.
double firstIsovalue(std::span<const float> values);

}  // namespace gxy
