// SPDX-License-Identifier: Apache-2.0
// What people expect to see over a picture: a legend of its colours, the axes' directions, the data's box and a text.
#pragma once
#include <optional>

#include "core/annotate/overlay.h"
#include "core/scene/resolve.h"
#include "core/scene/scene.h"

namespace gxy {

/// What annotations tell of.
struct Annotated {
  const Visualization& visualization;  ///< as the state has it
  const ShownSoFar& shown;             ///< ranges without values have no legend
  const Camera& camera;                ///< fitted
  const RenderSettings& settings;      ///< of the picture; its background decides between black and white
  size_t step = 0;                     ///< number of the time step, from 0
  std::optional<double> time = {};     ///< of that step, where it is known
};

/// The overlay of a picture of the camera's dimensions. Text sizes follow the picture's size; a legend that does not fit is
/// left out. Edges of the box behind the data are left out, so that nothing hides what is in front of it. In the text {step}
/// becomes the number of the step, and {time} its time, or its number where the time is not known.
Overlay overlayOf(const Annotations& annotations, const Annotated& what);

/// From three to about six round numbers (1, 2, 2.5 or 5 times a power of ten) in [lo, hi], ascending; none for an interval that
/// is empty or not finite.
std::vector<double> roundNumbers(double lo, double hi);

/// Numbers as people read them: with three to nine digits, and no more of them than leave every number right to half a hundredth of
/// `span`.
std::vector<std::string> numberTexts(const std::vector<double>& numbers, double span);

}  // namespace gxy
