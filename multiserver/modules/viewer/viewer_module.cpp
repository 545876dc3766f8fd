// SPDX-License-Identifier: Apache-2.0
// Module `viewer`: windows of clients, and batches of pictures.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "core/comm/error.h"
#include "core/data/dataset.h"
#include "core/rays/compiled_mesh.h"
#include "core/scene/camera.h"
#include "core/scene/colormaps.h"
#include "core/scene/json_text.h"
#include "core/scene/state_file.h"
#include "multiserver/modules/viewer/batch.h"
#include "multiserver/modules/viewer/cinema.h"
#include "multiserver/modules/viewer/documents.h"
#include "multiserver/modules/viewer/members.h"
#include "multiserver/modules/viewer/pick.h"
#include "multiserver/modules/viewer/window.h"
#include "multiserver/modules/viewer/windows.h"
#include "multiserver/protocol/json.h"
#include "multiserver/rendering/cost.h"
#include "multiserver/server/filter_runs.h"

namespace gxy::viewer {
namespace {

using nlohmann::json;
using protocol::Arguments;

std::shared_ptr<Windows> windowsOf(Session& session) {
  return session.state<Windows>([&] { return std::make_shared<Windows>(session); });
}

uint32_t windowId(Arguments& arguments) {
  const auto number = arguments.number();
  if (!number || *number < 1 || *number > 4294967295.0 || *number != double(uint32_t(*number)))
    arguments.fail("a window's ID is an integer from 1 to 4294967295");
  return uint32_t(*number);
}

json windowVerb(Services& services, Request& request, Arguments arguments) {
  Session& session = request.session();
  const uint32_t id = windowId(arguments);
  DocumentReader reader(request);
  Members members(reader, arguments.json(), "window");
  const auto windows = windowsOf(session);
  const auto known = windows->all();
  Window::Settings settings = known.count(id) ? known.at(id)->settings() : Window::Settings{};
  if (const json* size = members.find("size")) {
    if (!size->is_array() || size->size() != 2) members.fail("size", "[width, height]", *size);
    for (int i = 0; i < 2; i++)
      settings.size[i] = int(members.integerIn(size->at(size_t(i)), "size", 1, 65536));
    if (uint64_t(settings.size.x) * uint64_t(settings.size.y) > session.limits().pixels)
      members.fail("size", "at most " + std::to_string(session.limits().pixels) + " pixels", *size);
  }
  settings.follow = members.flag("follow", settings.follow);
  members.expectNoMore();
  windows->make(id, services, session.sharedOutbox())->setSettings(settings);
  return {{"window", id}, {"size", {settings.size.x, settings.size.y}}};
}

// Of data that no document can import, as those of filters, or whose document has no file for them; and of what data cannot show.
void warnOfData(Request& request, const Visualization& visualization, std::vector<std::string>& warnings) {
  ServerRank& serverRank = request.session().serverRank();
  std::set<std::string> told;
  for (const Vis& vis : visualization.operators) {
    const auto found = serverRank.datasets->find(request.session().tenant(), vis.dataset);
    if (!found && told.insert(vis.dataset).second)
      warnings.push_back("dataset " + inQuotes(vis.dataset) +
                         ": there is none that you see and the document has no file for it, expected one of "
                         "this name before a frame is rendered");
    if (!found || vis.type != VisType::Volume) continue;
    try {
      const auto dataset = serverRank.objects.pin(found->key).get<Dataset>();
      const auto warning = dataset->mesh ? warningOf(vis, *dataset->mesh) : std::nullopt;
      if (warning && told.insert(*warning).second) warnings.push_back(*warning);
    } catch (const Error&) {  // dropped meanwhile
    }
  }
}

json set(Request& request, Arguments arguments) {
  const uint32_t id = windowId(arguments);
  const WindowPtr window = windowsOf(request.session())->get(id);
  const std::string_view text = arguments.expectJson();
  StateFile file = DocumentReader(request).state(text, "set");
  const LedgerEntry room = roomFor(file.state, request.session());
  const auto& visualizations = file.state.visualizations;
  LedgerEntry memory;
  if (!visualizations.empty()) {
    checkCost(visualizations[0]);
    Session& session = request.session();
    memory = session.serverRank().takeMemory(session.tenant(), "windows", bytesOf(visualizations[0]));
  }
  const Camera* camera = file.state.cameras.empty() ? nullptr : &file.state.cameras[0];
  if (!visualizations.empty() && visualizations[0].view.camera) camera = &*visualizations[0].view.camera;
  if (camera) validate(*camera);
  for (std::string& w : importMissing(request, file.state.datasets)) file.warnings.push_back(std::move(w));
  if (!visualizations.empty()) warnOfData(request, visualizations[0], file.warnings);
  if (file.hasRenderer) window->setRenderer(file.state.settings);
  if (!visualizations.empty()) window->setVisualization(visualizations[0], std::move(memory));
  if (camera) window->setCamera(*camera);
  return {{"warnings", file.warnings}, {"text", linesOf(file.warnings)}};
}

struct RenderRequest {
  FrameOptions options;
  std::optional<Camera> camera;
};

Camera cameraOf(DocumentReader& reader, Members& members, const json& given, const char* verb) {
  const State state = reader.state(protocol::dump({{"Camera", given}}), verb).state;
  if (state.cameras.size() != 1) members.fail("Camera", "one camera", given);
  validate(state.cameras[0]);
  return state.cameras[0];
}

RenderRequest readRender(Request& request, const std::optional<std::string_view>& text) {
  DocumentReader reader(request);
  Members members(reader, text, "render");
  RenderRequest read;
  FrameOptions& options = read.options;
  if (const json* levels = members.find("levels")) {
    options.levels.clear();
    if (!levels->is_array() || levels->empty() || levels->size() > 7)
      members.fail("levels", "1 to 7 scales", *levels);
    for (const json& level : *levels) {
      const auto scale = uint32_t(members.integerIn(level, "levels", 1, 64));
      if (!options.levels.empty() && scale >= options.levels.back())
        members.fail("levels", "descending scales", *levels);
      options.levels.push_back(scale);
    }
  }
  options.passes = uint32_t(members.integer("passes", 1, 1, 4096));
  if (const json* rays = members.find("rays"))
    options.rays = uint32_t(members.integerIn(*rays, "rays", 1, 65536));
  options.quality = int(members.integer("quality", 75, 1, 100));
  options.tile = uint32_t(members.integer("tile", protocol::kTileSide, 64, protocol::kMostTileSide));
  options.wait = members.flag("wait", false);
  const std::string encoding = members.oneOf("encoding", {"zstd", "raw", "jpeg", "zlib"});
  options.encoding = encoding == "raw"    ? protocol::PixelEncoding::Raw
                     : encoding == "jpeg" ? protocol::PixelEncoding::Jpeg
                     : encoding == "zlib" ? protocol::PixelEncoding::Zlib
                                          : protocol::PixelEncoding::Zstd;
  if (const json* camera = members.find("Camera")) read.camera = cameraOf(reader, members, *camera, "render");
  members.expectNoMore();
  return read;
}

json render(Request& request, Arguments arguments) {
  const uint32_t id = windowId(arguments);
  const WindowPtr window = windowsOf(request.session())->get(id);
  const RenderRequest read = readRender(request, arguments.json());
  if (read.camera) window->setCamera(*read.camera);
  return {{"frame", window->render(read.options, askerOf(request))}};
}

json pickVerb(Services& services, Request& request, Arguments arguments) {
  const uint32_t id = windowId(arguments);
  glm::ivec2 pixel;
  for (int axis = 0; axis < 2; axis++) {
    const auto number = arguments.number();
    if (!number || std::abs(*number) > 65536 || *number != std::floor(*number))
      arguments.fail("X and Y are integers, a pixel of the window");
    pixel[axis] = int(*number);
  }
  arguments.expectEnd();
  const WindowPtr window = windowsOf(request.session())->get(id);
  return pick(services, request, *window, pixel);
}

json cancelFrame(Request& request, Arguments arguments) {
  const uint32_t id = windowId(arguments);
  arguments.expectEnd();
  windowsOf(request.session())->get(id)->cancel();
  return nullptr;
}

json closeWindow(Request& request, Arguments arguments) {
  const uint32_t id = windowId(arguments);
  arguments.expectEnd();
  windowsOf(request.session())->close(id);
  return nullptr;
}

json list(Request& request, Arguments arguments) {
  arguments.expectEnd();
  json windows = json::array();
  std::string text = "windows:";
  for (const auto& [id, window] : windowsOf(request.session())->all()) {
    const Window::Settings s = window->settings();
    windows.push_back({{"window", id},
                       {"size", {s.size.x, s.size.y}},
                       {"follow", s.follow},
                       {"frame", window->lastFrame()}});
    text += "\n" + std::to_string(id) + ": " + std::to_string(s.size.x) + " x " + std::to_string(s.size.y);
  }
  return {{"windows", windows}, {"text", text}};
}

// The entry from which a dataset can be had again: its file, or its filter.
DatasetSpec specOf(const std::string& name, const Dataset& d) {
  DatasetSpec spec{name, typeOf(d), d.file, d.array, d.color, d.radiusArray, d.fields};
  if (!d.stream.empty()) spec.array.clear();
  spec.filter = d.provenance.filter;
  spec.properties = d.provenance.properties;
  for (const Provenance::Input& input : d.provenance.inputs) {
    if (spec.inputs.empty() || spec.inputs.back().input != input.input)
      spec.inputs.push_back({input.input, {}});
    spec.inputs.back().datasets.push_back(input.name);
  }
  return spec;
}

// Adds the entry of what the tenant calls `name`, after those of what it is made of.
void addSpecs(Request& request, const std::string& name, std::vector<DatasetSpec>& specs) {
  Datasets& datasets = *request.session().serverRank().datasets;
  std::set<std::string> seen;
  for (const DatasetSpec& d : specs) seen.insert(d.name);
  std::vector<std::string> wanted{name};
  std::vector<DatasetSpec> found;
  while (!wanted.empty()) {
    const std::string next = std::move(wanted.back());
    wanted.pop_back();
    if (!seen.insert(next).second || !datasets.find(request.session().tenant(), next)) continue;
    const auto d = datasets.getPinned(request.session().tenant(), next).second.get<Dataset>();
    found.push_back(specOf(next, *d));
    for (const FilterInput& input : found.back().inputs)
      wanted.insert(wanted.end(), input.datasets.begin(), input.datasets.end());
  }
  std::move(found.rbegin(), found.rend(), std::back_inserter(specs));
}

json state(Request& request, Arguments arguments) {
  const uint32_t id = windowId(arguments);
  arguments.expectEnd();
  State state = windowsOf(request.session())->get(id)->state();
  for (const Visualization& v : state.visualizations)
    for (const Vis& vis : v.operators) addSpecs(request, vis.dataset, state.datasets);
  return {{"state", json::parse(writeState(state))}};
}

/// A batch, and the state that it renders.
struct BatchRequest {
  State state;
  std::string prefix;
  BatchRender render;
  std::vector<std::string> warnings;  ///< what of the document is not used
};

BatchRequest readBatch(Request& request, std::string_view text) {
  DocumentReader reader(request);
  Members members(reader, text, "batch");
  BatchRequest batch;
  const json* document = members.find("state");
  if (!document || !document->is_object())
    throw Error("batch: `state`: expected a state document; docs/protocol.md says what else there is");
  batch.render.toClient = members.oneOf("to", {"files", "client"}) == "client";
  batch.prefix = members.text("prefix", "picture");
  batch.render.format = members.oneOf("format", {"png", "exr", "raw"});
  batch.render.concurrent = int(members.integer("concurrent", 4, 1, 64));
  members.expectNoMore();
  StateFile file = reader.state(protocol::dump(*document), "batch");
  batch.state = std::move(file.state);
  batch.warnings = std::move(file.warnings);
  if (batch.state.visualizations.empty())
    throw Error("batch: `state` has no visualization, expected one or more");
  if (batch.state.cameras.empty()) batch.state.cameras = {defaultCamera()};
  return batch;
}

json batch(Services& services, Request& request, Arguments arguments) {
  BatchRequest batch = readBatch(request, arguments.expectJson());
  const LedgerEntry room = roomFor(batch.state, request.session());
  addPictures(batch.render, batch.state, batch.prefix);
  json result = renderBatch(services, request, batch.render);
  for (const json& w : result["warnings"]) batch.warnings.push_back(w);
  result["warnings"] = batch.warnings;
  if (!batch.warnings.empty())
    result["text"] = result["text"].get<std::string>() + "\n" + linesOf(batch.warnings);
  return result;
}

json camera(Request& request, Arguments arguments) {
  const uint32_t id = windowId(arguments);
  const WindowPtr window = windowsOf(request.session())->get(id);
  std::optional<Camera> camera;
  if (const auto text = arguments.json()) {
    DocumentReader reader(request);
    Members members(reader, text, "camera");
    if (const json* given = members.find("Camera")) camera = cameraOf(reader, members, *given, "camera");
    members.expectNoMore();
  }
  const Window::Seen seen = window->seen(camera);
  State state;
  state.cameras = {seen.camera};
  json ranges = json::array();
  for (const Range& range : seen.shown.ranges)
    ranges.push_back(range.empty() ? json() : json{range.min, range.max});
  const Box& box = seen.shown.box;
  return {
      {"Camera", json::parse(writeState(state)).at("Cameras").at(0)},
      {"box", box.empty() ? json() : json{{box.lo.x, box.lo.y, box.lo.z}, {box.hi.x, box.hi.y, box.hi.z}}},
      {"ranges", ranges}};
}

// What is asked for by NAME... [JSON]; `size`, if not null, is taken, too.
Look lookOf(Services& services, Request& request, Arguments& arguments, const char* verb,
            std::vector<std::string>& names, glm::ivec2* size) {
  names = {arguments.expectWord()};
  while (const auto name = arguments.word()) names.push_back(*name);
  DocumentReader reader(request);
  Members members(reader, arguments.json(), verb);
  LookOptions options;
  if (const json* values = members.find("isovalues")) {
    options.autoIsovalue = *values == "auto";
    if (!options.autoIsovalue && !values->is_array())
      members.fail("isovalues", "a list of numbers, or \"auto\"", *values);
    if (!options.autoIsovalue)
      for (const json& value : *values) {
        if (!value.is_number()) members.fail("isovalues", "a list of numbers, or \"auto\"", *values);
        options.isovalues.push_back(value.get<double>());
      }
  }
  options.slice = members.flag("slice", false);
  const std::string array = members.text("array", "");
  if (const json* sides = size ? members.find("size") : nullptr) {
    if (!sides->is_array() || sides->size() != 2) members.fail("size", "[width, height]", *sides);
    for (int i = 0; i < 2; i++) (*size)[i] = int(members.integerIn(sides->at(size_t(i)), "size", 1, 65536));
  }
  members.expectNoMore();
  return services.looks.look(request, names, array, options);
}

json scene(Services& services, Request& request, Arguments arguments) {
  std::vector<std::string> names;
  const Look look = lookOf(services, request, arguments, "scene", names, nullptr);
  json result{{"state", json::parse(writeState(look.state))}, {"text", writeState(look.state)}};
  for (const Look::Step& step : look.steps)
    result["steps"].push_back({{"time", step.time ? json(*step.time) : json()}, {"files", step.files}});
  return result;
}

// `show ID {"graph": ..., "view": ...}`: a window on a view of a graph; nothing if something else is to be shown.
std::optional<json> showView(Services& services, Request& request, Arguments arguments) {
  Arguments words = arguments;
  words.expectWord();
  if (words.word()) return std::nullopt;
  const auto text = words.json();
  DocumentReader reader(request);
  if (!text || !reader.object(*text, "show").contains("graph")) return std::nullopt;
  Session& session = request.session();
  const uint32_t id = windowId(arguments);
  Members members(reader, arguments.json(), "show");
  const std::string name = members.text("graph", ""), view = members.text("view", "");
  if (view.empty()) throw Error("show: `view` is missing, expected the name of a view of the graph");
  members.expectNoMore();
  const auto graph = services.graphs->get(session.tenant(), name);
  const auto windows = windowsOf(session);
  const bool isNew = windows->all().count(id) == 0;
  const WindowPtr window = windows->make(id, services, session.sharedOutbox());
  const auto size = graph->content(view).size;
  if (isNew && size && uint64_t(size->x) * uint64_t(size->y) <= session.limits().pixels)
    window->setSettings({*size, false});
  window->setGraph(graph, view);
  return json{{"window", id}, {"graph", name}, {"view", view}, {"text", ""}};
}

json show(Services& services, Request& request, Arguments arguments) {
  if (auto shown = showView(services, request, arguments)) return *std::move(shown);
  std::vector<std::string> names;
  glm::ivec2 size = Camera().dimensions;
  State state = lookOf(services, request, arguments, "show", names, &size).state;
  state.cameras[0].dimensions = size;
  BatchRender batch;
  batch.toClient = true;
  std::string prefix = state.visualizations[0].operators[0].dataset;
  std::replace(prefix.begin(), prefix.end(), '/', '_');
  addPictures(batch, state, prefix);
  json result = renderBatch(services, request, batch);
  result["state"] = json::parse(writeState(state));
  const auto warnings = result["warnings"].get<std::vector<std::string>>();
  std::string command = "gxyviewer";
  for (const std::string& name : names) command += " " + name;
  std::string text = result["pictures"].at(0).get<std::string>() + "; to turn it: " + command;
  if (!warnings.empty()) text += "\n" + linesOf(warnings);
  result["text"] = text;
  return result;
}

json colormaps(Request&, Arguments arguments) {
  arguments.expectEnd();
  json maps = json::array();
  std::string text;
  for (const std::string_view name : shippedColorMaps()) {
    json colors = json::array();
    const ColorMap map = shippedColorMap(name).value();
    for (const ColorPoint& p : map.points) colors.push_back({p.value, p.rgb.x, p.rgb.y, p.rgb.z});
    maps.push_back({{"name", name}, {"colors", std::move(colors)}});
    text += (text.empty() ? "" : "\n") + std::string(name);
  }
  return {{"maps", std::move(maps)}, {"text", std::move(text)}};
}

// Windows belong to their session, so what makes and changes them looks. `set` and `show` import nothing for a view-only
// session (FilterRuns::importAndMake).
Verb verb(std::string name, std::string arguments, std::string help, Order order,
          std::function<json(Request&, Arguments)> action, Effect effect = Effect::Looks) {
  Verb v{std::move(name), std::move(arguments), std::move(help), order, {}, effect};
  v.action = [usage = v.name + (v.arguments.empty() ? "" : " " + v.arguments), action = std::move(action)](
                 Request& request) { return action(request, Arguments(request.arguments(), usage)); };
  return v;
}

}  // namespace
}  // namespace gxy::viewer

GALAXY_MODULE(registration) {
  using namespace gxy;
  using namespace gxy::viewer;
  const auto services = std::make_shared<Services>(registration);
  registration.keep(services);
  Services& s = *services;
  registration.verb(verb("window", "ID [JSON]", "Makes or changes a window: size, follow.", Order::InTurn,
                         [&s](Request& r, Arguments a) { return windowVerb(s, r, std::move(a)); }));
  registration.verb(
      verb("set", "ID JSON", "What the window shows: parts of a state document.", Order::InTurn, set));
  registration.verb(verb("render", "ID [JSON]", "Begins a frame.", Order::InTurn, render));
  registration.verb(verb("pick", "ID X Y", "What the window shows at a pixel.", Order::InTurn,
                         [&s](Request& r, Arguments a) { return pickVerb(s, r, std::move(a)); }));
  registerPick(registration, s);
  registration.verb(verb("cancel_frame", "ID", "Ends the frame under way.", Order::InTurn, cancelFrame));
  registration.verb(verb("close", "ID", "Forgets a window.", Order::InTurn, closeWindow));
  registration.verb(verb("windows", "", "Lists the windows.", Order::InTurn, list));
  registration.verb(verb("state", "ID", "The window's state document.", Order::InTurn, state));
  registration.verb(
      verb("camera", "ID [JSON]",
           "The window's camera, or the one given, where its `fit` puts it, and the box and the "
           "ranges of the data shown.",
           Order::InTurn, camera));
  registration.verb(
      verb("colormaps", "", "The colour maps that the server ships.", Order::InTurn, colormaps));
  registration.verb(verb("scene", "NAME... [JSON]", "A state document that shows datasets or data files.",
                         Order::Aside, [&s](Request& r, Arguments a) { return scene(s, r, std::move(a)); }));
  registration.verb(verb("show", "NAME... [JSON] | ID {\"graph\": NAME, \"view\": NAME}",
                         "Sends a picture of datasets or data files; or has a window show a view of a graph.",
                         Order::Aside, [&s](Request& r, Arguments a) { return show(s, r, std::move(a)); }));
  registration.verb(verb(
      "batch", "JSON", "Renders every visualization with every camera of a state.", Order::Aside,
      [&s](Request& r, Arguments a) { return batch(s, r, std::move(a)); }, Effect::Changes));
  registration.verb(verb(
      "cinema", "JSON", "Makes a Cinema database of a sweep, or adds to it.", Order::Aside,
      [&s](Request& r, Arguments a) { return cinema(s, r, a.expectJson()); }, Effect::Changes));
}
