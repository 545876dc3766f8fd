// SPDX-License-Identifier: Apache-2.0
// Runs: what ranks have of lines without a gap, and what the home of a line knows of the runs around one.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "core/comm/transport.h"

namespace gxy {

/// The most numbers that are kept at points of lines: the value, and further fields.
inline constexpr size_t kMostLineValues = 4;

/// A point of a line as geometry has it.
struct LinePoint {
  glm::dvec3 position{0};
  std::array<float, kMostLineValues> values{};  ///< first the one that is shown; 0 where nothing is kept
  /// Whether all bits are equal.
  bool equals(const LinePoint& other) const;
};

/// Points of one line on one rank, with consecutive numbers. Equal points that follow each other are one.
struct LineRun {
  uint64_t line = 0;
  int32_t first = 0, last = 0;  ///< the numbers of its points before equal ones became one
  uint32_t points = 0;          ///< how many there are, >= 1
  std::array<LinePoint, 4>
      ends{};  ///< all of them if there are at most 4, else the first two and the last two

  int known() const { return points < 4 ? int(points) : 4; }
};

/// What is around a run on its line.
struct RunNeighbours {
  int32_t least = 0;                        ///< the number of the line's first point
  bool dropsFirst = false;                  ///< the run's first point is equal to the point before
  int before = 0;                           ///< how many points there are before it, at most 2
  bool after = false;                       ///< there is one after it
  std::array<LinePoint, 2> pointsBefore{};  ///< in order of the line: of one, the second
  LinePoint pointAfter;
};

/// What the home of lines finds out of all their runs.
struct HomeLines {
  std::vector<RunNeighbours> neighbours;       ///< in order of the runs
  uint64_t linesWithSegments = 0, points = 0;  ///< lines of at least two points, and their points
};

/// Puts together the lines of runs, which are in any order. Throws Error if a point comes twice or is missing.
HomeLines joinRuns(std::span<const LineRun> runs);

Bytes bytesOfRuns(std::span<const LineRun> runs);
std::vector<LineRun> runsIn(const Bytes& message);
Bytes bytesOfNeighbours(std::span<const RunNeighbours> neighbours);
/// Throws Error unless the message has as many as `expected`.
std::vector<RunNeighbours> neighboursIn(const Bytes& message, size_t expected);

}  // namespace gxy
