// SPDX-License-Identifier: Apache-2.0
// Maps for tests: smooth, spiky, stepped, nearly opaque, nearly transparent.
#pragma once
#include <algorithm>

#include "tests/rays/field.h"

namespace gxy::test {

struct Maps {
  ColorMap color;
  OpacityMap opacity;
};

enum class MapShape { Smooth, Spiky, Stepped, NearlyOpaque, NearlyTransparent };
inline constexpr MapShape kMapShapes[] = {MapShape::Smooth, MapShape::Spiky, MapShape::Stepped,
                                          MapShape::NearlyOpaque, MapShape::NearlyTransparent};

inline const char* nameOf(MapShape s) {
  constexpr const char* names[] = {"smooth", "spiky", "stepped", "nearly opaque", "nearly transparent"};
  return names[int(s)];
}

inline ColorMap randomColors(Random& random, int points) {
  ColorMap map;
  for (int i = 0; i < points; i++)
    map.points.push_back({double(i) / std::max(1, points - 1), random.point(0, 1)});
  return map;
}

/// A random map of that shape over values [0, 1].
inline Maps randomMaps(Random& random, MapShape shape) {
  Maps m;
  m.color = randomColors(random, 2 + random.below(5));
  auto& p = m.opacity.points;
  if (shape == MapShape::Smooth || shape == MapShape::NearlyTransparent) {
    const double most = shape == MapShape::Smooth ? 0.2 : 0.002;
    p.push_back({0, 0});
    for (double v : {0.3, 0.6, 1.0}) p.push_back({v, random.in(0, most)});
  } else if (shape == MapShape::Spiky) {
    p.push_back({0, 0});
    for (double v : {random.in(0.15, 0.4), random.in(0.5, 0.85)}) {
      const double w = random.in(0.01, 0.04);
      p.push_back({v - w, 0});
      p.push_back({v, random.in(0.1, 0.6)});
      p.push_back({v + w, 0});
    }
    p.push_back({1, 0});
  } else if (shape == MapShape::Stepped) {
    p.push_back({0, 0});
    for (double v : {random.in(0.2, 0.45), random.in(0.5, 0.8)}) {
      p.push_back({v, p.back().opacity});
      p.push_back({v, random.in(0, 0.3)});
    }
    p.push_back({1, p.back().opacity});
  } else {
    p = {{0, 0}, {random.in(0.3, 0.5), random.in(0, 0.05)}, {random.in(0.6, 0.9), 1}, {1, 1}};
  }
  return m;
}

/// Maps compiled for a field whose stored values are true values; opacity speaks of the shortest cell.
inline CompiledMap compiled(const Maps& m, const Field& f) {
  return CompiledMap(m.color, &m.opacity, MapUnits{0, 1, 1, f.shortestCell()});
}

inline constexpr Integrator kIntegrators[] = {Integrator::Midpoint, Integrator::ByCells};

/// The same plan in every macrocell: 0 or planOf().
inline std::vector<int32_t> evenPlan(const Field& f, int32_t plan) {
  return std::vector<int32_t>(f.macrocells().size(), plan);
}

}  // namespace gxy::test
