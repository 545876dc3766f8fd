// SPDX-License-Identifier: Apache-2.0
// The background of a picture.
#pragma once
#include <glm/vec4.hpp>

#include "core/scene/scene.h"

namespace gxy {

/// One colour, or a vertical gradient that is linear from the picture's lower edge to its upper edge. Colours
/// are rgba and not premultiplied.
class Background {
 public:
  Background(const glm::dvec4& color) : bottom_(color), top_(color) {}
  Background(const RenderSettings& settings)
      : bottom_(settings.background),
        top_(settings.backgroundTop.value_or(settings.background)),
        gradient_(settings.backgroundTop) {}

  bool isGradient() const { return gradient_; }
  const glm::dvec4& bottom() const { return bottom_; }
  const glm::dvec4& top() const { return top_; }

  /// Returns the colour at the middle of row `row` of `rows` rows of pixels; row 0 is the lowest.
  glm::dvec4 at(int row, int rows) const {
    return gradient_ ? bottom_ + (top_ - bottom_) * ((row + 0.5) / rows) : bottom_;
  }

 private:
  glm::dvec4 bottom_, top_;
  bool gradient_ = false;
};

}  // namespace gxy
