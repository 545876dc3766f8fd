// SPDX-License-Identifier: Apache-2.0
// Named fields at the points of geometry, besides the values that are shown.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/data/box.h"

namespace gxy {

/// The most fields that points can have, and the most components of one.
inline constexpr size_t kMostPointFields = 256;
inline constexpr int kMostPointComponents = 1024;

/// A field at the points of a block: point i has the values [i * components, (i + 1) * components). NaN: there is none.
struct PointField {
  std::string name;
  int components = 1;
  std::vector<float> values;
  bool operator==(const PointField&) const = default;
};

/// What is known of a field on every rank.
struct PointFieldInfo {
  std::string name;
  int components = 1;
  std::vector<Range> ranges;  ///< of each component, then of the magnitude if there are several
  bool operator==(const PointFieldInfo&) const = default;
};

/// The number of ranges of a field, and of the parts of it that can be shown.
inline size_t partsOf(int components) { return components == 1 ? 1 : size_t(components) + 1; }

/// Returns a component of a field at a point, or the magnitude of all for a negative one. Of one component, the
/// magnitude is the value itself, with its sign.
float fieldValue(const PointField& field, int component, size_t point);

/// Returns the field of this name; null if there is none.
const PointField* findField(std::span<const PointField> fields, const std::string& name);

/// Returns fields of the same names and components without points.
std::vector<PointField> emptyLike(std::span<const PointField> fields);

/// Whether two blocks have fields of the same names and components, in the same order.
bool areAlike(std::span<const PointField> a, std::span<const PointField> b);

/// Appends the values of point `point` to fields that are alike.
void appendFields(std::vector<PointField>& to, std::span<const PointField> from, size_t point);

/// Whether two points have the same bits in all fields. The fields are alike.
bool equalFields(std::span<const PointField> a, size_t pointA, std::span<const PointField> b, size_t pointB);

/// Mixes the values of a point into a hash.
uint64_t hashFields(std::span<const PointField> fields, size_t point, uint64_t hash);

/// The names and components of fields, to be told to users: `speed, velocity (3)`; "none" if there are none.
std::string listOf(std::span<const PointFieldInfo> fields);

/// Throws Error (what, and what is expected) unless names are different and not empty, and each field has the values of so many points.
void validateFields(std::span<const PointField> fields, size_t points);

}  // namespace gxy
