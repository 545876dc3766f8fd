// SPDX-License-Identifier: Apache-2.0
// Steps of an integration in one cell, and where they leave it.
//
// The method is that of Dormand and Prince, of order 5 with an estimate of its error, and with the polynomial of order 4 between a step's
// ends (Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, II.5 and II.6). Faces are planes in reference coordinates, so
// where a step meets one is a root of a polynomial of degree 4. Control points bound it: nothing of a step that reaches over a face
// remains unseen.
#pragma once
#include <array>
#include <glm/vec3.hpp>
#include <optional>

#include "core/analysis/cell_motion.h"

namespace gxy {

/// Reference coordinates within which a place counts as on a face, and by which a step may reach over a face that it begins on or ends
/// at.
inline constexpr double kOnFace = 0x1p-36;
/// Of the largest component of a velocity, the part across a face that counts as none.
inline constexpr double kTangential = 0x1p-40;
/// A step that is to meet a face goes a little further than straight on to it.
inline constexpr double kStepOver = 1.0625;

/// The greatest component, without signs.
double largestOf(glm::dvec3 v);

/// A step from one place to another.
struct CellStep {
  double time;                      ///< that it takes
  glm::dvec3 from, to;              ///< reference coordinates
  glm::dvec3 rate;                  ///< at `to`
  std::array<glm::dvec3, 5> power;  ///< the way as a polynomial of the part of the time, 0 to 1
  double error;                     ///< about how far `to` is wrong, reference coordinates

  glm::dvec3 at(double part) const;
};

/// Returns the step of a time from a place, where the rate is `rate`. Nothing if it looks at the field too far outside the cell, or where
/// the cell's map has no inverse.
std::optional<CellStep> stepIn(const CellMotion& motion, glm::dvec3 from, glm::dvec3 rate, double time);

/// Returns the face through which a head at a place leaves at once, as it is on it and its velocity leads out; -1: none.
int faceLeftAtOnce(CellType type, glm::dvec3 place, glm::dvec3 rate);

/// The time until a head meets a face if it goes straight on; infinity if it meets none.
double timeToFace(CellType type, glm::dvec3 place, glm::dvec3 rate);

/// Where a step leaves its cell.
struct StepExit {
  enum Kind { Inside, Leaves, Unclear } kind = Inside;
  double part = 1;  ///< Leaves: of the step's time
  int face = -1;    ///< Leaves
};
/// Unclear: it may go out and come back, and is to be made shorter.
StepExit exitOf(CellType type, const CellStep& step);

/// The length in the world of a part of a step's way.
double lengthOf(const CellMotion& motion, const CellStep& step, double part);
/// The part of a step, at most `most`, whose length is `length`.
double partOfLength(const CellMotion& motion, const CellStep& step, double most, double length);

}  // namespace gxy
