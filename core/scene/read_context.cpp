// SPDX-License-Identifier: Apache-2.0
#include "core/scene/read_context.h"

#include <algorithm>
#include <cctype>
#include <climits>
#include <cmath>
#include <fstream>
#include <numeric>

#include "core/comm/error.h"

namespace gxy {
namespace {

std::string lower(std::string_view s) {
  std::string out(s);
  for (char& c : out) c = char(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

/// The Levenshtein distance.
size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

}  // namespace

void ReadContext::warn(TextPosition at, const std::string& message) {
  constexpr size_t kMostWarnings = 100;
  if (warnings.size() < kMostWarnings) {
    warnings.push_back(locationPrefix(sourceName, at) + message);
  } else {
    ++suppressedWarnings;
  }
}

void ReadContext::fail(TextPosition at, const std::string& message) const {
  throw Error(locationPrefix(sourceName, at) + message);
}

std::string ReadContext::contentOf(const std::string& name) {
  std::string content = readFile(name);
  fileBytes += content.size();
  if (fileBytes > kMaxJsonBytes)
    throw Error(inQuotes(name) + ": with it the preset and camera files have " + std::to_string(fileBytes) +
                " bytes together, expected at most " + std::to_string(kMaxJsonBytes));
  return content;
}

std::string Limits::text() const {
  const bool below = std::isfinite(min), above = std::isfinite(max);
  if (below && above && !openMin && !openMax) return numberText(min) + " to " + numberText(max);
  std::string out;
  if (below) out.append(openMin ? "> " : ">= ").append(numberText(min));
  if (below && above) out.append(" and ");
  if (above) out.append(openMax ? "< " : "<= ").append(numberText(max));
  return out;
}

void Found::fail(const std::string& expected) const {
  context.fail(value.at, inQuotes(key, '`') + ": expected " + expected + ", found " + value.describe());
}

void Found::warn(const std::string& message) const {
  context.warn(value.at, inQuotes(key, '`') + ": " + message);
}

bool Found::boolean() const {
  if (!value.boolean()) fail("true or false");
  return *value.boolean();
}

double Found::number(const Limits& limits) const {
  const JsonNumber* n = value.number();
  if (!n || !limits.contain(n->value)) {
    const std::string range = limits.text();
    fail(range.empty() ? "a number" : "a number " + range);
  }
  return n->value;
}

int Found::integer(const Limits& limits) const {
  const JsonNumber* n = value.number();
  if (!n || !n->integral || !limits.contain(n->value)) fail("an integer " + limits.text());
  if (std::abs(n->value) > INT_MAX) fail("an integer of at most " + std::to_string(INT_MAX));
  return int(n->value);
}

const std::string& Found::text() const {
  if (!value.string()) fail("text in quotes");
  return *value.string();
}

std::vector<Found> Found::list(const std::string& expected) const {
  if (!value.array()) fail(expected);
  std::vector<Found> out;
  out.reserve(value.array()->size());
  for (const JsonValue& item : *value.array()) {
    out.push_back({context, key + "[" + std::to_string(out.size()) + "]", item, object});
  }
  return out;
}

std::vector<double> Found::numbers(size_t smallest, size_t largest, const std::string& expected) const {
  const JsonValue::Array* items = value.array();
  if (!items || items->size() < smallest || items->size() > largest) fail(expected);
  std::vector<double> out;
  out.reserve(items->size());
  for (const JsonValue& item : *items) {
    if (!item.number())
      context.fail(item.at,
                   inQuotes(key, '`') + ": expected " + expected + ", found in it " + item.describe());
    out.push_back(item.number()->value);
  }
  return out;
}

glm::dvec3 Found::vec3() const {
  const std::vector<double> v = numbers(3, 3, "[x, y, z]");
  return {v[0], v[1], v[2]};
}

glm::dvec4 Found::color() const {
  const std::vector<double> v = numbers(3, 4, "[r, g, b] or [r, g, b, a] of 0 to 1");
  return {clampedToUnit(v[0]), clampedToUnit(v[1]), clampedToUnit(v[2]),
          v.size() > 3 ? clampedToUnit(v[3]) : 1};
}

Plane Found::plane() const {
  const std::string expected = "[a, b, c, d] for a*x + b*y + c*z = d, with a, b, c not all 0";
  const std::vector<double> v = numbers(4, 4, expected);
  if (v[0] == 0 && v[1] == 0 && v[2] == 0) fail(expected);
  return {{v[0], v[1], v[2]}, v[3]};
}

glm::ivec2 Found::imageSize() const {
  constexpr Limits kSide{1, 65536};
  const std::vector<Found> sides = list("[width, height]");
  if (sides.size() != 2) fail("[width, height]");
  return {sides[0].integer(kSide), sides[1].integer(kSide)};
}

double Found::clampedToUnit(double x) const {
  if (kUnit.contain(x)) return x;
  warn(numberText(x) + " is outside 0 to 1 and was clamped");
  return std::clamp(x, 0.0, 1.0);
}

std::optional<std::string> closestName(std::string_view name, const std::vector<std::string>& candidates) {
  constexpr size_t kLongest = 64;  // bounds the work that a hostile name can cause
  if (name.size() > kLongest) return std::nullopt;
  const std::string wanted = lower(name);
  size_t best = std::max<size_t>(1, name.size() / 3) + 1;
  std::optional<std::string> closest;
  for (const std::string& candidate : candidates) {
    const size_t distance = editDistance(wanted, lower(candidate));
    if (distance < best) {
      best = distance;
      closest = candidate;
    }
  }
  return closest;
}

std::string suggestion(std::string_view name, const std::vector<std::string>& candidates) {
  const auto closest = closestName(name, candidates);
  return closest ? "; did you mean " + inQuotes(*closest, '`') + "?" : "";
}

std::string readTextFile(const std::filesystem::path& path) {
  const auto fail = [&](const std::string& why) -> std::string {
    throw Error(inQuotes(path.string()) + ": " + why);
  };
  if (path.native().find('\0') != std::string::npos) return fail("not a file name");
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return fail(error ? error.message() : "not a regular file");
  }
  const auto bytes = std::filesystem::file_size(path, error);
  if (error || bytes > kMaxJsonBytes) return fail("larger than " + std::to_string(kMaxJsonBytes) + " bytes");
  std::string text(bytes, '\0');
  std::ifstream in(path, std::ios::binary);
  if (!in || !in.read(text.data(), std::streamsize(bytes))) return fail("cannot be read");
  return text;
}

}  // namespace gxy
