// SPDX-License-Identifier: Apache-2.0
// Colour and opacity maps as the kernels read them (kernels/map.h), and what step planning asks of them.
#pragma once
#include <cstdint>
#include <vector>

#include "core/scene/scene.h"

namespace gxy {

/// How true values and world lengths become the kernels' units.
struct MapUnits {
  double shift = 0, scale = 1;  ///< true value = shift + scale * stored
  double worldPerT = 1;         ///< world length of one unit of a ray's t
  double referenceLength = 1;   ///< world length of the slab that an opacity map speaks of
};

/// Intervals over the stored value, each linear in extinction (per unit of t) and colour; the first and last are
/// constant and reach to infinity. An opacity map's extinction, -ln(1 - a) / L, is curved: it is cut until linear pieces
/// are within 2e-4 of it. Control points are nodes, so no spike is lost; two points at one value are a step. A step
/// justAbove another point (colormaps.h) is one float above it, so that the point's value is before it.
class CompiledMap {
 public:
  CompiledMap() = default;
  /// `opacity` null: colour only, extinction 0.
  CompiledMap(const ColorMap& color, const OpacityMap* opacity, const MapUnits& units);

  int uniform = 0;                ///< number of inner intervals if they are equally long, else 0
  float origin = 0, inverse = 0;  ///< first inner node; per bucket (or interval) length
  std::vector<int32_t> buckets;   ///< first interval of each bucket
  std::vector<float> nodes, lengths, rows, pieces, sums;  ///< see kernels/volume_view.h
  std::vector<int32_t> opaque;                            ///< the same
  glm::vec3 nan{0};                                       ///< colour where there is no value
  double largestColor = 0;                                ///< over all components

  /// What the map does over stored values [lo, hi].
  struct Over {
    double extinction = 0;  ///< largest, per unit of t
    double slope = 0;       ///< largest change of extinction and extinction times colour, per value and t
    double shade = 0;       ///< the part of it that colour has
    double kink = 0;        ///< largest change of the slope at a node inside
    double bend = 0;        ///< total variation of the slope inside
    double denseKink = 0;   ///< largest change of the slope at a node over the square of the extinction there
    double denseBend = 0;   ///< sum of these
    double curve = 0;       ///< the part of it that is not at nodes
    double jump = 0;  ///< largest step of extinction and extinction times colour at a discontinuity inside
  };
  Over over(float lo, float hi) const;

  int intervals() const { return int(lengths.size()); }

 private:
  /// Maxima over runs of 2^level intervals.
  struct RangeMax {
    std::vector<std::vector<double>> levels;
    void build(std::vector<double> values);
    double query(int first, int last) const;
  };
  int intervalOf(float value) const;
  double extinctionAt(int interval, float value) const;
  RangeMax extinction_, slope_, shade_, kink_, denseKink_, jump_;
  std::vector<double> bend_, denseBend_;  ///< variation of the slope up to intervals' starts
  std::vector<double> curve_;             ///< that in intervals
};

}  // namespace gxy
