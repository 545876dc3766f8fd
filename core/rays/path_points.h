// SPDX-License-Identifier: Apache-2.0
// What is stored of lines on the way, and how lines end.
#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace gxy {

/// Stored points of lines, in any order: (line, number) is the key of each. A structure of arrays. Points are
/// numbered from 0, the seed; behind it, against the field, they have negative numbers, so in order of numbers
/// they are in order of time. Not thread safe.
struct PathPoints {
  std::vector<uint64_t> line;
  std::vector<int32_t> number;
  std::vector<glm::dvec3> position;        ///< world
  std::vector<double> time;                ///< since the seed; negative behind it
  std::vector<double> length;              ///< along the line from the seed, world units; negative behind it
  std::vector<float> speed;                ///< of the field, world units per unit of time
  std::vector<std::vector<float>> values;  ///< of each recorded component; NaN without data

  size_t size() const { return line.size(); }
  /// Makes room for so many points with so many recorded components.
  void resize(size_t points, size_t components);
  int64_t bytes() const;
  /// Appends the points of another list with as many recorded components, or appends to an empty one.
  void append(PathPoints&& other);
  /// Puts the points in order of line and number.
  void sort();
};

/// Why a line has ended. The order is part of the protocol between ranks.
enum class EndReason : uint8_t {
  Left,       ///< left the grid, or the cells of a mesh
  Time,       ///< reached the time asked for
  Length,     ///< reached the length asked for
  Steps,      ///< went through as many cells as asked for
  Slow,       ///< the field is 0 or below the minimum speed, or the head is within 2^-20 cells of a zero
  NoData,     ///< came to a cell with a NaN or an infinity
  Condition,  ///< met the condition
  Closed,     ///< came back to where it was
  Stuck,      ///< crossed faces without getting on; or would have more than kMostPoints points
  Outside     ///< the seed is outside the grid, in no cell, or not finite
};
inline constexpr int kEndReasons = 10;
/// As users read it: "left", "time", ..., "no data", ...
const char* nameOf(EndReason reason);

/// The end of one head of a line; lines in both directions have two.
struct LineEnd {
  uint64_t line = 0;
  bool backward = false;
  EndReason reason = EndReason::Left;
  int32_t points = 0;  ///< numbers that are used up: stored points, the seed included; 0 for `Outside`
  double time = 0, length = 0;  ///< from the seed, signed as those of points
  glm::dvec3 position{0};       ///< world; that of the seed for `Outside`
};

}  // namespace gxy
