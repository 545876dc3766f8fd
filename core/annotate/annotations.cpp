// SPDX-License-Identifier: Apache-2.0
#include "core/annotate/annotations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <optional>
#include <string_view>

#include "core/scene/background.h"
#include "core/scene/camera.h"
#include "core/scene/colormaps.h"
#include "core/scene/json_text.h"

namespace gxy {
namespace {

using Line = Overlay::Line;
using Text = Overlay::Text;

constexpr size_t kLegends = 4;

double luminance(const glm::dvec4& background) {
  return background.a * glm::dot(glm::dvec3(background), {0.2126, 0.7152, 0.0722});
}

/// Sizes in pixels, in proportion to the picture, and colours that stand out from its background.
struct Measures {
  Measures(const Camera& camera, const Background& background) : size(camera.dimensions) {
    onBright = (luminance(background.bottom()) + luminance(background.top())) / 2 > 0.5;
    outline = glm::dvec3(onBright ? 0.35 : 0.75);
    ticks = glm::dvec3(onBright ? 0 : 1);
    font = std::clamp(int(std::lround(std::min(size.x, size.y) / 32)), 10, 40);
    line = std::max(1.0, font / 12.0);
  }
  glm::dvec2 size;
  int font;
  double line;
  bool onBright;
  glm::dvec3 outline, ticks;  ///< their colours
};

std::string formatted(double x, int digits) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, x == 0 ? 0 : x);  // and not -0
  return text;
}

void replaceAll(std::string& text, std::string_view what, const std::string& by) {
  for (size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size())
    text.replace(at, what.size(), by);
}

// --- legends --------------------------------------------------------------------------------------------------------

bool colorsByValue(const Vis& vis) {
  return vis.type != VisType::Volume || vis.volumeRendering || !vis.slices.empty() || !vis.isovalues.empty();
}

struct Legend {
  std::string title;
  ColorMap map;
};

bool isOneColor(const ColorMap& map) {
  return std::all_of(map.points.begin(), map.points.end(),
                     [&](const ColorPoint& p) { return p.rgb == map.points[0].rgb; });
}

/// Returns one legend for each pair of dataset and map, kLegends at most. Maps of one colour have none.
std::vector<Legend> legendsOf(const Annotated& what) {
  std::vector<Legend> legends;
  const auto& operators = what.visualization.operators;
  for (size_t i = 0; i < operators.size() && i < what.shown.ranges.size(); i++) {
    Vis vis = operators[i];
    const Range& range = what.shown.ranges[i];
    if (range.empty() || !colorsByValue(vis)) continue;
    if (vis.rangeOfData) vis.dataRange = {range.min, range.max};
    Legend legend{vis.dataset + (vis.array.empty() ? "" : " " + vis.array) +
                      (vis.component ? " [" + std::to_string(*vis.component) + "]" : ""),
                  effectiveColorMap(vis)};
    const bool there = std::any_of(legends.begin(), legends.end(), [&](const Legend& other) {
      return other.title == legend.title && other.map == legend.map;
    });
    if (!there && !isOneColor(legend.map) && legends.size() < kLegends) legends.push_back(std::move(legend));
  }
  return legends;
}

/// Draws a legend that fills the rectangle, with the title at the top and the bar's lowest number at the bottom.
void addLegend(const Legend& legend, glm::dvec2 lo, glm::dvec2 hi, const Measures& m, Overlay& overlay) {
  overlay.texts.push_back({{hi.x, hi.y}, {1, 1}, m.font, legend.title});
  const double bottom = lo.y + m.font / 2.0, top = hi.y - 2.2 * m.font;
  Overlay::Bar bar{{hi.x - m.font, bottom}, {hi.x, top}, {}};
  const double first = legend.map.points.front().value, last = legend.map.points.back().value;
  const int rows = std::max(1, int(std::lround(top) - std::lround(bottom)));
  for (int y = 0; y < rows; y++) {
    const double fraction = (y + 0.5) / rows;
    bar.colors.push_back(evaluate(legend.map, first * (1 - fraction) + last * fraction));
  }
  overlay.bars.push_back(std::move(bar));

  std::vector<double> numbers{first};
  if (last > first) {
    numbers = roundNumbers(first, last);
    while (double(numbers.size()) * 1.3 * m.font > top - bottom)  // keep every second number
      for (size_t i = 0; i < numbers.size(); i++) numbers.erase(numbers.begin() + ptrdiff_t(i));
    // The ends of the range get numbers if no round number is near them.
    const double room = (last - first) * 1.2 * m.font / (top - bottom);
    if (numbers.empty() || numbers.front() - first > room) numbers.insert(numbers.begin(), first);
    if (last - numbers.back() > room) numbers.push_back(last);
  }
  const std::vector<std::string> texts = numberTexts(numbers, last - first);
  for (size_t i = 0; i < numbers.size(); i++) {
    const double fraction = last > first ? (numbers[i] - first) / (last - first) : 0.5;
    const double y = bottom + fraction * (top - bottom), x = hi.x - 1.2 * m.font;
    overlay.lines.push_back({{x, y}, {x + 0.2 * m.font, y}, m.line, m.ticks});
    overlay.texts.push_back({{x - 0.3 * m.font, y}, {1, 0.5}, m.font, texts[i]});
  }
}

void addLegends(const Annotated& what, const Measures& m, Overlay& overlay) {
  const std::vector<Legend> legends = legendsOf(what);
  const double margin = m.font, width = 6.0 * m.font;
  if (legends.empty() || m.size.x < 2 * width) return;
  const double height = std::min((m.size.y - margin) / double(legends.size()) - margin, 18.0 * m.font);
  if (height < 5.0 * m.font) return;
  const double all = double(legends.size()) * (height + margin) - margin;
  double top = (m.size.y + all) / 2;
  for (const Legend& legend : legends) {
    addLegend(legend, {m.size.x - margin - width, top - height}, {m.size.x - margin, top}, m, overlay);
    top -= height + margin;
  }
}

// --- the axes' directions -------------------------------------------------------------------------------------------

void addAxes(const CameraBasis& basis, const Measures& m, Overlay& overlay) {
  const double length = 2.2 * m.font, reach = length + 1.5 * m.font;
  if (std::min(m.size.x, m.size.y) < 3 * reach) return;
  const glm::dvec2 at(reach, reach + m.font);  // above the viewer's text at the bottom
  const glm::dvec3 right = glm::normalize(basis.du), up = glm::normalize(basis.dv);
  const std::array<glm::dvec3, 3> colors{{{1, 0.35, 0.3}, {0.4, 0.9, 0.35}, {0.45, 0.6, 1}}};
  std::array<int, 3> order{0, 1, 2};  // the farthest tip first
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return basis.view[a] > basis.view[b]; });
  for (const int axis : order) {
    const glm::dvec2 way(right[axis], up[axis]);
    overlay.lines.push_back({at, at + length * way, 2 * m.line, colors[size_t(axis)]});
    overlay.texts.push_back({at + length * way + 0.8 * m.font * way, {0.5, 0.5}, m.font, {"xyz"[axis]}});
  }
}

// --- the box --------------------------------------------------------------------------------------------------------

/// A point's depth along the view, and its position in the picture in pixels.
double depthOf(const CameraBasis& basis, const glm::dvec3& p) { return glm::dot(p - basis.eye, basis.view); }
glm::dvec2 placeOf(const CameraBasis& basis, const glm::dvec3& p) {
  const glm::dvec3 from = (basis.orthographic ? p : (p - basis.eye) / depthOf(basis, p)) - basis.corner;
  return {glm::dot(from, basis.du) / glm::dot(basis.du, basis.du),
          glm::dot(from, basis.dv) / glm::dot(basis.dv, basis.dv)};
}

struct Edge {
  int axis;
  bool outer;           ///< the edge is on the silhouette of the box
  glm::dvec3 from, to;  ///< ends, ascending along the axis
};

/// Returns the edges of the box that nothing inside it can hide: the edges of the faces that face the viewer.
std::vector<Edge> edgesInFront(const Box& box, const CameraBasis& basis) {
  const auto faces = [&](int axis, bool high) {  // whether this face faces the viewer
    if (basis.orthographic) return high ? basis.view[axis] < 0 : basis.view[axis] > 0;
    return high ? basis.eye[axis] > box.hi[axis] : basis.eye[axis] < box.lo[axis];
  };
  std::vector<Edge> edges;
  for (int axis = 0; axis < 3; axis++)
    for (int corner = 0; corner < 4; corner++) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const bool highU = corner & 1, highV = corner & 2;
      const bool seenU = faces(u, highU), seenV = faces(v, highV);
      if (!seenU && !seenV) continue;
      Edge edge{axis, seenU != seenV, box.lo, box.lo};
      edge.from[u] = edge.to[u] = highU ? box.hi[u] : box.lo[u];
      edge.from[v] = edge.to[v] = highV ? box.hi[v] : box.lo[v];
      edge.to[axis] = box.hi[axis];
      edges.push_back(edge);
    }
  return edges;
}

/// Returns the edge as a line in the picture, without the part behind the viewer.
std::optional<Line> lineOf(Edge edge, const CameraBasis& basis, const Measures& m) {
  if (!basis.orthographic) {
    const double a = depthOf(basis, edge.from), b = depthOf(basis, edge.to);
    const double nearest = 1e-3 * std::max(a, b);
    if (!(nearest > 0)) return {};
    if (a < nearest) edge.from += (edge.to - edge.from) * ((nearest - a) / (b - a));
    if (b < nearest) edge.to += (edge.from - edge.to) * ((nearest - b) / (a - b));
  }
  return Line{placeOf(basis, edge.from), placeOf(basis, edge.to), m.line, m.outline};
}

void addOutline(const Box& box, const CameraBasis& basis, const Measures& m, Overlay& overlay) {
  if (box.empty()) return;
  struct Labelled {
    Edge edge;
    Line line;
  };
  std::array<std::optional<Labelled>, 3> lowest;  // by axis: the edge with the numbers
  for (const Edge& edge : edgesInFront(box, basis)) {
    const std::optional<Line> line = lineOf(edge, basis, m);
    if (!line) continue;
    overlay.lines.push_back(*line);
    if (!edge.outer) continue;
    auto& best = lowest[size_t(edge.axis)];
    if (!best || line->from.y + line->to.y < best->line.from.y + best->line.to.y) best = {edge, *line};
  }
  const glm::dvec3 centre = (box.lo + box.hi) / 2.0;
  const bool seen = basis.orthographic || depthOf(basis, centre) > 0;
  const glm::dvec2 middle = seen ? placeOf(basis, centre) : m.size / 2.0;
  for (const auto& labelled : lowest) {
    if (!labelled) continue;
    const auto& [edge, line] = *labelled;
    const glm::dvec2 way = line.to - line.from;
    const double length = glm::length(way);
    if (length < 5.0 * m.font) continue;
    glm::dvec2 out = glm::dvec2(way.y, -way.x) / length;  // away from the box
    if (glm::dot(out, (line.from + line.to) / 2.0 - middle) < 0) out = -out;
    const std::vector<std::string> extents =
        numberTexts({box.lo[edge.axis], box.hi[edge.axis]}, box.hi[edge.axis] - box.lo[edge.axis]);
    const std::array<std::string, 3> texts{extents[0], std::string(1, "xyz"[edge.axis]), extents[1]};
    const glm::dvec2 anchor(0.5 - 0.5 * out.x, 0.5 - 0.5 * out.y);
    for (int i = 0; i < 3; i++) {
      const double along = std::array{0.12, 0.5, 0.88}[size_t(i)];
      overlay.texts.push_back(
          {line.from + along * way + 0.4 * m.font * out, anchor, m.font, texts[size_t(i)]});
    }
  }
}

}  // namespace

std::vector<double> roundNumbers(double lo, double hi) {
  const double span = hi - lo;
  if (!(span > 0) || !std::isfinite(span)) return {};
  const double power = std::pow(10, std::floor(std::log10(span / 3)));
  double step = power;
  for (const double factor : {2.0, 2.5, 5.0, 10.0})
    if (factor * power <= span / 3) step = factor * power;
  std::vector<double> numbers;
  for (double k = std::ceil(lo / step); k * step <= hi && numbers.size() < 8; k++)
    numbers.push_back(k * step);
  return numbers;
}

std::vector<std::string> numberTexts(const std::vector<double>& numbers, double span) {
  std::vector<std::string> texts;
  bool close = false;
  for (int digits = 3; !close && digits <= 9; digits++) {
    texts.clear();
    close = true;
    for (const double x : numbers) {
      texts.push_back(formatted(x, digits));
      close &= std::abs(std::strtod(texts.back().c_str(), nullptr) - x) <= span / 200;
    }
  }
  return texts;
}

Overlay overlayOf(const Annotations& annotations, const Annotated& what) {
  Overlay overlay;
  const Measures m(what.camera, what.settings);
  overlay.onBright = m.onBright;
  const CameraBasis basis = cameraBasis(what.camera);
  if (annotations.outline) addOutline(what.shown.box, basis, m, overlay);
  if (annotations.axes) addAxes(basis, m, overlay);
  if (annotations.legend) addLegends(what, m, overlay);
  if (!annotations.text.empty()) {
    std::string text = annotations.text.substr(0, 1000);  // draw() shows 200 characters at most
    const std::string step = std::to_string(what.step);
    replaceAll(text, "{step}", step);
    replaceAll(text, "{time}", what.time ? numberText(*what.time) : step);
    overlay.texts.push_back({{m.font, m.size.y - m.font}, {0, 1}, m.font, text});
  }
  return overlay;
}

}  // namespace gxy
