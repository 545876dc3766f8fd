// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/pace.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gxy {

namespace {

/// A quality, and its bytes relative to those of quality 70, measured on pictures of volumes and of surfaces.
struct Quality {
  int quality;
  double bytes;
};
constexpr std::array<Quality, 4> kQualities{{{85, 1.5}, {70, 1}, {50, 0.75}, {30, 0.55}}};
constexpr int kWorst = 50;  // Below this quality, a coarser level looks better.
constexpr double kRoom = 0.7;

double bytesOf(int quality) {
  for (const Quality& q : kQualities)
    if (q.quality <= quality) return q.bytes;
  return kQualities.back().bytes;
}

constexpr double kForgotten = 0.005;  // known costs decrease by this fraction with each frame

double smooth(double mean, double value) { return 0.6 * mean + 0.4 * value; }

}  // namespace

size_t Pace::indexOf(uint32_t scale) {
  return size_t(std::find(kScales.begin(), kScales.end(), scale) - kScales.begin());
}

void Pace::resized(double factor) {
  for (std::optional<Cost>& cost : costs_)
    if (cost) cost->seconds *= factor, cost->bytes *= factor;
}

void Pace::take(const Pass& pass) {
  const Cost cost{pass.rendering, double(pass.bytes) / bytesOf(pass.detail.quality)};
  for (std::optional<Cost>& other : costs_)
    if (other) other->seconds *= 1 - kForgotten, other->bytes *= 1 - kForgotten;
  std::optional<Cost>& known = costs_[indexOf(pass.detail.scale)];
  known = known ? Cost{smooth(known->seconds, cost.seconds), smooth(known->bytes, cost.bytes)} : cost;
  if (pass.bytesPerSecond) {
    const double seconds = 1 / *pass.bytesPerSecond;
    secondsPerByte_ = secondsPerByte_ ? smooth(*secondsPerByte_, seconds) : seconds;
  }
}

// Returns the cost of a scale. If it is not known, it is estimated from the nearest known scale: twice the
// scale has a quarter of the pixels, and costs somewhat more than a quarter.
Pace::Cost Pace::expected(size_t index) const {
  std::optional<size_t> from;
  for (size_t i = 0; i < kScales.size(); i++)
    if (costs_[i] &&
        (!from || std::max(i, index) - std::min(i, index) < std::max(*from, index) - std::min(*from, index)))
      from = i;
  if (!from) return {};
  const double factor = std::pow(double(kScales[*from]) / kScales[index], 1.6);
  return {costs_[*from]->seconds * factor, costs_[*from]->bytes * factor};
}

bool Pace::fits(Detail detail) const {
  const Cost cost = expected(indexOf(detail.scale));
  const bool finer = detail.scale < last_.scale;
  const bool larger = finer || (detail.scale == last_.scale && detail.quality > last_.quality);
  return cost.seconds <= (finer ? kRoom : 1) * kFrame &&
         secondsPerByte_.value_or(0) * cost.bytes * bytesOf(detail.quality) <= (larger ? kRoom : 1) * kFrame;
}

Detail Pace::choose() {
  if (std::none_of(costs_.begin(), costs_.end(), [](const auto& cost) { return cost.has_value(); }))
    return last_;
  for (const uint32_t scale : kScales)
    for (const Quality& q : kQualities)
      if ((q.quality >= kWorst || scale == kScales.back()) && fits({scale, q.quality}))
        return last_ = {scale, q.quality};
  return last_ = {kScales.back(), kQualities.back().quality};
}

}  // namespace gxy
