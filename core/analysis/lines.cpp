// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/lines.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/analysis/line_runs.h"
#include "core/comm/error.h"

namespace gxy {

namespace {

/// A stored point, and where it is.
struct PointKey {
  uint64_t line;
  int32_t number;
  uint32_t piece;
  size_t index;
};

class LineMaker {
 public:
  using TakeMemory = std::function<LedgerEntry(int64_t)>;
  LineMaker(TracedLines& lines, const LineValue& value, const TakeMemory& takeMemory, Collectives& ranks,
            const std::vector<NamedLineValue>& fields)
      : lines_(lines), values_{value}, takeMemory_(takeMemory), ranks_(ranks), fields_(fields) {
    for (const NamedLineValue& f : fields) values_.push_back(f.value);
  }

  // Finds the runs of this rank.
  void findRuns() {
    sortPoints();
    const Advance advance = advanceOf(ranks_, 0.5, 0.6);
    size_t kept = 0;
    for (size_t i = 0; i < keys_.size(); i++) {
      tell(advance, i, keys_.size());
      const PointKey key = keys_[i];
      const LinePoint point = pointOf(key);
      const bool follows = !runs_.empty() && runs_.back().line == key.line;
      if (follows && runs_.back().last == key.number)
        throw Error("line " + std::to_string(key.line) + " has a point " + std::to_string(key.number) +
                    " twice; expected seeds with different numbers");
      if (!follows || runs_.back().last + 1 != key.number) {
        runs_.push_back({key.line, key.number, key.number, 0, {}});
        begins_.push_back(kept);
      } else if (pointOf(keys_[kept - 1]).equals(point)) {
        runs_.back().last = key.number;
        continue;
      }
      keys_[kept++] = key;
      add(runs_.back(), key.number, point);
    }
    keys_.resize(kept);
    begins_.push_back(kept);
  }

  // The runs for each home.
  std::vector<Bytes> messages() {
    std::vector<std::vector<LineRun>> byHome(size_t(ranks_.size()));
    for (const LineRun& run : runs_) byHome[homeOf(run.line)].push_back(run);
    std::vector<Bytes> messages;
    for (const auto& runs : byHome) messages.push_back(bytesOfRuns(runs));
    return messages;
  }

  // Answers the runs of lines that are at home here, and counts the lines.
  std::vector<Bytes> answers(const std::vector<Bytes>& received, MadeLines& made) const {
    std::vector<LineRun> all;
    std::vector<size_t> begins{0};
    for (const Bytes& message : received) {
      const std::vector<LineRun> runs = runsIn(message);
      all.insert(all.end(), runs.begin(), runs.end());
      begins.push_back(all.size());
    }
    ranks_.check();
    const HomeLines home = joinRuns(all);
    made.lines = home.linesWithSegments;
    made.points = home.points;
    std::vector<Bytes> answers;
    for (size_t r = 0; r + 1 < begins.size(); r++)
      answers.push_back(
          bytesOfNeighbours(std::span(home.neighbours).subspan(begins[r], begins[r + 1] - begins[r])));
    return answers;
  }

  // Makes the segments of this rank.
  void makeSegments(const std::vector<Bytes>& answers, MadeLines& made) {
    std::vector<std::vector<RunNeighbours>> byHome;
    std::vector<size_t> next(answers.size(), 0), count(answers.size(), 0);
    for (const LineRun& run : runs_) count[homeOf(run.line)]++;
    for (size_t r = 0; r < answers.size(); r++) byHome.push_back(neighboursIn(answers[r], count[r]));
    reserve(byHome, made);
    const Advance advance = advanceOf(ranks_, 0.7, 1);
    std::fill(next.begin(), next.end(), 0);
    for (size_t r = 0; r < runs_.size(); r++) {
      tell(advance, begins_[r], keys_.size() + 1);
      const size_t home = homeOf(runs_[r].line);
      makeRun(r, byHome[home][next[home]++], made.block);
    }
  }

 private:
  size_t homeOf(uint64_t line) const { return size_t(line % uint64_t(ranks_.size())); }

  void sortPoints() {
    size_t all = 0;
    for (const PathPoints& piece : lines_.points) all += piece.size();
    keyMemory_ = takeMemory_(int64_t(all * sizeof(PointKey)));
    keys_.reserve(all);
    for (size_t p = 0; p < lines_.points.size(); p++) {
      const PathPoints& piece = lines_.points[p];
      for (size_t i = 0; i < piece.size(); i++)
        keys_.push_back({piece.line[i], piece.number[i], uint32_t(p), i});
      ranks_.check();
    }
    // A comparison that throws ends the sort, so that it can be cancelled.
    const double expected = 1.5 * double(all) * std::log2(double(all) + 2);
    const Advance advance = advanceOf(ranks_, 0, 0.5);
    size_t compared = 0;
    std::sort(keys_.begin(), keys_.end(), [&](const PointKey& a, const PointKey& b) {
      if (++compared % (size_t(1) << 20) == 0) advance(std::min(double(compared) / expected, 1.0));
      return a.line != b.line ? a.line < b.line : a.number < b.number;
    });
  }

  LinePoint pointOf(const PointKey& key) const {
    const PathPoints& piece = lines_.points[key.piece];
    LinePoint point{piece.position[key.index], {}};
    for (size_t v = 0; v < values_.size(); v++) point.values[v] = valueOf(values_[v], piece, key.index);
    return point;
  }

  static float valueOf(const LineValue& value, const PathPoints& piece, size_t i) {
    switch (value.kind) {
      case LineValue::Kind::Speed:
        return piece.speed[i];
      case LineValue::Kind::Time:
        return float(piece.time[i]);
      case LineValue::Kind::Length:
        return float(piece.length[i]);
      case LineValue::Kind::Recorded:
        break;
    }
    return piece.values.at(size_t(value.component))[i];
  }

  static void add(LineRun& run, int32_t number, const LinePoint& point) {
    run.last = number;
    if (run.points < 4) {
      run.ends[run.points] = point;
    } else {
      run.ends[2] = run.ends[3];
      run.ends[3] = point;
    }
    run.points++;
  }

  // Counts before it makes: the block has no room that it does not need.
  void reserve(const std::vector<std::vector<RunNeighbours>>& byHome, MadeLines& made) const {
    std::vector<size_t> next(byHome.size(), 0);
    size_t points = 0, segments = 0;
    for (const LineRun& run : runs_) {
      const size_t home = homeOf(run.line);
      const RunNeighbours& n = byHome[home][next[home]++];
      const size_t own = run.points - n.dropsFirst, made = own + (n.before > 0) - (own > 0);
      if (own == 0 || made == 0) continue;
      segments += made;
      points += own + size_t(n.before) + n.after;
    }
    if (points >= std::numeric_limits<uint32_t>::max())
      throw Error("lines: this rank has " + std::to_string(points) + " points, expected fewer than 2^32 - 1");
    GeometryBlock& block = made.block;
    const size_t pointBytes = sizeof(glm::dvec3) + values_.size() * sizeof(float);
    constexpr size_t kSegmentBytes = 4 * sizeof(uint32_t) + sizeof(uint64_t);
    made.memory = takeMemory_(int64_t(points * pointBytes + segments * kSegmentBytes));
    block.points.reserve(points);
    block.values.reserve(points);
    for (const NamedLineValue& f : fields_)
      block.fields.emplace_back(PointField{f.name, 1, {}}).values.reserve(points);
    block.segments.reserve(segments);
    block.neighbours.reserve(segments);
    block.ids.reserve(segments);
  }

  static uint32_t addPoint(GeometryBlock& block, const LinePoint& point) {
    block.points.push_back(point.position);
    block.values.push_back(point.values[0]);
    for (size_t f = 0; f < block.fields.size(); f++) block.fields[f].values.push_back(point.values[f + 1]);
    return uint32_t(block.points.size() - 1);
  }

  void makeRun(size_t r, const RunNeighbours& n, GeometryBlock& block) {
    const size_t begin = begins_[r] + n.dropsFirst, end = begins_[r + 1];
    if (begin == end || (n.before == 0 && end - begin == 1)) return;
    const auto first = uint32_t(block.points.size());
    for (int k = 2 - n.before; k < 2; k++) addPoint(block, n.pointsBefore[size_t(k)]);
    for (size_t i = begin; i < end; i++) addPoint(block, pointOf(keys_[i]));
    if (n.after) addPoint(block, n.pointAfter);
    const auto last = uint32_t(block.points.size() - 1);
    const auto own = first + uint32_t(n.before);
    for (size_t i = begin; i < end; i++) {
      const auto b = own + uint32_t(i - begin);
      if (b == first) continue;  // the line begins here
      const uint32_t a = b - 1;
      block.segments.push_back({a, b});
      block.neighbours.push_back({a == first ? a : a - 1, b == last ? b : b + 1});
      block.ids.push_back(idOf(keys_[i], n.least));
    }
  }

  // The id of the segment that ends at a point.
  static uint64_t idOf(const PointKey& end, int32_t least) {
    const int64_t number = int64_t(end.number) - least - 1;
    if (number >= int64_t(1) << 24)
      throw Error("line " + std::to_string(end.line) + " has more than 2^24 segments");
    return end.line << 24 | uint64_t(number);
  }

  TracedLines& lines_;
  std::vector<LineValue> values_;  ///< what is kept at points: the value that is shown, then those of fields
  const TakeMemory& takeMemory_;
  Collectives& ranks_;
  const std::vector<NamedLineValue>& fields_;
  LedgerEntry keyMemory_;
  std::vector<PointKey> keys_;  ///< in order of line and number; once runs are found, without equal points
  std::vector<LineRun> runs_;   ///< in the same order
  std::vector<size_t> begins_;  ///< the first key of each run, and the number of keys
};

// The sums over all ranks.
void sumUp(MadeLines& made, const std::vector<LineEnd>& ends, Collectives& ranks) {
  std::array<uint64_t, kEndReasons + 2> mine{};
  for (const LineEnd& end : ends) mine[size_t(end.reason)]++;
  mine[kEndReasons] = made.lines;
  mine[kEndReasons + 1] = made.points;
  made.lines = made.points = 0;
  for (const auto& theirs : gatherValues(ranks, std::span<const uint64_t>(mine))) {
    for (size_t k = 0; k < kEndReasons; k++) made.ends[k] += theirs[k];
    made.lines += theirs[kEndReasons];
    made.points += theirs[kEndReasons + 1];
  }
}

}  // namespace

MadeLines makeLines(TracedLines lines, const LineValue& value,
                    const std::function<LedgerEntry(int64_t)>& takeMemory, Collectives& ranks,
                    const std::vector<NamedLineValue>& fields) {
  MadeLines made;
  if (fields.size() >= kMostLineValues)
    throw Error(std::to_string(fields.size()) + " fields are to be kept of lines, expected fewer than " +
                std::to_string(kMostLineValues));
  LineMaker maker(lines, value, takeMemory, ranks, fields);
  std::vector<Bytes> messages;
  agree(ranks, [&] {
    maker.findRuns();
    messages = maker.messages();
  });
  std::vector<Bytes> received = ranks.allToAll(std::move(messages));
  std::vector<Bytes> answers;
  agree(ranks, [&] { answers = maker.answers(received, made); });
  received = ranks.allToAll(std::move(answers));
  agree(ranks, [&] { maker.makeSegments(received, made); });
  sumUp(made, lines.ends, ranks);
  return made;
}

}  // namespace gxy
