// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tools/gxybench/scenes.h"

namespace gxy::bench {

std::string fractionText(double x) {
  const double inverse = 1 / x;
  char text[32];
  if (x < 1 && std::abs(inverse - std::round(inverse)) < 1e-9 * inverse)
    std::snprintf(text, sizeof text, "1/%.0f", std::round(inverse));
  else
    std::snprintf(text, sizeof text, "%g", x);
  return text;
}

bool Scene::rendersVolumes() const {
  const auto& operators = state.visualizations.at(0).operators;
  return std::any_of(operators.begin(), operators.end(), [](const Vis& v) { return v.volumeRendering; });
}

bool Scene::hasExtinctionMaps() const {
  const auto& operators = state.visualizations.at(0).operators;
  return std::any_of(operators.begin(), operators.end(),
                     [](const Vis& v) { return v.volumeRendering && v.opacitymap.extinction; });
}

bool Scene::isosurfacesAlone() const {
  const auto& operators = state.visualizations.at(0).operators;
  return std::all_of(operators.begin(), operators.end(), [](const Vis& v) {
    return v.type == VisType::Volume && !v.volumeRendering && v.slices.empty() && !v.isovalues.empty();
  });
}

std::vector<Setting> settingsOf(const Scene& scene, const Ladders& ladders) {
  const auto wanted = [&](const char* method) {
    return std::find(ladders.methods.begin(), ladders.methods.end(), method) != ladders.methods.end();
  };
  State state = scene.state;
  state.settings.step = 0;
  if (!scene.rendersVolumes()) return {{"adaptive", fractionText(state.settings.tolerance), state}};

  std::vector<Setting> settings;
  const auto descending = [](std::vector<double> values) {
    std::sort(values.begin(), values.end(), std::greater<>());
    return values;
  };
  if (wanted("adaptive"))
    for (double tolerance : descending(ladders.tolerances)) {
      settings.push_back({"adaptive", fractionText(tolerance), state});
      settings.back().state.settings.tolerance = tolerance;
    }
  if (wanted("fixed"))
    for (double step : descending(ladders.steps)) {
      settings.push_back({"fixed", fractionText(step), state});
      settings.back().state.settings.step = step;
    }
  if (wanted("uncorrected") && !scene.hasExtinctionMaps()) {
    state.settings.step = 1;
    for (Vis& vis : state.visualizations[0].operators) vis.referenceLength.reset();
    settings.push_back({"uncorrected", "1", state});
  }
  return settings;
}

}  // namespace gxy::bench
