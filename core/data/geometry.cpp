// SPDX-License-Identifier: Apache-2.0
#include "core/data/geometry.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "core/comm/error.h"
#include "core/comm/parallel_for.h"
#include "core/data/block_arrays.h"
#include "core/data/geometry_bytes.h"
#include "core/data/joined.h"

namespace gxy {
namespace {

constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

const char* nameOf(GeometryKind kind) {
  switch (kind) {
    case GeometryKind::Particles:
      return "particles";
    case GeometryKind::PathLines:
      return "path lines";
    case GeometryKind::Triangles:
      break;
  }
  return "triangles";
}

[[noreturn]] void fail(GeometryKind kind, const std::string& what) {
  throw Error(std::string(nameOf(kind)) + ": " + what);
}

void appendPoint(GeometryBlock& to, const GeometryBlock& from, uint32_t point) {
  forPointArrays(from.fields, [&](auto of, size_t each) {
    const auto& array = of(from);
    if (array.empty()) return;
    for (size_t i = point * each; i < (point + 1) * each; ++i) of(to).push_back(array[i]);
  });
}

/// Makes room for so many points with the attributes of `like`.
void reservePoints(GeometryBlock& block, const GeometryBlock& like, size_t points) {
  forPointArrays(like.fields, [&](auto of, size_t each) {
    if (!of(like).empty()) of(block).reserve(points * each);
  });
}

void reservePrimitives(GeometryBlock& block, GeometryKind kind, size_t primitives) {
  block.ids.reserve(primitives);
  if (kind == GeometryKind::Triangles) block.triangles.reserve(primitives);
  if (kind != GeometryKind::PathLines) return;
  block.segments.reserve(primitives);
  block.neighbours.reserve(primitives);
}

/// Appends primitive p of `from`. pointOf(index in `from`) returns the point's index in `to`, and adds the
/// point if it is new.
template <typename PointOf>
void appendPrimitive(GeometryBlock& to, const GeometryBlock& from, GeometryKind kind, uint32_t p,
                     PointOf pointOf) {
  to.ids.push_back(from.ids[p]);
  if (kind == GeometryKind::Particles) {
    appendPoint(to, from, p);
  } else if (kind == GeometryKind::PathLines) {
    const auto [a, b] = from.segments[p];
    const auto [before, after] = from.neighbours[p];
    const uint32_t first = pointOf(a), second = pointOf(b), previous = pointOf(before), next = pointOf(after);
    to.segments.push_back({first, second});
    to.neighbours.push_back({previous, next});
  } else {
    const auto [a, b, c] = from.triangles[p];
    const uint32_t first = pointOf(a), second = pointOf(b), third = pointOf(c);
    to.triangles.push_back({first, second, third});
  }
}

/// All attributes of a point but its fields, compared by their bits.
struct PointKey {
  glm::dvec3 position{0};
  glm::vec3 normal{0};
  glm::vec3 look{0};  ///< the colour, or the value and two zeros
  float radius = 0, unused = 0;

  PointKey(const GeometryBlock& block, uint32_t point) : position(block.points[point]) {
    if (!block.normals.empty()) normal = block.normals[point];
    if (!block.values.empty()) look.x = block.values[point];
    if (!block.colors.empty()) look = block.colors[point];
    if (!block.radiusValues.empty()) radius = block.radiusValues[point];
  }
  bool operator==(const PointKey& other) const { return std::memcmp(this, &other, sizeof *this) == 0; }
};
static_assert(sizeof(PointKey) == 56, "compared and hashed as bytes: no padding");

uint64_t hashOf(const PointKey& key) {
  std::array<uint64_t, 7> words;
  std::memcpy(words.data(), &key, sizeof key);
  uint64_t hash = 0;
  for (uint64_t w : words) {
    hash = (hash ^ w) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 32;
  }
  return hash;
}

/// Whether two points of two blocks with fields that are alike have the same attributes and fields.
bool equalPoints(const GeometryBlock& a, uint32_t pointA, const GeometryBlock& b, uint32_t pointB) {
  return PointKey(a, pointA) == PointKey(b, pointB) && equalFields(a.fields, pointA, b.fields, pointB);
}

/// Finds points of a block by content: a hash table of point indices with linear probing, for a limited
/// number of points.
class PointsByContent {
 public:
  PointsByContent(const GeometryBlock& block, size_t points)
      : block_(block), slots_(std::bit_ceil(2 * points), kNone) {}

  /// Returns the index of the point with the content of a point of another block. If there is none, it is kNone, and
  /// the caller sets it to the index of the point that it appends.
  uint32_t& at(const GeometryBlock& from, uint32_t point) {
    size_t i = hashFields(from.fields, point, hashOf(PointKey(from, point)));
    while (slots_[i &= slots_.size() - 1] != kNone && !equalPoints(block_, slots_[i], from, point)) ++i;
    return slots_[i];
  }

 private:
  const GeometryBlock& block_;
  std::vector<uint32_t> slots_;
};

/// Whether segment p of a block continues segment p - 1: they share a point and are each other's neighbours.
bool continuesLine(const GeometryBlock& block, size_t p) {
  return block.segments[p - 1][1] == block.segments[p][0] &&
         block.neighbours[p][0] == block.segments[p - 1][0] &&
         block.neighbours[p - 1][1] == block.segments[p][1];
}

/// Removes the segments of a line, segments [begin, end), whose end repeats their beginning. Appends the
/// others to `left` and updates their neighbours. If all points of the line are equal, its first segment
/// stays: it is drawn as a ball.
void withoutRepeatedPoints(GeometryBlock& block, size_t begin, size_t end, std::vector<uint32_t>& left) {
  const size_t first = left.size();
  for (size_t p = begin; p < end; ++p) {
    const auto [a, b] = block.segments[p];
    if (a != b && !equalPoints(block, a, block, b)) left.push_back(uint32_t(p));
  }
  if (left.size() == first) left.push_back(uint32_t(begin));
  if (left.size() - first == end - begin) return;
  for (size_t i = first; i < left.size(); ++i) {
    const auto [a, b] = block.segments[left[i]];
    block.neighbours[left[i]] = {i > first ? block.segments[left[i - 1]][0] : a,
                                 i + 1 < left.size() ? block.segments[left[i + 1]][1] : b};
  }
}

bool isFinite(glm::dvec3 p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

bool isUsable(const GeometryBlock& block, GeometryKind kind, size_t p) {
  for (uint32_t i : primitivePoints(block, kind, p)) {
    if (!isFinite(block.points[i])) return false;
  }
  if (kind == GeometryKind::PathLines) {
    const auto [before, after] = block.neighbours[p];
    return isFinite(block.points[before]) && isFinite(block.points[after]);
  }
  if (kind == GeometryKind::Triangles) {
    // The triangle is scaled by its longest edge first, so that tiny and huge ones neither underflow nor overflow.
    const auto [a, b, c] = block.triangles[p];
    glm::dvec3 u = block.points[b] - block.points[a], v = block.points[c] - block.points[a];
    double longest = 0;
    for (int axis = 0; axis < 3; ++axis) longest = std::max({longest, std::abs(u[axis]), std::abs(v[axis])});
    return longest > 0 && glm::cross(u / longest, v / longest) != glm::dvec3(0);
  }
  return true;
}

}  // namespace

double radiusValue(const GeometryBlock& block, size_t point) {
  const std::vector<float>& values = block.radiusValues.empty() ? block.values : block.radiusValues;
  return values.empty() ? 0 : double(values[point]);
}

bool hasValues(const Geometry& geometry) {
  return std::any_of(geometry.blocks.begin(), geometry.blocks.end(),
                     [](const auto& each) { return !each.second.values.empty(); });
}

PrimitivePoints primitivePoints(const GeometryBlock& block, GeometryKind kind, size_t p) {
  switch (kind) {
    case GeometryKind::Particles:
      return {{uint32_t(p), 0, 0}, 1};
    case GeometryKind::PathLines:
      return {{block.segments[p][0], block.segments[p][1], 0}, 2};
    case GeometryKind::Triangles:
      break;
  }
  return {block.triangles[p], 3};
}

void validate(const GeometryBlock& block, GeometryKind kind) {
  const size_t points = block.points.size(), primitives = block.ids.size();
  const auto check = [&](const char* what, size_t count, size_t expected) {
    if (count != expected) {
      fail(kind, std::to_string(count) + " " + what + ", expected " + std::to_string(expected));
    }
  };
  check("segments", block.segments.size(), kind == GeometryKind::PathLines ? primitives : 0);
  check("segments with neighbours", block.neighbours.size(), block.segments.size());
  check("triangles", block.triangles.size(), kind == GeometryKind::Triangles ? primitives : 0);
  if (kind == GeometryKind::Particles) check("ids", primitives, points);
  if (!block.normals.empty()) check("normals", block.normals.size(), points);
  if (!block.values.empty()) check("values", block.values.size(), points);
  if (!block.colors.empty()) check("colours", block.colors.size(), points);
  if (!block.radiusValues.empty()) check("values of radii", block.radiusValues.size(), points);
  if (!block.values.empty() && !block.colors.empty()) fail(kind, "values and colours, expected one of them");
  try {
    validateFields(block.fields, points);
  } catch (const Error& e) {
    fail(kind, e.what());
  }
  if (points >= kNone)
    fail(kind, std::to_string(points) + " points in one block, expected fewer than 2^32 - 1");
  const auto checkIndices = [&](const auto& list) {
    for (size_t p = 0; p < list.size(); ++p) {
      for (uint32_t i : list[p]) {
        if (i >= points) {
          fail(kind, "primitive " + std::to_string(block.ids[p]) + " refers to point " + std::to_string(i) +
                         ", expected fewer than " + std::to_string(points));
        }
      }
    }
  };
  checkIndices(block.triangles);
  checkIndices(block.segments);
  checkIndices(block.neighbours);
}

GeometryBlock subset(const GeometryBlock& block, GeometryKind kind, std::span<const uint32_t> primitives,
                     const Advance& advance) {
  GeometryBlock chosen;
  chosen.fields = emptyLike(block.fields);
  reservePrimitives(chosen, kind, primitives.size());
  if (kind == GeometryKind::Particles) reservePoints(chosen, block, primitives.size());
  const auto append = [&](auto&& numberOf) {
    for (size_t i = 0; i < primitives.size(); ++i) {
      tell(advance, i, primitives.size());
      appendPrimitive(chosen, block, kind, primitives[i], [&](uint32_t point) {
        uint32_t& number = numberOf(point);
        if (number == kNone) {
          number = uint32_t(chosen.points.size());
          appendPoint(chosen, block, point);
        }
        return number;
      });
    }
  };
  if (primitives.size() > block.points.size() / 16) {
    std::vector<uint32_t> numbers(block.points.size(), kNone);
    append([&](uint32_t point) -> uint32_t& { return numbers[point]; });
  } else {  // For many small pieces, a table of all points each time would take longer than the pieces themselves.
    std::unordered_map<uint32_t, uint32_t> numbers;
    append([&](uint32_t point) -> uint32_t& { return numbers.try_emplace(point, kNone).first->second; });
  }
  return chosen;
}

GeometryBlock merged(GeometryKind kind, std::span<const GeometryBlock> parts, const Advance& advance) {
  return merged(kind, joined(kind, {parts.begin(), parts.end()}), advance);
}

GeometryBlock merged(GeometryKind kind, GeometryBlock&& parts, const Advance& advance) {
  GeometryBlock all = std::move(parts);
  const auto twice = [&](uint64_t id) {
    fail(kind, "primitive " + std::to_string(id) + " comes twice, expected each id once");
  };
  if (kind == GeometryKind::Particles) {
    advance(0);
    sortById(all);
    const auto same = std::adjacent_find(all.ids.begin(), all.ids.end());
    if (same != all.ids.end()) twice(*same);
    return all;
  }
  std::vector<uint32_t> order(all.ids.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto before = [&](uint32_t a, uint32_t b) { return all.ids[a] < all.ids[b]; };
  if (!std::is_sorted(order.begin(), order.end(), before)) std::sort(order.begin(), order.end(), before);
  for (size_t i = 1; i < order.size(); ++i)
    if (all.ids[order[i]] == all.ids[order[i - 1]]) twice(all.ids[order[i]]);
  GeometryBlock block;
  block.fields = emptyLike(all.fields);
  reservePrimitives(block, kind, order.size());
  reservePoints(block, all, all.points.size());
  PointsByContent byContent(block, all.points.size());
  std::vector<uint32_t> indices(all.points.size(), kNone);  // saves a lookup by content at each further use
  for (size_t i = 0; i < order.size(); ++i) {
    tell(advance, i, order.size());
    appendPrimitive(block, all, kind, order[i], [&](uint32_t point) {
      if (indices[point] == kNone) {
        uint32_t& index = byContent.at(all, point);
        if (index == kNone) {
          index = uint32_t(block.points.size());
          appendPoint(block, all, point);
        }
        indices[point] = index;
      }
      return indices[point];
    });
  }
  return block;
}

int64_t dropUnusable(GeometryBlock& block, GeometryKind kind) {
  std::vector<uint32_t> usable;
  if (kind == GeometryKind::PathLines) {
    for (size_t begin = 0, end = 0; begin < block.segments.size(); begin = end) {
      for (end = begin + 1; end < block.segments.size() && continuesLine(block, end);) ++end;
      withoutRepeatedPoints(block, begin, end, usable);
    }
  } else {
    std::atomic<bool> all = true;
    parallelFor(
        size_t(0), block.ids.size(),
        [&](size_t p) {
          if (!isUsable(block, kind, p)) all = false;
        },
        [](double) {});
    if (all) return 0;
    usable.resize(block.ids.size());
    std::iota(usable.begin(), usable.end(), 0u);
  }
  std::erase_if(usable, [&](uint32_t p) { return !isUsable(block, kind, p); });
  const int64_t dropped = int64_t(block.ids.size() - usable.size());
  if (dropped > 0) block = subset(block, kind, usable);
  return dropped;
}

Box boxOf(const GeometryBlock& block) {
  Box box;
  for (const glm::dvec3& p : block.points) box.extend(p);
  return box;
}

Range rangeOf(const GeometryBlock& block) {
  Range range;
  for (float v : block.values) range.extend(v);
  return range;
}

bool repeatsValues(const GeometryBlock& block, const PointField& field, const std::string& array) {
  return !block.values.empty() && field.components == 1 && field.name == array;
}

std::optional<Range> radiusRangeOf(const GeometryBlock& block) {
  if (block.radiusValues.empty()) return {};
  Range range;
  for (float v : block.radiusValues) range.extend(v);
  return range;
}

int64_t bytesOf(const Geometry& geometry) {
  int64_t sum = 0;
  for (const auto& [partition, block] : geometry.blocks) sum += bytesOf(block);
  return sum;
}

}  // namespace gxy
