// SPDX-License-Identifier: Apache-2.0
// A sweep: axes along which a state is varied, for the pictures of a Cinema database. docs/cinema.md is its reference.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/json_text.h"

namespace gxy {

/// What an axis varies.
enum class AxisKind : uint8_t {
  Phi,       ///< the camera, turned about its `viewup`, degrees
  Theta,     ///< the camera, raised towards its `viewup`, degrees
  Angles,    ///< both: pairs of phi and theta
  Camera,    ///< which of the state's cameras
  Isovalue,  ///< an isovalue of an operator
  Slice,     ///< the offset of a slice of an operator
  Clip,      ///< the offset of a clip plane of an operator
  Colormap,  ///< the colour map of an operator
  Key,       ///< any key of the state
  Time       ///< the time steps
};

/// One value of an axis.
struct SweepValue {
  std::vector<double> numbers;     ///< of an axis of numbers; of Angles both
  std::string json;                ///< the value as JSON, what a key of the state becomes
  std::vector<std::string> cells;  ///< what it is called in the table, by column of the axis
  TextPosition at;                 ///< where it stands in the sweep
};

struct SweepAxis {
  AxisKind kind = AxisKind::Phi;
  std::vector<std::string> columns;  ///< names of its columns in the table: one, or two of Angles
  std::vector<SweepValue> values;    ///< empty: all cameras, or Time
  int op = 0;                        ///< which operator
  int index = 0;                     ///< which of its isovalues, slices or clip planes
  std::string path;                  ///< of Key: a JSON Pointer (RFC 6901)
  TextPosition at;                   ///< where it stands in the sweep

  // As they were read, before `values` and `columns` are made of them.
  std::string name;
  std::vector<std::string> labels;
  std::optional<double> from, to;
  int count = 0;
};

/// The pictures are those of the product of all axes, in the order written: the last one varies fastest.
struct Sweep {
  std::string source;  ///< name of the text, in messages
  std::vector<SweepAxis> axes;
  std::optional<glm::dvec3> center;   ///< what the camera turns about, world; none: what it looks at
  std::vector<std::string> warnings;  ///< of unknown keys and keys without effect

  bool hasTime() const;
  /// Names of the columns of all axes.
  std::vector<std::string> columns() const;
};

/// The most pictures of one time step.
inline constexpr uint64_t kMostSweptPictures = 10000;

/// Reads the text of a sweep. Throws Error "SOURCE:LINE:COLUMN: `key`: expected ..., found ..." for any mistake, and no other
/// exception. Has no state: any thread may call it.
Sweep readSweep(std::string_view text, const std::string& sourceName);

/// The same for a file. Throws Error also if it cannot be read.
Sweep readSweepFile(const std::filesystem::path& path);

/// Returns the tables of docs/cinema.md, in Markdown, made from the schema.
std::string sweepReference();

}  // namespace gxy
