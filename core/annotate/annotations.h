// SPDX-License-Identifier: Apache-2.0
// Annotations over a picture: legends of its colours, the directions of the axes, the box of the data, and a text.
#pragma once
#include <optional>

#include "core/annotate/overlay.h"
#include "core/scene/resolve.h"
#include "core/scene/scene.h"

namespace gxy {

/// The picture that is annotated.
struct Annotated {
  const Visualization& visualization;  ///< as in the state, not resolved
  const ShownSoFar& shown;             ///< an operator whose range is empty has no legend
  const Camera& camera;                ///< after fitted()
  const RenderSettings& settings;      ///< the background decides between black and white text
  size_t step = 0;                     ///< number of the time step, from 0
  std::optional<double> time = {};     ///< time of that step, if it is known
};

/// Makes the overlay for a picture of the camera's dimensions. Text sizes follow the picture's size. Legends
/// that do not fit are left out. Edges of the box behind the data are left out, because the overlay is drawn
/// over the data. In the text {step} is replaced by the number of the step, and {time} by its time, or by its
/// number if the time is not known.
Overlay overlayOf(const Annotations& annotations, const Annotated& what);

/// Returns three to about six round numbers in [lo, hi], ascending, at distances of 1, 2, 2.5 or 5 times a
/// power of ten. Returns none if the interval is empty or not finite.
std::vector<double> roundNumbers(double lo, double hi);

/// Returns numbers as text, all with the same number of digits: the fewest, from three to nine, for which
/// every text is within `span` / 200 of its number.
std::vector<std::string> numberTexts(const std::vector<double>& numbers, double span);

}  // namespace gxy
