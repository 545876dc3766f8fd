// SPDX-License-Identifier: Apache-2.0
// Draws lines, bars and texts over a picture.
#pragma once
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "core/image/image.h"

namespace gxy {

/// Lines, bars and texts, drawn in this order. Positions are in pixels from the picture's lower left corner,
/// colours are in [0, 1]. Parts outside the picture and elements whose position is not finite are left out. A
/// text that lies partly outside is moved inside if it fits.
struct Overlay {
  struct Line {
    glm::dvec2 from{0}, to{0};
    double width = 1;
    glm::dvec3 color{1};
  };
  /// A rectangle with a thin frame and horizontal stripes.
  struct Bar {
    glm::dvec2 lo{0}, hi{0};
    std::vector<glm::dvec3> colors;  ///< of the stripes, bottom to top; all have the same height
  };
  /// White with a dark rim, or black with a bright rim, so that it is readable on any background.
  struct Text {
    glm::dvec2 at{0};      ///< position of the text's point `anchor`
    glm::dvec2 anchor{0};  ///< a point of the text's box; (0, 0): lower left corner, (1, 1): upper right
    int height = 14;       ///< font size in pixels
    std::string text;      ///< UTF-8, one line
  };
  std::vector<Line> lines = {};
  std::vector<Bar> bars = {};
  std::vector<Text> texts = {};
  bool onBright = false;  ///< the background is bright, so texts are black

  bool empty() const { return lines.empty() && bars.empty() && texts.empty(); }
};

/// Draws the overlay over the picture, with antialiased edges. If the font for texts is missing, throws Error
/// and says what to install.
void draw(const Overlay& overlay, Image& picture);

/// Blends a colour over pixel (x, y), which is in the picture, with opacity `coverage` in (0, 1].
using Blend = std::function<void(int x, int y, const glm::dvec3& color, double coverage)>;

/// The same for pictures in any other form, of `size` pixels: calls `blend` for each pixel that is covered.
void draw(const Overlay& overlay, glm::ivec2 size, const Blend& blend);

}  // namespace gxy
