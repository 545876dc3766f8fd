// SPDX-License-Identifier: Apache-2.0
// Small fields for tests, and the views of them that the kernels read in float and in double.
#pragma once
#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>
#include <vector>

#include "core/data/bricks.h"
#include "core/data/macrocells.h"
#include "core/kernels/single.h"
#include "core/kernels/twin.h"
#include "core/rays/compiled_map.h"
#include "core/rays/iso_mask.h"
#include "core/rays/step_plan.h"
#include "tests/kernels/random.h"
#include "tests/support/every_cell.h"

namespace gxy::test {

/// The kernels' types by their `real`; their functions are found through the arguments.
template <class Real>
struct Kernels {
  using View = single::VolumeView;
  using Map = single::MapView;
  using Ray = single::VolumeRay;
  using Range = single::MarchRange;
  using Count = single::MarchCount;
  using Radiance = single::Radiance;
  using IsoStart = single::IsoStart;
  using IsoHit = single::IsoHit;
};
template <>
struct Kernels<double> {
  using View = twin::VolumeView;
  using Map = twin::MapView;
  using Ray = twin::VolumeRay;
  using Range = twin::MarchRange;
  using Count = twin::MarchCount;
  using Radiance = twin::Radiance;
  using IsoStart = twin::IsoStart;
  using IsoHit = twin::IsoHit;
};

/// Samples of a grid that fills a box around 0 of longest side 1 (render space), whole or the part `extent` of it.
struct Field {
  Grid grid;
  ScalarType stored = ScalarType::Float32;
  int components = 1, component = 0;  ///< component < 0: the magnitude
  VolumeBlock block;

  int summary() const { return components == 1 ? 0 : component >= 0 ? component : components; }
  const std::vector<Macrocell>& macrocells() const { return block.summaries[size_t(summary())]; }
  /// The stored value of component c at a global point.
  double stored1(int64_t i, int64_t j, int64_t k, int c) const;
  /// The scalar at a global point.
  double at(int64_t i, int64_t j, int64_t k) const;
  double longestCell() const { return std::max({grid.spacing.x, grid.spacing.y, grid.spacing.z}); }
  double shortestCell() const { return std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z}); }
};

inline Grid gridOf(Index3 points, glm::dvec3 aspect = glm::dvec3(1)) {
  const glm::dvec3 size = aspect * glm::dvec3(points[0] - 1, points[1] - 1, points[2] - 1);
  const double scale = 1 / std::max({size.x, size.y, size.z});
  return {-0.5 * scale * size, scale * aspect, points};
}

template <class T>
void fill(Field& f, const std::function<double(int64_t, int64_t, int64_t, int)>& value) {
  const Extent& e = f.block.extent;
  f.block.samples.resize(size_t(e.count()) * size_t(f.components) * sizeof(T));
  std::byte* out = f.block.samples.data();
  for (int64_t k = 0; k < e.points[2]; k++)
    for (int64_t j = 0; j < e.points[1]; j++)
      for (int64_t i = 0; i < e.points[0]; i++)
        for (int c = 0; c < f.components; c++, out += sizeof(T)) {
          const T x = T(value(e.first[0] + i, e.first[1] + j, e.first[2] + k, c));
          std::memcpy(out, &x, sizeof x);
        }
}

/// value(i, j, k, component) at the points of the grid, stored as `stored`.
inline Field makeField(const Grid& grid, const std::function<double(int64_t, int64_t, int64_t, int)>& value,
                       ScalarType stored = ScalarType::Float32, int components = 1, int component = 0,
                       Extent extent = {}) {
  Field f;
  f.grid = grid;
  f.stored = stored;
  f.components = components;
  f.component = component;
  f.block.extent = extent.count() > 0 ? extent : Extent{{0, 0, 0}, grid.points};
  if (stored == ScalarType::Float32) fill<float>(f, value);
  if (stored == ScalarType::UInt8) fill<std::uint8_t>(f, value);
  if (stored == ScalarType::Int8) fill<std::int8_t>(f, value);
  if (stored == ScalarType::UInt16) fill<std::uint16_t>(f, value);
  if (stored == ScalarType::Int16) fill<std::int16_t>(f, value);
  completeBlock(f.block, stored, components);
  return f;
}

/// field(p), p in [-1, 1]^3 over the longest side.
inline Field sampled(const Grid& grid, const std::function<double(glm::dvec3)>& field) {
  return makeField(grid, [&](int64_t i, int64_t j, int64_t k, int) {
    return field(2.0 * (grid.origin + grid.spacing * glm::dvec3(i, j, k)));
  });
}
inline Field cube(int64_t n, const std::function<double(glm::dvec3)>& field) {
  return sampled(gridOf({n, n, n}), field);
}

template <class T>
double readSample(const Field& f, int64_t index) {
  T x;
  std::memcpy(&x, f.block.samples.data() + size_t(index) * sizeof(T), sizeof(T));
  return double(x);
}

inline double Field::stored1(int64_t i, int64_t j, int64_t k, int c) const {
  const Extent& e = block.extent;
  const size_t point = Bricks(e.points)(i - e.first[0], j - e.first[1], k - e.first[2]);
  const int64_t index = int64_t(point) * components + c;
  if (stored == ScalarType::Float32) return readSample<float>(*this, index);
  if (stored == ScalarType::UInt8) return readSample<std::uint8_t>(*this, index);
  if (stored == ScalarType::Int8) return readSample<std::int8_t>(*this, index);
  if (stored == ScalarType::UInt16) return readSample<std::uint16_t>(*this, index);
  return readSample<std::int16_t>(*this, index);
}

inline double Field::at(int64_t i, int64_t j, int64_t k) const {
  if (component >= 0) return stored1(i, j, k, component);
  double sum = 0;
  for (int c = 0; c < components; c++) sum += stored1(i, j, k, c) * stored1(i, j, k, c);
  return std::sqrt(sum);
}

/// What a view shows besides the samples.
struct Shown {
  CompiledMap map;
  std::vector<int32_t> plan;  ///< per macrocell of the block
  std::vector<float> isovalues;
  bool wide = false;
  bool isoEverywhere = false;  ///< the isosurface walk skips nothing
};

/// A VolumeView, a MapView and what they point to. Keep the Field alive.
template <class Real>
class View {
 public:
  View(const Field& f, const Shown& s)
      : buckets_(s.map.buckets.begin(), s.map.buckets.end()),
        opaque_(s.map.opaque.begin(), s.map.opaque.end()),
        nodes_(s.map.nodes.begin(), s.map.nodes.end()),
        spans_(s.map.spans.begin(), s.map.spans.end()),
        rows_(s.map.rows.begin(), s.map.rows.end()),
        pieces_(s.map.pieces.begin(), s.map.pieces.end()),
        sums_(s.map.sums.begin(), s.map.sums.end()),

        isovalues_(s.isovalues.begin(), s.isovalues.end()),
        plan_(s.plan),
        isoMask_(isoMask(f.block, f.stored, f.components, f.component, f.macrocells(), s.isovalues)) {
    if (s.isoEverywhere) isoMask_ = everyCell(f.macrocells().size());
    const Extent& e = f.block.extent;
    const Bricks bricks(e.points);
    const Index3 cells = f.grid.cells();
    view_.samples = f.block.samples.data();
    view_.kind = f.stored == ScalarType::Float32  ? SAMPLE_F32
                 : f.stored == ScalarType::UInt8  ? SAMPLE_U8
                 : f.stored == ScalarType::Int8   ? SAMPLE_I8
                 : f.stored == ScalarType::UInt16 ? SAMPLE_U16
                                                  : SAMPLE_I16;
    view_.stride = f.components;
    view_.component = f.component;
    view_.wide = s.wide;
    view_.brickRow = int(bricks.row()), view_.brickLayer = int(bricks.layer());
    view_.firstX = int(e.first[0]), view_.firstY = int(e.first[1]), view_.firstZ = int(e.first[2]);
    view_.lastX = int(e.first[0] + e.points[0] - 1);
    view_.lastY = int(e.first[1] + e.points[1] - 1);
    view_.lastZ = int(e.first[2] + e.points[2] - 1);
    view_.cellsX = int(cells[0]), view_.cellsY = int(cells[1]), view_.cellsZ = int(cells[2]);
    // through float, as a backend gets them
    view_.originX = Real(float(f.grid.origin.x));
    view_.originY = Real(float(f.grid.origin.y));
    view_.originZ = Real(float(f.grid.origin.z));
    view_.inverseX = Real(float(1 / f.grid.spacing.x));
    view_.inverseY = Real(float(1 / f.grid.spacing.y));
    view_.inverseZ = Real(float(1 / f.grid.spacing.z));
    view_.plan = plan_.data();
    view_.byCells = std::any_of(plan_.begin(), plan_.end(), [](int32_t p) { return (p & PLAN_CELLS) != 0; });
    view_.isoMask = isoMask_.data();
    view_.macroX = int(f.block.macrocells[0]), view_.macroY = int(f.block.macrocells[1]);
    view_.macroFirstX = int(f.block.firstMacrocell[0]);
    view_.macroFirstY = int(f.block.firstMacrocell[1]);
    view_.macroFirstZ = int(f.block.firstMacrocell[2]);
    map_.intervals = s.map.intervals();
    map_.uniformIntervals = s.map.uniform;
    map_.buckets = int(s.map.buckets.size());
    map_.nanRed = Real(s.map.nan.r), map_.nanGreen = Real(s.map.nan.g), map_.nanBlue = Real(s.map.nan.b);
    map_.origin = Real(s.map.origin), map_.inverse = Real(s.map.inverse);
    map_.bucket = buckets_.data(), map_.nodes = nodes_.data(), map_.spans = spans_.data();
    map_.rows = rows_.empty() ? nullptr : rows_.data();
    map_.pieces = pieces_.data(), map_.sums = sums_.data();
    map_.opaque = opaque_.data();
    view_.isovalues = int(isovalues_.size());
    view_.isovalue = isovalues_.data();
  }
  View(const View&) = delete;
  View& operator=(const View&) = delete;

  const typename Kernels<Real>::View& operator*() const { return view_; }
  const typename Kernels<Real>::Map& map() const { return map_; }

 private:
  std::vector<int> buckets_, opaque_;
  std::vector<Real> nodes_, spans_, rows_, pieces_, sums_, isovalues_;
  std::vector<int32_t> plan_, isoMask_;
  typename Kernels<Real>::View view_{};
  typename Kernels<Real>::Map map_{};
};

struct RaySpec {
  glm::dvec3 o, d;
};

/// The ray as the kernels see it; o and d are rounded to float first, also in the twin.
template <class Real>
typename Kernels<Real>::Ray rayIn(const View<Real>& view, const RaySpec& r) {
  const glm::vec3 o(r.o), d(r.d);
  return volumeRay(*view, glm::vec<3, Real>(o), glm::vec<3, Real>(d), Real(0), Real(1e30));
}

template <class Real>
struct March {
  typename Kernels<Real>::Radiance L{{0, 0, 0}, 0};
  typename Kernels<Real>::Count count{};
};

/// The march through consecutive intervals that end at `cuts` and at infinity.
template <class Real>
March<Real> march(const View<Real>& view, const typename Kernels<Real>::Ray& ray, Real tMin = 0,
                  const std::vector<Real>& cuts = {}, Real tStop = Real(1e30)) {
  March<Real> m;
  Real from = 0, begun = -1;
  for (size_t i = 0; i <= cuts.size(); i++) {
    const Real to = i < cuts.size() ? cuts[i] : Real(1e30);
    integrateVolume(view.map(), *view, ray, {from, to, to, Real(-1), to > tStop ? tStop : Real(1e30), tMin},
                    begun, m.L, m.count);
    from = to;
  }
  return m;
}

/// A ray towards the box of the field: from outside or inside, a fifth axis-parallel, a fifth through lattice points.
inline RaySpec randomRay(Random& random, const Field& f) {
  const glm::dvec3 half = -f.grid.origin;
  auto inside = [&] { return half * random.point(-1, 1); };
  auto lattice = [&] {
    glm::dvec3 p;
    for (int a = 0; a < 3; a++) p[a] = random.below(int(f.grid.points[size_t(a)]));
    return f.grid.origin + f.grid.spacing * p;
  };
  RaySpec r;
  const int kind = random.below(10);
  const glm::dvec3 target = kind < 2 ? lattice() : inside();
  if (kind == 2 || kind == 3) {
    r.d = glm::dvec3(0);
    r.d[random.below(3)] = random.below(2) ? 1 : -1;
    const glm::dvec3 through = kind == 2 ? lattice() : target;
    r.o = through - r.d * (random.below(3) ? 1.5 : 0.1);
  } else if (kind == 4) {
    r.o = lattice();
    r.d = random.direction();
  } else {
    r.d = random.direction();
    r.o = kind == 5 ? target : target - 1.5 * r.d;
  }
  return r;
}

/// The test signal of Marschner and Lobb (1994), on [-1, 1]^3.
inline double marschnerLobb(glm::dvec3 p) {
  const double pi = std::numbers::pi, r = std::sqrt(p.x * p.x + p.y * p.y);
  return (1 - std::sin(pi * p.z / 2) + 0.25 * (1 + std::cos(12 * pi * std::cos(pi * r / 2)))) / 2.5;
}

/// Sum of waves over four octaves, about in [0, 1].
inline double turbulence(glm::dvec3 p) {
  double s = 0, a = 0.25, w = 4;
  for (int i = 0; i < 4; i++, a *= 0.6, w *= 2.1) {
    s += a * std::sin(w * p.x + 2 * std::sin(w * p.y + i)) * std::sin(1.3 * w * p.y + std::cos(w * p.z)) *
         std::cos(0.9 * w * p.z + i + w * 0.3 * p.x);
  }
  return 0.5 + s;
}

}  // namespace gxy::test
