// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/mesh_walk.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <string>

#include "core/analysis/reference_faces.h"
#include "core/comm/error.h"
#include "core/data/replicate.h"
#include "core/rays/flow_views.h"

namespace gxy {

namespace {

/// Cells of way that count as moving on.
constexpr double kWay = 0x1p-16;
/// Crossings of faces without that, after which the next cell is searched for, and after which the line is stuck.
constexpr int kNeighbourCrossings = 8, kMostCrossings = 14;
/// Trial steps in one cell after which a line is stuck. MeshHead::stalled counts crossings below kTrial, and trials in multiples of it.
constexpr int kMostTrials = 65536, kTrial = 16;
/// Steps of so little way are taken whatever their error is, a few of them; shorter ones than the other are not tried.
constexpr double kFinestStep = 0x1p-20, kLeastStep = 0x1p-44;
/// Steps in which rounding has a part.
constexpr double kLeastTolerance = 1e-8;
/// Of a cell's size, the width of gaps that lines go over: points that hang in a face lie in it up to the rounding of files.
constexpr double kGap = 2e-6;

double leastMargin(const MeshFields& fields) { return 0.5 * borderSlack(fields.partitioning()); }

}  // namespace

MeshTrace::MeshTrace(const MeshFields& fields, int partition, const TraceOptions& options)
    : fields(fields),
      partition(partition),
      options(options),
      limits(limitsOf(options, fields.diagonal())),
      points(options.normalised && options.points == PointsMode::EqualTime ? PointsMode::EqualLength
                                                                           : options.points),
      tolerance(std::max(options.tolerance, kLeastTolerance) / 100),
      block(nullptr),
      margin(leastMargin(fields)) {
  const auto found = fields.vectors().blocks.find(partition);
  if (found != fields.vectors().blocks.end()) block = &found->second;
}

MeshWalk::MeshWalk(const MeshTrace& trace, MeshHead& head, bool backward, uint64_t line,
                   AdvanceResult& result)
    : t_(trace), head_(head), backward_(backward), line_(line), result_(result) {}

int64_t MeshWalk::spent(const AdvanceCounters& c) {
  return int64_t(c.cells) + int64_t(c.steps) / kStepsPerCell;
}

MeshWalk::Stop MeshWalk::run(int64_t most) {
  if (!findCell()) {
    reason_ = EndReason::Outside;
    return Stop::Ends;
  }
  const bool byCells = t_.points == PointsMode::Cells;
  const int64_t until = spent(result_.counters) + most;
  if (head_.leaving >= 0) cross(head_.leaving);
  // What has not been stored yet is not known to who goes on.
  while (!reason_ && next_ < 0 && ((byCells && head_.fresh) || spent(result_.counters) < until))
    goThroughCell();
  if (next_ >= 0) return Stop::Leaves;
  if (!reason_) return Stop::GoesOn;
  if (t_.points == PointsMode::Ends ? head_.length > 0 : byCells && head_.fresh) storeHere();
  return Stop::Ends;
}

// Returns false for a seed outside.
bool MeshWalk::findCell() {
  if (head_.unplaced) {
    const auto found = t_.fields.reader().place(t_.partition, head_.place);
    if (!found) return false;
    head_.unplaced = false;
    const CellType type = found->block->cells.typeOf(found->cell);
    enter(found->cell, intoCell(type, found->reference));
    return true;
  }
  if (head_.cell < 0) {
    const glm::dvec3 near(head_.near);
    const double margin = 0x1p-22 * largestOf(near) + double(std::numeric_limits<float>::min());
    for (const uint32_t cell : t_.fields.reader().cellsNear(t_.partition, near, margin))
      if (keyOf(*t_.block, cell) == head_.key) head_.cell = int32_t(cell);
    if (head_.cell < 0)
      throw Error("a head of a line is in a cell that partition " + std::to_string(t_.partition) +
                  " does not have");
  }
  enter(uint32_t(head_.cell), head_.place);
  return true;
}

void MeshWalk::enter(uint32_t cell, glm::dvec3 place) {
  if (!motion_ || uint32_t(head_.cell) != cell) {
    motion_.emplace(t_.fields.vectors(), *t_.block, cell, backward_ ? -1 : 1);
    head_.cell = int32_t(cell);
  }
  head_.place = place;
}

std::optional<EndReason> MeshWalk::endBeforeStep() const {
  if (!(t_.limits.time - head_.time > 0)) return EndReason::Time;
  if (!(t_.limits.length - head_.length > 0)) return EndReason::Length;
  if (head_.steps >= std::min<int64_t>(t_.options.steps, INT32_MAX - 1)) return EndReason::Steps;
  if (head_.stalled / kTrial >= kMostTrials) return head_.way > 0 ? EndReason::Stuck : EndReason::Closed;
  if (head_.stalled % kTrial >= kMostCrossings) return EndReason::Stuck;
  return std::nullopt;
}

void MeshWalk::goThroughCell() {
  result_.counters.cells++;
  if (head_.points == 0) storeHere();
  if (!motion_->hasData()) return end(EndReason::NoData);
  if ((reason_ = endBeforeStep())) return;
  if (meetsCondition()) return end(EndReason::Condition);
  const auto rate = motion_->rateAt(head_.place);
  if (!rate) return leave(kNoFaceOfCell);
  if (const int face = faceLeftAtOnce(motion_->type(), head_.place, *rate); face >= 0) return leave(face);
  if (isSlow(motion_->speedAt(head_.place))) return end(EndReason::Slow);
  takeSteps(*rate);
}

void MeshWalk::takeSteps(glm::dvec3 rate) {
  double time = 0;
  while (!(reason_ = endBeforeStep())) {
    const Tried tried = takeStep(rate, time);
    if (tried == Tried::Done || tried == Tried::OnFace || reason_) return;
    if (tried == Tried::Inside) time = 0;
  }
}

// The time of a step that does not go far over a face. Of a pyramid the map is not smooth at the top, where z is 0 and which an estimate
// of a step's error may not see.
double MeshWalk::longestStep(glm::dvec3 rate) const {
  const double straight = kStepOver * timeToFace(motion_->type(), head_.place, rate);
  if (motion_->type() != CellType::Pyramid) return straight;
  return std::min(straight, std::max(0.5 * head_.place.z, kFinestStep) / largestOf(rate));
}

// `time` is that of the step, or 0 for a new one.
MeshWalk::Tried MeshWalk::takeStep(glm::dvec3& rate, double& time) {
  result_.counters.steps++;
  head_.stalled += kTrial;
  const double fastest = largestOf(rate);
  const double wanted = time > 0 ? time : double(head_.step) / fastest;
  const double now = std::min({wanted, time > 0 ? wanted : longestStep(rate), t_.limits.time - head_.time});
  const auto again = [&](double shorter) {
    time = now * shorter;
    if (!(time * fastest > kLeastStep)) end(EndReason::Stuck);
    return Tried::Again;
  };
  const auto step = stepIn(*motion_, head_.place, rate, now);
  if (!step) return again(0.5);
  const double way = largestOf(step->to - step->from);
  const bool wrong = !(step->error <= t_.tolerance * way);
  if (wrong && now * fastest > kFinestStep) {
    const double most = std::sqrt(std::sqrt(t_.tolerance * way / step->error));
    return again(most > 0.25 ? std::min(0.9 * most, 0.9) : 0.2);
  }
  const StepExit exit = exitOf(motion_->type(), *step);
  if (exit.kind == StepExit::Unclear) return again(0.5);
  if (exit.kind == StepExit::Leaves && !(exit.part > 0)) {
    leave(exit.face);
    return Tried::Done;
  }
  if (exit.part < 0.5) return again(kStepOver * exit.part);
  const Tried tried = accept(*step, exit, now < wanted, rate);
  if (!wrong || reason_ || tried == Tried::Done) return tried;
  // The cell's map is hardly one here. Where it folds, the line goes on in another cell.
  if (++head_.stalled % kTrial <= kNeighbourCrossings) return tried;
  leave(kNoFaceOfCell);
  return Tried::Done;
}

// The error of a step of the method for each cell of way grows as the fourth power of the way.
void MeshWalk::setNextStep(const CellStep& step, bool shortened) {
  const double way = largestOf(step.to - step.from);
  const double allowed = t_.tolerance * way;
  const double best =
      step.error < 1e-8 * allowed ? 1.0 : 0.9 * way * std::sqrt(std::sqrt(allowed / step.error));
  // A step that something else has made short says little.
  const double next = shortened ? std::max(double(head_.step), best) : std::min(best, 4 * way);
  head_.step = next > kFinestStep ? float(std::min(next, 1.0)) : float(kFinestStep);  // if it is NaN, too
}

MeshWalk::Tried MeshWalk::accept(const CellStep& step, StepExit exit, bool shortened, glm::dvec3& rate) {
  const bool leaves = exit.kind == StepExit::Leaves;
  const double time = head_.time, length = head_.length;
  double part = exit.part, gone = lengthOf(*motion_, step, part);
  setNextStep(step, shortened);
  const double lengthLeft = t_.limits.length - length;
  if (gone >= lengthLeft) {
    part = partOfLength(*motion_, step, part, lengthLeft), gone = lengthLeft;
    end(EndReason::Length);
  } else if (!leaves && step.time >= t_.limits.time - time) {
    end(EndReason::Time);
  }
  const glm::dvec3 to = part < 1 ? step.at(part) : step.to;
  const CellType type = motion_->type();
  head_.place = leaves && !reason_ ? ontoFace(type, exit.face, to) : intoCell(type, to);
  head_.way += float(largestOf(head_.place - step.from));
  if (head_.way > float(kWay)) head_.stalled -= head_.stalled % kTrial, head_.way = 0;
  head_.time = reason_ == EndReason::Time ? t_.limits.time : time + step.time * part;
  head_.length = reason_ == EndReason::Length ? t_.limits.length : length + gone;
  head_.fresh = true;
  if (t_.points == PointsMode::EqualTime || t_.points == PointsMode::EqualLength)
    storeMultiples(step, part, time, length);
  if (head_.points >= kMostPoints) end(EndReason::Stuck);
  if (!reason_ && meetsCondition()) end(EndReason::Condition);
  if (reason_) return Tried::Done;
  if (leaves) {
    leave(exit.face);
    return Tried::Done;
  }
  const auto here = head_.place == step.to ? std::optional(step.rate) : motion_->rateAt(head_.place);
  if (!here) return Tried::OnFace;  // goThroughCell() looks again
  rate = *here;
  if (isSlow(motion_->speedAt(head_.place))) end(EndReason::Slow);
  return faceLeftAtOnce(type, head_.place, rate) >= 0 ? Tried::OnFace : Tried::Inside;
}

// ----------------------------------------------------------------------------------------------------------
// from cell to cell

void MeshWalk::leave(int face) {
  if (t_.points == PointsMode::Cells && head_.fresh) storeHere();
  cross(face);
}

void MeshWalk::cross(int face) {
  const CellType type = motion_->type();
  const auto cell = uint32_t(head_.cell);
  const glm::dvec3 at = world();
  const int crossings = head_.stalled % kTrial + 1;
  FaceId link = kNoFace;
  if (face < shapeOf(type).faces)
    link = t_.block->neighbours[size_t(type)]
                               [(cell - t_.block->cells.first(type)) * shapeOf(type).faces + size_t(face)];
  const int owner = t_.fields.partitioning().nearest(at);
  // Of a face with more than two cells a block may have two, and take them for neighbours.
  const bool sure = owner == t_.partition || t_.fields.vectors().report.crowdedFaces == 0;
  const bool linked = link != kNoFace && crossings <= kNeighbourCrossings && sure;
  if (!linked && owner != t_.partition) {
    head_.leaving = face;
    head_.near = glm::vec3(at);
    head_.key = keyOf(*t_.block, cell);
    head_.cell = -1;
    next_ = owner;
    return;
  }
  head_.leaving = -1;
  head_.stalled = crossings;
  head_.steps++;
  if (linked) {
    const CellType to = t_.block->cells.typeOf(cellOf(link));
    enter(cellOf(link), acrossFace(type, t_.block->cells.pointsOf(cell), face, head_.place, to,
                                   t_.block->cells.pointsOf(cellOf(link))));
  } else if (!findNextCell(at)) {
    end(link == kNoFace && face != kNoFaceOfCell ? EndReason::Left : EndReason::Stuck);
  }
}

// Of the other cells that have the point, enters the first one that the head does not leave at once.
bool MeshWalk::findNextCell(glm::dvec3 world) {
  glm::dvec3 lo(std::numeric_limits<double>::infinity()), hi = -lo;
  for (const glm::dvec3& p : motion_->corners().points()) lo = glm::min(lo, p), hi = glm::max(hi, p);
  const double margin = std::min(kGap * largestOf(hi - lo), t_.margin);
  for (const uint32_t cell : t_.fields.reader().cellsNear(t_.partition, world, margin)) {
    if (cell == uint32_t(head_.cell)) continue;
    const CellMotion there(t_.fields.vectors(), *t_.block, cell, backward_ ? -1 : 1);
    const auto found = there.corners().placeOf(world, kGap);
    if (!found) continue;
    const glm::dvec3 place = intoCell(there.type(), *found);
    const auto rate = there.hasData() ? there.rateAt(place) : std::optional(glm::dvec3(0));
    if (!rate || faceLeftAtOnce(there.type(), place, *rate) >= 0) continue;
    enter(cell, place);
    return true;
  }
  return false;
}

// ----------------------------------------------------------------------------------------------------------
// what is asked for

bool MeshWalk::isSlow(double speed) const {
  return speed <= std::max(t_.fields.leastSpeed(), 0x1p-20 * motion_->spread()) ||
         speed < t_.options.minimumSpeed;
}

double MeshWalk::valueHere(size_t recorded, const reference::ShapeFunctions& shape) const {
  const RecordedField& field = t_.fields.recorded()[recorded];
  const Mesh& mesh = *t_.fields.meshes()[size_t(field.volume)];
  const MeshPlace place{&mesh.blocks.at(t_.partition), uint32_t(head_.cell), shape, {}};
  return valueAt(mesh, place, mesh.components == 1 ? 0 : field.component);
}

bool MeshWalk::meetsCondition() const {
  if (!t_.options.condition) return false;
  const TraceCondition& c = *t_.options.condition;
  const double x = valueHere(size_t(c.field), reference::shapeAt(motion_->type(), head_.place));
  return x >= c.lo && x <= c.hi;
}

void MeshWalk::storeMultiples(const CellStep& step, double part, double time, double length) {
  const bool byTime = t_.points == PointsMode::EqualTime;
  // A multiple at the end of a line counts, up to rounding.
  const double until = (byTime ? head_.time : head_.length) * (1 + 0x1p-40);
  for (; head_.points < kMostPoints && head_.points * t_.options.interval <= until;) {
    const double multiple = head_.points * t_.options.interval;
    const double u = byTime ? std::clamp((multiple - time) / step.time, 0.0, part)
                            : partOfLength(*motion_, step, part, multiple - length);
    const glm::dvec3 place = intoCell(motion_->type(), step.at(u));
    store(place, byTime ? multiple : time + step.time * u,
          byTime ? length + lengthOf(*motion_, step, u) : multiple);
  }
}

void MeshWalk::store(glm::dvec3 place, double time, double length) {
  const reference::ShapeFunctions shape = reference::shapeAt(motion_->type(), place);
  PathPoints& points = result_.points;
  if (points.values.empty()) points.values.resize(t_.fields.recordedComponents());
  const double sign = backward_ ? -1 : 1;
  points.line.push_back(line_);
  points.number.push_back(backward_ ? -head_.points : head_.points);
  points.position.push_back(shape.mean(motion_->corners().points()));
  points.length.push_back(sign * length);
  points.time.push_back(sign * (t_.options.normalised ? length : time));
  const auto speed = float(motion_->speedAt(place));
  points.speed.push_back(speed - speed == 0 ? speed : std::numeric_limits<float>::quiet_NaN());
  for (size_t k = 0; k < points.values.size(); k++) points.values[k].push_back(float(valueHere(k, shape)));
  head_.points++;
  head_.fresh = false;
}

}  // namespace gxy
