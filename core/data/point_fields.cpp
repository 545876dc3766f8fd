// SPDX-License-Identifier: Apache-2.0
#include "core/data/point_fields.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/comm/error.h"
#include "core/comm/error_text.h"

namespace gxy {

float fieldValue(const PointField& field, int component, size_t point) {
  const float* values = field.values.data() + point * size_t(field.components);
  if (component >= 0 || field.components == 1) return values[std::max(component, 0)];
  double sum = 0;
  for (int c = 0; c < field.components; c++) sum += double(values[c]) * double(values[c]);
  return float(std::sqrt(sum));
}

const PointField* findField(std::span<const PointField> fields, const std::string& name) {
  const auto found =
      std::find_if(fields.begin(), fields.end(), [&](const PointField& f) { return f.name == name; });
  return found == fields.end() ? nullptr : &*found;
}

std::vector<PointField> emptyLike(std::span<const PointField> fields) {
  std::vector<PointField> empty;
  for (const PointField& f : fields) empty.push_back({f.name, f.components, {}});
  return empty;
}

bool areAlike(std::span<const PointField> a, std::span<const PointField> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const PointField& x, const PointField& y) {
    return x.name == y.name && x.components == y.components;
  });
}

void appendFields(std::vector<PointField>& to, std::span<const PointField> from, size_t point) {
  for (size_t f = 0; f < from.size(); f++) {
    const auto n = size_t(from[f].components);
    const float* first = from[f].values.data() + point * n;
    to[f].values.insert(to[f].values.end(), first, first + n);
  }
}

bool equalFields(std::span<const PointField> a, size_t pointA, std::span<const PointField> b, size_t pointB) {
  for (size_t f = 0; f < a.size(); f++) {
    const auto n = size_t(a[f].components);
    if (std::memcmp(a[f].values.data() + pointA * n, b[f].values.data() + pointB * n, n * sizeof(float)) != 0)
      return false;
  }
  return true;
}

uint64_t hashFields(std::span<const PointField> fields, size_t point, uint64_t hash) {
  for (const PointField& f : fields) {
    const auto n = size_t(f.components);
    for (size_t c = 0; c < n; c++) {
      uint32_t bits;
      std::memcpy(&bits, &f.values[point * n + c], sizeof bits);
      hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 32;
    }
  }
  return hash;
}

std::string listOf(std::span<const PointFieldInfo> fields) {
  std::string list;
  for (const PointFieldInfo& f : fields) {
    list += (list.empty() ? "" : ", ") + inQuotes(f.name);
    if (f.components > 1) list += " (" + std::to_string(f.components) + " components)";
  }
  return list.empty() ? "none" : list;
}

void validateFields(std::span<const PointField> fields, size_t points) {
  if (fields.size() > kMostPointFields)
    throw Error(std::to_string(fields.size()) + " fields of points, expected at most " +
                std::to_string(kMostPointFields));
  for (size_t f = 0; f < fields.size(); f++) {
    const PointField& field = fields[f];
    if (field.name.empty()) throw Error("field " + std::to_string(f) + " of points has no name");
    if (findField(fields.first(f), field.name))
      throw Error("field " + inQuotes(field.name) + " of points is there twice, expected different names");
    if (field.components < 1 || field.components > kMostPointComponents)
      throw Error("field " + inQuotes(field.name) + " of points has " + std::to_string(field.components) +
                  " components, expected 1 to " + std::to_string(kMostPointComponents));
    if (field.values.size() != points * size_t(field.components))
      throw Error("field " + inQuotes(field.name) + " of points has " + std::to_string(field.values.size()) +
                  " values, expected " + std::to_string(points * size_t(field.components)));
  }
}

}  // namespace gxy
