// SPDX-License-Identifier: Apache-2.0
// A state that shows data of which nobody has said how, so that a first picture of them is a good one.
//
// Volumes are shown by volume rendering: colour and opacity follow the value where the values are spread over their range,
// else their quantiles, rare values being the more opaque ones, so that a field that is nearly empty shows what it has.
// Geometry is shown as it is, points as spheres and lines as tubes of a part of the points' spacing. One light goes with the
// camera, which sees all data from somewhat above.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/scene/resolve.h"

namespace gxy {

/// What a first look needs to know of a dataset.
struct LookFacts {
  DatasetSpec dataset;
  DataFacts data;
  std::vector<float>
      values;  ///< a sample of what is mapped, ascending, finite; empty: there is nothing to map
  std::optional<int> thin = {};  ///< the only axis along which a volume is one cell thick: it is an image
};

struct LookOptions {
  std::vector<double> isovalues;  ///< show these surfaces of volumes instead
  bool autoIsovalue = false;      ///< or one where the values divide best
  bool slice = false;             ///< or the three slices through the middle
};

/// The state: its datasets, one visualization, one camera. Pure: equal facts give equal states.
State firstLook(std::span<const LookFacts> data, const LookOptions& options = {});

/// Sorts the sample and gives it the ends of the whole range, which it may have missed.
void completeSample(LookFacts& facts);

/// The value at a fraction of a sample that ascends.
double quantile(std::span<const float> ascending, double fraction);

/// The maps of a first look at values; `extent`: how far a ray goes through the volume, world units.
struct FirstMaps {
  ColorMap colors;
  OpacityMap opacities;
  double referenceLength = 1;
};
FirstMaps firstMaps(std::span<const float> values, double extent);

/// The colours of surfaces, points and lines: none is as dark as the background. Of equal values, or none: nearly white.
ColorMap firstSurfaceColors(std::span<const float> values);

/// Where a surface divides the sample: in the middle of a spread one, else where one in twenty values lies above.
double firstIsovalue(std::span<const float> values);

}  // namespace gxy
