// SPDX-License-Identifier: Apache-2.0
#include "core/data/joined.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>

#include "core/comm/error.h"
#include "core/data/block_arrays.h"

namespace gxy {
namespace {

constexpr size_t kMostPoints = std::numeric_limits<uint32_t>::max();

const char* pluralOf(GeometryKind kind) {
  if (kind == GeometryKind::Particles) return "particles: ";
  return kind == GeometryKind::PathLines ? "path lines: " : "triangles: ";
}

using Parts = std::vector<GeometryBlock>;

/// Joins the array that of(part) is of each part.
template <class Of>
auto joinedArray(Parts& parts, Of of) {
  std::remove_reference_t<decltype(of(parts[0]))> all;
  size_t count = 0;
  for (GeometryBlock& part : parts) count += of(part).size();
  all.reserve(count);
  for (GeometryBlock& part : parts) {
    all.insert(all.end(), of(part).begin(), of(part).end());
    of(part) = {};
  }
  return all;
}

void checkAlike(GeometryKind kind, const Parts& parts) {
  const GeometryBlock* first = nullptr;
  size_t points = 0;
  for (const GeometryBlock& part : parts) {
    if (part.points.empty()) continue;
    points += part.points.size();
    if (!first) {
      first = &part;
    } else if (!areAlike(first->fields, part.fields)) {
      throw Error(std::string(pluralOf(kind)) +
                  "parts have different fields, expected the same names and components");
    } else if (first->normals.empty() != part.normals.empty() ||
               first->values.empty() != part.values.empty() || first->colors.empty() != part.colors.empty() ||
               first->radiusValues.empty() != part.radiusValues.empty()) {
      throw Error(
          std::string(pluralOf(kind)) +
          "some parts have normals, values, colours or radii and others have none, expected all alike");
    }
  }
  if (points >= kMostPoints)
    throw Error(std::string(pluralOf(kind)) + "a partition has " + std::to_string(points) +
                " points, counting those that several messages have each time, expected fewer than 2^32 - 1; "
                "use more partitions");
}

/// Makes the indices of each part those of the points of all parts.
void shiftIndices(Parts& parts) {
  uint32_t offset = 0;
  for (GeometryBlock& part : parts) {
    const auto shift = [&](auto& list) {
      for (auto& indices : list)
        for (uint32_t& i : indices) i += offset;
    };
    shift(part.triangles);
    shift(part.segments);
    shift(part.neighbours);
    offset += uint32_t(part.points.size());
  }
}

}  // namespace

GeometryBlock joined(GeometryKind kind, Parts parts, Indices indices) {
  if (parts.size() == 1) return std::move(parts[0]);
  checkAlike(kind, parts);
  std::erase_if(parts, [](const GeometryBlock& part) { return part.points.empty() && part.ids.empty(); });
  GeometryBlock all;
  if (parts.empty()) return all;
  if (indices == Indices::OfPart) shiftIndices(parts);
  all.fields = emptyLike(parts[0].fields);
  forPointArrays(all.fields, [&](auto of, size_t) { of(all) = joinedArray(parts, of); });
  forPrimitiveArrays([&](auto of) { of(all) = joinedArray(parts, of); });
  return all;
}

void sortById(GeometryBlock& block) {
  if (std::is_sorted(block.ids.begin(), block.ids.end())) return;
  std::vector<uint32_t> order(block.ids.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return block.ids[a] < block.ids[b]; });
  const auto apply = [&](auto of, size_t each) {
    auto& array = of(block);
    if (array.empty()) return;
    std::remove_reference_t<decltype(array)> sorted;
    sorted.reserve(array.size());
    for (const uint32_t i : order)
      sorted.insert(sorted.end(), array.begin() + std::ptrdiff_t(i * each),
                    array.begin() + std::ptrdiff_t((i + 1) * each));
    array = std::move(sorted);
  };
  forPointArrays(block.fields, apply);
  apply(
      [](auto& particles) -> auto& { return particles.ids; }, 1);
}

}  // namespace gxy
