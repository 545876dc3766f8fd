// SPDX-License-Identifier: Apache-2.0
#include "core/scene/swept_pictures.h"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include "core/comm/error.h"
#include "core/scene/cinema_table.h"
#include "core/scene/orbit.h"
#include "core/scene/resolve.h"
#include "core/scene/schema.h"
#include "core/scene/state_pictures.h"

namespace gxy {
namespace {

bool isOfCamera(AxisKind kind) {
  return kind == AxisKind::Phi || kind == AxisKind::Theta || kind == AxisKind::Angles ||
         kind == AxisKind::Camera;
}
bool isOfDocument(AxisKind kind) { return !isOfCamera(kind) && kind != AxisKind::Time; }

[[noreturn]] void failAt(const Sweep& sweep, TextPosition at, const std::string& message) {
  throw Error(locationPrefix(sweep.source, at) + message);
}

/// The number of a camera's axis values, which are all cameras if the sweep lists none.
size_t valuesOf(const SweepAxis& axis, const State& state) {
  if (axis.kind == AxisKind::Time) return 1;
  return axis.kind == AxisKind::Camera && axis.values.empty() ? std::max<size_t>(state.cameras.size(), 1)
                                                              : axis.values.size();
}

const SweepAxis* axisOf(const Sweep& sweep, AxisKind kind) {
  const auto at = std::find_if(sweep.axes.begin(), sweep.axes.end(),
                               [&](const SweepAxis& axis) { return axis.kind == kind; });
  return at == sweep.axes.end() ? nullptr : &*at;
}

void checkState(const Sweep& sweep, const State& state) {
  if (state.visualizations.size() != 1)
    throw Error(sweep.source + ": the state has " + std::to_string(state.visualizations.size()) +
                " visualizations, expected one");
  const SweepAxis* cameras = axisOf(sweep, AxisKind::Camera);
  if (!cameras && state.cameras.size() > 1)
    throw Error(sweep.source + ": the state has " + std::to_string(state.cameras.size()) +
                " cameras, expected one, or an axis \"camera\"");
  if (cameras)
    for (const SweepValue& value : cameras->values)
      if (value.numbers[0] >= double(std::max<size_t>(state.cameras.size(), 1)))
        failAt(sweep, value.at,
               "`values`: there is no camera " + value.cells[0] + ", expected 0 to " +
                   std::to_string(std::max<size_t>(state.cameras.size(), 1) - 1));
  for (const SweepAxis& axis : sweep.axes) {
    const auto& operators = state.visualizations[0].operators;
    const bool ofOperator = axis.kind == AxisKind::Isovalue || axis.kind == AxisKind::Slice ||
                            axis.kind == AxisKind::Clip || axis.kind == AxisKind::Colormap;
    if (!ofOperator) continue;
    if (operators.empty())
      failAt(sweep, axis.at, "axis: the visualization has no operators, expected one or more");
    if (size_t(axis.op) >= operators.size())
      failAt(sweep, axis.at,
             "`operator`: there is no operator " + std::to_string(axis.op) + ", expected 0 to " +
                 std::to_string(operators.size() - 1));
    const Vis& vis = operators[size_t(axis.op)];
    const bool iso = axis.kind == AxisKind::Isovalue;
    if ((iso || axis.kind == AxisKind::Slice) && vis.type != VisType::Volume)
      failAt(sweep, axis.at,
             "axis: operator " + std::to_string(axis.op) +
                 " shows no volume, expected one that does for isovalues and slices");
    const size_t some = iso                            ? std::max<size_t>(vis.isovalues.size(), 1)
                        : axis.kind == AxisKind::Slice ? vis.slices.size()
                        : axis.kind == AxisKind::Clip  ? vis.clipPlanes.size()
                                                       : 1;
    if (size_t(axis.index) >= some)
      failAt(sweep, axis.at,
             "`index`: operator " + std::to_string(axis.op) + " has " + std::to_string(some) +
                 " of them, expected a smaller number, from 0 on");
  }
}

/// Where a document axis writes its value.
std::string pointerOf(const SweepAxis& axis) {
  const std::string op = "/Visualizations/0/operators/" + std::to_string(axis.op);
  const std::string index = std::to_string(axis.index);
  switch (axis.kind) {
    case AxisKind::Isovalue:
      return op + "/isovalues/" + index;
    case AxisKind::Slice:
      return op + "/slices/" + index + "/3";
    case AxisKind::Clip:
      return op + "/clip planes/" + index + "/3";
    case AxisKind::Colormap:
      return op + "/colormap";
    default:
      return axis.path;
  }
}

/// The parts of a JSON Pointer, after its escapes.
std::vector<std::string> partsOf(const std::string& pointer) {
  std::vector<std::string> parts;
  for (size_t begin = 1; begin <= pointer.size();) {
    const size_t end = std::min(pointer.find('/', begin), pointer.size());
    std::string part = pointer.substr(begin, end - begin);
    for (const auto& [escape, character] : {std::pair{"~1", "/"}, std::pair{"~0", "~"}})
      for (size_t at = 0; (at = part.find(escape, at)) != std::string::npos; at++)
        part.replace(at, 2, character);
    parts.push_back(std::move(part));
    begin = end + 1;
  }
  return parts;
}

/// Writes a value into a document. Returns false if there is no place for it.
bool place(OrderedJson& document, const std::string& pointer, const std::string& value) {
  const std::vector<std::string> parts = partsOf(pointer);
  OrderedJson* at = &document;
  for (size_t i = 0; i < parts.size(); i++) {
    const std::string& part = parts[i];
    const bool last = i + 1 == parts.size();
    if (at->is_null()) *at = last && part == "0" ? OrderedJson::array() : OrderedJson::object();
    if (at->is_array()) {
      const bool number =
          !part.empty() && part.size() < 7 && part.find_first_not_of("0123456789") == part.npos;
      const size_t index = number ? size_t(std::stoul(part)) : at->size() + 1;
      if (index > at->size() || (index == at->size() && !last)) return false;
      if (index == at->size()) at->push_back(nullptr);
      at = &(*at)[index];
    } else if (at->is_object()) {
      // Only lists of an operator, such as `isovalues`, may be made anew; other objects must be there.
      if (!at->contains(part) && !last && i + 2 != parts.size()) return false;
      at = &(*at)[part];
    } else {
      return false;
    }
  }
  *at = OrderedJson::parse(value);
  return true;
}

/// Writes states in which the values of document axes have been changed.
class Documents {
 public:
  Documents(const Sweep& sweep, const State& state, const StateOfText& read)
      : sweep_(sweep),
        read_(read),
        saved_(OrderedJson::parse(writeState(state))),
        cameras_(state.cameras.size()) {
    for (const std::string& warning : read_(saved_.dump()).warnings) known_.insert(wordsOf(warning));
  }

  /// Throws Error unless each value alone makes a state.
  void check(const std::function<void()>& check) const {
    for (const SweepAxis& axis : sweep_.axes)
      if (isOfDocument(axis.kind))
        for (const SweepValue& value : axis.values) {
          if (check) check();
          with({{&axis, &value}});
        }
  }

  State with(const std::vector<std::pair<const SweepAxis*, const SweepValue*>>& values) const {
    OrderedJson document = saved_;
    for (const auto& change : values)
      if (!place(document, pointerOf(*change.first), change.second->json))
        failAt(sweep_, change.first->at,
               "`path`: " + inQuotes(change.first->path) +
                   " leads nowhere in the state; expected a JSON Pointer such as "
                   "\"/Renderer/tolerance\", into the state as it is saved");
    const SweepValue& last = *values.back().second;
    StateFile file;
    try {
      file = read_(document.dump());
      checkState(sweep_, file.state);
      if (axisOf(sweep_, AxisKind::Camera) && file.state.cameras.size() != cameras_)
        throw Error("it has " + std::to_string(file.state.cameras.size()) + " cameras, expected " +
                    std::to_string(cameras_) + " as without the sweep");
    } catch (const Error& e) {
      failAt(sweep_, last.at,
             "`values`: with " + inQuotes(last.cells[0]) + " the state is wrong: " + wordsOf(e.what()));
    }
    for (const std::string& warning : file.warnings)
      if (known_.count(wordsOf(warning)) == 0)
        failAt(sweep_, last.at,
               "`values`: with " + inQuotes(last.cells[0]) + " the state is wrong: " + wordsOf(warning));
    return std::move(file.state);
  }

 private:
  /// A message without its place, which is of a text that nobody has written.
  std::string wordsOf(const std::string& message) const {
    const auto numberBefore = [&](size_t end) {  // ":12" ends here; returns where it begins
      size_t begin = end;
      while (begin > 0 && message[begin - 1] >= '0' && message[begin - 1] <= '9') begin--;
      return begin < end && begin > 0 && message[begin - 1] == ':' ? begin - 1 : std::string::npos;
    };
    for (size_t end = message.find(": "); end != std::string::npos; end = message.find(": ", end + 1)) {
      const size_t column = numberBefore(end);
      if (column != std::string::npos && numberBefore(column) != std::string::npos)
        return message.substr(end + 2);
    }
    const std::string ofSweep = sweep_.source + ": ";
    return message.starts_with(ofSweep) ? message.substr(ofSweep.size()) : message;
  }

  const Sweep& sweep_;
  const StateOfText& read_;
  const OrderedJson saved_;
  const size_t cameras_;         ///< of the state
  std::set<std::string> known_;  ///< warnings that the state gives without any change
};

/// The camera of a picture: one of the state's, turned.
Camera cameraOf(const Sweep& sweep, const State& state, const std::vector<size_t>& chosen) {
  size_t index = 0;
  double phi = 0, theta = 0;
  for (size_t a = 0; a < sweep.axes.size(); a++) {
    const SweepAxis& axis = sweep.axes[a];
    if (axis.kind == AxisKind::Camera)
      index = axis.values.empty() ? chosen[a] : size_t(axis.values[chosen[a]].numbers[0]);
    if (axis.kind == AxisKind::Phi || axis.kind == AxisKind::Angles) phi = axis.values[chosen[a]].numbers[0];
    if (axis.kind == AxisKind::Theta) theta = axis.values[chosen[a]].numbers[0];
    if (axis.kind == AxisKind::Angles) theta = axis.values[chosen[a]].numbers[1];
  }
  const Camera camera = state.cameras.empty() ? defaultCamera() : state.cameras.at(index);
  return orbited(camera, phi, theta, sweep.center.value_or(camera.viewpoint + camera.viewdirection));
}

/// The scenes of a sweep, each once.
class Scenes {
 public:
  explicit Scenes(SweptPictures& swept) : swept_(swept) {}

  /// The index of the scene of a state, whose cameras do not count.
  size_t indexOf(const State& state) {
    State alone = state;
    alone.cameras.clear();
    const size_t hash = std::hash<std::string>()(writeState(alone));
    SweptScene scene{datasetsOf(alone.datasets), std::move(alone.visualizations.at(0)), alone.settings,
                     std::move(alone.annotations)};
    const auto [begin, end] = known_.equal_range(hash);
    for (auto at = begin; at != end; ++at)
      if (swept_.scenes[at->second] == scene) return at->second;
    known_.emplace(hash, swept_.scenes.size());
    swept_.scenes.push_back(std::move(scene));
    return swept_.scenes.size() - 1;
  }

 private:
  size_t datasetsOf(const std::vector<DatasetSpec>& datasets) {
    auto& all = swept_.datasets;
    const auto at = std::find(all.begin(), all.end(), datasets);
    const auto index = size_t(at - all.begin());
    if (at == all.end()) all.push_back(datasets);
    return index;
  }

  SweptPictures& swept_;
  std::unordered_multimap<size_t, size_t> known_;  ///< indices by a hash
};

}  // namespace

State SweptPictures::stateOf(size_t index) const {
  State state;
  state.datasets = datasets.at(index);
  for (const size_t s : scenesOf(index)) state.visualizations.push_back(scenes[s].visualization);
  return state;
}

std::vector<size_t> SweptPictures::scenesOf(size_t index) const {
  std::vector<size_t> some;
  for (size_t s = 0; s < scenes.size(); s++)
    if (scenes[s].datasets == index) some.push_back(s);
  return some;
}

std::vector<std::string> SweptPictures::parametersOf(size_t picture, const std::string& ofTime) const {
  std::vector<std::string> cells = pictures.at(picture).parameters;
  if (time) cells.at(*time) = ofTime;
  return cells;
}

size_t countOfPictures(const Sweep& sweep, State state) {
  useOwnCamera(state);
  checkState(sweep, state);
  uint64_t count = 1;
  for (const SweepAxis& axis : sweep.axes) count *= valuesOf(axis, state);
  if (count > kMostSweptPictures)
    throw Error(sweep.source + ": " + std::to_string(count) + " pictures, expected at most " +
                std::to_string(kMostSweptPictures) + " of one time");
  return size_t(count);
}

size_t countOfScenes(const Sweep& sweep) {
  size_t count = 1;
  for (const SweepAxis& axis : sweep.axes)
    if (isOfDocument(axis.kind)) count *= axis.values.size();
  return count;
}

SweptPictures sweptPictures(const Sweep& sweep, State state, const StateOfText& read,
                            const std::function<void()>& check) {
  useOwnCamera(state);
  const size_t total = countOfPictures(sweep, state);
  SweptPictures swept;
  swept.columns = sweep.columns();
  const Documents documents(sweep, state, read);
  documents.check(check);
  Scenes scenes(swept);
  std::map<std::vector<size_t>, std::pair<State, size_t>>
      made;  // with its scene, by the values of document axes
  std::vector<size_t> chosen(sweep.axes.size(), 0);
  for (size_t picture = 0; picture < total; picture++) {
    size_t rest = picture;
    for (size_t a = sweep.axes.size(); a-- > 0;) {
      const size_t values = valuesOf(sweep.axes[a], state);
      chosen[a] = rest % values;
      rest /= values;
    }
    std::vector<size_t> key;
    std::vector<std::pair<const SweepAxis*, const SweepValue*>> changes;
    SweptPicture one;
    for (size_t a = 0; a < sweep.axes.size(); a++) {
      const SweepAxis& axis = sweep.axes[a];
      if (axis.kind == AxisKind::Time) {
        swept.time = one.parameters.size();
        one.parameters.emplace_back();
      } else if (axis.values.empty()) {
        one.parameters.push_back(std::to_string(chosen[a]));
      } else {
        const SweepValue& value = axis.values[chosen[a]];
        one.parameters.insert(one.parameters.end(), value.cells.begin(), value.cells.end());
        if (isOfDocument(axis.kind)) {
          key.push_back(chosen[a]);
          changes.emplace_back(&axis, &value);
        }
      }
    }
    auto known = made.find(key);
    if (known == made.end()) {
      if (check) check();
      State changed = changes.empty() ? state : documents.with(changes);
      const size_t index = scenes.indexOf(changed);
      changed.visualizations.clear();
      changed.datasets.clear();
      known = made.emplace(std::move(key), std::pair(std::move(changed), index)).first;
    }
    cinemaFileName(one.parameters, swept.time);  // throws for a name that is too long
    one.scene = known->second.second;
    one.camera = cameraOf(sweep, known->second.first, chosen);
    swept.pictures.push_back(std::move(one));
  }
  return swept;
}

}  // namespace gxy
