// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/interpolate_filter.h"

#include <array>

#include "core/analysis/field_values.h"
#include "core/analysis/made_geometry.h"
#include "core/data/geometry_bytes.h"

namespace gxy {

FilterInfo Interpolate::info() {
  FilterInfo info{
      "Interpolate",
      1,
      "The points of the first input with the values that a field has there. Points outside the field, and "
      "in its cells without data, "
      "have no value (NaN), and are counted.",
      {{"points", kParticles | kPathLines | kTriangles, "The points."}, {"field", kVolumes, "The field."}},
      DatasetType::Particles};
  info.makesLike = "points";
  return info;
}

std::vector<KeyRow<Interpolate>> Interpolate::properties() {
  using I = Interpolate;
  return {customKey<I>(
              "component", "integer >= 0", "The component of a field that has several.",
              [](const Found& f, I& i) {
                i.component = f.integer({0, 1023});
              },
              [](const I& i) { return i.component ? OrderedJson(*i.component) : OrderedJson(); })
              .byDefault("the magnitude")};
}

FilterResult Interpolate::run(FilterRun& run) const {
  const Dataset& points = *run.input("points").data;
  const FilterSource& field = run.input("field");
  GeometryBlock block;
  LedgerEntry memory;
  int number = 0;
  run.begin(0, 1, "values at points");
  agree(run.ranks, [&] {
    number = componentOf(*field.data->volume, field.name, component);
    const GeometryBlock& from = points.geometry->block;
    memory = run.takeMemory("geometry", bytesOf(from) + int64_t(from.points.size() * sizeof(float)));
    block = from;
    block.colors.clear();
  });
  FieldValues found =
      valuesAt(*field.data->volume, *field.data->partitioning, std::array{number}, block.points, run.ranks);
  block.values = std::move(found.values);
  FilterResult result;
  result.dataset = madeGeometry(run, points.geometry->name, points.geometry->kind, std::move(block),
                                points.partitioning, std::move(memory));
  result.told = {{"outside", found.outside}, {"no data", found.noData}};
  return result;
}

}  // namespace gxy
