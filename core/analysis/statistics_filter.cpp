// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/statistics_filter.h"

#include <cmath>

#include "core/analysis/derive_filter.h"
#include "core/analysis/field_reader.h"
#include "core/analysis/statistics.h"
#include "core/comm/error.h"
#include "core/data/shown_array.h"

namespace gxy {
namespace {

using nlohmann::json;

json finite(double x) { return std::isfinite(x) ? json(x) : json(); }

enum class Of { Grid, Mesh, Points, Lines };

json described(const ExtremeValue& e, Of of) {
  if (e.index < 0) return nullptr;
  json told{{"value", e.value}, {"position", {e.position.x, e.position.y, e.position.z}}};
  if (of != Of::Mesh) told["index"] = e.index;
  return told;
}

json described(const Statistics& s, Of of) {
  json told{{"count", s.count},
            {"no data", s.noData},
            {"least", described(s.least, of)},
            {"largest", described(s.largest, of)},
            {"sum", finite(s.sum)},
            {"mean", finite(s.mean)},
            {"variance", finite(s.variance)}};
  if (of == Of::Grid || of == Of::Lines) told["integral"] = finite(s.integral);
  if (of == Of::Lines) told["length"] = finite(s.length);
  if (!s.histogram.empty())
    told["histogram"] = {{"range", {finite(s.binRange.min), finite(s.binRange.max)}},
                         {"counts", s.histogram}};
  if (!s.quantiles.empty()) {
    told["quantiles"] = json::array();
    for (const double q : s.quantiles) told["quantiles"].push_back(finite(q));
  }
  return told;
}

}  // namespace

FilterInfo StatisticsFilter::info() {
  return {"Statistics",
          1,
          "Numbers of a field, or of the values of geometry: `count`, `no data`, `least` and `largest` with "
          "their positions, `sum`, `mean`, `variance`, "
          "`integral`, `length` of lines, a histogram and exact quantiles. Of an unstructured volume each "
          "point counts once, or each "
          "cell if the values are those of cells (`values` says which), whatever its size, and there is no "
          "`integral`.",
          {{"field", kVolumes | kUnstructured | kParticles | kPathLines | kTriangles, "Whose values."},
           {"any name", kVolumes, "A field; `where` calls it by this name. It calls the input `field` so.",
            FilterPort::Count::AnyName}},
          std::nullopt};
}

std::vector<KeyRow<StatisticsFilter>> StatisticsFilter::properties() {
  using S = StatisticsFilter;
  return {
      textKey("array", &S::array, "Of geometry: which field of its points.").byDefault("its values"),
      customKey<S>(
          "component", "integer >= 0", "The component of a field, or of an `array`, that has several.",
          [](const Found& f, S& s) {
            s.component = f.integer({0, 1023});
          },
          [](const S& s) { return s.component ? OrderedJson(*s.component) : OrderedJson(); })
          .byDefault("the magnitude"),
      customKey<S>(
          "where", "text",
          "A logical [expression](derived-fields.md): only points of the grid where it holds count.",
          [](const Found& f, S& s) { s.where = readExpression(f); },
          [](const S& s) { return s.where.empty() ? OrderedJson() : OrderedJson(s.where); })
          .byDefault("everywhere"),
      integerKey("histogram", &S::histogram, {0, StatisticsOptions::kMostBins},
                 "The number of bins of the histogram; 0: none."),
      customKey<S>(
          "histogram range", "[least, largest]", "The ends of the histogram.",
          [](const Found& f, S& s) {
            const auto r = f.numbers(2, 2, "[least, largest]");
            if (!(r[0] < r[1])) f.fail("[least, largest] with least < largest");
            s.range = Range{r[0], r[1]};
          },
          [](const S& s) {
            return s.range ? OrderedJson{s.range->min, s.range->max} : OrderedJson();
          })
          .byDefault("the least and the largest value"),
      customKey<S>(
          "quantiles", "list of numbers 0 to 1",
          "Fractions of the values, at most 100, whose quantiles are told.",
          [](const Found& f, S& s) {
            for (const Found& item : f.list("a list of numbers 0 to 1")) {
              if (s.quantiles.size() == 100) item.fail("at most 100 fractions");
              s.quantiles.push_back(item.number(kUnit));
            }
          },
          [](const S& s) { return s.quantiles.empty() ? OrderedJson() : OrderedJson(s.quantiles); })
          .byDefault("none"),
  };
}

FilterResult StatisticsFilter::run(FilterRun& run) const {
  const FilterSource& source = run.input("field");
  StatisticsOptions options{0, histogram, range, quantiles};
  FilterResult result;
  run.begin(0, 1, "statistics");
  if (source.data->geometry) {
    const ShownArray shown{array, component};
    std::shared_ptr<const OwnedGeometry> geometry = source.data->geometry;
    LedgerEntry memory;
    agree(run.ranks, [&] {
      if ((component && array.empty()) || !where.empty())
        throw Error("Statistics: `component` without `array`, and `where`, are for fields on a grid, and " +
                    inQuotes(source.name) + " is geometry");
      if (showsOwnValues(*geometry, shown)) return;
      memory = run.takeMemory("geometry", bytesToShow(*geometry, shown));
      geometry = geometryToShow(geometry, shown, source.name);
    });
    const GeometryKind kind = geometry->kind;
    result.told = described(geometryStatistics(geometry->block, kind, run.ranks, options),
                            kind == GeometryKind::PathLines ? Of::Lines : Of::Points);
    return result;
  }
  if (const Mesh* mesh = source.data->mesh.get()) {
    agree(run.ranks, [&] {
      if (!array.empty() || !where.empty())
        throw Error("Statistics: `array` is for fields of points, and `where` for fields on a grid, and " +
                    inQuotes(source.name) + " is an unstructured volume");
      const int number = componentOf(mesh->components, source.name, component);
      options.component = number < 0 ? mesh->components : number;
    });
    result.told = described(meshStatistics(*mesh, *source.data->partitioning, run.ranks, options), Of::Mesh);
    result.told["values"] = mesh->ofCells ? "cells" : "points";
    return result;
  }
  const Volume& volume = *source.data->volume;
  std::optional<Expression> condition;
  agree(run.ranks, [&] {
    if (!array.empty())
      throw Error("Statistics: `array` is for fields of points, and " + inQuotes(source.name) +
                  " is a volume");
    const int number = componentOf(volume.components, source.name, component);
    options.component = number < 0 ? volume.components : number;
    if (!where.empty()) condition.emplace(where);
  });
  WorkingMemory working(run);
  std::shared_ptr<Volume> holds;
  if (condition) {
    DeriveOptions derive;
    derive.time = run.time();
    derive.memory = working.teller();
    holds = conditionOf(*condition, fieldsOf(run, "Statistics"), run.ranks, derive);
  }
  result.told = described(
      fieldStatistics(volume, *source.data->partitioning, run.ranks, options, holds.get()), Of::Grid);
  return result;
}

}  // namespace gxy
