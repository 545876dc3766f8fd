// SPDX-License-Identifier: Apache-2.0
#include "core/data/point_averages.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>

#include "core/comm/parallel_for.h"
#include "core/data/cells_around.h"

namespace gxy {

namespace {

/// A symmetric matrix of three rows, of which the lower half counts.
using Symmetric = std::array<std::array<double, 3>, 3>;

struct PrincipalAxes {
  std::array<glm::dvec3, 3> axis;
  std::array<double, 3> variance;
};

/// By Jacobi's method: turns one pair of axes after the other until what is beside the diagonal counts for nothing.
PrincipalAxes principalAxes(Symmetric m) {
  std::array<glm::dvec3, 3> axis{glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)};
  constexpr int kMostSweeps = 12;
  for (int sweep = 0; sweep < kMostSweeps; sweep++) {
    bool turned = false;
    for (size_t q = 1; q < 3; q++)
      for (size_t p = 0; p < q; p++) {
        const double beside = m[q][p], scale = std::sqrt(std::abs(m[p][p] * m[q][q]));
        if (beside == 0 || std::abs(beside) <= 1e-16 * scale) continue;
        turned = true;
        const double theta = (m[q][q] - m[p][p]) / (2 * beside);
        const double t = (theta < 0 ? -1 : 1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        const size_t r = 3 - p - q;
        const auto at = [&](size_t i, size_t k) -> double& { return i > k ? m[i][k] : m[k][i]; };
        const double rp = at(r, p), rq = at(r, q);
        m[p][p] -= t * beside;
        m[q][q] += t * beside;
        m[q][p] = 0;
        at(r, p) = c * rp - s * rq;
        at(r, q) = s * rp + c * rq;
        const glm::dvec3 u = axis[p], v = axis[q];
        axis[p] = c * u - s * v;
        axis[q] = s * u + c * v;
      }
    if (!turned) break;
  }
  return {axis, {m[0][0], m[1][1], m[2][2]}};
}

/// The weights of numbers that stand at `places`, for the value of their best linear function at the origin.
void findWeights(std::span<const glm::dvec3> places, std::vector<double>& weights) {
  const auto count = double(places.size());
  weights.assign(places.size(), 1 / count);
  glm::dvec3 mean(0);
  for (const glm::dvec3& p : places) mean += p;
  mean /= count;
  Symmetric spread{};
  for (const glm::dvec3& p : places)
    for (int i = 0; i < 3; i++)
      for (int k = 0; k <= i; k++) spread[size_t(i)][size_t(k)] += (p[i] - mean[i]) * (p[k] - mean[k]);
  for (auto& row : spread)
    for (double& s : row) s /= count;
  const PrincipalAxes principal = principalAxes(spread);
  const double largest = std::max({principal.variance[0], principal.variance[1], principal.variance[2]});
  for (size_t a = 0; a < 3; a++) {
    const double variance = principal.variance[a], away = -glm::dot(principal.axis[a], mean);
    constexpr double kNoSpread = 1e-12;  // of the largest variance: what rounding leaves
    if (!(variance > kNoSpread * largest) || away * away > (count - 1) * variance) continue;
    const double slope = away / (variance * count);
    for (size_t i = 0; i < places.size(); i++)
      weights[i] += slope * glm::dot(principal.axis[a], places[i] - mean);
  }
}

bool isFiniteCell(std::span<const float> values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

/// The average at one point after the other. One thread at a time may use it.
class PointAverage {
 public:
  PointAverage(std::span<const glm::dvec3> points, const MeshCellsView& cells, std::span<const float> values,
               size_t components)
      : points_(points), cells_(cells), values_(values), components_(components) {}

  void find(size_t point, std::span<const uint32_t> around, float* average) {
    places_.clear();
    used_.clear();
    for (const uint32_t cell : around) {
      if (!isFiniteCell(valuesOf(cell))) continue;
      glm::dvec3 sum(0);
      const auto corners = cells_.pointsOf(cell);
      for (const uint32_t corner : corners) sum += points_[corner] - points_[point];
      places_.push_back(sum / double(corners.size()));
      used_.push_back(cell);
    }
    if (used_.empty()) {
      std::fill_n(average, components_, std::numeric_limits<float>::quiet_NaN());
      return;
    }
    findWeights(places_, weights_);
    for (size_t c = 0; c < components_; c++) average[c] = averageOf(c);
  }

 private:
  std::span<const float> valuesOf(uint32_t cell) const {
    return values_.subspan(cell * components_, components_);
  }

  float averageOf(size_t component) const {
    const auto first = double(valuesOf(used_[0])[component]);
    double sum = 0, low = first, high = first;
    for (size_t i = 0; i < used_.size(); i++) {
      const auto value = double(valuesOf(used_[i])[component]);
      sum += weights_[i] * (value - first);  // weights add up to 1: the average of equal values is exact
      low = std::min(low, value);
      high = std::max(high, value);
    }
    return float(std::clamp(first + sum, low, high));
  }

  const std::span<const glm::dvec3> points_;
  const MeshCellsView& cells_;
  const std::span<const float> values_;
  const size_t components_;
  std::vector<glm::dvec3> places_;
  std::vector<uint32_t> used_;
  std::vector<double> weights_;
};

}  // namespace

std::vector<float> averagesAtPoints(std::span<const glm::dvec3> points, const MeshCellsView& cells,
                                    std::span<const float> values, int components, const Advance& advance) {
  const CellsAround around(cells, points.size());
  const auto each = size_t(components);
  std::vector<float> averages(points.size() * each);
  constexpr size_t kTogether = 1024;
  const size_t runs = (points.size() + kTogether - 1) / kTogether;
  std::atomic<size_t> done = 0;
  parallelFor(size_t(0), runs, [&](size_t run) {
    PointAverage average(points, cells, values, each);
    const size_t end = std::min(points.size(), (run + 1) * kTogether);
    for (size_t p = run * kTogether; p < end; p++) average.find(p, around.of(p), &averages[p * each]);
    advance(double(++done) / double(runs));
  });
  return averages;
}

}  // namespace gxy
