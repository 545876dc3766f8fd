// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/interpolate_filter.h"

#include <array>

#include "core/analysis/field_values.h"
#include "core/analysis/made_geometry.h"
#include "core/analysis/recorded_fields.h"
#include "core/data/geometry_bytes.h"

namespace gxy {

FilterInfo Interpolate::info() {
  FilterInfo info{
      "Interpolate",
      2,
      "The points of the first input with the values that fields have there, and with the fields "
      "that they had. What is shown is the first field; operators show the others by `array`. "
      "Points outside a field, and in its cells without data, have no value (NaN), and are counted.",
      {{"points", kParticles | kPathLines | kTriangles, "The points."},
       {"fields", kVolumes | kUnstructured, "The fields.", FilterPort::Count::Many}},
      DatasetType::Particles};
  info.makesLike = "points";
  return info;
}

std::vector<KeyRow<Interpolate>> Interpolate::properties() {
  using I = Interpolate;
  return {customKey<I>(
              "component", "integer >= 0",
              "The component of the first field that is shown, if it has several.",
              [](const Found& f, I& i) {
                i.component = f.integer({0, 1023});
              },
              [](const I& i) { return i.component ? OrderedJson(*i.component) : OrderedJson(); })
              .byDefault("the magnitude")};
}

FilterResult Interpolate::run(FilterRun& run) const {
  const Dataset& points = *run.input("points").data;
  const std::vector<FilterSource>& fields = run.inputs().at("fields");
  const FilterSource& first = fields.front();
  const int components = first.data->components();
  GeometryBlock block;
  std::vector<LedgerEntry> memory;
  int number = 0;
  run.begin(0, 1, "values at points");
  agree(run.ranks, [&] {
    checkNames(fields, "Interpolate");
    number = componentOf(components, first.name, component);
    const GeometryBlock& from = points.geometry->block;
    memory.push_back(run.takeMemory("geometry", bytesOf(from) + int64_t(from.points.size() * sizeof(float))));
    block = from;
    block.colors.clear();
    if (!points.geometry->array.empty() && !block.values.empty())
      setField(block, {points.geometry->array, 1, std::move(block.values)});
    block.values.clear();
  });
  FieldValues found = ValueReader(run, first).at(std::array{number}, block.points, run.ranks);
  block.values = std::move(found.values);
  std::span<const FilterSource> further = fields;
  if (components == 1) further = further.subspan(1);
  const std::vector<PointsWithout> without = recordFields(run, further, block, memory);
  if (components == 1) std::erase_if(block.fields, [&](const PointField& f) { return f.name == first.name; });
  FilterResult result;
  LedgerEntry entry = std::move(memory.front());
  result.dataset =
      madeGeometry(run, points.geometry->name, points.geometry->kind, std::move(block), points.partitioning,
                   std::move(entry), nameOfComponent(first.name, components, number));
  result.told = {{"outside", found.outside},
                 {"no data", found.noData},
                 {"fields", toldOfPoints(*result.dataset->geometry)}};
  for (nlohmann::json& field : result.told["fields"])
    for (size_t i = 0; i < further.size(); i++)
      if (field["name"] == further[i].name)
        field.update({{"outside", without[i].outside}, {"no data", without[i].noData}});
  return result;
}

}  // namespace gxy
