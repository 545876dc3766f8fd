// SPDX-License-Identifier: Apache-2.0
// Random States within the bounds that the state file can say, from a seed.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace gxy {

class RandomState {
 public:
  explicit RandomState(uint64_t seed) : engine_(seed) {}

  State state() {
    State out;
    for (int i = 0, n = integer(0, 3); i < n; ++i) out.datasets.push_back(dataset(i));
    out.settings = {unit(), unit() * 4, integer(1, 64), {unit(), unit(), unit(), unit()}};
    if (coin()) out.settings.backgroundTop = glm::dvec4(unit(), unit(), unit(), unit());
    for (int i = 0, n = integer(0, 3); i < n; ++i) out.visualizations.push_back(visualization());
    for (int i = 0, n = integer(0, 3); i < n; ++i) out.cameras.push_back(camera());
    if (coin()) out.annotations = {coin(), coin(), coin(), text()};
    return out;
  }

 private:
  int integer(int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(engine_); }
  bool coin() { return integer(0, 1) == 1; }
  double unit() { return 1 - std::uniform_real_distribution<double>(0, 1)(engine_); }  // (0, 1]
  double any() { return (unit() * 2 - 1) * std::pow(10.0, integer(-200, 200)); }
  double positive() { return std::abs(any()) + 1e-300; }
  glm::dvec3 vector() { return {any(), any(), any() + 1}; }
  std::string text() {
    static const char* const kPieces[] = {
        "a", "Z", " ", "\"", "\\", "/", "\n", "\t", "\x01", "\xC3\xA9", "\xF0\x9F\x8C\x8C"};
    std::string out;
    for (int i = 0, n = integer(0, 8); i < n; ++i) out += kPieces[integer(0, 10)];
    return out;
  }

  DatasetSpec dataset(int i) {
    if (integer(0, 3) == 0) return derived(i);
    DatasetSpec d{std::to_string(i).append(text()),
                  DatasetType(integer(0, 3)),
                  text(),
                  text(),
                  {unit(), unit(), unit(), unit()}};
    if (d.type != DatasetType::Volume)
      for (int n = integer(0, 2); n > 0; --n) d.fields.push_back(std::to_string(n) + text());
    return d;
  }

  DatasetSpec derived(int i) {
    DatasetSpec d{std::to_string(i).append(text()),
                  DatasetType(integer(0, 3)),
                  "",
                  "",
                  {unit(), unit(), unit(), unit()}};
    d.filter = "F" + text();
    for (int n = integer(0, 3); n > 0; --n) {
      FilterInput& input = d.inputs.emplace_back(FilterInput{std::to_string(n) + text(), {}});
      for (int names = integer(1, 3); names > 0; --names) input.datasets.push_back(text());
    }
    if (coin()) d.properties = R"({"a":[1,2.5,{"b":null}],"c":"text","d":false})";
    return d;
  }

  Camera camera() {
    Camera out{vector(),   vector(),
               vector(),   coin() ? 0 : unit() * 179,
               positive(), {integer(1, 4096), integer(1, 4096)},
               text(),     coin()};
    return out;
  }

  std::vector<double> ascending() {
    std::vector<double> out;
    for (int i = 0, n = integer(1, 6); i < n; ++i) out.push_back(i && coin() && coin() ? out.back() : any());
    std::sort(out.begin(), out.end());
    return out;
  }

  std::vector<Plane> planes() {
    std::vector<Plane> out;
    for (int i = 0, n = integer(0, 3); i < n; ++i) out.push_back({vector(), any()});
    return out;
  }

  Lighting lighting() {
    Lighting out{{}, coin(), integer(0, 64), positive(), unit(), unit(), unit(), unit() * 100};
    for (int i = 0, n = integer(0, 3); i < n; ++i)
      out.sources.push_back({LightType(integer(0, 2)), vector()});
    return out;
  }

  Vis vis() {
    Vis out;
    out.type = VisType(integer(0, 3));
    out.dataset = "other" + text();
    if (coin()) out.array = text();
    if (coin()) out.component = integer(0, 9);
    out.colormap.points.clear();
    for (const double v : ascending()) out.colormap.points.push_back({v, {unit(), unit(), unit()}});
    if (out.type != VisType::Volume && coin()) out.colormap.nan = glm::dvec3{unit(), unit(), unit()};
    out.opacitymap = {coin(), {}};
    for (const double v : ascending())
      out.opacitymap.points.push_back({v, out.opacitymap.extinction ? positive() : unit()});
    if (coin())
      out.dataRange = {-positive(), positive()};
    else
      out.rangeOfData = coin();
    out.radiusOfData = coin();
    if (coin()) out.referenceLength = positive();
    out.opacity = unit();
    out.clipPlanes = planes();
    out.volumeRendering = coin();
    out.cells = coin() ? CellsShown::Flat : CellsShown::Smooth;
    for (int i = 0, n = integer(0, 3); i < n; ++i) out.isovalues.push_back(any());
    out.slices = planes();
    out.radius0 = any(), out.radius1 = any(), out.value0 = any(), out.value1 = any();
    out.twoSided = coin();
    return out;
  }

  Visualization visualization() {
    Visualization out{text(), lighting(), {}, {}};
    if (coin()) {
      out.view.name = "view " + std::to_string(views_++);  // each name once
      out.view.follow = coin();
      out.view.asItComes = coin();
      if (coin()) out.view.camera = camera();
      if (coin()) out.view.size = glm::ivec2(integer(1, 4000), integer(1, 4000));
    }
    for (int i = 0, n = integer(0, 3); i < n; ++i) out.operators.push_back(vis());
    return out;
  }

  std::mt19937_64 engine_;
  int views_ = 0;
};

}  // namespace gxy
