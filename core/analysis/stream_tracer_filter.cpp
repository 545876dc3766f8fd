// SPDX-License-Identifier: Apache-2.0
#include "core/analysis/stream_tracer_filter.h"

#include <algorithm>
#include <utility>

#include "core/analysis/made_geometry.h"
#include "core/analysis/mesh_fields.h"
#include "core/analysis/recorded_fields.h"
#include "core/analysis/tracer.h"
#include "core/comm/error.h"
#include "core/rays/field_maker.h"

namespace gxy {
namespace {

constexpr const char* kDirections[] = {"forward", "backward", "both"};
constexpr const char* kColors[] = {"speed", "time", "length", "field"};

constexpr const char* kLineFields[] = {"speed", "time", "length", "vorticity"};
constexpr const char* kLineFieldsText = "list of speed, time, length, vorticity";

/// A row for one of several words.
template <class Value, size_t n>
KeyRow<StreamTracer> wordKey(std::string name, const char* const (&words)[n], std::string type,
                             Value StreamTracer::*member, std::string meaning) {
  return customKey<StreamTracer>(
      std::move(name), type, std::move(meaning),
      [member, &words, type](const Found& found, StreamTracer& s) {
        const auto it = std::find(std::begin(words), std::end(words), found.text());
        if (it == std::end(words)) found.fail(type);
        s.*member = Value(it - std::begin(words));
      },
      [member, &words](const StreamTracer& s) { return OrderedJson(words[size_t(s.*member)]); });
}

/// A row for a limit that an entry may leave out.
KeyRow<StreamTracer> limitKey(std::string name, std::optional<double> StreamTracer::*member,
                              std::string meaning, std::string otherwise) {
  return customKey<StreamTracer>(
             std::move(name), "number >= 0", std::move(meaning),
             [member](const Found& found, StreamTracer& s) { s.*member = found.number(kNonNegative); },
             [member](const StreamTracer& s) {
               return s.*member ? OrderedJson(*(s.*member)) : OrderedJson();
             })
      .byDefault(std::move(otherwise));
}

constexpr const char* kPoints = "\"cells\", \"ends\", {\"dt\": number > 0} or {\"ds\": number > 0}";

void readPointsMode(const Found& found, StreamTracer& s) {
  if (const auto* object = found.value.object()) {
    if (object->size() != 1 || ((*object)[0].key != "dt" && (*object)[0].key != "ds")) found.fail(kPoints);
    const JsonMember& member = (*object)[0];
    const Found interval{found.context, member.key, member.value, found.value};
    s.interval = interval.number(kPositive);
    s.points = member.key == "dt" ? PointsMode::EqualTime : PointsMode::EqualLength;
    return;
  }
  const std::string* word = found.value.string();
  if (!word || (*word != "cells" && *word != "ends")) found.fail(kPoints);
  s.points = *word == "cells" ? PointsMode::Cells : PointsMode::Ends;
}

OrderedJson writePointsMode(const StreamTracer& s) {
  switch (s.points) {
    case PointsMode::EqualTime:
      return {{"dt", s.interval}};
    case PointsMode::EqualLength:
      return {{"ds", s.interval}};
    case PointsMode::Ends:
      return "ends";
    case PointsMode::Cells:
      break;
  }
  return "cells";
}

void readWhere(const Found& found, StreamTracer& s) {
  const std::vector<double> bounds = found.numbers(2, 2, "[lo, hi]");
  if (!(bounds[0] <= bounds[1])) found.fail("[lo, hi] with lo <= hi");
  s.where = Range{bounds[0], bounds[1]};
}

void readLineFields(const Found& found, StreamTracer& s) {
  readOneOrMany(found, [&](const Found& item) {
    const std::string& name = item.text();
    if (std::find(std::begin(kLineFields), std::end(kLineFields), name) == std::end(kLineFields))
      item.fail(kLineFieldsText);
    if (std::find(s.fields.begin(), s.fields.end(), name) != s.fields.end()) item.fail("each field once");
    s.fields.push_back(name);
  });
}

/// Those that are kept on the way, but for the values.
std::vector<NamedLineValue> keptFields(const StreamTracer& s) {
  std::vector<NamedLineValue> kept;
  constexpr LineValue::Kind kKinds[] = {LineValue::Kind::Speed, LineValue::Kind::Time,
                                        LineValue::Kind::Length};
  for (const std::string& name : s.fields)
    for (size_t k = 0; k < std::size(kKinds); k++)
      if (name == kLineFields[k] && size_t(s.colorBy) != k) kept.push_back({name, {kKinds[k], 0}});
  return kept;
}

nlohmann::json endsIn(const MadeLines& made) {
  nlohmann::json ends = nlohmann::json::object();
  for (int k = 0; k < kEndReasons; k++)
    if (made.ends[size_t(k)]) ends[nameOf(EndReason(k))] = made.ends[size_t(k)];
  return ends;
}

}  // namespace

FilterInfo StreamTracer::info() {
  return {
      "StreamTracer",
      1,
      "Lines along a vector field, from seeds on. The field is trilinear between its samples, or what the "
      "shape functions of an unstructured volume's cells make of values at points, and a line is "
      "followed cell by cell. The reply counts the ends of lines by their reasons.",
      {{"vectors", kVolumes | kUnstructured, "The field: three components."},
       {"seeds", kParticles, "Where lines begin."},
       {"field", kVolumes | kUnstructured,
        "A field of one component on the same grid or cells, for `where` and `color by`.",
        FilterPort::Count::Optional},
       {"fields", kVolumes | kUnstructured, "Volumes on any grids whose values the points get.",
        FilterPort::Count::Any}},
      DatasetType::PathLines};
}

std::vector<KeyRow<StreamTracer>> StreamTracer::properties() {
  using S = StreamTracer;
  return {
      limitKey("time", &S::time, "The longest time of each direction.", "no limit"),
      limitKey("length", &S::length, "The greatest length of each direction, in the units of the world.",
               "10 diagonals of the field's box"),
      customKey<S>(
          "steps", "integer > 0", "The most cells that a line goes through in each direction.",
          [](const Found& f, S& s) {
            s.steps = f.integer({1, 2147483647});
          },
          [](const S& s) { return s.steps ? OrderedJson(*s.steps) : OrderedJson(); })
          .byDefault("no limit")
          .advanced(),
      wordKey(
          "direction", kDirections, "forward, backward or both", &S::direction,
          "Where lines go from their seeds. Behind the seed time is negative. `both` makes one line of each "
          "seed, whose points are in order of time."),
      numberKey("tolerance", &S::tolerance, kPositive,
                "The error, in cells, that is added in 100 cells of way.")
          .advanced(),
      flagKey("normalised", &S::normalised, "Whether time is the length of the line: field lines."),
      customKey<S>(
          "points", kPoints,
          "Which points of lines there are: where they cross the faces of cells, their ends only, or "
          "those at multiples of a time or of a length.",
          readPointsMode, writePointsMode)
          .advanced(),
      numberKey("minimum speed", &S::minimumSpeed, kNonNegative, "Lines end where the field is smaller."),
      customKey<S>("where", "[lo, hi]", "Lines end where the value of the input `field` is in this range.",
                   readWhere,
                   [](const S& s) {
                     return s.where ? OrderedJson{s.where->min, s.where->max} : OrderedJson();
                   })
          .byDefault("nowhere")
          .advanced(),
      wordKey(
          "color by", kColors, "speed, time, length or field", &S::colorBy,
          "The values of points: the field's magnitude, time or length from the seed, or the value of the "
          "input `field`."),
      customKey<S>("fields", kLineFieldsText,
                   "Further fields of points. `vorticity` is the curl of the field in the cell of "
                   "the point; on a face, of "
                   "the upper one, and in an unstructured volume of the first one.",
                   readLineFields,
                   [](const S& s) { return s.fields.empty() ? OrderedJson() : OrderedJson(s.fields); })
          .byDefault("none")
          .advanced(),
  };
}

TraceOptions StreamTracer::options() const {
  TraceOptions o;
  o.tolerance = tolerance;
  if (time) o.time = *time;
  o.length = length;
  if (steps) o.steps = *steps;
  o.minimumSpeed = minimumSpeed;
  o.normalised = normalised;
  o.points = points;
  o.interval = interval;
  if (where) o.condition = TraceCondition{0, where->min, where->max};
  return o;
}

namespace {

// What makes the fields of a request may fail on one rank alone, too.
void setGridFields(const FilterRun& run, const FilterSource& vectors, const FilterSource* field,
                   TraceRequest& request) {
  std::vector<std::shared_ptr<const Volume>> volumes{vectors.data->volume};
  if (field) {
    if (!field->data->volume || !(field->data->volume->grid == vectors.data->volume->grid))
      throw Error("StreamTracer: " + inQuotes(field->name) + " has another grid than " +
                  inQuotes(vectors.name) + ", expected the same");
    volumes.push_back(field->data->volume);
  }
  const auto fields = std::make_shared<const CompiledFields>(std::move(volumes), vectors.data->partitioning);
  request.fields = fields;
  request.device = run.services().fieldMaker->make(fields, run.ranks.rank());
}

void setMeshFields(const FilterRun& run, const FilterSource& vectors, const FilterSource* field,
                   TraceRequest& request) {
  std::vector<std::shared_ptr<const Mesh>> meshes{vectors.data->mesh};
  if (field) {
    if (!field->data->mesh || !haveSameCells(*field->data->mesh, *vectors.data->mesh))
      throw Error("StreamTracer: " + inQuotes(field->name) + " has other points or cells than " +
                  inQuotes(vectors.name) + ", expected the same");
    meshes.push_back(field->data->mesh);
  }
  const auto fields = std::make_shared<const MeshFields>(std::move(meshes), vectors.data->partitioning,
                                                         [&run] { run.ranks.check(); });
  request.fields = fields;
  request.device = fields;
}

}  // namespace

// May fail on one rank alone: it is called inside agree().
TraceRequest StreamTracer::request(const FilterRun& run) const {
  const FilterServices& services = run.services();
  if (!services.tracer || !services.fieldMaker)
    throw Error("StreamTracer: lines cannot be traced here, expected a program that can");
  const FilterSource& vectors = run.input("vectors");
  const FilterSource* field = run.optional("field");
  if (!field && (where || colorBy == ColorBy::Field))
    throw Error(std::string("StreamTracer: `") + (where ? "where" : "color by") +
                "` needs the input `field`, expected one");
  if (vectors.data->components() != 3)
    throw Error("StreamTracer: " + inQuotes(vectors.name) + " has " +
                std::to_string(vectors.data->components()) +
                " components, expected 3; `Derive` composes them of scalars by [u, v, w]");
  if (field && field->data->components() != 1)
    throw Error("StreamTracer: " + inQuotes(field->name) + " has " +
                std::to_string(field->data->components()) + " components, expected one");
  if (const auto others = run.inputs().find("fields"); others != run.inputs().end()) {
    checkNames(others->second, "StreamTracer");
    for (const FilterSource& source : others->second)
      if (std::find(std::begin(kLineFields), std::end(kLineFields), source.name) != std::end(kLineFields))
        throw Error("StreamTracer: a dataset of the input `fields` is called " + inQuotes(source.name) +
                    ", as a field of lines is, expected another name");
  }
  TraceRequest request;
  if (vectors.data->mesh) {
    setMeshFields(run, vectors, field, request);
  } else {
    setGridFields(run, vectors, field, request);
  }
  const GeometryBlock& seeds = run.input("seeds").data->geometry->block;
  request.seeds = seeds.points;
  request.lines = seeds.ids;
  request.direction = direction;
  request.options = options();
  request.priority.tenant = services.turn;
  request.account = services.tenant;
  request.takeMemory = [&services](int64_t bytes) { return services.takeMemory("lines", bytes); };
  return request;
}

FilterResult StreamTracer::run(FilterRun& run) const {
  TraceRequest asked;
  run.begin(0, 2, "lines");
  LedgerEntry tree;
  agree(run.ranks, [&] {
    if (const auto& mesh = run.input("vectors").data->mesh)
      tree = run.takeMemory("search tree", MeshFields::bytesFor(*mesh));
    asked = request(run);
  });
  TracedLines traced = run.services().tracer->trace(std::move(asked), run.ranks);
  tree = LedgerEntry();
  run.begin(1, 2, "segments");
  constexpr LineValue::Kind kKinds[] = {LineValue::Kind::Speed, LineValue::Kind::Time,
                                        LineValue::Kind::Length, LineValue::Kind::Recorded};
  MadeLines made = makeLines(
      std::move(traced), {kKinds[size_t(colorBy)], 0},
      [&](int64_t bytes) { return run.takeMemory("geometry", bytes); }, run.ranks, keptFields(*this));
  std::vector<LedgerEntry> memory;
  const FilterSource* field = run.optional("field");
  const auto others = run.inputs().find("fields");
  if (others != run.inputs().end()) recordFields(run, others->second, made.block, memory);
  if (std::find(fields.begin(), fields.end(), "vorticity") != fields.end())
    recordVorticity(run, run.input("vectors"), made.block, memory);
  FilterResult result;
  result.told = {{"lines", made.lines}, {"points", made.points}, {"ends", endsIn(made)}};
  result.dataset = madeGeometry(run, "lines", GeometryKind::PathLines, std::move(made.block),
                                run.input("vectors").data->partitioning, std::move(made.memory),
                                colorBy == ColorBy::Field ? field->name : kColors[size_t(colorBy)]);
  result.told["fields"] = toldOfPoints(*result.dataset->geometry);
  return result;
}

}  // namespace gxy
