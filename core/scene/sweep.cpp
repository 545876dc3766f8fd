// SPDX-License-Identifier: Apache-2.0
#include "core/scene/sweep.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include "core/comm/error.h"
#include "core/scene/cinema_table.h"
#include "core/scene/schema.h"
#include "core/scene/schema_table.h"

namespace gxy {

/// The bit of KeyInfo::appliesTo.
inline unsigned typeBit(const SweepAxis& axis) { return 1u << unsigned(axis.kind); }

bool Sweep::hasTime() const {
  return std::any_of(axes.begin(), axes.end(), [](const SweepAxis& a) { return a.kind == AxisKind::Time; });
}

std::vector<std::string> Sweep::columns() const {
  std::vector<std::string> all;
  for (const SweepAxis& axis : axes) all.insert(all.end(), axis.columns.begin(), axis.columns.end());
  return all;
}

namespace {

constexpr const char* kAxes[] = {"phi",   "theta", "angles",   "camera", "isovalue",
                                 "slice", "clip",  "colormap", "key",    "time"};

constexpr unsigned kindBit(AxisKind kind) { return 1u << unsigned(kind); }
constexpr unsigned kSurfaces =
    kindBit(AxisKind::Isovalue) | kindBit(AxisKind::Slice) | kindBit(AxisKind::Clip);
constexpr unsigned kNumbers = kSurfaces | kindBit(AxisKind::Phi) | kindBit(AxisKind::Theta);
constexpr unsigned kAllKinds = (1u << std::size(kAxes)) - 1;

bool isIn(AxisKind kind, unsigned kinds) { return (kindBit(kind) & kinds) != 0; }

std::string namesOfAxes() {
  std::string all;
  for (const char* name : kAxes)
    all += (all.empty() ? "" : name == kAxes[std::size(kAxes) - 1] ? " or " : ", ") + std::string(name);
  return all;
}

void readKind(const Found& found, SweepAxis& axis) {
  const auto at = std::find(std::begin(kAxes), std::end(kAxes), found.text());
  if (at == std::end(kAxes))
    found.context.fail(found.value.at, inQuotes(found.key, '`') + ": expected " + namesOfAxes() + ", found " +
                                           found.value.describe() +
                                           suggestion(found.text(), {std::begin(kAxes), std::end(kAxes)}));
  axis.kind = AxisKind(at - std::begin(kAxes));
}

SweepValue numberValue(double x, TextPosition at) {
  x += 0.0;  // -0 is 0
  return {{x}, OrderedJson(x).dump(), {floatCell(x)}, at};
}

/// A text that readers of the table take for one.
void checkText(const Found& item, const std::string& text) {
  constexpr size_t kLongest = 64;
  if (text.empty() || text.size() > kLongest || cellType(text) != TableCellType::Text ||
      text.front() == ' ' || text.back() == ' ' ||
      std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }))
    item.fail("a text of 1 to 64 bytes that is no number, without blanks around it");
}

SweepValue valueOf(const Found& item, AxisKind kind) {
  if (isIn(kind, kNumbers)) return numberValue(item.number(), item.value.at);
  switch (kind) {
    case AxisKind::Angles: {
      const std::vector<double> pair = item.numbers(2, 2, "[phi, theta]");
      const double phi = pair[0] + 0.0, theta = pair[1] + 0.0;
      return {{phi, theta}, {}, {floatCell(phi), floatCell(theta)}, item.value.at};
    }
    case AxisKind::Camera: {
      const int index = item.integer(kNonNegative);
      return {{double(index)}, {}, {std::to_string(index)}, item.value.at};
    }
    case AxisKind::Colormap:
      checkText(item, item.text());
      return {{}, OrderedJson(item.text()).dump(), {item.text()}, item.value.at};
    default: {
      SweepValue value;
      value.at = item.value.at;
      value.json = jsonOf(item.value).dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
      if (item.value.number()) value.cells = {floatCell(item.value.number()->value + 0.0)};
      if (item.value.boolean()) value.cells = {*item.value.boolean() ? "true" : "false"};
      if (item.value.string()) value.cells = {*item.value.string()};
      return value;
    }
  }
}

void readValues(const Found& found, SweepAxis& axis) {
  if (axis.kind == AxisKind::Time) return;
  const std::vector<Found> items = found.list("a list of values");
  if (items.empty() || items.size() > kMostSweptPictures)
    found.fail("a list of 1 to " + std::to_string(kMostSweptPictures) + " values");
  for (const Found& item : items) axis.values.push_back(valueOf(item, axis.kind));
}

void readLabels(const Found& found, SweepAxis& axis) {
  for (const Found& item : found.list("a list of texts")) {
    checkText(item, item.text());
    axis.labels.push_back(item.text());
  }
  if (axis.labels.size() != axis.values.size())
    found.fail("as many labels as there are values, " + std::to_string(axis.values.size()));
}

void readName(const Found& found, SweepAxis& axis) {
  checkText(found, found.text());
  if (isFileColumn(found.text())) found.fail("a name that does not begin with FILE");
  axis.name = found.text();
}

const Schema<SweepAxis>& axisSchema() {
  using A = SweepAxis;
  using F = const Found&;
  static const Schema<A> schema{
      "axis",
      {
          customKey<A>("axis", namesOfAxes(), "What is varied; see above.", readKind).require(),
          customKey<A>("name", "text", "Name of its column in the table.", readName)
              .only(kAllKinds & ~kindBit(AxisKind::Angles))
              .byDefault("the axis; of a key the last part of its `path`"),
          customKey<A>("path", "text", "The key: a JSON Pointer into the state, as it is saved.",
                       [](F f, A& a) { a.path = f.text(); })
              .only(kindBit(AxisKind::Key))
              .byDefault("required"),
          customKey<A>(
              "operator", "integer >= 0", "Which operator of the visualization.",
              [](F f, A& a) { a.op = f.integer(kNonNegative); }, [](const A& a) { return OrderedJson(a.op); })
              .only(kSurfaces | kindBit(AxisKind::Colormap)),
          customKey<A>(
              "index", "integer >= 0", "Which of the operator's isovalues, slices or clip planes.",
              [](F f, A& a) { a.index = f.integer(kNonNegative); },
              [](const A& a) { return OrderedJson(a.index); })
              .only(kSurfaces),
          customKey<A>("values", "list, of different values",
                       "Numbers; of angles pairs [phi, theta], of a camera its number from 0 on, of a colour "
                       "map its name, of a key any JSON values.",
                       readValues)
              .only(kAllKinds & ~kindBit(AxisKind::Time))
              .byDefault("`from`, `to` and `count`; of a camera all of them"),
          customKey<A>("from", "number", "The first of equally spaced values.",
                       [](F f, A& a) { a.from = f.number(); })
              .only(kNumbers)
              .byDefault("-"),
          customKey<A>("to", "number", "The last of them.", [](F f, A& a) { a.to = f.number(); })
              .only(kNumbers)
              .byDefault("-"),
          customKey<A>("count", "integer 2 to 10000", "How many there are, both ends included.",
                       [](F f, A& a) {
                         a.count = f.integer({2, double(kMostSweptPictures)});
                       })
              .only(kNumbers)
              .byDefault("-"),
          customKey<A>("labels", "list of texts", "What the table says in place of the values.", readLabels)
              .only(kindBit(AxisKind::Key) | kindBit(AxisKind::Colormap))
              .byDefault("numbers, texts, true and false as they are; required for other values"),
      }};
  return schema;
}

std::string lastPartOf(const std::string& path) { return path.substr(path.rfind('/') + 1); }

/// Equally spaced values, where there are any.
void space(const ReadContext& context, SweepAxis& axis) {
  const bool spaced = axis.from || axis.to || axis.count > 0;
  if (!spaced || !isIn(axis.kind, kNumbers)) return;
  if (!axis.values.empty() || !axis.from || !axis.to || axis.count == 0 || *axis.from == *axis.to)
    context.fail(axis.at,
                 "axis: expected `values`, or else `from`, `to` and `count` together, with `from` "
                 "other than `to`");
  for (int i = 0; i < axis.count; i++) {
    const double part = double(i) / (axis.count - 1);
    axis.values.push_back(
        numberValue(i + 1 == axis.count ? *axis.to : *axis.from + part * (*axis.to - *axis.from), axis.at));
  }
}

void labelValues(const ReadContext& context, SweepAxis& axis) {
  const bool labelled = axis.kind == AxisKind::Key || axis.kind == AxisKind::Colormap;
  for (size_t i = 0; i < axis.labels.size() && labelled; i++) axis.values[i].cells = {axis.labels[i]};
  std::set<std::vector<std::string>> known;
  for (const SweepValue& value : axis.values) {
    if (value.cells.empty())
      context.fail(value.at,
                   "`values`: expected `labels` for values other than numbers, texts, true and false");
    const std::string& cell = value.cells[0];
    const TableCellType type = cellType(cell);
    if (axis.kind == AxisKind::Key && axis.labels.empty() &&
        (type != cellType(axis.values[0].cells[0]) || cell.empty() || cell.size() > 64 ||
         type == TableCellType::Integer))
      context.fail(value.at,
                   "`values`: expected numbers only, or texts only of 1 to 64 bytes that are no "
                   "numbers, or `labels`");
    if (!known.insert(value.cells).second)
      context.fail(value.at, "`values`: " + inQuotes(cell) + " is given twice, expected different values");
  }
}

/// Completes what was read of an axis.
void finish(ReadContext& context, SweepAxis& axis) {
  space(context, axis);
  if (axis.values.empty() && axis.kind != AxisKind::Time && axis.kind != AxisKind::Camera)
    context.fail(axis.at, "axis without `values`; expected a list of them");
  if (axis.kind == AxisKind::Key && (axis.path.size() < 2 || axis.path[0] != '/'))
    context.fail(axis.at, "axis without `path`; expected a JSON Pointer such as \"/Renderer/tolerance\"");
  labelValues(context, axis);
  if (axis.kind == AxisKind::Angles)
    axis.columns = {"phi", "theta"};
  else if (!axis.name.empty())
    axis.columns = {axis.name};
  else
    axis.columns = {axis.kind == AxisKind::Key ? lastPartOf(axis.path) : kAxes[unsigned(axis.kind)]};
  const std::string& column = axis.columns[0];
  if (cellType(column) != TableCellType::Text || column.empty() || isFileColumn(column))
    context.fail(axis.at,
                 "axis: expected a `name` for its column, as " + inQuotes(column) + " cannot be one");
}

void readAxes(const Found& found, Sweep& sweep) {
  std::set<std::string> columns;
  bool turns = false, cameras = false, time = false;
  uint64_t pictures = 1;
  for (const Found& item : found.list("a list of axes")) {
    SweepAxis axis;
    axis.at = item.value.at;
    readObject(item.context, item.value, axisSchema(), axis);
    finish(item.context, axis);
    for (const std::string& column : axis.columns)
      if (!columns.insert(column).second)
        item.context.fail(
            axis.at, "axis: there is a column " + inQuotes(column) + " already, expected another `name`");
    const auto once = [&](bool& seen, const char* what) {
      if (std::exchange(seen, true)) item.context.fail(axis.at, std::string("axis: expected one ") + what);
    };
    if (axis.kind == AxisKind::Angles) once(turns, "axis of angles, or phi and theta");
    if (axis.kind == AxisKind::Camera) once(cameras, "axis of cameras");
    if (axis.kind == AxisKind::Time) once(time, "axis of the time");
    for (const SweepAxis& other : sweep.axes) {
      const bool same =
          axis.kind == other.kind && isIn(axis.kind, kindBit(AxisKind::Phi) | kindBit(AxisKind::Theta));
      const bool pairs = (axis.kind == AxisKind::Angles || other.kind == AxisKind::Angles) &&
                         isIn(axis.kind == AxisKind::Angles ? other.kind : axis.kind,
                              kindBit(AxisKind::Phi) | kindBit(AxisKind::Theta));
      if (same || pairs)
        item.context.fail(axis.at, "axis: expected one axis of phi and one of theta, or one of angles");
    }
    pictures *= std::max<size_t>(axis.values.size(), 1);
    if (pictures > kMostSweptPictures)
      item.context.fail(axis.at, "axis: with it there are " + std::to_string(pictures) +
                                     " pictures or more, expected at most " +
                                     std::to_string(kMostSweptPictures) + " of one time");
    sweep.axes.push_back(std::move(axis));
  }
  if (sweep.axes.empty()) found.fail("a list of one axis or more");
}

const Schema<Sweep>& sweepSchema() {
  static const Schema<Sweep> schema{
      "sweep",
      {
          customKey<Sweep>("axes", "list of axes", "What is varied; the last one varies fastest.", readAxes)
              .require(),
          customKey<Sweep>("center", "[x, y, z]",
                           "What `phi`, `theta` and `angles` turn the camera about, world.",
                           [](const Found& f, Sweep& s) { s.center = f.vec3(); })
              .byDefault("`viewpoint` + `viewdirection`, which is the camera's `viewcenter`"),
      }};
  return schema;
}

}  // namespace

Sweep readSweep(std::string_view text, const std::string& sourceName) {
  ReadContext context;
  context.sourceName = sourceName;
  const JsonValue root = parseJson(text, sourceName);
  Sweep sweep;
  sweep.source = sourceName;
  readObject(context, root, sweepSchema(), sweep);
  sweep.warnings = std::move(context.warnings);
  return sweep;
}

Sweep readSweepFile(const std::filesystem::path& path) {
  return readSweep(readTextFile(path), path.string());
}

std::string sweepReference() {
  return schemaTable(sweepSchema(), kAxes) + "\n" + schemaTable(axisSchema(), kAxes);
}

}  // namespace gxy
