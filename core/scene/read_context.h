// SPDX-License-Identifier: Apache-2.0
// Reads values from a parsed state file. Its error messages say what is wrong, where, and what was expected.
#pragma once
#include <array>
#include <filesystem>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/colormaps.h"
#include "core/scene/json_text.h"
#include "core/scene/scene.h"
#include "core/scene/state_file.h"

namespace gxy {

class FilterSchemas;

/// The state of reading one state file. One thread uses it.
struct ReadContext {
  std::string sourceName;  ///< name of the text in messages
  NamedFileReader readFile;
  const FilterSchemas* filters = nullptr;  ///< null: entries of filters are kept as they are
  std::vector<std::string> warnings;
  size_t suppressedWarnings = 0;

  std::vector<DatasetSpec> datasets;  ///< datasets of this file, once they have been read
  /// An operator of `Operators`, without its name.
  struct NamedOperator {
    JsonValue value;
    size_t values = 0;  ///< how many values it has
  };
  std::map<std::string, NamedOperator> operators;  ///< once they have been read
  size_t namedValues = 0;  ///< of all operators that were named in place of an operator, each time
  std::optional<Lighting> oldLighting;  ///< Renderer.Lighting, for visualizations without their own

  // Contents of preset and camera files by name, since a short text may name a long file many times.
  std::map<std::string, ColorPreset> presets;
  std::map<std::string, Camera> cameras;
  size_t fileBytes = 0;     ///< size of all files that have been read
  size_t presetPoints = 0;  ///< number of points of all maps that presets have given

  void warn(TextPosition at, const std::string& message);
  [[noreturn]] void fail(TextPosition at, const std::string& message) const;
  /// Returns the content of a file. Throws Error if all files together exceed kMaxJsonBytes.
  std::string contentOf(const std::string& name);
};

/// The interval that a number must lie in.
struct Limits {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool openMin = false, openMax = false;

  bool contain(double x) const { return (openMin ? x > min : x >= min) && (openMax ? x < max : x <= max); }
  /// "", ">= 0", "0 to 1", "> 0 and < 180".
  std::string text() const;
};
inline constexpr Limits kAny{};
inline constexpr Limits kNonNegative{0};
inline constexpr Limits kPositive{0, std::numeric_limits<double>::infinity(), true};
inline constexpr Limits kUnit{0, 1};

/// A value found under a key of an object, or as an element of a list with the key `key[i]`.
struct Found {
  ReadContext& context;
  std::string key;
  const JsonValue& value;
  const JsonValue& object;  ///< the object that has the key

  /// Throws Error "`key`: expected EXPECTED, found VALUE", with the position.
  [[noreturn]] void fail(const std::string& expected) const;
  void warn(const std::string& message) const;

  bool boolean() const;
  double number(const Limits& limits = kAny) const;
  int integer(const Limits& limits) const;
  const std::string& text() const;
  /// Returns the elements of a list; `expected` describes the list in messages.
  std::vector<Found> list(const std::string& expected) const;
  /// Returns a list of at least `smallest` and at most `largest` numbers.
  std::vector<double> numbers(size_t smallest, size_t largest, const std::string& expected) const;
  glm::dvec3 vec3() const;
  /// Reads rgb or rgba. Values outside [0, 1] are clamped with a warning.
  glm::dvec4 color() const;
  Plane plane() const;
  /// Reads [width, height] of a picture in pixels, each 1 to 65536.
  glm::ivec2 imageSize() const;
  /// Clamps `x` to [0, 1], with a warning if it is outside.
  double clampedToUnit(double x) const;
};

/// Returns the candidate that a misspelt name most likely means, or nothing. Letter case does not matter.
std::optional<std::string> closestName(std::string_view name, const std::vector<std::string>& candidates);
/// Returns "; did you mean `X`?" with the closest name, or "".
std::string suggestion(std::string_view name, const std::vector<std::string>& candidates);

/// Returns the content of a regular file. Throws Error with the path and the reason if it cannot be read or
/// has more than kMaxJsonBytes.
std::string readTextFile(const std::filesystem::path& path);

}  // namespace gxy
