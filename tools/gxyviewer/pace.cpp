// SPDX-License-Identifier: Apache-2.0
#include "pace.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace gxy {

namespace {

/// Qualities, and their bytes over those of quality 70: measured on pictures of volumes and of surfaces.
struct Quality {
  int quality;
  double bytes;
};
constexpr std::array<Quality, 4> kQualities{{{85, 1.5}, {70, 1}, {50, 0.75}, {30, 0.55}}};
constexpr int kWorst = 50;  // below it a coarser level looks better
constexpr double kRoom = 0.6;

double bytesOf(int quality) {
  for (const Quality& q : kQualities)
    if (q.quality <= quality) return q.bytes;
  return kQualities.back().bytes;
}

constexpr double kForgotten = 0.005;  // of what other scales cost, with each frame

double smooth(double mean, double value) { return 0.6 * mean + 0.4 * value; }

}  // namespace

size_t Pace::indexOf(uint32_t scale) { return size_t(std::countr_zero(scale)); }

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

// Half the scale has four times the pixels, and costs somewhat less than four times as much.
Pace::Cost Pace::expected(size_t index) const {
  constexpr double kFiner = 3;
  if (costs_[index]) return *costs_[index];
  for (size_t coarser = index + 1; coarser < kScales; coarser++)
    if (costs_[coarser]) {
      const double factor = std::pow(kFiner, double(coarser - index));
      return {costs_[coarser]->seconds * factor, costs_[coarser]->bytes * factor};
    }
  for (size_t finer = index; finer-- > 0;)
    if (costs_[finer]) {
      const double factor = std::pow(kFiner, double(index - finer));
      return {costs_[finer]->seconds / factor, costs_[finer]->bytes / factor};
    }
  return {};
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
  for (uint32_t scale = 1; scale <= kCoarsest; scale *= 2)
    for (const Quality& q : kQualities) {
      const Detail detail{scale, q.quality};
      if ((q.quality >= kWorst || scale == kCoarsest) && fits(detail)) return last_ = detail;
    }
  return last_ = {kCoarsest, kQualities.back().quality};
}

}  // namespace gxy
