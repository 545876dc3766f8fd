// SPDX-License-Identifier: Apache-2.0
#include "core/rays/flow_views.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <string>

#include "core/comm/error.h"
#include "core/data/bricks.h"
#include "core/rays/fill_views.h"

namespace gxy {

namespace {

void setPair(double x, float& high, float& rest) {
  high = float(x);
  rest = std::isfinite(high) ? float(x - double(high)) : 0;
}

TraceLimits gridLimits(const CompiledFields& fields, const TraceOptions& o) {
  const Box box = fields.grid().box();
  return limitsOf(o, glm::length(box.hi - box.lo));
}

int pointsOf(const TraceOptions& o) {
  switch (o.points) {
    case PointsMode::Cells:
      return POINTS_CELLS;
    case PointsMode::EqualTime:
      return o.normalised ? POINTS_LENGTH : POINTS_TIME;
    case PointsMode::EqualLength:
      return POINTS_LENGTH;
    case PointsMode::Ends:
      break;
  }
  return POINTS_ENDS;
}

void setCondition(const CompiledFields& fields, const TraceOptions& o, single::FlowView& v) {
  v.conditionLow = 1, v.conditionHigh = 0;
  if (!o.condition) return;
  const Volume& volume = *fields.volumes()[size_t(fields.recorded()[size_t(o.condition->field)].volume)];
  const double lo = (o.condition->lo - volume.shift) / volume.scale;
  const double hi = (o.condition->hi - volume.shift) / volume.scale;
  v.conditionLow = float(std::min(lo, hi)), v.conditionHigh = float(std::max(lo, hi));
}

// World time and length of a head or a point, with the sign of its direction.
struct Measure {
  const FlowUnits& units;
  bool normalised;
  double length(bool backward, float high, float rest) const {
    return (backward ? -1 : 1) * (double(high) + double(rest)) * units.length;
  }
  double time(bool backward, float high, float rest, double length) const {
    return normalised ? length : (backward ? -1 : 1) * (double(high) + double(rest)) * units.time;
  }
};

}  // namespace

single::FlowView flowViewOf(const CompiledFields& fields, const Extent& block, const TraceOptions& o) {
  single::FlowView v{};
  const FlowUnits& u = fields.units();
  v.scaleX = u.scale[0], v.scaleY = u.scale[1], v.scaleZ = u.scale[2];
  v.shiftX = u.shift[0], v.shiftY = u.shift[1], v.shiftZ = u.shift[2];
  v.spacingX = u.spacing[0], v.spacingY = u.spacing[1], v.spacingZ = u.spacing[2];
  const StepBounds bounds = stepBoundsOf(o.tolerance);
  v.theta = bounds.theta, v.kappa = bounds.kappa;
  v.slowest = float(o.minimumSpeed * u.time / u.length);
  const TraceLimits limits = gridLimits(fields, o);
  setPair(limits.time / u.time, v.timeLimit, v.timeLimitRest);
  setPair(limits.length / u.length, v.lengthLimit, v.lengthLimitRest);
  v.points = pointsOf(o);
  setPair(o.interval / (v.points == POINTS_TIME ? u.time : u.length), v.interval, v.intervalRest);
  setCondition(fields, o, v);
  v.stepsLimit = int(std::min<int64_t>(o.steps, std::numeric_limits<int>::max()));
  // Products of denormal samples and a larger scale might count for something.
  v.flush = std::max({v.scaleX, v.scaleY, v.scaleZ}) > 65536;
  v.rim = fields.grid().rim;
  const Index3 cells = fields.grid().cells();
  v.cellsX = int(cells[0]), v.cellsY = int(cells[1]), v.cellsZ = int(cells[2]);
  v.firstX = int(block.first[0]), v.firstY = int(block.first[1]), v.firstZ = int(block.first[2]);
  v.endX = v.firstX + int(block.points[0]) - 1;
  v.endY = v.firstY + int(block.points[1]) - 1;
  v.endZ = v.firstZ + int(block.points[2]) - 1;
  return v;
}

single::VolumeView samplesViewOf(const Volume& volume, const VolumeBlock& block, int component) {
  single::VolumeView v{};
  v.samples = block.samples.data();
  v.kind = sampleKindOf(volume.stored);
  v.stride = volume.components;
  v.component = volume.components == 1 ? 0 : component;
  v.wide = block.samples.size() >= size_t(1) << 31;
  const Bricks bricks(block.extent.points);
  v.brickRow = int(bricks.row()), v.brickLayer = int(bricks.layer());
  v.firstX = int(block.extent.first[0]), v.firstY = int(block.extent.first[1]),
  v.firstZ = int(block.extent.first[2]);
  return v;
}

FlowParts flowPartsOf(const CompiledFields& fields, int rank) {
  FlowParts parts;
  const Volume& vectors = fields.vectors();
  for (int p : fields.partitioning().owned(rank)) {
    const Extent* extent = fields.extentOf(p);
    if (!extent) continue;
    FlowPart& part = parts[p];
    part.extent = extent;
    for (int a = 0; a < 3; a++) part.vectors[size_t(a)] = samplesViewOf(vectors, vectors.blocks.at(p), a);
    for (const RecordedField& r : fields.recorded()) {
      const Volume& volume = *fields.volumes()[size_t(r.volume)];
      part.recorded.push_back(samplesViewOf(volume, volume.blocks.at(p), r.component));
    }
  }
  return parts;
}

size_t bytesOf(const FlowParts& parts) {
  size_t n = 0;
  for (const auto& [p, part] : parts) n += sizeof part + part.recorded.size() * sizeof(single::VolumeView);
  return n;
}

const FlowPart& partIn(const FlowParts& parts, int partition) {
  const auto found = parts.find(partition);
  if (found == parts.end())
    throw Error("heads of lines came for partition " + std::to_string(partition) +
                ", which has no data on this rank");
  return found->second;
}

StoredPoints::StoredPoints(size_t capacity) : capacity_(capacity) {
#define GXY_COUNT(type, name) +1
  storage_.resize(capacity * size_t(0 GXY_STORED_FIELDS(GXY_COUNT)));
#undef GXY_COUNT
  uint32_t* p = storage_.data();
#define GXY_POINT(type, name)              \
  view_.name = reinterpret_cast<type*>(p); \
  p += capacity;
  GXY_STORED_FIELDS(GXY_POINT)
#undef GXY_POINT
}

void appendPoints(const CompiledFields& fields, const TraceOptions& options, const HeadList& heads,
                  const StoredView& p, size_t count, const RecordValues& record, PathPoints& out) {
  const Measure measure{fields.units(), options.normalised};
  const double speedUnit = fields.units().length / fields.units().time;
  const bool byTime = options.points == PointsMode::EqualTime,
             byLength = options.points == PointsMode::EqualLength;
  const bool exactTimes = byTime || (options.normalised && byLength);
  const bool exactLengths = byLength || (options.normalised && byTime);
  const size_t first = out.size();
  const auto points = size_t(std::count_if(p.head, p.head + count, [](int head) { return head >= 0; }));
  out.resize(first + points, fields.recorded().size());
  size_t to = first;
  for (size_t i = 0; i < count; i++) {
    const int head = p.head[i];
    if (head < 0) continue;
    const bool backward = heads.backward(head);
    const int32_t number = backward ? -p.number[i] : p.number[i];
    const double multiple = number * options.interval;
    const double length = exactLengths ? multiple : measure.length(backward, p.length[i], p.lengthRest[i]);
    out.line[to] = heads.line(head);
    out.number[to] = number;
    out.position[to] = fields.worldOf({p.cellX[i], p.cellY[i], p.cellZ[i]}, {p.fx[i], p.fy[i], p.fz[i]});
    out.time[to] = exactTimes ? multiple : measure.time(backward, p.time[i], p.timeRest[i], length);
    out.length[to] = length;
    out.speed[to] = float(p.speed[i] * speedUnit);
    to++;
  }
  std::vector<float> values(out.values.empty() ? 0 : count);
  for (size_t k = 0; k < out.values.size(); k++) {
    record(k, p, count, values.data());
    to = first;
    for (size_t i = 0; i < count; i++)
      if (p.head[i] >= 0) out.values[k][to++] = values[i];
  }
}

void finishHeads(const CompiledFields& fields, const TraceOptions& options, HeadList heads,
                 AdvanceResult& result) {
  const HeadView& h = heads.view();
  const Measure measure{fields.units(), options.normalised};
  const TraceLimits limits = gridLimits(fields, options);
  std::map<int, std::vector<int>> leaving;
  for (int i = 0; i < heads.size(); i++) {
    const Index3 cell{h.cellX[i], h.cellY[i], h.cellZ[i]};
    if (h.reason[i] == LINE_LEAVES || h.reason[i] == LINE_GOES_ON) {
      leaving[h.reason[i] == LINE_LEAVES ? fields.partitionOf(cell) : heads.partition].push_back(i);
      h.reason[i] = LINE_GOES_ON;
      continue;
    }
    LineEnd end;
    end.line = heads.line(i);
    end.backward = heads.backward(i);
    end.reason = EndReason(h.reason[i] - 1);
    end.points = h.points[i];
    end.length = measure.length(end.backward, h.length[i], h.lengthRest[i]);
    end.time = measure.time(end.backward, h.time[i], h.timeRest[i], end.length);
    // The pairs of the kernel have 48 bits; limits are met exactly.
    settleAtLimit(options, limits, end);
    end.position = fields.worldOf(cell, {h.fx[i], h.fy[i], h.fz[i]});
    result.ends.push_back(end);
    result.retired++;
  }
  for (const auto& [partition, which] : leaving) result.leaving.push_back(heads.gather(partition, which));
}

}  // namespace gxy
