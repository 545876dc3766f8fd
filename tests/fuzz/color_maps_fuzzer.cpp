// SPDX-License-Identifier: Apache-2.0
// A document taken as a ParaView preset and as each of an operator's maps: whatever the bytes, an Error, or maps
// that ascend, stay in their bounds, and can be evaluated and compiled.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>

#include "core/comm/error.h"
#include "core/rays/compiled_map.h"
#include "core/scene/colormaps.h"
#include "core/scene/state_file.h"

namespace {

using namespace gxy;

template <class Parse>
void errorOrNothing(Parse parse) {
  try {
    parse();
  } catch (const Error&) {
  }
}

bool unit(double x) { return x >= 0 && x <= 1; }
bool fits(const ColorPoint& p) { return unit(p.rgb.r) && unit(p.rgb.g) && unit(p.rgb.b); }
bool fits(const OpacityPoint& p) { return p.opacity >= 0 && std::isfinite(p.opacity); }

template <class Map>
void look(const Map& map) {
  if (map.points.empty()) std::abort();
  double before = -std::numeric_limits<double>::infinity();
  for (const auto& p : map.points) {
    if (!std::isfinite(p.value) || p.value < before || !fits(p)) std::abort();
    before = p.value;
    evaluate(map, p.value);
    evaluate(map, std::nextafter(p.value, before));
  }
  evaluate(map, std::numeric_limits<double>::quiet_NaN());
  evaluate(rescaled(map, {0.25, 0.75}), 0.5);
}

void compile(const ColorMap& colors, const OpacityMap* opacities) {
  for (const MapUnits& units : {MapUnits{}, MapUnits{-3, 0.01, 2.5, 0.125}})
    errorOrNothing([&] {
      const CompiledMap map(colors, opacities, units);
      const CompiledMap::Over over = map.over(0.25f, 0.75f);
      if (!(over.extinction >= 0)) std::abort();
    });
}

void look(const Vis& vis) {
  const ColorMap colors = effectiveColorMap(vis);
  const OpacityMap opacities = effectiveOpacityMap(vis);
  look(colors);
  look(opacities);
  compile(colors, &opacities);
  compile(colors, nullptr);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  errorOrNothing([&] {
    const ColorPreset preset = parseColorPreset(parseJson(text, "input"), "input");
    look(preset.colors);
    if (preset.opacities) look(*preset.opacities);
    compile(preset.colors, preset.opacities ? &*preset.opacities : nullptr);
  });
  if (text.find('"') != std::string::npos) return 0;  // the name of a file is not what is asked here
  for (const char* key : {"colormap", "opacitymap", "extinctionmap"})
    errorOrNothing([&] {
      const StateFile file =
          readState(R"({"Visualization": {"operators": [{"type": "Volume", "dataset": "d", )"
                    R"("volume rendering": true, "data range": [-1, 2], ")" +
                        std::string(key) + "\": " + text + "}]}}",
                    "input");
      for (const Visualization& v : file.state.visualizations)
        for (const Vis& vis : v.operators) look(vis);
    });
  return 0;
}
