// SPDX-License-Identifier: Apache-2.0
#include "core/data/shown_array.h"

#include <algorithm>
#include <utility>

#include "core/comm/error.h"
#include "core/comm/error_text.h"
#include "core/data/geometry_bytes.h"

namespace gxy {
namespace {

const PointFieldInfo& infoOf(const OwnedGeometry& geometry, const ShownArray& shown,
                             const std::string& dataset) {
  const auto found = std::find_if(geometry.fields.begin(), geometry.fields.end(),
                                  [&](const PointFieldInfo& f) { return f.name == shown.name; });
  if (found != geometry.fields.end() && (!shown.component || *shown.component < found->components))
    return *found;
  if (found != geometry.fields.end())
    throw Error("dataset " + inQuotes(dataset) + ": component " + std::to_string(*shown.component) +
                " of array " + inQuotes(shown.name) + " was asked for, it has " +
                std::to_string(found->components) + " (counted from 0)");
  std::string list = geometry.array.empty() ? "" : inQuotes(geometry.array);
  if (!geometry.fields.empty()) list += (list.empty() ? "" : ", ") + listOf(geometry.fields);
  throw Error("dataset " + inQuotes(dataset) + ": there is no array " + inQuotes(shown.name) +
              " of points; expected one of those there are: " + (list.empty() ? "none" : list));
}

GeometryBlock blockToShow(const GeometryBlock& from, bool ownValues, const ShownArray& shown) {
  GeometryBlock block;
  block.points = from.points;
  block.normals = from.normals;
  block.radiusValues = from.radiusValues;
  block.triangles = from.triangles;
  block.segments = from.segments;
  block.neighbours = from.neighbours;
  block.ids = from.ids;
  if (ownValues) {
    block.values = from.values;
    block.colors = from.colors;
  } else if (const PointField* field = findField(from.fields, shown.name)) {
    block.values.reserve(block.points.size());
    for (size_t i = 0; i < block.points.size(); i++)
      block.values.push_back(fieldValue(*field, shown.component.value_or(-1), i));
  }
  return block;
}

}  // namespace

bool showsOwnValues(const OwnedGeometry& geometry, const ShownArray& shown) {
  if (shown.name.empty()) return true;
  return shown.name == geometry.array && shown.component.value_or(0) == 0;
}

Range rangeOfShown(const OwnedGeometry& geometry, const ShownArray& shown, const std::string& dataset) {
  if (showsOwnValues(geometry, shown)) return geometry.range;
  const PointFieldInfo& info = infoOf(geometry, shown, dataset);
  return shown.component ? info.ranges.at(size_t(*shown.component)) : info.ranges.back();
}

int64_t bytesToShow(const OwnedGeometry& geometry, const ShownArray& shown) {
  if (showsOwnValues(geometry, shown) && geometry.block.fields.empty()) return 0;
  int64_t fields = 0;
  for (const PointField& f : geometry.block.fields) fields += int64_t(f.values.size() * sizeof(float));
  return bytesOf(geometry.block) - fields + int64_t(geometry.block.points.size() * sizeof(float));
}

std::shared_ptr<const OwnedGeometry> geometryToShow(std::shared_ptr<const OwnedGeometry> geometry,
                                                    const ShownArray& shown, const std::string& dataset) {
  const bool ownValues = showsOwnValues(*geometry, shown);
  if (ownValues && geometry->block.fields.empty()) return geometry;
  auto made = std::make_shared<OwnedGeometry>();
  made->name = geometry->name;
  made->kind = geometry->kind;
  made->range = rangeOfShown(*geometry, shown, dataset);
  made->block = blockToShow(geometry->block, ownValues, shown);
  made->colored = ownValues && geometry->colored;
  made->array = ownValues ? geometry->array : shown.name;
  made->box = geometry->box;
  made->middle = geometry->middle;
  made->spacing = geometry->spacing;
  made->radiusRange = geometry->radiusRange;
  made->primitives = geometry->primitives;
  made->droppedPrimitives = geometry->droppedPrimitives;
  return made;
}

}  // namespace gxy
