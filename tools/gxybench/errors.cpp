// SPDX-License-Identifier: Apache-2.0
#include "tools/gxybench/errors.h"

#include <algorithm>
#include <cmath>

#include "core/comm/error.h"

namespace gxy::bench {
namespace {

constexpr double kMiss = 1e30;

/// Compares a picture with the truth, pixel by pixel.
class Comparison {
 public:
  Comparison(const Truth& truth, const Picture& picture, double tolerance)
      : truth_(truth), picture_(picture), tolerance_(tolerance) {}

  double difference(size_t p) const {
    double worst = 0;
    for (size_t c = 0; c < 3; c++) {
      const double d = std::abs(double(picture_.rgba[4 * p + c]) - truth_.rgb[3 * p + c]);
      worst = std::isnan(d) ? INFINITY : std::max(worst, d);
    }
    return worst;
  }

  bool isFlip(size_t p) const {
    if (truth_.low.empty()) return false;
    bool changes = false, among = true;
    for (size_t c = 0; c < 3; c++) {
      const double low = truth_.low[3 * p + c], high = truth_.high[3 * p + c], x = picture_.rgba[4 * p + c];
      changes = changes || high - low > 0.5 * tolerance_;
      among = among && x >= low - tolerance_ && x <= high + tolerance_;
    }
    return changes && among;
  }

  bool isDepthFlip(size_t p) const {
    const double slack = 0.5 * truth_.cell, t = picture_.depth[p];
    return truth_.farthest[p] - truth_.nearest[p] > slack && t >= truth_.nearest[p] - slack &&
           t <= truth_.farthest[p] + slack;
  }

 private:
  const Truth& truth_;
  const Picture& picture_;
  double tolerance_;
};

/// Distances of hits from the true ones, in cells, where they are on the same sheet.
struct Distances {
  double squares = 0;
  int64_t count = 0;
};

/// Compares the hit of pixel p. Returns true if the difference is a flip.
bool compareHit(const Truth& truth, const Picture& picture, const Comparison& comparison, size_t p, Row& row,
                Distances& distances) {
  const bool mine = picture.depth[p] < kMiss, theirs = truth.depth[p] < kMiss;
  if (!mine && !theirs) return false;
  row.hits += theirs;
  const double dt = mine && theirs ? std::abs(picture.depth[p] - truth.depth[p]) / truth.cell : INFINITY;
  if (dt <= 0.5) {
    distances.squares += dt * dt;
    distances.count++;
    row.dtMax = std::max(row.dtMax, dt);
    return false;
  }
  if (comparison.isDepthFlip(p)) return true;
  (!mine ? row.missed : !theirs ? row.extra : row.wrongSheet)++;
  return false;
}

}  // namespace

void compareWith(const Truth& truth, const Picture& picture, bool isosurfacesAlone, Row& row) {
  if (picture.width != truth.width || picture.height != truth.height)
    throw Error("the picture is " + std::to_string(picture.width) + " x " + std::to_string(picture.height) +
                " pixels, its reference " + std::to_string(truth.width) + " x " +
                std::to_string(truth.height));
  const Comparison comparison(truth, picture, row.tolerance);
  const size_t pixels = truth.depth.size();
  double squares = 0;
  Distances distances;
  row.flips = 0;
  row.hits = isosurfacesAlone ? 0 : -1;
  row.missed = row.extra = row.wrongSheet = 0;
  row.dtMax = 0;
  std::vector<double> worst;
  for (size_t p = 0; p < pixels; p++) {
    const bool depthFlip = isosurfacesAlone && compareHit(truth, picture, comparison, p, row, distances);
    const double d = comparison.difference(p);
    if (depthFlip || (d > row.tolerance && comparison.isFlip(p))) {
      row.flips++;
      continue;
    }
    worst.push_back(d);
    for (size_t c = 0; c < 3; c++) {
      const double e = double(picture.rgba[4 * p + c]) - truth.rgb[3 * p + c];
      squares += e * e;
    }
  }
  const double counted = double(std::max<size_t>(worst.size(), 1));
  row.rmsError = std::sqrt(squares / (3 * counted));
  std::sort(worst.begin(), worst.end());
  row.maxError = worst.empty() ? 0 : worst.back();
  row.p999Error = worst.empty() ? 0 : worst[size_t(std::ceil(0.999 * counted)) - 1];
  row.dtRms = std::sqrt(distances.squares / double(std::max<int64_t>(distances.count, 1)));
}

}  // namespace gxy::bench
