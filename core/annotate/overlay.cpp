// SPDX-License-Identifier: Apache-2.0
#include "core/annotate/overlay.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "core/image/text_mask.h"

namespace gxy {
namespace {

/// The picture that is drawn on.
struct Target {
  glm::ivec2 size;
  const Blend& blend;

  void cover(int x, int y, const glm::dvec3& color, double coverage) const {
    if (x >= 0 && y >= 0 && x < size.x && y < size.y && coverage > 0)
      blend(x, y, color, std::min(coverage, 1.0));
  }
};

/// Clips the line [from, to] to the picture widened by `margin` pixels (Liang and Barsky, "A new concept and
/// method for line clipping", 1984). Returns false if no part of it is inside.
bool clipLine(glm::dvec2& from, glm::dvec2& to, const Target& target, double margin) {
  double first = 0, last = 1;
  const glm::dvec2 way = to - from, hi = glm::dvec2(target.size) + margin;
  for (int axis = 0; axis < 2; axis++) {
    const double d = way[axis];
    if (d == 0) {
      if (from[axis] < -margin || from[axis] > hi[axis]) return false;
      continue;
    }
    const double a = (-margin - from[axis]) / d, b = (hi[axis] - from[axis]) / d;
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  if (!(first <= last)) return false;
  to = from + last * way;
  from += first * way;
  return true;
}

bool isFinite(const glm::dvec2& p) { return std::isfinite(p.x) && std::isfinite(p.y); }

/// Returns the nearest integer, limited to a million pixels, which is far outside any picture.
int rounded(double x) { return int(std::lround(std::clamp(x, -1e6, 1e6))); }

/// The coverage of a pixel is the distance of its centre from the line's rim, which lies half a pixel
/// outside the line.
void drawLine(const Overlay::Line& line, const Target& target) {
  const double reach = line.width / 2 + 0.5;
  glm::dvec2 from = line.from, to = line.to;
  if (!clipLine(from, to, target, reach)) return;
  const glm::dvec2 way = to - from;
  const double square = glm::dot(way, way);
  const bool steep = std::abs(way.y) > std::abs(way.x);
  const int along = steep ? 1 : 0, across = 1 - along;
  const double length = std::sqrt(square);
  // the largest distance of a covered pixel from the line's middle, in the direction `across`
  const double span = length > 0 ? reach * length / std::abs(way[along]) : reach;
  for (int i = int(std::floor(std::min(from[along], to[along]) - reach));
       i <= int(std::ceil(std::max(from[along], to[along]) + reach)); i++) {
    const double t = way[along] != 0 ? std::clamp((i + 0.5 - from[along]) / way[along], 0.0, 1.0) : 0;
    const double middle = from[across] + t * way[across];
    for (int j = int(std::floor(middle - span)); j <= int(std::ceil(middle + span)); j++) {
      glm::dvec2 p;
      p[along] = i + 0.5, p[across] = j + 0.5;
      const double s = square > 0 ? std::clamp(glm::dot(p - from, way) / square, 0.0, 1.0) : 0;
      target.cover(steep ? j : i, steep ? i : j, line.color, reach - glm::distance(p, from + s * way));
    }
  }
}

void drawBar(const Overlay::Bar& bar, const Target& target) {
  const glm::ivec2 lo(rounded(bar.lo.x), rounded(bar.lo.y));
  const glm::ivec2 hi(rounded(bar.hi.x), rounded(bar.hi.y));
  for (int y = lo.y - 1; y <= hi.y; y++)
    for (int x = lo.x - 1; x <= hi.x; x++) {
      const bool frame = x < lo.x || y < lo.y || x == hi.x || y == hi.y;
      glm::dvec3 color(0.5);
      if (!frame) {
        const auto n = double(bar.colors.size());
        color = bar.colors[size_t(std::min((y - lo.y + 0.5) / (hi.y - lo.y) * n, n - 1))];
      }
      target.cover(x, y, color, 1);
    }
}

/// Cuts the text to 200 characters, more than a picture can show.
std::string cut(const std::string& text) {
  constexpr int kMost = 200;
  size_t end = 0;
  for (int n = 0; end < text.size(); end++) {
    const bool begins = (uint8_t(text[end]) & 0xC0) != 0x80;  // the first byte of a character in UTF-8
    if (begins && n++ == kMost) break;
  }
  return text.substr(0, end);
}

/// Moves the interval [begin, begin + length) into [0, size) if a part of it is inside and it fits.
/// Returns its beginning.
int movedIn(int begin, int length, int size) {
  const bool outside = begin >= size || begin + length <= 0;
  return outside || length > size ? begin : std::clamp(begin, 0, size - length);
}

void drawText(const Overlay::Text& text, bool onBright, const Target& target) {
  const TextMask mask = textMask(cut(text.text), text.height);
  if (mask.width == 0) return;
  const int x = movedIn(rounded(text.at.x - text.anchor.x * mask.width), mask.width, target.size.x);
  const int y = movedIn(rounded(text.at.y - text.anchor.y * mask.height), mask.height, target.size.y);
  constexpr int kRim = 1;
  for (int j = -kRim; j < mask.height + kRim; j++)
    for (int i = -kRim; i < mask.width + kRim; i++) {
      float near = 0;
      for (int v = -kRim; v <= kRim; v++)
        for (int u = -kRim; u <= kRim; u++) near = std::max(near, mask.at(i + u, j + v));
      target.cover(x + i, y + j, glm::dvec3(onBright ? 1 : 0), 0.6 * double(near));
      target.cover(x + i, y + j, glm::dvec3(onBright ? 0 : 1), double(mask.at(i, j)));
    }
}

}  // namespace

void draw(const Overlay& overlay, glm::ivec2 size, const Blend& blend) {
  const Target target{size, blend};
  for (const Overlay::Line& line : overlay.lines)
    if (isFinite(line.from) && isFinite(line.to)) drawLine(line, target);
  for (const Overlay::Bar& bar : overlay.bars) drawBar(bar, target);
  for (const Overlay::Text& text : overlay.texts)
    if (isFinite(text.at)) drawText(text, overlay.onBright, target);
}

void draw(const Overlay& overlay, Image& picture) {
  draw(overlay, {picture.width, picture.height}, [&](int x, int y, const glm::dvec3& color, double a) {
    float* const pixel = &picture.rgba[4 * (size_t(y) * size_t(picture.width) + size_t(x))];
    for (int c = 0; c < 3; c++) pixel[c] = float(a * color[c] + (1 - a) * double(pixel[c]));
    pixel[3] = float(a + (1 - a) * double(pixel[3]));
  });
}

}  // namespace gxy
