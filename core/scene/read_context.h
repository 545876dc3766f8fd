// SPDX-License-Identifier: Apache-2.0
// Reading values out of a parsed state file with messages that say what, where and what was expected.
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

/// What the reader of one state file knows. One per file, used by one thread.
struct ReadContext {
  std::string sourceName;  ///< for messages
  NamedFileReader readFile;
  std::vector<std::string> warnings;
  size_t suppressedWarnings = 0;

  std::vector<DatasetSpec> datasets;    ///< of this file, once they have been read
  std::optional<Lighting> oldLighting;  ///< Renderer.Lighting, for visualizations without their own

  // What the text's files hold, by name: a short text may name a long file many times.
  std::map<std::string, ColorPreset> presets;
  std::map<std::string, Camera> cameras;
  size_t fileBytes = 0;     ///< of all files that have been read
  size_t presetPoints = 0;  ///< of all maps that presets have given

  void warn(TextPosition at, const std::string& message);
  [[noreturn]] void fail(TextPosition at, const std::string& message) const;
  /// The content of a file, while all of them together are within their bounds; else throws Error.
  std::string contentOf(const std::string& name);
};

/// The interval a number must lie in.
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

/// A value found under a key of an object (or, as `key[i]`, at a place of a list).
struct Found {
  ReadContext& context;
  std::string key;
  const JsonValue& value;
  const JsonValue& object;  ///< that holds the key

  /// "`key`: expected EXPECTED, found VALUE", with the position.
  [[noreturn]] void fail(const std::string& expected) const;
  void warn(const std::string& message) const;

  bool boolean() const;
  double number(const Limits& limits = kAny) const;
  int integer(const Limits& limits) const;
  const std::string& text() const;
  /// A list, whose places are found one by one; `expected` describes it.
  std::vector<Found> list(const std::string& expected) const;
  /// A list of smallest to largest numbers.
  std::vector<double> numbers(size_t smallest, size_t largest, const std::string& expected) const;
  glm::dvec3 vec3() const;
  /// rgb or rgba; values outside [0, 1] are clamped with a warning.
  glm::dvec4 color() const;
  Plane plane() const;
  /// Clamped to [0, 1] with a warning.
  double clampedToUnit(double x) const;
};

/// The candidate that a misspelt name most likely means, or nothing. Letter case is forgiven.
std::optional<std::string> closestName(std::string_view name, const std::vector<std::string>& candidates);
/// "; did you mean `X`?" or "".
std::string suggestion(std::string_view name, const std::vector<std::string>& candidates);

/// The content of a regular file of at most kMaxJsonBytes. Throws Error with the path and the reason.
std::string readTextFile(const std::filesystem::path& path);

}  // namespace gxy
