// SPDX-License-Identifier: Apache-2.0
#include "core/io/volume_description.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/comm/error.h"
#include "core/comm/error_text.h"

namespace gxy {
namespace {

using nlohmann::json;

constexpr const char* kTypeWords =
    "float, uchar, int8, uint8, int16, uint16, int32, uint32, int64, uint64 or double";

// The first word of a type is the one that is written.
constexpr std::pair<const char*, ScalarType> kTypes[] = {
    {"float", ScalarType::Float32}, {"uchar", ScalarType::UInt8},   {"int8", ScalarType::Int8},
    {"uint8", ScalarType::UInt8},   {"int16", ScalarType::Int16},   {"uint16", ScalarType::UInt16},
    {"int32", ScalarType::Int32},   {"uint32", ScalarType::UInt32}, {"int64", ScalarType::Int64},
    {"uint64", ScalarType::UInt64}, {"double", ScalarType::Float64}};

std::optional<ScalarType> typeOfWord(std::string_view word) {
  const auto found =
      std::find_if(std::begin(kTypes), std::end(kTypes), [&](const auto& t) { return t.first == word; });
  if (found == std::end(kTypes)) return {};
  return found->second;
}

const char* wordOfType(ScalarType type) {
  return std::find_if(std::begin(kTypes), std::end(kTypes), [&](const auto& t) { return t.second == type; })
      ->first;
}

/// The words of a text, each with its line. The raw file's name is the rest of its line, including blanks.
class Words {
 public:
  Words(std::string_view text, const std::string& where) : text_(text), where_(where) {}

  std::string_view next(const char* expected) {
    skipBlanks();
    if (at_ == text_.size()) fail("the file ends, expected " + std::string(expected));
    const size_t begin = at_;
    while (at_ < text_.size() && !isBlank(text_[at_])) ++at_;
    return text_.substr(begin, at_ - begin);
  }
  std::string_view restOfLine(const char* expected) {
    skipBlanks();
    if (at_ == text_.size()) fail("the file ends, expected " + std::string(expected));
    const size_t begin = at_;
    size_t end = at_;
    for (; at_ < text_.size() && text_[at_] != '\n'; ++at_)
      if (!isBlank(text_[at_])) end = at_ + 1;
    return text_.substr(begin, end - begin);
  }
  void expectEnd() {
    skipBlanks();
    if (at_ < text_.size())
      fail("expected nothing after the name of the raw file, found " + inQuotes(next("")));
  }
  template <class T>
  T number(const char* expected) {
    const std::string_view word = next(expected);
    T value{};
    const auto [end, error] =
        std::from_chars(word.data() + (word[0] == '+'), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size())
      fail("expected " + std::string(expected) + ", found " + inQuotes(word));
    return value;
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw Error(where_ + ":" + std::to_string(line_) + ": " + what);
  }

 private:
  static bool isBlank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f';
  }
  void skipBlanks() {
    for (; at_ < text_.size() && isBlank(text_[at_]); ++at_) line_ += text_[at_] == '\n';
  }
  std::string_view text_;
  std::string where_;
  size_t at_ = 0;
  int line_ = 1;
};

void checkName(const std::string& name, const std::string& where) {
  if (name.empty() || name.find('\0') != std::string::npos)
    throw Error(where + ": the name of the raw file is empty or not a name");
}

const json& member(const json& object, const char* key, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) throw Error(where + ": key \"" + key + "\" is missing");
  return *found;
}

template <class T>
std::array<T, 3> triple(const json& object, const char* key, const std::string& where) {
  const json& value = member(object, key, where);
  const bool counts = std::is_integral_v<T>;
  const std::string expected =
      std::string(": expected an array of three ") + (counts ? "integers" : "numbers");
  if (!value.is_array() || value.size() != 3) throw Error(where + ": \"" + key + "\"" + expected);
  std::array<T, 3> result;
  for (int axis = 0; axis < 3; ++axis) {
    const json& entry = value[size_t(axis)];
    // An unsigned value above the signed range would wrap around. No grid is that large.
    const bool fits = counts ? entry.is_number_integer() && !(entry.is_number_unsigned() &&
                                                              entry.get<uint64_t>() > uint64_t(INT64_MAX))
                             : entry.is_number();
    if (!fits) throw Error(where + ": \"" + key + "\"" + expected);
    result[size_t(axis)] = entry.get<T>();
  }
  return result;
}

std::string text(const json& object, const char* key, const std::string& where) {
  const json& value = member(object, key, where);
  if (!value.is_string()) throw Error(where + ": \"" + key + "\": expected a string");
  return value.get<std::string>();
}

std::vector<std::string> warningsOfUnknownKeys(const json& object, const std::string& where) {
  constexpr size_t kMost = 10;
  static const std::set<std::string> known = {
      "type", "origin", "counts", "delta", "rawdata", "number of components", "byte order"};
  std::vector<std::string> warnings;
  size_t more = 0;
  for (const auto& [key, value] : object.items()) {
    if (known.count(key)) continue;
    if (warnings.size() < kMost)
      warnings.push_back(where + ": unknown key " + inQuotes(key) + " is ignored");
    else
      more++;
  }
  if (more > 0) warnings.push_back(where + ": and " + std::to_string(more) + " more unknown keys");
  return warnings;
}

}  // namespace

std::optional<ScalarType> scalarTypeOfWord(std::string_view word) { return typeOfWord(word); }

VolumeDescription parseVol(std::string_view text, const std::string& where) {
  Words words(text, where);
  VolumeDescription volume;
  const std::string_view word = words.next("a type");
  const auto type = typeOfWord(word);
  if (!type) words.fail("unknown type " + inQuotes(word) + ", expected " + kTypeWords);
  volume.type = *type;
  for (int a = 0; a < 3; ++a) volume.grid.origin[a] = words.number<double>("a coordinate of the origin");
  for (int a = 0; a < 3; ++a) volume.grid.points[size_t(a)] = words.number<int64_t>("a number of points");
  for (int a = 0; a < 3; ++a) volume.grid.spacing[a] = words.number<double>("a spacing");
  volume.rawFile = words.restOfLine("the name of the raw file");
  words.expectEnd();
  checkName(volume.rawFile, where);
  checkGrid(volume.grid, volume.type, volume.components, where);
  return volume;
}

VolumeDescription parseVolumeJson(std::string_view source, const std::string& where) {
  json document;
  try {
    document = json::parse(source);
  } catch (const json::exception& e) {
    throw Error(where + ": not valid JSON: " + e.what());
  }
  if (!document.is_object()) throw Error(where + ": expected a JSON object that describes a volume");

  VolumeDescription volume;
  volume.warnings = warningsOfUnknownKeys(document, where);
  const std::string word = text(document, "type", where);
  const auto type = typeOfWord(word);
  if (!type) throw Error(where + ": \"type\": unknown type " + inQuotes(word) + ", expected " + kTypeWords);
  volume.type = *type;
  const auto origin = triple<double>(document, "origin", where);
  const auto delta = triple<double>(document, "delta", where);
  volume.grid.points = triple<int64_t>(document, "counts", where);
  volume.grid.origin = {origin[0], origin[1], origin[2]};
  volume.grid.spacing = {delta[0], delta[1], delta[2]};
  volume.rawFile = text(document, "rawdata", where);
  if (const auto found = document.find("number of components"); found != document.end()) {
    if (!found->is_number_integer() || found->get<double>() < 1 || found->get<double>() > 1024)
      throw Error(where + ": \"number of components\": expected an integer from 1 to 1024");
    volume.components = found->get<int>();
  }
  if (document.contains("byte order")) {
    const std::string order = text(document, "byte order", where);
    if (order != "little" && order != "big")
      throw Error(where + ": \"byte order\": expected \"little\" or \"big\", found " + inQuotes(order));
    volume.swapBytes = (order == "big") != (std::endian::native == std::endian::big);
  }
  checkName(volume.rawFile, where);
  checkGrid(volume.grid, volume.type, volume.components, where);
  return volume;
}

std::string formatVol(const VolumeDescription& volume) {
  if (volume.components != 1)
    throw Error("a .vol file holds one component, not " + std::to_string(volume.components));
  const Grid& g = volume.grid;
  std::string text = wordOfType(volume.type) + std::string("\n");
  char line[128];
  const auto reals = [&](glm::dvec3 v) {
    std::snprintf(line, sizeof line, "%.17g %.17g %.17g\n", v.x, v.y, v.z);
    text += line;
  };
  reals(g.origin);
  text += std::to_string(g.points[0]) + " " + std::to_string(g.points[1]) + " " +
          std::to_string(g.points[2]) + "\n";
  reals(g.spacing);
  return text + volume.rawFile + "\n";
}

std::string formatVolumeJson(const VolumeDescription& volume) {
  const Grid& g = volume.grid;
  nlohmann::ordered_json document;
  document["type"] = wordOfType(volume.type);
  document["origin"] = {g.origin.x, g.origin.y, g.origin.z};
  document["counts"] = g.points;
  document["delta"] = {g.spacing.x, g.spacing.y, g.spacing.z};
  document["rawdata"] = volume.rawFile;
  document["number of components"] = volume.components;
  const bool big = (std::endian::native == std::endian::big) != volume.swapBytes;
  document["byte order"] = big ? "big" : "little";
  return document.dump(2) + "\n";
}

void checkGrid(const Grid& grid, ScalarType type, int components, const std::string& where) {
  int64_t bytes = int64_t(bytesOf(type));
  bool overflow = components < 1 || __builtin_mul_overflow(bytes, int64_t(components), &bytes);
  for (int a = 0; a < 3; ++a) {
    const int64_t points = grid.points[size_t(a)];
    if (!std::isfinite(grid.origin[a])) throw Error(where + ": the origin is not finite");
    if (!(grid.spacing[a] > 0) || !std::isfinite(grid.spacing[a]))
      throw Error(where + ": the spacing is " + std::to_string(grid.spacing[a]) +
                  ", expected positive numbers");
    if (points < 2)
      throw Error(where + ": " + std::to_string(points) + " points along " + "xyz"[a] +
                  ", expected at least 2");
    if (!std::isfinite(grid.origin[a] + grid.spacing[a] * double(points - 1)))
      throw Error(where + ": the grid's extent is not finite");
    overflow = overflow || __builtin_mul_overflow(bytes, points, &bytes);
  }
  if (overflow) throw Error(where + ": the counts are too large: the samples would not fit into 2^63 bytes");
}

}  // namespace gxy
