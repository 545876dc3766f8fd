// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "core/scene/schema.h"

namespace gxy {
namespace {

constexpr unsigned bit(VisType type) { return 1u << unsigned(type); }
constexpr unsigned kVolume = bit(VisType::Volume);
constexpr unsigned kGeometry = ~kVolume;
constexpr unsigned kRound = bit(VisType::Particles) | bit(VisType::PathLines);

const char* typeName(VisType type) {
  constexpr const char* kNames[] = {"Volume", "Particles", "PathLines", "Triangles"};
  return kNames[unsigned(type)];
}

// What took the place of operators of the earlier Galaxy.
constexpr const char* kIsosurfaceEntry =
    R"json({"filter": "IsosurfaceSampler", "inputs": {"field": DATASET}, "isovalue": VALUE})json";
constexpr const char* kGradientEntry =
    R"json({"filter": "IsosurfaceSampler", "inputs": {"field": GRADIENT}, "isovalue": VALUE}, where GRADIENT is )json"
    R"json({"filter": "Derive", "inputs": {"f": DATASET}, "expression": "mag(grad(f))"})json";

void readType(const Found& found, Vis& vis) {
  std::string name = found.text();
  if (name.ends_with("Vis")) name.resize(name.size() - 3);
  if (name == "IsoSampler" || name == "GradientSampler") {
    found.context.fail(found.value.at, inQuotes(found.key, '`') + ": " + inQuotes(found.text()) +
                                           " samples data, which an entry of `Datasets` does now: " +
                                           (name == "IsoSampler" ? kIsosurfaceEntry : kGradientEntry));
  }
  if (name == "Volume") {
    vis.type = VisType::Volume;
  } else if (name == "Particles") {
    vis.type = VisType::Particles;
  } else if (name == "Triangles" || name == "Surface") {
    vis.type = VisType::Triangles;
  } else if (name == "PathLines") {
    vis.type = VisType::PathLines;
    vis.radius0 = -1, vis.radius1 = 1, vis.value0 = 0, vis.value1 = 1;
  } else {
    found.fail("Volume, Particles, PathLines or Triangles (or Surface), with or without the ending Vis");
  }
}

void readDataset(const Found& found, Vis& vis) {
  vis.dataset = found.text();
  const auto& all = found.context.datasets;
  if (all.empty()) return;
  const auto it =
      std::find_if(all.begin(), all.end(), [&](const DatasetSpec& d) { return d.name == vis.dataset; });
  if (it == all.end()) {
    std::vector<std::string> names;
    for (const DatasetSpec& d : all) names.push_back(d.name);
    found.warn("no dataset " + inQuotes(vis.dataset) + " in this file" + suggestion(vis.dataset, names));
  } else if (it->typeIsKnown && unsigned(it->type) != unsigned(vis.type)) {
    found.fail(std::string("a dataset of type ") + typeName(vis.type));
  }
}

void rejectKey(const Found& found, Vis&) {
  found.context.fail(found.value.at, inQuotes(found.key, '`') +
                                         ": internal keys mean nothing outside one server; "
                                         "expected `dataset` with the dataset's name");
}

void readComponent(const Found& found, Vis& vis) {
  if (vis.type != VisType::Volume && vis.array.empty())
    found.warn("it has no effect without `array` on an operator of this type");
  if (found.value.string() && *found.value.string() == "magnitude") return vis.component.reset();
  if (!found.value.number()) found.fail("an integer >= 0 or \"magnitude\"");
  vis.component = found.integer(kNonNegative);
}

constexpr const char *kFlatCells = "flat", *kSmoothCells = "smooth";

void readCells(const Found& found, Vis& vis) {
  const std::string& how = found.text();
  if (how != kFlatCells && how != kSmoothCells) found.fail("\"flat\" or \"smooth\"");
  vis.cells = how == kFlatCells ? CellsShown::Flat : CellsShown::Smooth;
}

void readExtinctionMap(const Found& found, Vis& vis) {
  if (found.object.find("opacitymap")) {
    found.context.fail(found.value.at, "`extinctionmap`: given beside `opacitymap`; expected one of them");
  }
  vis.opacitymap = readOpacityMap(found, true);
}

void readDataRange(const Found& found, Vis& vis) {
  const std::string expected = "[min, max] with min <= max, or \"data\"";
  vis.rangeOfData = found.value.string() && *found.value.string() == "data";
  if (vis.rangeOfData) return;
  const std::vector<double> v = found.numbers(2, 2, expected);
  if (v[0] > v[1]) found.fail(expected);
  vis.dataRange = {v[0], v[1]};
}

void readRadius(const Found& found, Vis& vis) {
  vis.radiusOfData = found.value.string() && *found.value.string() == "auto";
  if (vis.radiusOfData) return;
  if (!found.value.number()) found.fail("a number or \"auto\"");
  vis.radius0 = vis.radius1 = found.number();
  vis.value0 = vis.value1 = 0;
}

std::vector<Plane> planes(const Found& found) {
  std::vector<Plane> out;
  for (const Found& item : found.list("a list of [a, b, c, d]")) out.push_back(item.plane());
  return out;
}

template <class T>
OrderedJson orAbsent(const std::optional<T>& value) {
  return value ? OrderedJson(*value) : OrderedJson();
}

OrderedJson orAbsent(const std::vector<double>& values) {
  return values.empty() ? OrderedJson() : OrderedJson(values);
}

using V = const Vis&;
using F = const Found&;

std::vector<KeyRow<Vis>> whatKeys() {
  return {
      customKey<Vis>("type", "Volume, Particles, PathLines or Triangles; also with the ending Vis",
                     "What kind of operator this is. `Surface` and `SurfaceVis` mean Triangles.", readType,
                     [](V v) { return OrderedJson(typeName(v.type)); })
          .require(),
      customKey<Vis>("dataset", "text", "Name of the dataset to look at.", readDataset,
                     [](V v) { return OrderedJson(v.dataset); })
          .require(),
      customKey<Vis>("key", "-", "Not accepted: the earlier Galaxy's internal number of a dataset.",
                     rejectKey)
          .byDefault("-")
          .advanced(),
      textKey("array", &Vis::array,
              "Which field of the points gives the values, and the radii unless the dataset has a `radius "
              "array`. "
              "Filters and the key `fields` of datasets give points several.")
          .only(kGeometry)
          .byDefault("the dataset's values"),
      customKey<Vis>("component", "integer >= 0 or \"magnitude\"",
                     "Component of a volume, or of an `array`, that has several.", readComponent,
                     [](V v) { return orAbsent(v.component); })
          .byDefault("magnitude"),
      flagKey("volume rendering", &Vis::volumeRendering,
              "March through the volume; combines with `isovalues` and `slices`.")
          .only(kVolume),
      customKey<Vis>(
          "cells", "\"flat\" or \"smooth\"",
          "How an unstructured volume whose data are those of cells is shown: each cell in its own value, or "
          "mixed between averages at points. Isosurfaces are always those of the averages.",
          readCells,
          [](V v) { return v.cells == CellsShown::Smooth ? OrderedJson(kSmoothCells) : OrderedJson(); })
          .only(kVolume)
          .byDefault("`\"flat\"`")
          .advanced(),
  };
}

std::vector<KeyRow<Vis>> mapKeys() {
  return {
      customKey<Vis>(
          "colormap", "list of [value, r, g, b], or text",
          "Colour by value. Text: a shipped map (Viridis, Inferno, Cool to Warm, Turbo, Gray), a ParaView "
          "JSON preset file, or \"default\". Without effect on geometry that has colours of its own.",
          [](F f, Vis& v) { readColorMap(f, v); }, [](V v) { return toJson(v.colormap); })
          .alias({"transfer function"}),
      customKey<Vis>(
          "nan color", "[r, g, b] of 0 to 1",
          "Colour of geometry where its values are NaN. Volumes, their slices and isosurfaces end there.",
          [](F f, Vis& v) {
            const glm::dvec3 color(f.color());
            if (v.type != VisType::Volume) v.colormap.nan = color;
          },
          [](V v) { return v.colormap.nan ? toJson(*v.colormap.nan) : OrderedJson(); })
          .only(kGeometry)
          .byDefault("`NanColor` of a preset file, else the map's first colour")
          .advanced(),
      customKey<Vis>(
          "opacitymap", "list of [value, opacity 0 to 1]",
          "Opacity by value, of a slab one `reference length` thick. Surfaces have `opacity`.",
          [](F f, Vis& v) { v.opacitymap = readOpacityMap(f, false); },
          [](V v) { return v.opacitymap.extinction ? OrderedJson() : toJson(v.opacitymap); })
          .only(kVolume)
          .with("volume rendering", &Vis::volumeRendering),
      customKey<Vis>("extinctionmap", "list of [value, extinction >= 0]",
                     "Instead of `opacitymap`: extinction by value, per world unit.", readExtinctionMap,
                     [](V v) { return v.opacitymap.extinction ? toJson(v.opacitymap) : OrderedJson(); })
          .only(kVolume)
          .with("volume rendering", &Vis::volumeRendering)
          .byDefault("-")
          .advanced(),
      customKey<Vis>(
          "data range", "[min, max] or \"data\"",
          "Values onto which the ends of each map are stretched. \"data\": those of the data, of the first "
          "step shown; later steps widen the range.",
          readDataRange, [](V v) { return v.rangeOfData ? OrderedJson("data") : orAbsent(v.dataRange); })
          .byDefault("the maps' own values"),
      customKey<Vis>(
          "reference length", "number > 0", "Thickness that `opacitymap` speaks of, world units.",
          [](F f, Vis& v) { v.referenceLength = f.number(kPositive); },
          [](V v) { return orAbsent(v.referenceLength); })
          .only(kVolume)
          .with("volume rendering", &Vis::volumeRendering)
          .byDefault("smallest cell spacing")
          .advanced(),
  };
}

std::vector<KeyRow<Vis>> surfaceKeys() {
  return {
      customKey<Vis>(
          "opacity", "number 0 to 1", "Opacity of surfaces: isosurfaces, slices, geometry.",
          [](F f, Vis& v) { v.opacity = f.clampedToUnit(f.number()); },
          [](V v) { return OrderedJson(v.opacity); }),
      flagKey("two sided", &Vis::twoSided, "Normals are turned to face the viewer.").advanced(),
      customKey<Vis>(
          "clip planes", "list of [a, b, c, d]", "Only what has a\\*x + b\\*y + c\\*z >= d for all is shown.",
          [](F f, Vis& v) { v.clipPlanes = planes(f); }, [](V v) { return toJson(v.clipPlanes); })
          .byDefault("none"),
      customKey<Vis>(
          "isovalues", "list of numbers", "Values of isosurfaces; with slices, at most 65535.",
          [](F f, Vis& v) { v.isovalues = f.numbers(0, kMaxJsonValues, "a list of numbers"); },
          [](V v) { return orAbsent(v.isovalues); })
          .only(kVolume)
          .byDefault("none"),
      customKey<Vis>(
          "slices", "list of [a, b, c, d]", "Slices on the planes a\\*x + b\\*y + c\\*z = d.",
          [](F f, Vis& v) { v.slices = planes(f); }, [](V v) { return toJson(v.slices); })
          .only(kVolume)
          .byDefault("none"),
      customKey<Vis>("plane", "[a, b, c, d]", "One slice more.",
                     [](F f, Vis& v) { v.slices.push_back(f.plane()); })
          .only(kVolume)
          .byDefault("-")
          .advanced(),
  };
}

std::vector<KeyRow<Vis>> radiusKeys() {
  return {
      customKey<Vis>(
          "radius", "number or \"auto\"",
          "Constant radius, world units; short for the four below. \"auto\": three tenths of the mean "
          "spacing of the data's points.",
          readRadius, [](V v) { return v.radiusOfData ? OrderedJson("auto") : OrderedJson(); })
          .only(kRound)
          .byDefault("-"),
      numberKey("radius0", &Vis::radius0, kAny, "Radius at `value0`; <= 0 draws nothing.")
          .only(kRound)
          .byDefault("0.025; PathLines: -1")
          .advanced(),
      numberKey("radius1", &Vis::radius1, kAny, "Radius at `value1`; linear between, constant outside.")
          .only(kRound)
          .byDefault("0; PathLines: 1")
          .advanced(),
      numberKey("value0", &Vis::value0, kAny,
                "See `radius0`. Where both values are equal, `radius0` is constant.")
          .only(kRound)
          .byDefault("0")
          .advanced(),
      numberKey("value1", &Vis::value1, kAny, "See `radius1`.")
          .only(kRound)
          .byDefault("0; PathLines: 1")
          .advanced(),
  };
}

Schema<Vis> makeSchema() {
  Schema<Vis> schema{"operator", whatKeys()};
  for (auto&& keys : {mapKeys(), surfaceKeys(), radiusKeys()}) {
    schema.keys.insert(schema.keys.end(), keys.begin(), keys.end());
  }
  return schema;
}

}  // namespace

const Schema<Vis>& operatorSchema() {
  static const Schema<Vis> schema = makeSchema();
  return schema;
}

}  // namespace gxy
