// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <limits>
#include <map>
#include <optional>

#include "core/comm/error.h"
#include "core/rays/flow_views.h"

namespace gxy {

// What counts for kCellsPerCall.
static int64_t spent(const AdvanceCounters& c) { return int64_t(c.cells) + int64_t(c.steps) / kStepsPerCell; }

AdvanceCounters& AdvanceCounters::operator+=(const AdvanceCounters& o) {
  headsAdvanced += o.headsAdvanced;
  cells += o.cells;
  steps += o.steps;
  nsAdvance += o.nsAdvance;
  return *this;
}

namespace single {
namespace {

real sampleOf(const FlowView& v, real stored, real scale, real shift) {
  return (v.flush != 0 ? flushSmall(stored) : stored) * scale + shift;
}

CellVectors vectorsOf(const FlowView& v, const FlowPart& part, ivec3 cell, real sign) {
  const CellValues x = cellValues(part.vectors[0], cell);
  const CellValues y = cellValues(part.vectors[1], cell);
  const CellValues z = cellValues(part.vectors[2], cell);
  const vec3 scale = make_v3(v.scaleX, v.scaleY, v.scaleZ) * sign;
  const vec3 shift = make_v3(v.shiftX, v.shiftY, v.shiftZ) * sign;
  const auto at = [&](real a, real b, real c) {
    return make_v3(sampleOf(v, a, scale.x, shift.x), sampleOf(v, b, scale.y, shift.y),
                   sampleOf(v, c, scale.z, shift.z));
  };
  return {at(x.v000, y.v000, z.v000), at(x.v100, y.v100, z.v100), at(x.v010, y.v010, z.v010),
          at(x.v110, y.v110, z.v110), at(x.v001, y.v001, z.v001), at(x.v101, y.v101, z.v101),
          at(x.v011, y.v011, z.v011), at(x.v111, y.v111, z.v111)};
}

// One head on its way through a block.
class Walk {
 public:
  Walk(const FlowView& view, const FlowPart& part, std::optional<int> condition, const HeadView& heads, int i,
       std::vector<std::array<float, 13>>& points, AdvanceCounters& counters)
      : v_(view), part_(part), condition_(condition), h_(heads), i_(i), points_(points), counters_(counters) {
    cell_ = {h_.cellX[i], h_.cellY[i], h_.cellZ[i]};
    f_ = {h_.fx[i], h_.fy[i], h_.fz[i]};
    sign_ = h_.info[i] & HEAD_BACKWARD ? -1.0f : 1.0f;
    time_ = h_.time[i], timeRest_ = h_.timeRest[i];
    length_ = h_.length[i], lengthRest_ = h_.lengthRest[i];
    stalled_ = h_.stalled[i], way_ = h_.way[i];
  }
  ~Walk() {
    h_.cellX[i_] = cell_.x, h_.cellY[i_] = cell_.y, h_.cellZ[i_] = cell_.z;
    h_.fx[i_] = f_.x, h_.fy[i_] = f_.y, h_.fz[i_] = f_.z;
    h_.time[i_] = time_, h_.timeRest[i_] = timeRest_;
    h_.length[i_] = length_, h_.lengthRest[i_] = lengthRest_;
    h_.stalled[i_] = stalled_, h_.way[i_] = way_;
    h_.reason[i_] = reason_;
  }
  Walk(const Walk&) = delete;
  Walk& operator=(const Walk&) = delete;

  // Goes through cells until the head ends or leaves, or has been in `most` more.
  void run(int64_t most) {
    for (const int64_t until = spent(counters_) + most;
         reason_ == LINE_GOES_ON && (mustGoOn() || spent(counters_) < until);)
      goThroughCell();
    const bool ended = reason_ != LINE_GOES_ON && reason_ != LINE_LEAVES;
    const bool stores = v_.points == POINTS_ENDS ? length_ > 0 : v_.points == POINTS_CELLS && h_.fresh[i_];
    if (ended && stores) storeHere();
  }

 private:
  // What has not been stored yet is not known to who goes on.
  bool mustGoOn() const { return v_.points == POINTS_CELLS && h_.fresh[i_]; }

  void goThroughCell() {
    counters_.cells++;
    const CellVectors c = vectorsOf(v_, part_, cell_, sign_);
    const bool data = holdsVectors(c);
    flow_ = cellFlow(c);
    if (h_.points[i_] == 0) storeHere();
    const vec3 lo = cellLow(v_, cell_), hi = cellHigh(v_, cell_);
    vec3 k = flowOnFaces(c, f_, flowAt(flow_, f_));
    const real derivative = flowDerivative(c);
    real speed = flowSpeed(k, spacing());
    reason_ = data ? endOfPatience(stalled_, way_) : LINE_NO_DATA;
    if (reason_ == LINE_GOES_ON)
      reason_ = limitReached(v_, time_, timeRest_, length_, lengthRest_, h_.steps[i_]);
    if (reason_ == LINE_GOES_ON && meetsCondition()) reason_ = LINE_CONDITION;
    if (reason_ != LINE_GOES_ON) return;
    const int face = faceAtOnce(f_, k, lo, hi);
    if (face >= 0) {
      if (v_.points == POINTS_CELLS && h_.fresh[i_]) storeHere();
      return cross(face);
    }
    if (isSlow(v_, k, speed, derivative)) reason_ = LINE_SLOW;
    real h = 0;
    for (int result = STEP_AGAIN; reason_ == LINE_GOES_ON && result != STEP_FACE && result != STEP_EXIT;) {
      reason_ = limitReached(v_, time_, timeRest_, length_, lengthRest_, h_.steps[i_]);
      if (reason_ == LINE_GOES_ON) reason_ = endOfPatience(stalled_, way_);
      if (reason_ == LINE_GOES_ON) result = step(derivative, lo, hi, k, speed, h);
    }
  }

  int step(real derivative, vec3 lo, vec3 hi, vec3& k, real& speed, real& h) {
    const real time = time_, timeRest = timeRest_, length = length_, lengthRest = lengthRest_;
    StepShape shape;
    real part;
    int face, reason;
    counters_.steps++;
    const int result = tryStep(v_, flow_, derivative, lo, hi, f_, k, speed, h, time_, timeRest_, length_,
                               lengthRest_, stalled_, way_, shape, part, face, reason);
    if (result == STEP_AGAIN) return result;
    h_.fresh[i_] = 1;
    reason_ = reason;
    if (v_.points == POINTS_TIME || v_.points == POINTS_LENGTH)
      storeMultiples(shape, part, lo, hi, time, timeRest, length, lengthRest);
    if (reason_ == LINE_GOES_ON && h_.points[i_] >= MOST_POINTS) reason_ = LINE_STUCK;
    if (reason_ == LINE_GOES_ON && meetsCondition()) reason_ = LINE_CONDITION;
    if (reason_ == LINE_GOES_ON && result == STEP_INSIDE && isSlow(v_, k, speed, derivative))
      reason_ = LINE_SLOW;
    if (reason_ == LINE_GOES_ON && result == STEP_EXIT) {
      if (v_.points == POINTS_CELLS) storeHere();
      cross(face);
    }
    return result;
  }

  void cross(int face) {
    const int crossings = (stalled_ & (TRIAL - 1)) + 1;
    stalled_ = crossings;
    reason_ = crossFace(v_, face, cell_, f_);
    h_.steps[i_]++;
  }

  bool meetsCondition() const {
    if (!condition_) return false;
    const CellValues c = cellValues(part_.recorded[size_t(*condition_)], cell_);
    const real x = trilinear(c, f_);
    return holdsData(c) && x >= v_.conditionLow && x <= v_.conditionHigh;
  }

  void storeMultiples(const StepShape& s, real part, vec3 lo, vec3 hi, real time, real timeRest, real length,
                      real lengthRest) {
    const bool byTime = v_.points == POINTS_TIME;
    const int n = byTime ? multiplesUntil(v_, h_.points[i_], time_, timeRest_)
                         : multiplesUntil(v_, h_.points[i_], length_, lengthRest_);
    for (int k = 0; k < n; k++) {
      const int number = h_.points[i_];
      const real u = byTime ? partAtTime(v_, s, part, number, time, timeRest)
                            : partAtLength(v_, s, part, number, length, lengthRest);
      const vec3 p = stepPoint(s, u);
      const vec3 g = make_v3(intoCell(p.x, lo.x, hi.x), intoCell(p.y, lo.y, hi.y), intoCell(p.z, lo.z, hi.z));
      real t = time, tRest = timeRest, l = length, lRest = lengthRest;
      addToPair(t, tRest, s.h * u);
      addToPair(l, lRest, stepLength(s, u));
      store(cell_, g, t, tRest, l, lRest, flowSpeed(flowAt(flow_, g), spacing()));
    }
  }

  void storeHere() {
    store(cell_, f_, time_, timeRest_, length_, lengthRest_, flowSpeed(flowAt(flow_, f_), spacing()));
    h_.fresh[i_] = 0;
  }

  void store(ivec3 cell, vec3 f, real time, real timeRest, real length, real lengthRest, real speed) {
    const auto bits = [](int x) { return std::bit_cast<float>(x); };
    // NaN always has the same bits.
    if (!(speed - speed == 0)) speed = std::numeric_limits<float>::quiet_NaN();
    points_.push_back({bits(i_), bits(h_.points[i_]), bits(cell.x), bits(cell.y), bits(cell.z), f.x, f.y, f.z,
                       time, timeRest, length, lengthRest, speed});
    h_.points[i_]++;
  }

  vec3 spacing() const { return make_v3(v_.spacingX, v_.spacingY, v_.spacingZ); }

  const FlowView& v_;
  const FlowPart& part_;
  const std::optional<int> condition_;
  const HeadView& h_;
  const int i_;
  std::vector<std::array<float, 13>>& points_;
  AdvanceCounters& counters_;
  ivec3 cell_;
  vec3 f_;
  real sign_, time_, timeRest_, length_, lengthRest_, way_;
  int stalled_, reason_ = LINE_GOES_ON;
  CellFlow flow_{};
};

}  // namespace
}  // namespace single

namespace {

class PlainFields final : public DeviceFields {
 public:
  PlainFields(std::shared_ptr<const CompiledFields> fields, int rank)
      : fields_(std::move(fields)), parts_(flowPartsOf(*fields_, rank)) {}

  void advance(int partition, HeadList heads, const TraceOptions& options, Done done) const override {
    const FlowPart& part = partIn(parts_, partition);
    const auto start = std::chrono::steady_clock::now();
    AdvanceResult result;
    result.counters.headsAdvanced = uint64_t(heads.size());
    const single::FlowView view = flowViewOf(*fields_, *part.extent, options);
    const std::optional<int> condition =
        options.condition ? std::optional(options.condition->field) : std::nullopt;
    std::vector<std::array<float, 13>> points;
    for (int i = 0; i < heads.size(); i++) {
      const int64_t left = kCellsPerCall - spent(result.counters);
      single::Walk(view, part, condition, heads.view(), i, points, result.counters)
          .run(std::max<int64_t>(left, 0));
    }
    addPoints(part, options, heads, points, result.points);
    finishHeads(*fields_, options, std::move(heads), result);
    result.counters.nsAdvance =
        uint64_t(std::chrono::nanoseconds(std::chrono::steady_clock::now() - start).count());
    done(std::move(result));
  }

  size_t bytes() const override { return bytesOf(parts_); }

 private:
  void addPoints(const FlowPart& part, const TraceOptions& options, const HeadList& heads,
                 const std::vector<std::array<float, 13>>& points, PathPoints& out) const {
    const StoredPoints stored(points.size());
    const StoredView& s = stored.view();
    for (size_t i = 0; i < points.size(); i++) {
      const float* x = points[i].data();
#define GXY_TAKE(type, name) s.name[i] = std::bit_cast<type>(*x++);
      GXY_STORED_FIELDS(GXY_TAKE)
#undef GXY_TAKE
    }
    const RecordValues record = [&](size_t k, const StoredView& p, size_t count, float* values) {
      const Volume& volume = *fields_->volumes()[size_t(fields_->recorded()[k].volume)];
      for (size_t i = 0; i < count; i++) {
        const single::CellValues c = cellValues(part.recorded[k], {p.cellX[i], p.cellY[i], p.cellZ[i]});
        const double x = double(single::trilinear(c, {p.fx[i], p.fy[i], p.fz[i]}));
        values[i] =
            holdsData(c) ? float(volume.shift + volume.scale * x) : std::numeric_limits<float>::quiet_NaN();
      }
    };
    appendPoints(*fields_, options, heads, s, points.size(), record, out);
  }

  std::shared_ptr<const CompiledFields> fields_;
  FlowParts parts_;
};

}  // namespace

std::unique_ptr<DeviceFields> makePlainFields(std::shared_ptr<const CompiledFields> fields, int rank) {
  return std::make_unique<PlainFields>(std::move(fields), rank);
}

}  // namespace gxy
