// SPDX-License-Identifier: Apache-2.0
#include "tests/random/random_data.h"

#include "tests/agreement/scenes.h"

#include <cstring>
#include <functional>
#include <limits>
#include <numbers>

namespace gxy::test {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

std::function<double(glm::dvec3)> randomField(Choices& choose) {
  const glm::dvec3 a = choose.point(-3, 3), b = choose.point(-4, 4), centre = choose.point(-0.5, 0.5);
  const double phase = choose.in(0, 6);
  auto wave = [=](glm::dvec3 p) {
    return 0.5 + 0.28 * std::sin(glm::dot(a, p) + phase) + 0.22 * std::sin(glm::dot(b, p));
  };
  switch (choose.below(8)) {
    case 0:
      return [=](glm::dvec3 p) { return 0.6 * glm::length(p - centre); };
    case 1:
      return [=](glm::dvec3 p) { return 0.5 + 0.1 * glm::dot(a, p); };
    case 2:
      return [=](glm::dvec3) { return 0.4; };
    case 3:
      return [=](glm::dvec3 p) { return std::round(5 * wave(p)) / 5; };
    case 4:
      return [=](glm::dvec3 p) { return std::exp(-4 * glm::dot(p - centre, p - centre)); };
    case 5: {  // noise
      const uint64_t salt = choose.seed();
      return [=](glm::dvec3 p) {
        Choices at(salt ^ uint64_t(std::llround(p.x * 1e4) * 73856093) ^
                   uint64_t(std::llround(p.y * 1e4) * 19349663) ^
                   uint64_t(std::llround(p.z * 1e4) * 83492791));
        return at.unit();
      };
    }
    default:
      return wave;
  }
}

namespace {

Grid randomGrid(Choices& choose) {
  Grid grid;
  for (int a = 0; a < 3; a++)
    grid.points[size_t(a)] = choose.oneIn(5) ? choose.from(2, 3) : choose.from(2, 18);
  if (choose.oneIn(12)) grid.points[size_t(choose.below(3))] = 60;
  const double half = choose.oneIn(3) ? choose.in(0.3, 0.8) : 1;
  glm::dvec3 size(half);
  if (choose.oneIn(3)) size *= choose.point(0.2, 1);
  if (choose.oneIn(15)) size[choose.below(3)] *= 1e-4;
  const glm::dvec3 centre = choose.oneIn(3) ? choose.point(-0.4, 0.4) : glm::dvec3(0);
  grid.origin = centre - size;
  for (int a = 0; a < 3; a++) grid.spacing[a] = 2 * size[a] / double(grid.points[size_t(a)] - 1);
  return grid;
}

template <class T>
Samples bytesOf(const std::vector<double>& values) {
  Samples out(values.size() * sizeof(T));
  for (size_t i = 0; i < values.size(); i++) {
    const T x = T(std::is_integral_v<T> ? std::round(values[i]) : values[i]);
    std::memcpy(out.data() + i * sizeof(T), &x, sizeof(T));
  }
  return out;
}

}  // namespace

RandomVolume randomVolume(Choices& choose) {
  RandomVolume made;
  WholeVolume& v = made.volume;
  v.grid = randomGrid(choose);
  const auto type = choose.oneIn(2) ? ScalarType::Float32 : ScalarType(choose.below(10));
  v.components = choose.oneIn(6) ? choose.from(2, 4) : 1;

  const bool real = type == ScalarType::Float32 || type == ScalarType::Float64;
  double most = 0;  // of integers
  withType(type, [&](auto t) { most = double(std::numeric_limits<decltype(t)>::max()); });
  const bool isSigned = withType(type, [](auto t) { return std::numeric_limits<decltype(t)>::is_signed; });
  double lo = 0, hi = 1;
  if (real) {
    const double span = choose.oneIn(3) ? choose.scale(1e-15, 1e15) : 1;
    // an import shifts values to their range unless a magnitude is to be had
    const double farthest = type == ScalarType::Float64 && v.components == 1 ? 1e9 : 30;
    lo = choose.oneIn(3) ? span * choose.in(-farthest, farthest) : 0;
    hi = lo + span;
  } else {
    const double top = std::min(most, bytesOf(type) > 2 ? choose.scale(100, most) : most) * 0.9;
    lo = isSigned ? -top * choose.unit() : 0;
    hi = std::max(top * choose.in(0.5, 1), lo + 8);
    if (bytesOf(type) > 2 && choose.oneIn(3) && v.components == 1) lo = hi - std::max(hi * 1e-6, 50.0);
  }
  made.lo = lo, made.hi = hi;

  const auto field = randomField(choose);
  std::vector<double> values;
  const glm::dvec3 n(v.grid.points[0] - 1, v.grid.points[1] - 1, v.grid.points[2] - 1);
  const int holes = real && choose.oneIn(4) ? choose.from(1, 3) : 0;  // 1: a ball, 2: scattered, 3: a slab
  const glm::dvec3 hole = choose.point(-0.6, 0.6);
  for (int64_t k = 0; k < v.grid.points[2]; k++)
    for (int64_t j = 0; j < v.grid.points[1]; j++)
      for (int64_t i = 0; i < v.grid.points[0]; i++) {
        const glm::dvec3 p = 2.0 * glm::dvec3(i, j, k) / n - 1.0;
        const bool none = (holes == 1 && glm::length(p - hole) < 0.4) || (holes == 2 && choose.oneIn(40)) ||
                          (holes == 3 && p.x < hole.x);
        for (int c = 0; c < v.components; c++) {
          const double f = field(c % 2 ? glm::dvec3(p.y, p.z, p.x) : p);
          const double value = lo + (hi - lo) * (real ? f : std::clamp(f, 0.0, 1.0));
          values.push_back(!none ? value : choose.oneIn(3) ? std::numeric_limits<double>::infinity() : kNaN);
        }
      }
  const auto samples = withType(type, [&](auto t) { return bytesOf<decltype(t)>(values); });
  Range all;
  for (const Range& r : statisticsOf(samples, type, v.components).ranges) all.extend(r);
  const Encoding encoding = encodingOf(type, v.components, all);
  v.samples = convert(samples, type, encoding);
  v.stored = encoding.stored, v.shift = encoding.shift, v.scale = encoding.scale;
  return made;
}

namespace {

WholeGeometry finished(GeometryKind kind, GeometryBlock block) {
  WholeGeometry g{kind, std::move(block)};
  const size_t count = kind == GeometryKind::Particles   ? g.block.points.size()
                       : kind == GeometryKind::PathLines ? g.block.segments.size()
                                                         : g.block.triangles.size();
  for (size_t i = 0; i < count; i++) g.block.ids.push_back(i);
  dropUnusable(g.block, kind);
  return g;
}

/// Values, or in a quarter neither these nor, in half of that, colours; beside them, in a quarter, those of radii.
void addValues(Choices& choose, GeometryBlock& block) {
  Choices radii = choose;  // what is chosen next does not depend on these
  if (radii.oneIn(4))
    for (size_t i = 0; i < block.points.size(); i++)
      block.radiusValues.push_back(radii.oneIn(16) ? float(kNaN) : float(radii.unit()));
  if (choose.oneIn(4)) {
    Choices colors = choose;  // what is chosen next does not depend on these
    if (colors.oneIn(2)) return;
    for (size_t i = 0; i < block.points.size(); i++) block.colors.push_back(glm::vec3(colors.point(0, 1)));
    return;
  }
  const bool holes = choose.oneIn(5);
  for (size_t i = 0; i < block.points.size(); i++)
    block.values.push_back(holes && choose.oneIn(8) ? float(kNaN) : float(choose.unit()));
}

}  // namespace

WholeGeometry randomParticles(Choices& choose) {
  GeometryBlock block;
  for (int n = choose.from(1, 30); n > 0; n--)
    block.points.push_back(!block.points.empty() && choose.oneIn(10) ? block.points.back()
                                                                     : choose.point(-1, 1));
  addValues(choose, block);
  return finished(GeometryKind::Particles, std::move(block));
}

WholeGeometry randomLines(Choices& choose, bool repeats) {
  GeometryBlock block;
  for (int lines = choose.from(1, 4); lines > 0; lines--) {
    std::vector<glm::dvec3> points{choose.point(-1, 1)};
    for (int n = choose.from(1, 7); n > 0; n--)
      points.push_back(repeats && choose.oneIn(10) ? points.back() : points.back() + choose.point(-0.6, 0.6));
    agreement::addLine(block, points, {});
  }
  addValues(choose, block);
  return finished(GeometryKind::PathLines, std::move(block));
}

WholeGeometry randomMesh(Choices& choose) {
  GeometryBlock block;
  if (choose.oneIn(2)) {
    block = agreement::sphereMesh(choose.from(3, 10), choose.oneIn(2), false);
    const glm::dvec3 centre = choose.point(-0.5, 0.5), size = choose.point(0.2, 0.7);
    for (glm::dvec3& p : block.points) p = centre + size * p;
  } else {
    for (int n = choose.from(1, 25); n > 0; n--) {
      const auto first = uint32_t(block.points.size());
      const glm::dvec3 at = choose.point(-1, 1);
      const double size = choose.oneIn(4) ? 1 : 0.4;
      for (int k = 0; k < 3; k++) block.points.push_back(at + choose.point(-size, size));
      if (choose.oneIn(12)) block.points.back() = block.points[first];  // degenerate
      block.triangles.push_back({first, first + 1, first + 2});
    }
  }
  addValues(choose, block);
  return finished(GeometryKind::Triangles, std::move(block));
}

}  // namespace gxy::test
