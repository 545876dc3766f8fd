// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/line_runs.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <string>

#include "core/comm/error.h"
#include "core/comm/wire.h"

namespace gxy {

namespace {

void write(Writer& w, const LinePoint& p) { w.write(p.position).write(p.values); }

LinePoint readPoint(Reader& in) {
  LinePoint p;
  p.position = in.read<glm::dvec3>();
  p.values = in.read<std::array<float, kMostLineValues>>();
  return p;
}

/// One line at its home.
class HomeLine {
 public:
  /// `order` are the indices of its runs, in order of their numbers.
  HomeLine(std::span<const LineRun> runs, std::span<const size_t> order, HomeLines& home)
      : runs_(runs), order_(order), home_(home) {}

  void join() {
    check();
    const uint64_t points = lookBack();
    lookAhead();
    if (points < 2) return;
    home_.linesWithSegments++;
    home_.points += points;
  }

 private:
  void check() const {
    for (size_t i = 1; i < order_.size(); i++) {
      const LineRun& run = runs_[order_[i]];
      const int64_t expected = int64_t(runs_[order_[i - 1]].last) + 1;
      if (run.first < expected)
        throw Error("line " + std::to_string(run.line) + " has a point " + std::to_string(run.first) +
                    " twice; expected seeds with different numbers");
      if (run.first > expected)
        throw Error("line " + std::to_string(run.line) + " has no point " + std::to_string(expected));
    }
  }

  // In order of the line: the two points before each run. Returns the number of points.
  uint64_t lookBack() {
    std::array<LinePoint, 2> behind{};
    int count = 0;
    uint64_t points = 0;
    for (const size_t i : order_) {
      const LineRun& run = runs_[i];
      RunNeighbours& n = home_.neighbours[i];
      n.least = runs_[order_.front()].first;
      n.before = count;
      n.pointsBefore = behind;
      n.dropsFirst = count > 0 && run.ends[0].equals(behind[1]);
      for (int k = n.dropsFirst; k < run.known(); k++) {
        behind = {behind[1], run.ends[size_t(k)]};
        count = std::min(count + 1, 2);
      }
      points += run.points - n.dropsFirst;
    }
    return points;
  }

  // Against the order of the line: the point after each run.
  void lookAhead() {
    const LinePoint* ahead = nullptr;
    for (auto i = order_.rbegin(); i != order_.rend(); ++i) {
      const LineRun& run = runs_[*i];
      RunNeighbours& n = home_.neighbours[*i];
      n.after = ahead != nullptr;
      if (ahead) n.pointAfter = *ahead;
      if (run.known() > int(n.dropsFirst)) ahead = &run.ends[n.dropsFirst];
    }
  }

  const std::span<const LineRun> runs_;
  const std::span<const size_t> order_;
  HomeLines& home_;
};

}  // namespace

bool LinePoint::equals(const LinePoint& other) const {
  return std::memcmp(&position, &other.position, sizeof position) == 0 &&
         std::memcmp(&values, &other.values, sizeof values) == 0;
}

HomeLines joinRuns(std::span<const LineRun> runs) {
  HomeLines home;
  home.neighbours.resize(runs.size());
  std::vector<size_t> order(runs.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return runs[a].line != runs[b].line ? runs[a].line < runs[b].line : runs[a].first < runs[b].first;
  });
  for (size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && runs[order[end]].line == runs[order[begin]].line) end++;
    HomeLine(runs, std::span(order).subspan(begin, end - begin), home).join();
  }
  return home;
}

Bytes bytesOfRuns(std::span<const LineRun> runs) {
  Writer w;
  w.write(uint64_t(runs.size()));
  for (const LineRun& run : runs) {
    w.write(run.line).write(run.first).write(run.last).write(run.points);
    for (int k = 0; k < run.known(); k++) write(w, run.ends[size_t(k)]);
  }
  return w.take();
}

std::vector<LineRun> runsIn(const Bytes& message) {
  Reader in(message, "runs of lines");
  std::vector<LineRun> runs;
  for (auto left = in.read<uint64_t>(); left > 0; left--) {
    LineRun& run = runs.emplace_back();
    run.line = in.read<uint64_t>();
    run.first = in.read<int32_t>();
    run.last = in.read<int32_t>();
    run.points = in.read<uint32_t>();
    if (run.points < 1 || run.first > run.last) in.fail("a run has no points");
    for (int k = 0; k < run.known(); k++) run.ends[size_t(k)] = readPoint(in);
  }
  in.expectEnd();
  return runs;
}

Bytes bytesOfNeighbours(std::span<const RunNeighbours> neighbours) {
  Writer w;
  for (const RunNeighbours& n : neighbours) {
    w.write(n.least).write(n.dropsFirst).write(uint8_t(n.before)).write(n.after);
    for (int k = 2 - n.before; k < 2; k++) write(w, n.pointsBefore[size_t(k)]);
    if (n.after) write(w, n.pointAfter);
  }
  return w.take();
}

std::vector<RunNeighbours> neighboursIn(const Bytes& message, size_t expected) {
  Reader in(message, "neighbours of runs");
  std::vector<RunNeighbours> neighbours(expected);
  for (RunNeighbours& n : neighbours) {
    n.least = in.read<int32_t>();
    n.dropsFirst = in.read<bool>();
    n.before = in.read<uint8_t>();
    n.after = in.read<bool>();
    if (n.before > 2 || (n.dropsFirst && n.before == 0)) in.fail("a run has points before it that cannot be");
    for (int k = 2 - n.before; k < 2; k++) n.pointsBefore[size_t(k)] = readPoint(in);
    if (n.after) n.pointAfter = readPoint(in);
  }
  in.expectEnd();
  return neighbours;
}

}  // namespace gxy
