// SPDX-License-Identifier: Apache-2.0
// Colour and opacity maps in the form that kernels read (kernels/map.h), with the bounds that step planning
// needs.
#pragma once
#include <cstdint>
#include <vector>

#include "core/scene/scene.h"

namespace gxy {

/// Converts true values and world lengths into the kernels' units.
struct MapUnits {
  double shift = 0, scale = 1;  ///< true value = shift + scale * stored
  double worldPerT = 1;         ///< world length of one unit of a ray's t
  double referenceLength = 1;   ///< world length of the slab that has the opacity of the map
};

/// A map as a list of intervals over the stored value. In each, extinction (per unit of t) and colour are
/// linear; the first and last are constant and reach to infinity. An opacity map has a curved extinction,
/// -ln(1 - a) / L: it is cut until linear pieces are within 2e-4 of it. Control points are nodes, so no spike
/// is lost. Two points at one value are a step. A step that is justAbove another point (colormaps.h) is one
/// float above it, so that the point's value lies before the step.
class CompiledMap {
 public:
  CompiledMap() = default;
  /// If `opacity` is null, the map has colours only and extinction 0.
  CompiledMap(const ColorMap& color, const OpacityMap* opacity, const MapUnits& units);

  int uniform = 0;                ///< number of inner intervals if they are equally long, else 0
  float origin = 0, inverse = 0;  ///< first inner node; 1 / length of a bucket (or, if uniform, an interval)
  std::vector<int32_t> buckets;   ///< first interval of each bucket
  std::vector<float> nodes, spans, rows, pieces, sums;  ///< see kernels/map_view.h
  std::vector<int32_t> opaque;                          ///< see kernels/map_view.h
  glm::vec3 nan{0};                                     ///< colour of NaN
  double largestColor = 0;                              ///< largest component of any colour

  /// Bounds of the map over stored values [lo, hi]. Slopes are of extinction and of extinction times colour,
  /// per unit of stored value and of t.
  struct Over {
    double extinction = 0;  ///< largest extinction, per unit of t
    double slope = 0;       ///< largest slope
    double shade = 0;       ///< largest part of a slope that the change of colour makes
    double kink = 0;        ///< largest change of the slope at a node inside [lo, hi]
    double bend = 0;        ///< total variation of the slope inside [lo, hi]
    double denseKink = 0;   ///< largest quotient of a node's kink and the square of the extinction there
    double denseBend = 0;   ///< sum of these quotients
    double curve = 0;       ///< the part of `bend` that is not at nodes
    double jump = 0;        ///< largest step of extinction and of extinction times colour inside
  };
  Over over(float lo, float hi) const;

  int intervals() const { return int(spans.size() / 4); }

 private:
  /// Answers maxima over ranges, from the maxima over runs of 2^level intervals.
  struct RangeMax {
    std::vector<std::vector<double>> levels;
    void build(std::vector<double> values);
    double query(int first, int last) const;
  };
  int intervalOf(float value) const;
  double extinctionAt(int interval, float value) const;
  RangeMax extinction_, slope_, shade_, kink_, denseKink_, jump_;
  std::vector<double> bend_, denseBend_;  ///< variation of the slope up to the start of each interval
  std::vector<double> curve_;             ///< the part of bend_ within intervals, likewise
};

}  // namespace gxy
