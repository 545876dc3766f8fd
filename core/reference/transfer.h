// SPDX-License-Identifier: Apache-2.0
// Maps from values to colour and extinction, in double and exact at their control points.
#pragma once
#include <vector>

#include "core/scene/scene.h"

namespace gxy::reference {

/// Both maps between two neighbouring control points, where their entries are linear.
class LinearTransfer {
 public:
  glm::dvec3 colour(double value) const { return colour_ + (value - colourStart_) * colourSlope_; }
  /// Extinction per world unit. Finite, unless the opacity is 1 all along.
  double extinction(double value) const;
  bool opaque() const { return opaque_; }

 private:
  friend class Transfer;
  glm::dvec3 colour_{0}, colourSlope_{0};
  double colourStart_ = 0;
  double entry_ = 0, entrySlope_ = 0, entryStart_ = 0;
  double referenceLength_ = 0;  ///< 0: entries are extinctions
  bool opaque_ = false;
};

/// The colour and opacity maps of a Vis, moved to its data range. Immutable; safe to use from any thread.
class Transfer {
 public:
  /// `referenceLength`, in world units, is the thickness of the slab whose opacity an opacity map gives. An
  /// empty colour map is grey 0.4 at 0 to white at 1, an empty opacity map 1 everywhere.
  Transfer(const Vis& vis, double referenceLength);

  glm::dvec3 colour(double value) const;
  glm::dvec3 firstColour() const { return colours_.front().rgb; }
  /// The colour of geometry whose value is NaN.
  glm::dvec3 colourOfNan() const { return colourOfNan_; }

  /// Extinction per world unit; infinite where the opacity is 1.
  double extinction(double value) const;

  /// The maps in the neighbourhood of a value. At a control point they are those on its upper side.
  LinearTransfer around(double value) const;

  /// True when the extinction is zero on all of [lo, hi].
  bool transparent(double lo, double hi) const;

  /// The values of all control points, ascending, each once. Between two of them both maps are linear.
  const std::vector<double>& breaks() const { return breaks_; }

 private:
  std::vector<ColorPoint> colours_;
  glm::dvec3 colourOfNan_;
  std::vector<OpacityPoint> opacities_;
  bool perLength_;
  double referenceLength_;
  std::vector<double> breaks_;
};

}  // namespace gxy::reference
