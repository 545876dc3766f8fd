// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>

#include "core/scene/dataset_type.h"
#include "core/scene/filter_schema.h"
#include "core/scene/schema.h"

namespace gxy {
namespace {

DatasetSpec readDataset(const Found& item) {
  if (item.value.find("filter")) return readFilterEntry(item);
  DatasetSpec dataset;
  readObject(item.context, item.value, datasetSchema(), dataset);
  if (dataset.name.empty()) dataset.name = dataset.filename;
  if (dataset.name.empty())
    item.context.fail(item.value.at, "dataset without `filename` and without `name`; expected one of them");
  return dataset;
}

void readDatasets(const Found& found, State& state) {
  std::vector<std::string> names;
  readOneOrMany(found, [&](const Found& item) {
    state.datasets.push_back(readDataset(item));
    if (const std::string& name = state.datasets.back().name; !name.empty()) names.push_back(name);
  });
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  if (twice != names.end()) {
    found.context.fail(found.value.at,
                       "two datasets named " + inQuotes(*twice) + "; expected each name once");
  }
  found.context.datasets = state.datasets;
}

void readOldLighting(const Found& found, RenderSettings&) {
  found.context.warn(found.value.at,
                     "deprecated: `Lighting` of the renderer is used for visualizations that have none; "
                     "write it inside each visualization");
  found.context.oldLighting.emplace();
  readObject(found.context, found.value, lightingSchema(), *found.context.oldLighting);
}

/// A key of the earlier Galaxy that nothing needs any more.
KeyRow<RenderSettings> obsoleteKey(std::string name, std::string why) {
  return customKey<RenderSettings>(name, "number", "Deprecated, not used: " + why + ".",
                                   [=](const Found& found, RenderSettings&) {
                                     found.number();
                                     found.warn("deprecated and not used: " + why);
                                   })
      .byDefault("-");
}

/// A ray names the surface that it starts on by its operator and its number in that operator, in 16 bits each.
constexpr size_t kMostSurfaces = 65535;

Vis readOperator(const Found& item, const JsonValue& value) {
  Vis vis;
  readObject(item.context, value, operatorSchema(), vis);
  if (const size_t surfaces = vis.isovalues.size() + vis.slices.size(); surfaces > kMostSurfaces)
    item.context.fail(value.at, inQuotes(item.key, '`') + ": expected at most " +
                                    std::to_string(kMostSurfaces) + " isovalues and slices together, found " +
                                    std::to_string(surfaces));
  if (vis.type == VisType::Volume && !vis.volumeRendering && vis.isovalues.empty() && vis.slices.empty())
    item.warn("shows nothing; a Volume needs `volume rendering`, `isovalues` or `slices`");
  return vis;
}

void readOperators(const Found& found, Visualization& visualization) {
  for (const Found& item : found.list("a list of operators")) {
    if (visualization.operators.size() == kMostSurfaces)
      item.fail("at most " + std::to_string(kMostSurfaces) + " operators");
    const JsonValue* value = &item.value;
    if (std::holds_alternative<std::string>(item.value.value)) {
      const auto& named = item.context.operators;
      const auto known = named.find(item.text());
      if (known == named.end()) {
        std::vector<std::string> names;
        for (const auto& [name, op] : named) names.push_back(name);
        item.fail("an operator, or the name of one of `Operators`" + suggestion(item.text(), names));
      }
      value = &known->second.value;
      item.context.namedValues += known->second.values;
      if (item.context.namedValues > kMaxJsonValues)
        item.fail("at most " + std::to_string(kMaxJsonValues) + " values in all operators that are named");
    }
    visualization.operators.push_back(readOperator(item, *value));
  }
}

/// How many values a value has, with long texts as several.
size_t valuesIn(const JsonValue& value) {
  size_t count = 1;
  if (const auto* text = value.string()) count += text->size() / sizeof(JsonValue);
  if (const auto* items = value.array())
    for (const JsonValue& item : *items) count += valuesIn(item);
  if (const auto* members = value.object())
    for (const JsonMember& member : *members) count += valuesIn(member.value);
  return count;
}

void readNamedOperators(const Found& found, State&) {
  readOneOrMany(found, [&](const Found& item) {
    const JsonMember* name = item.value.find("name");
    if (!name)
      item.context.fail(item.value.at, inQuotes(item.key, '`') +
                                           ": `name` is missing, expected what visualizations call it");
    const std::string& text = Found{item.context, "name", name->value, item.value}.text();
    JsonValue op = item.value;
    std::erase_if(std::get<JsonValue::Object>(op.value),
                  [](const JsonMember& member) { return member.key == "name"; });
    readOperator(item, op);  // also of those that no visualization has
    const size_t values = valuesIn(op);
    if (!item.context.operators.emplace(text, ReadContext::NamedOperator{std::move(op), values}).second)
      item.context.fail(name->at, "two operators named " + inQuotes(text) + "; expected each name once");
  });
}

void readOutputType(const Found& found, OutputSpec& output) {
  using Type = OutputSpec::Type;
  for (const Type type : {Type::DataFile, Type::Pictures, Type::Publish})
    if (found.text() == nameOf(type)) {
      output.type = type;
      return;
    }
  found.fail("Data file, Pictures or Publish");
}

void readOutputs(const Found& found, State& state) {
  readOneOrMany(found, [&](const Found& item) {
    OutputSpec output;
    readObject(item.context, item.value, outputSchema(), output);
    if (output.name.empty()) output.name = output.to;
    for (const OutputSpec& other : state.outputs)
      if (other.name == output.name)
        item.context.fail(item.value.at,
                          "two outputs named " + inQuotes(output.name) + "; expected each name once");
    state.outputs.push_back(std::move(output));
  });
}

void readVisualizations(const Found& found, State& state) {
  std::set<std::string> names;
  readOneOrMany(found, [&](const Found& item) {
    Visualization visualization;
    visualization.lighting = item.context.oldLighting.value_or(Lighting{});
    if (item.value.find("Lighting") || item.value.find("lighting")) visualization.lighting = Lighting{};
    readObject(item.context, item.value, visualizationSchema(), visualization);
    if (const std::string& name = visualization.view.name; !name.empty() && !names.insert(name).second)
      item.context.fail(item.value.at,
                        "two visualizations named " + inQuotes(name) + "; expected each name once");
    state.visualizations.push_back(std::move(visualization));
  });
}

OrderedJson writeDatasets(const std::vector<DatasetSpec>& datasets) {
  OrderedJson out = OrderedJson::array();
  for (const DatasetSpec& d : datasets)
    out.push_back(d.filter.empty() ? writeObject(d, datasetSchema()) : writeFilterEntry(d));
  return out;
}

template <class T>
OrderedJson writeAll(const std::vector<T>& items, const Schema<T>& schema) {
  OrderedJson out = OrderedJson::array();
  for (const T& item : items) out.push_back(writeObject(item, schema));
  return out;
}

}  // namespace

void readDatasetType(const Found& found, DatasetSpec& dataset) {
  const auto type = datasetTypeNamed(found.text());
  if (!type) found.fail("Volume, Particles, PathLines or Triangles");
  dataset.type = *type;
}

constexpr size_t kMostFieldsOfDataset = 256;

const Schema<DatasetSpec>& datasetSchema() {
  using D = DatasetSpec;
  static const Schema<D> schema{
      "dataset",
      {
          textKey("name", &D::name, "What operators call it; each name once.").byDefault("the file name"),
          customKey<D>("type", "Volume, Particles, PathLines or Triangles", "What is in the file.",
                       readDatasetType, [](const D& d) { return OrderedJson(nameOf(d.type)); })
              .require(),
          customKey<D>(
              "filename", "text", "The file: absolute, or relative to the state file's directory.",
              [](const Found& f, D& d) { d.filename = f.text(); },
              [](const D& d) { return d.filename.empty() ? OrderedJson() : OrderedJson(d.filename); })
              .byDefault("the dataset that the data space calls `name`"),
          textKey("array", &D::array, "Which array of the file to map or, if it holds colours, to show.")
              .byDefault("its active scalars, else its first array"),
          customKey<D>(
              "radius array", "text",
              "Which array of the file's points gives the radii, as `radius0` and the keys beside it say.",
              [](const Found& f, D& d) {
                const std::string& name = f.text();
                if (d.type == DatasetType::Particles || d.type == DatasetType::PathLines)
                  d.radiusArray = name;
              },
              [](const D& d) { return d.radiusArray.empty() ? OrderedJson() : OrderedJson(d.radiusArray); })
              .only(1u << unsigned(DatasetType::Particles) | 1u << unsigned(DatasetType::PathLines))
              .byDefault("`array`"),
          customKey<D>(
              "fields", "text or list of texts",
              "Which further arrays of the file's points are read. Operators show them by `array`, and files "
              "that are exported have them.",
              [](const Found& f, D& d) {
                readOneOrMany(f, [&](const Found& name) {
                  if (d.fields.size() == kMostFieldsOfDataset) name.fail("at most 256 arrays");
                  if (std::count(d.fields.begin(), d.fields.end(), name.text())) name.fail("each array once");
                  if (d.type != DatasetType::Volume) d.fields.push_back(name.text());
                });
              },
              [](const D& d) { return d.fields.empty() ? OrderedJson() : OrderedJson(d.fields); })
              .only(~(1u << unsigned(DatasetType::Volume)))
              .byDefault("none"),
          colorKey("color", &D::color,
                   "Colour of geometry whose file has neither values to map nor colours. Values that are NaN "
                   "have the operator's `nan color`.")
              .alias({"default color"}),
      }};
  return schema;
}

const Schema<RenderSettings>& rendererSchema() {
  using R = RenderSettings;
  static const Schema<R> schema{
      "renderer",
      {
          numberKey("tolerance", &R::tolerance, {0, 1, true},
                    "Error that every channel of every pixel stays below."),
          numberKey("step", &R::step, kNonNegative,
                    "If not 0: march with equal steps of about this many cells (1/256 to 3.9), instead."),
          integerKey("rays per pixel", &R::raysPerPixel, {1, 65536}, "Primary rays through each pixel."),
          colorKey("background", &R::background, "Colour behind everything."),
          colorKey("background top", &R::backgroundTop,
                   "Makes a gradient: linear from `background` at the picture's lower edge to this colour at "
                   "its upper edge.")
              .byDefault("none"),
          customKey<R>("Lighting", "lighting", "Deprecated: used for visualizations without their own.",
                       readOldLighting)
              .alias({"lighting"})
              .byDefault("-"),
          obsoleteKey("epsilon", "rays leave surfaces by an amount that follows from rounding"),
          obsoleteKey("far", "a setting of the earlier Galaxy's Schlieren renderer"),
      }};
  return schema;
}

void readShow(const Found& found, Visualization& visualization) {
  if (found.text() != "together" && found.text() != "as it comes")
    found.fail("\"together\" or \"as it comes\"");
  visualization.view.asItComes = found.text() == "as it comes";
}

const Schema<Visualization>& visualizationSchema() {
  using V = Visualization;
  static const Schema<V> schema{
      "visualization",
      {
          customKey<V>(
              "name", "text", "What outputs, windows and messages call it; each name once.",
              [](const Found& f, V& v) { v.view.name = f.text(); },
              [](const V& v) { return v.view.name.empty() ? OrderedJson() : OrderedJson(v.view.name); })
              .byDefault("empty"),
          customKey<V>(
              "camera", "object, as in `Cameras`", "From where it looks, in place of all `Cameras`.",
              [](const Found& f, V& v) { v.view.camera = readCamera(f); },
              [](const V& v) {
                return v.view.camera ? writeObject(*v.view.camera, cameraSchema()) : OrderedJson();
              })
              .byDefault("each of `Cameras`; in a graph the first, else fitted to the data"),
          customKey<V>(
              "size", "[width, height], integers 1 to 65536",
              "Pixels of its pictures, in place of `dimensions` of cameras.",
              [](const Found& f, V& v) { v.view.size = f.imageSize(); },
              [](const V& v) {
                return v.view.size ? OrderedJson{v.view.size->x, v.view.size->y} : OrderedJson();
              })
              .byDefault("the camera's"),
          customKey<V>(
              "follow", "true or false", "Whether windows show newer data by themselves.",
              [](const Found& f, V& v) { v.view.follow = f.boolean(); },
              [](const V& v) { return v.view.follow ? OrderedJson() : OrderedJson(false); })
              .byDefault("`true`"),
          customKey<V>(
              "show", "\"together\" or \"as it comes\"",
              "Whether windows on it in a graph change when all that they show is there, or data by "
              "data.",
              readShow,
              [](const V& v) { return v.view.asItComes ? OrderedJson("as it comes") : OrderedJson(); })
              .byDefault("`\"together\"`"),
          textKey("annotation", &V::annotation,
                  "Becomes part of the picture's name, as PREFIX_00000_annotation.png.")
              .advanced(),
          customKey<V>(
              "Lighting", "lighting", "How surfaces are lit.",
              [](const Found& f, V& v) { readObject(f.context, f.value, lightingSchema(), v.lighting); },
              [](const V& v) { return writeObject(v.lighting, lightingSchema()); })
              .alias({"lighting"})
              .advanced()
              .byDefault("see below"),
          customKey<V>("operators", "list of operators", "What is shown, all in one picture.", readOperators,
                       [](const V& v) { return writeAll(v.operators, operatorSchema()); })
              .require(),
      }};
  return schema;
}

const Schema<OutputSpec>& outputSchema() {
  using O = OutputSpec;
  static const Schema<O> schema{
      "output",
      {
          textKey("name", &O::name, "What states and messages call it; each name once.").byDefault("`to`"),
          customKey<O>("type", "Data file, Pictures or Publish",
                       "What is made: a file of a dataset; a picture of a view of a [graph](graph.md); or "
                       "another name of a "
                       "dataset that a graph makes.",
                       readOutputType, [](const O& o) { return OrderedJson(nameOf(o.type)); })
              .require(),
          textKey("of", &O::of, "The dataset, or the view.").require(),
          textKey("to", &O::to,
                  "The file, by whose ending its format is known; {step} becomes the number of the time "
                  "step. Or the "
                  "other name.")
              .require(),
      }};
  return schema;
}

const Schema<Annotations>& annotationsSchema() {
  using A = Annotations;
  static const Schema<A> schema{
      "annotations",
      {
          flagKey("legend", &A::legend, "Colour legends of what is coloured by value."),
          flagKey("axes", &A::axes, "The directions of the axes, in the lower left corner."),
          flagKey("outline", &A::outline, "The box of the data that are shown, with its extents."),
          textKey("text", &A::text,
                  "A line in the upper left corner; {step} becomes the number of the time step, {time} its "
                  "time."),
      }};
  return schema;
}

const Schema<State>& stateSchema() {
  static const Schema<State> schema{
      "state file",
      {
          customKey<State>("Datasets", "dataset or list of datasets",
                           "The data, imported before anything is rendered.", readDatasets,
                           [](const State& s) { return writeDatasets(s.datasets); })
              .byDefault("none"),
          customKey<State>(
              "Renderer", "renderer", "How pictures are computed.",
              [](const Found& f, State& s) { readObject(f.context, f.value, rendererSchema(), s.settings); },
              [](const State& s) { return writeObject(s.settings, rendererSchema()); })
              .byDefault("see below"),
          customKey<State>("Operators", "operator or list of operators",
                           "Operators that have a `name` each, which `operators` of visualizations may say "
                           "in place of an operator.",
                           readNamedOperators)
              .byDefault("none"),
          customKey<State>("Visualizations", "visualization or list of visualizations",
                           "What is shown; each is rendered with each camera.", readVisualizations,
                           [](const State& s) { return writeAll(s.visualizations, visualizationSchema()); })
              .alias({"Visualization"})
              .byDefault("none"),
          customKey<State>(
              "Cameras", "camera, text, or list of these",
              "Views. Text: a ParaView camera file (.pvcc or its JSON form).",
              [](const Found& f, State& s) {
                readOneOrMany(f, [&](const Found& item) { s.cameras.push_back(readCamera(item)); });
              },
              [](const State& s) { return writeAll(s.cameras, cameraSchema()); })
              .alias({"Camera"})
              .byDefault("none"),
          customKey<State>(
              "Annotations", "annotations", "What is drawn over pictures.",
              [](const Found& f, State& s) {
                readObject(f.context, f.value, annotationsSchema(), s.annotations);
              },
              [](const State& s) {
                return s.annotations == Annotations() ? OrderedJson()
                                                      : writeObject(s.annotations, annotationsSchema());
              })
              .byDefault("none"),
          customKey<State>("GUI", "object", "What the [browser GUI](gui.md) keeps: places of nodes, notes.",
                           [](const Found&, State&) {})
              .byDefault("none"),
          customKey<State>("version", "1", "Of the format of state files.",
                           [](const Found& f, State&) {
                             if (f.number() != 1) f.fail("1; a newer Galaxy may read it");
                           })
              .byDefault("1"),
          customKey<State>("Outputs", "output or list of outputs",
                           "What is made of data beside pictures of windows.", readOutputs,
                           [](const State& s) {
                             return s.outputs.empty() ? OrderedJson() : writeAll(s.outputs, outputSchema());
                           })
              .byDefault("none"),
      }};
  return schema;
}

}  // namespace gxy
