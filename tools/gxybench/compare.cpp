// SPDX-License-Identifier: Apache-2.0
#include "tools/gxybench/compare.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

namespace gxy::bench {
namespace {

constexpr double kScatterOfOne = 0.25;
constexpr double kMoreFlips = 1e-3;  // part of the pixels; more flips are a remark
constexpr double kMostOff = 1e-4;    // cells; smaller distances between a hit and the exact root are ignored
constexpr double kMoreError = 1.5, kLeastError = 1e-6;

struct Point {
  double time, error;
};

double timeOf(const Row& r, const CurveAxes& axes) { return axes.wall ? r.wall : r.cpu; }

/// The settings that no other is better than in both time and error; error falls as time rises.
std::vector<Point> front(const std::vector<Row>& rows, const CurveAxes& axes) {
  std::vector<Point> all, best;
  for (const Row& r : rows)
    if (timeOf(r, axes) > 0 && r.*axes.error > 0) all.push_back({timeOf(r, axes), r.*axes.error});
  std::sort(all.begin(), all.end(), [](Point a, Point b) { return a.time < b.time; });
  for (const Point& p : all)
    if (best.empty() || p.error < best.back().error) best.push_back(p);
  return best;
}

/// The time that the curve needs for an error within its range.
double timeFor(const std::vector<Point>& curve, double error) {
  size_t i = 1;
  while (i + 1 < curve.size() && curve[i].error > error) i++;
  const Point &a = curve[i - 1], &b = curve[i];
  const double f = std::log(error / a.error) / std::log(b.error / a.error);
  return a.time * std::pow(b.time / a.time, f);
}

/// The relative scatter of repeats about their median: root mean square over the settings. A single frame
/// says nothing about that, and is taken to scatter widely.
double scatter(const std::vector<Row>& rows, const CurveAxes& axes) {
  double sum = 0;
  for (const Row& r : rows) {
    const double spread = (axes.wall ? r.wallSpread : r.cpuSpread) / std::max(timeOf(r, axes), 1e-12);
    const double half = r.repeats > 1 ? 0.5 * spread : kScatterOfOne;
    sum += half * half / double(rows.size());
  }
  return std::sqrt(sum);
}

/// Geometric mean, smallest and largest of several ratios.
class Ratios {
 public:
  void add(double r) {
    if (!(r > 0) || !std::isfinite(r)) return;
    least = std::min(least, r), most = std::max(most, r);
    logs_ += std::log(r), count_++;
  }
  double mean() const { return count_ > 0 ? std::exp(logs_ / count_) : 0; }
  double least = INFINITY, most = 0;

 private:
  double logs_ = 0;
  int count_ = 0;
};

Ratios atEqualError(const std::vector<Point>& older, const std::vector<Point>& newer) {
  Ratios ratios;
  if (older.size() < 2 || newer.size() < 2) return ratios;
  const double from = std::max(older.back().error, newer.back().error);
  const double to = std::min(older.front().error, newer.front().error);
  std::set<double> errors;
  for (const auto* curve : {&older, &newer})
    for (const Point& p : *curve)
      if (p.error >= from && p.error <= to) errors.insert(p.error);
  for (double e : errors) ratios.add(timeFor(newer, e) / timeFor(older, e));
  return ratios;
}

void append(std::string& text, const std::string& more) { text += (text.empty() ? "" : "; ") + more; }

/// Adds what has become worse at one setting besides its time.
void addRemarks(const Row& older, const Row& newer, std::string& remark) {
  const int64_t before = older.missed + older.extra + older.wrongSheet;
  const int64_t now = newer.missed + newer.extra + newer.wrongSheet;
  if (newer.hits >= 0 && older.hits >= 0 && now > before)
    append(remark, std::to_string(now - before) + " more wrong hits");
  if (!std::isfinite(newer.maxError) && std::isfinite(older.maxError))
    append(remark, "pixels that are no number at " + newer.setting);
  if (newer.method == "adaptive" && newer.maxError > newer.tolerance && older.maxError <= older.tolerance)
    append(remark, "tolerance " + newer.setting + " no longer held");
  const double pixels = double(newer.width) * newer.height;
  if (double(newer.flips - older.flips) > kMoreFlips * pixels)
    append(remark, std::to_string(newer.flips - older.flips) + " more flips at " + newer.setting);
  if (newer.dtMax > std::max(2 * older.dtMax, kMostOff))
    append(remark, "hits further off at " + newer.setting);
}

Change changeOf(const std::vector<Row>& older, const std::vector<Row>& newer, const CurveAxes& axes) {
  Change change;
  change.scene = newer.front().scene, change.curve = newer.front().curve();
  change.noise = std::max(0.02, std::hypot(scatter(older, axes), scatter(newer, axes)));
  Ratios times = atEqualError(front(older, axes), front(newer, axes)), settings, errors;
  double growth = 0;
  for (const Row& n : newer)
    for (const Row& o : older)
      if (o.setting == n.setting) {
        settings.add(timeOf(n, axes) / timeOf(o, axes));
        errors.add(n.*axes.error / o.*axes.error);
        growth = std::max(growth, n.*axes.error / std::max(o.*axes.error, kLeastError));
        addRemarks(o, n, change.remark);
      }
  change.atSettings = times.mean() == 0;
  if (change.atSettings) times = settings;
  // Without a curve along which time could be traded for error, the error must not grow by itself.
  if (change.atSettings && growth > kMoreError)
    append(change.remark, "error " + std::to_string(growth).substr(0, 5) + " times as large");
  change.ratio = times.mean(), change.least = times.least, change.most = times.most;
  change.errorRatio = errors.mean() > 0 ? errors.mean() : 1;
  return change;
}

bool sameSize(const std::vector<Row>& older, const std::vector<Row>& newer) {
  const Row &o = older.front(), &n = newer.front();
  return o.width == n.width && o.height == n.height;
}

using CurveName = std::pair<std::string, std::string>;

std::map<CurveName, std::vector<Row>> curvesOf(const std::vector<Row>& rows, std::vector<CurveName>& order) {
  std::map<CurveName, std::vector<Row>> curves;
  for (const Row& r : rows) {
    const CurveName name{r.scene, r.curve()};
    if (std::find(order.begin(), order.end(), name) == order.end()) order.push_back(name);
    curves[name].push_back(r);
  }
  return curves;
}

}  // namespace

std::vector<Change> changes(const std::vector<Row>& older, const std::vector<Row>& newer,
                            const CurveAxes& axes) {
  std::vector<CurveName> order;
  const auto newCurves = curvesOf(newer, order), oldCurves = curvesOf(older, order);
  std::vector<Change> all;
  for (const CurveName& name : order) {
    const auto o = oldCurves.find(name), n = newCurves.find(name);
    if (o != oldCurves.end() && n != newCurves.end() && sameSize(o->second, n->second)) {
      all.push_back(changeOf(o->second, n->second, axes));
    } else {
      Change& change = all.emplace_back();
      change.scene = name.first, change.curve = name.second;
      if (n == newCurves.end()) change.remark = "not in the new table";
      if (n != newCurves.end() && o != oldCurves.end()) change.remark = "measured at another size";
    }
  }
  return all;
}

std::string report(const std::vector<Change>& all) {
  std::string out;
  char line[400];
  for (const Change& c : all) {
    std::snprintf(line, sizeof line, "%-32s %-34s ", c.scene.c_str(), c.curve.c_str());
    out += line;
    if (c.ratio == 0) {
      out += c.remark.empty() ? "not in the old table" : c.remark;
    } else {
      std::snprintf(line, sizeof line, "time x %.3f (%.3f to %.3f%s), noise %.1f %%: %s; error x %.3g",
                    c.ratio, c.least, c.most, c.atSettings ? ", at equal settings" : "", 100 * c.noise,
                    c.slower()   ? "SLOWER"
                    : c.faster() ? "faster"
                                 : "as before",
                    c.errorRatio);
      out += line;
      if (!c.remark.empty()) out += "; WORSE: " + c.remark;
    }
    out += '\n';
  }
  return out;
}

}  // namespace gxy::bench
