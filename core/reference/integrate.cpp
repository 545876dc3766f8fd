// SPDX-License-Identifier: Apache-2.0
#include "core/reference/integrate.h"

#include <cmath>
#include <glm/common.hpp>

#include "core/reference/cells.h"

namespace gxy::reference {
namespace {

constexpr int kNodes = 5;
constexpr int kDeepest = 48;

/// Gauss-Legendre nodes and weights on [0, 1], and for each node the weights of the integral from 0 to it
/// (the Butcher matrix of the Gauss method; Hairer, Norsett, Wanner, Solving ODEs I, section II.7).
struct GaussRule {
  std::array<double, kNodes> x, weight;
  std::array<std::array<double, kNodes>, kNodes> until;

  GaussRule() {
    const double r = std::sqrt(10.0 / 7), inner = std::sqrt(5 - 2 * r) / 3, outer = std::sqrt(5 + 2 * r) / 3;
    const double wInner = (322 + 13 * std::sqrt(70.0)) / 1800, wOuter = (322 - 13 * std::sqrt(70.0)) / 1800;
    const std::array<double, kNodes> xi{-outer, -inner, 0, inner, outer};
    weight = {wOuter, wInner, 64.0 / 225, wInner, wOuter};
    for (int i = 0; i < kNodes; i++) {
      x[i] = 0.5 * (1 + xi[i]);
      const auto p = legendre(xi[i]);
      for (int j = 0; j < kNodes; j++) {
        const auto q = legendre(xi[j]);
        double sum = x[i];
        for (int k = 1; k < kNodes; k++) sum += q[k] * 0.5 * (p[k + 1] - p[k - 1]);
        until[i][j] = weight[j] * sum;
      }
    }
  }

  static std::array<double, kNodes + 1> legendre(double x) {
    std::array<double, kNodes + 1> p{1, x};
    for (int k = 1; k < kNodes; k++) p[k + 1] = ((2 * k + 1) * x * p[k] - k * p[k - 1]) / (k + 1);
    return p;
  }
};

const GaussRule kGauss;

}  // namespace

VolumeRay::VolumeRay(std::span<const VolumeTerm> terms, const Ray& ray, Interval range)
    : spans_(terms.size()) {
  for (size_t v = 0; v < terms.size(); v++) {
    const Interval visible = range.intersected(terms[v].clip);
    std::visit([&](const auto* field) { addCells(v, terms[v], *field, ray, visible); }, terms[v].field);
  }
  std::sort(breaks_.begin(), breaks_.end());
  breaks_.erase(std::unique(breaks_.begin(), breaks_.end()), breaks_.end());
}

void VolumeRay::addCells(size_t term, const VolumeTerm& how, const Field& field, const Ray& ray,
                         Interval visible) {
  for (CellWalk walk(field.grid(), ray); walk.inside() && walk.entry() < visible.hi; walk.advance()) {
    const Interval cell{walk.entry(), walk.exit()}, seen = visible.intersected(cell);
    const auto corners = seen.lo < seen.hi ? field.corners(walk.cell()) : std::nullopt;
    if (corners)
      addCell(term, how, visible, cell, alongRay(*corners, walk.local(cell.lo), walk.local(cell.hi)));
  }
}

void VolumeRay::addCells(size_t term, const VolumeTerm& how, const MeshField& field, const Ray& ray,
                         Interval visible) {
  for (const MeshSpan& s : field.along(ray, visible)) addCell(term, how, visible, {s.t0, s.t1}, s.value);
}

void VolumeRay::addCell(size_t term, const VolumeTerm& how, Interval visible, Interval cell,
                        const Cubic& cubic) {
  const Interval seen = visible.intersected(cell);
  const double lo = cubic.min(), hi = cubic.max();
  if (!(seen.lo < seen.hi) || how.transfer->transparent(lo, hi)) return;
  spans_[term].push_back({cell.lo, cell.hi, seen, cubic, how.transfer});
  breaks_.insert(breaks_.end(), {seen.lo, seen.hi});
  const auto& points = how.transfer->breaks();
  for (auto p = std::lower_bound(points.begin(), points.end(), lo); p != points.end() && *p <= hi; ++p) {
    for (double s : roots(cubic, *p)) {
      const double t = cell.lo + s * (cell.hi - cell.lo);
      if (seen.contains(t)) breaks_.push_back(t);
    }
  }
}

VolumeRay::Piece VolumeRay::gauss(const Active& active, double a, double b) {
  std::array<double, kNodes> sigma{};
  std::array<glm::dvec3, kNodes> source{};
  for (int i = 0; i < kNodes; i++) {
    const double t = a + kGauss.x[i] * (b - a);
    for (const ActiveSpan& one : active) {
      const double value = one.value(t), extinction = one.maps.extinction(value);
      sigma[i] += extinction;
      if (extinction > 0) source[i] += extinction * one.maps.colour(value);
    }
  }
  Piece piece{0, glm::dvec3(0)};
  for (int i = 0; i < kNodes; i++) piece.optical += kGauss.weight[i] * sigma[i];
  piece.optical *= b - a;
  // The colour of the middle is taken out and integrated in closed form, so that a uniform colour has no
  // error at all.
  const glm::dvec3 middle = sigma[kNodes / 2] > 0 ? source[kNodes / 2] / sigma[kNodes / 2] : glm::dvec3(0);
  for (int i = 0; i < kNodes; i++) {
    double until = 0;
    for (int j = 0; j < kNodes; j++) until += kGauss.until[i][j] * sigma[j];
    piece.colour += kGauss.weight[i] * std::exp(-until * (b - a)) * (source[i] - sigma[i] * middle);
  }
  piece.colour = piece.colour * (b - a) - middle * std::expm1(-piece.optical);
  return piece;
}

void VolumeRay::adapt(const Active& active, double a, double b, const Piece& coarse, int depth,
                      Running& running) {
  const double middle = 0.5 * (a + b), before = running.total.transmittance;
  const Piece left = gauss(active, a, middle), right = gauss(active, middle, b);
  const double through = std::exp(-left.optical), optical = left.optical + right.optical;
  const glm::dvec3 colour = left.colour + through * right.colour;
  const glm::dvec3 off = glm::abs(colour - coarse.colour);
  const double error =
      std::max({off.x, off.y, off.z, std::abs(std::exp(-optical) - std::exp(-coarse.optical))});
  if (before * error <= running.tolerance || depth == kDeepest || !(middle > a && middle < b)) {
    running.total.colour += before * colour;
    running.total.transmittance = before * std::exp(-optical);
    return;
  }
  adapt(active, a, middle, left, depth + 1, running);
  adapt(active, middle, b, right, depth + 1, running);
}

void VolumeRay::integratePiece(const Active& active, double a, double b, Running& running) {
  glm::dvec3 opaque(0);
  int opaqueTerms = 0;
  for (const ActiveSpan& one : active) {
    if (!one.maps.opaque()) continue;
    opaque += one.maps.colour(one.value(a));
    opaqueTerms++;
  }
  if (opaqueTerms == 0) return adapt(active, a, b, gauss(active, a, b), 0, running);
  running.total.colour += running.total.transmittance * opaque / double(opaqueTerms);
  running.total.transmittance = 0;
}

RayIntegral VolumeRay::integrate(Interval stretch, double tolerance) const {
  // Each piece gets a thousandth of the tolerance, since thousands of pieces may add their errors. The
  // estimate is that of the coarser of two results, and the finer one is used.
  Running running{{}, tolerance * 1e-3};
  std::vector<size_t> next(spans_.size(), 0);
  Active active;
  double a = stretch.lo;
  for (auto it = std::upper_bound(breaks_.begin(), breaks_.end(), a); running.total.transmittance > 0; ++it) {
    if (it == breaks_.end() || a >= stretch.hi) break;
    const double b = std::min(*it, stretch.hi);
    active.clear();
    for (size_t v = 0; v < spans_.size(); v++) {
      while (next[v] < spans_[v].size() && spans_[v][next[v]].seen.hi <= a) next[v]++;
      if (next[v] == spans_[v].size() || spans_[v][next[v]].seen.lo > a) continue;
      ActiveSpan one{&spans_[v][next[v]], {}};
      one.maps = one.span->transfer->around(one.value(0.5 * (a + b)));
      active.push_back(one);
    }
    if (!active.empty() && a < b) integratePiece(active, a, b, running);
    a = b;
  }
  return running.total;
}

RayIntegral integrateRay(std::span<const VolumeTerm> terms, const Ray& ray, Interval stretch,
                         double tolerance) {
  return VolumeRay(terms, ray, stretch).integrate(stretch, tolerance);
}

}  // namespace gxy::reference
