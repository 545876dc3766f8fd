// SPDX-License-Identifier: Apache-2.0
// Lines, bars and texts over a picture.
#pragma once
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "core/image/image.h"

namespace gxy {

/// What is drawn over a picture, in this order: lines, bars, texts. Positions are in pixels from the picture's lower left
/// corner, colours in [0, 1]. What lies outside the picture, or has no finite place, is left out; a text that lies partly outside is moved in.
struct Overlay {
  struct Line {
    glm::dvec2 from{0}, to{0};
    double width = 1;
    glm::dvec3 color{1};
  };
  /// A rectangle with a thin frame, of one colour in each row of pixels.
  struct Bar {
    glm::dvec2 lo{0}, hi{0};
    std::vector<glm::dvec3> colors;  ///< bottom to top, each as high as the others
  };
  /// White with a dark rim, or black with a bright one, so that it is read on any background.
  struct Text {
    glm::dvec2 at{0};      ///< the point of the text that `anchor` names
    glm::dvec2 anchor{0};  ///< 0, 0: its lower left corner; 1, 1: its upper right one
    int height = 14;       ///< of a line of text
    std::string text;      ///< UTF-8, one line
  };
  std::vector<Line> lines = {};
  std::vector<Bar> bars = {};
  std::vector<Text> texts = {};
  bool onBright = false;  ///< the background is: texts are black

  bool empty() const { return lines.empty() && bars.empty() && texts.empty(); }
};

/// Draws it over the picture, with smooth edges. Throws Error, with what to install, where there is no font for its texts.
void draw(const Overlay& overlay, Image& picture);

/// Lays a colour over a pixel that is in the picture; `coverage`, in (0, 1], says how much of it.
using Blend = std::function<void(int x, int y, const glm::dvec3& color, double coverage)>;

/// The same for pictures in another form.
void draw(const Overlay& overlay, glm::ivec2 size, const Blend& blend);

}  // namespace gxy
