// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/remote_window.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "core/comm/error.h"
#include "core/scene/state_file.h"
#include "multiserver/protocol/json.h"
#include "multiserver/protocol/statement.h"

namespace gxy {

using nlohmann::json;
using protocol::PixelHeader;
using protocol::PixelKind;

namespace {

constexpr std::chrono::milliseconds kRest{250};  // After this time without a new camera, the camera rests.
// Shortest and longest time until a refused frame is requested again.
constexpr std::chrono::seconds kAgain{1};
constexpr std::chrono::seconds kAgainAtMost{16};
constexpr size_t kUnderWay = 2;            // number of frames under way while the camera moves
constexpr uint64_t kMeasurable = 8 << 10;  // From this many bytes on, the speed of the link can be measured.
constexpr const char* kWindow = "1";
constexpr uint32_t kStillWindow = 2;

json cameraJson(const Camera& camera) {
  State state;
  state.cameras = {camera};
  const json document = json::parse(writeState(state));
  const json& cameras = document.contains("Cameras") ? document["Cameras"] : document["Camera"];
  return cameras.is_array() ? cameras.at(0) : cameras;
}

std::vector<std::string> namesOf(const State& state) {
  std::vector<std::string> names;
  for (const Vis& vis : state.visualizations.at(0).operators)
    if (std::find(names.begin(), names.end(), vis.dataset) == names.end()) names.push_back(vis.dataset);
  return names;
}

std::string statement(const std::string& verb, const json& argument) {
  return verb + " " + kWindow + " " + protocol::dump(argument);
}

}  // namespace

RemoteWindow::RemoteWindow(Client::Options options, const State& state, uint32_t passes, OnWarning onWarning)
    : passes_(passes),
      onWarning_(std::move(onWarning)),
      canvas_({1, 1}),
      shownCamera_(state.cameras.at(0)),
      camera_(state.cameras.at(0)) {
  options.onPixels = [this](const PixelHeader& header, auto data) { takePixels(header, data); };
  options.onEvent = [this](const json& event) { takeEvent(event); };
  options.onEnd = [this](const std::string& why) { fail("the connection has ended: " + why); };
  client_ = std::make_unique<Client>(std::move(options));
  const glm::ivec2 size = camera_.dimensions;
  if (const uint64_t most = client_->welcome().limits.pixels; uint64_t(size.x) * uint64_t(size.y) > most)
    throw Error("a window of " + std::to_string(size.x) + " x " + std::to_string(size.y) +
                ": expected at most " + std::to_string(most) + " pixels");
  {
    const std::lock_guard lock(mutex_);
    canvas_.resize(size);
  }
  client_->expect("load data");
  client_->expect("load viewer");
  client_->expect(statement("viewer.window", {{"size", {size.x, size.y}}, {"follow", true}}));
  // Requests are answered in turn, so the reply to this echo comes after those to all requests before.
  set(state, [this](const std::string& error) { fail(error); });
  client_->send("server.echo", [this](const Reply& reply) {
    if (!reply.ok) return fail(reply.error);
    const std::lock_guard lock(mutex_);
    loaded_ = true;
    progress_.clear();
    changed_.notify_all();
  });
}

void RemoteWindow::set(const State& state, std::function<void(const std::string& error)> refused) {
  client_->send(statement("viewer.set", json::parse(writeState(state))),
                [this, refused = std::move(refused)](const Reply& reply) {
                  if (!reply.ok) return refused(reply.error);
                  {
                    const std::lock_guard lock(mutex_);
                    setError_.clear();
                  }
                  if (onWarning_ && reply.value.contains("warnings"))
                    for (const json& warning : reply.value["warnings"])
                      if (warning.is_string()) onWarning_(warning);
                });
  {
    const std::lock_guard lock(mutex_);
    names_ = namesOf(state);
    boxes_.clear();
  }
  for (const std::string& name : names_)
    client_->send("data.observe " + protocol::asWord(name), [](const Reply&) {});
  askForBoxes();
}

void RemoteWindow::show(const State& state) {
  State without = state;
  without.cameras.clear();
  set(without, [this](const std::string& error) {
    const std::lock_guard lock(mutex_);
    setError_ = error;
  });
  cameraSent_ = false;
  moved_ = Clock::now();
}

void RemoteWindow::import(const std::vector<DatasetSpec>& datasets) {
  State state;
  state.datasets = datasets;
  const json document = json::parse(writeState(state));
  {
    const std::lock_guard lock(mutex_);
    for (const DatasetSpec& dataset : datasets) own_.insert(dataset.name);
  }
  client_->send("data.import " + protocol::dump({{"Datasets", document.at("Datasets")}}),
                [this](const Reply& reply) {
                  const std::lock_guard lock(mutex_);
                  progress_.clear();
                  imported_ = Imported{reply.ok ? std::string() : reply.error, {}};
                  if (reply.ok) imported_->generations = reply.value.value("generations", Generations());
                });
}

std::optional<RemoteWindow::Imported> RemoteWindow::imported() {
  const std::lock_guard lock(mutex_);
  return std::exchange(imported_, std::nullopt);
}

void RemoteWindow::drop(const std::vector<DatasetSpec>& datasets) {
  try {
    client_->send(std::string("viewer.close ") + kWindow, [](const Reply&) {});
    for (const DatasetSpec& dataset : datasets)
      client_->request("data.drop " + protocol::asWord(dataset.name));
  } catch (const Error&) {
    // The server has gone.
  }
}

void RemoteWindow::fail(const std::string& why) {
  const std::lock_guard lock(mutex_);
  if (failure_.empty()) failure_ = why;
  changed_.notify_all();
}

void RemoteWindow::askForBoxes() {
  for (const std::string& name : names_)
    client_->send("data.info " + protocol::asWord(name),
                  [this, name](const Reply& reply) { takeInfo(name, reply); });
  client_->send(std::string("viewer.camera ") + kWindow, [this](const Reply& reply) { takeShown(reply); });
}

// If the reply is an error, there are no annotations.
void RemoteWindow::takeShown(const Reply& reply) {
  ShownSoFar shown;
  if (reply.ok && reply.value.is_object()) {
    for (const json& range : reply.value.value("ranges", json::array())) {
      Range& to = shown.ranges.emplace_back();
      if (!range.is_null()) to = {range.at(0), range.at(1)};
    }
    if (const json box = reply.value.value("box", json()); !box.is_null())
      for (const json& corner : box) shown.box.extend(glm::dvec3(corner.at(0), corner.at(1), corner.at(2)));
  }
  const std::lock_guard lock(mutex_);
  shown_ = std::move(shown);
  canvasChanged_ = true;
}

// A dataset that does not exist has no box. Frames report the consequences for the picture.
void RemoteWindow::takeInfo(const std::string& name, const Reply& reply) {
  const std::lock_guard lock(mutex_);
  boxes_.erase(name);
  if (!reply.ok || std::find(names_.begin(), names_.end(), name) == names_.end()) return;
  for (const json& dataset : reply.value.at("datasets"))
    if (!dataset.at("box").is_null()) boxes_[name] = dataset.at("box").get<Box>();  // null: no data
}

void RemoteWindow::takePixels(const PixelHeader& header, std::span<const std::byte> data) {
  const auto now = Clock::now();
  const std::lock_guard lock(mutex_);
  statistics_.bytes += data.size();
  if (header.window == kStillWindow) {
    if (still_) still_->take(header, data);
    return;
  }
  if (header.frame < frame_.number) return;
  const auto text = [&] {
    return protocol::parseObject({reinterpret_cast<const char*>(data.data()), data.size()}, "frame");
  };
  if (header.frame > frame_.number) {
    if (header.kind == PixelKind::EndOfFrame && text().at("status") == "superseded") {
      asked_.skip(header.frame);  // It never began, so the frame before it goes on.
      return changed_.notify_all();
    }
    frame_ = {};
    frame_.number = header.frame;
  }
  if (header.kind == PixelKind::Tile && frame_.bytes == 0 && !frame_.shown) {
    // Pixels have come, so earlier errors are over.
    renderError_.clear();
    refusals_ = 0;
    again_.reset();
  }
  if (header.kind == PixelKind::EndOfFrame) {
    const json end = text();
    frame_.ended = true;
    frame_.status = end.at("status");
    frame_.error = end.value("error", "");
    frame_.seconds = end.at("seconds");
    frame_.generations = end.at("generations").get<std::map<std::string, uint64_t>>();
    asked_.done(header.frame);
  } else {
    if (header.kind == PixelKind::Tile && !frame_.shown) {
      if (frame_.bytes == 0) frame_.begin = now, frame_.firstBytes = data.size();
      frame_.bytes += data.size();
    }
    canvasChanged_ |= canvas_.take(header, data);
    if (header.kind == PixelKind::EndOfPass) {
      frame_.scale = header.scale;
      frame_.pass = header.pass;
      if (!frame_.shown) showFirst(text());
    }
  }
  changed_.notify_all();
}

// Called when the first pass of the newest frame is complete. `pass` is the text of its end.
void RemoteWindow::showFirst(const json& pass) {
  const auto now = Clock::now();
  frame_.shown = true;
  Generations shown = pass.value("generations", Generations());
  canvasChanged_ |= shown != generations_;  // Annotations may show them.
  generations_ = std::move(shown);
  statistics_.frames++;
  statistics_.passBytes = frame_.bytes;
  if (const auto camera = asked_.cameraOf(frame_.number)) shownCamera_ = *camera;
  if (const FramesAsked::Asked* asked = asked_.find(frame_.number)) {
    statistics_.firstPixels = std::chrono::duration<double>(now - asked->at).count();
    if (asked->moving) {
      Pace::Pass took{*asked->moving, pass.at("seconds"), frame_.bytes, {}};
      const double seconds = std::chrono::duration<double>(now - frame_.begin).count();
      const uint64_t bytes = frame_.bytes - frame_.firstBytes;
      if (bytes >= kMeasurable && seconds > 0) took.bytesPerSecond = double(bytes) / seconds;
      pace_.take(took);
    }
  }
  asked_.done(frame_.number);
}

void RemoteWindow::takeEvent(const json& event) {
  const std::lock_guard lock(mutex_);
  const std::string kind = event.value("event", "");
  if (kind == "progress") progress_ = event.value("text", "");
  if (kind == "waiting") progress_ = event.value("ranks", json()).empty() ? "" : event.value("text", "");
  if (kind == "error") renderError_ = event.value("text", "");  // The server will try again.
  for (const char* change : {"added", "updated", "dropped", "renamed", "lost"}) boxesDue_ |= kind == change;
}

Camera RemoteWindow::fittedCamera(const Camera& camera) {
  const json reply = client_->expect(statement("viewer.camera", {{"Camera", cameraJson(camera)}}));
  Camera fitted = readState(protocol::dump({{"Camera", reply.at("Camera")}}), "camera").state.cameras.at(0);
  fitted.dimensions = camera.dimensions;
  return fitted;
}

void RemoteWindow::setCamera(const Camera& camera) {
  if (camera == camera_) return;
  camera_ = camera;
  cameraSent_ = false;
  moved_ = Clock::now();
}

void RemoteWindow::resize(glm::ivec2 size) {
  {
    const std::lock_guard lock(mutex_);
    if (size == canvas_.size()) return;
    pace_.resized(double(size.x) * size.y / (double(canvas_.size().x) * canvas_.size().y));
    canvas_.resize(size);
    canvasChanged_ = true;
  }
  camera_.dimensions = size;
  cameraSent_ = false;
  moved_ = Clock::now();
  client_->send(statement("viewer.window", {{"size", {size.x, size.y}}}), [this](const Reply& reply) {
    const std::lock_guard lock(mutex_);
    if (!reply.ok) renderError_ = reply.error;
  });
}

void RemoteWindow::update(Clock::time_point now) {
  size_t underWay;
  bool again, boxesDue;
  {
    const std::lock_guard lock(mutex_);
    if (!loaded_ || !failure_.empty()) return;
    underWay = asked_.underWay();
    again = again_ && now >= *again_;
    boxesDue = std::exchange(boxesDue_, false);
  }
  if (boxesDue) askForBoxes();
  closeStill();
  if (!cameraSent_ && underWay < kUnderWay)
    render(true, now);
  else if (cameraSent_ && underWay == 0 && (movingSent_ ? now - moved_ >= kRest : again))
    render(false, now);
}

void RemoteWindow::pick(glm::ivec2 pixel) {
  client_->send(
      std::string("viewer.pick ") + kWindow + " " + std::to_string(pixel.x) + " " + std::to_string(pixel.y),
      [this](const Reply& reply) {
        const std::lock_guard lock(mutex_);
        picked_ = reply.ok ? reply.value.value("text", "") : "error: " + reply.error;
      });
}

std::optional<std::string> RemoteWindow::picked() {
  const std::lock_guard lock(mutex_);
  return std::exchange(picked_, std::nullopt);
}

bool RemoteWindow::whole() const {
  const std::lock_guard lock(mutex_);
  return cameraSent_ && !movingSent_ && asked_.underWay() == 0 && frame_.number == asked_.newest() &&
         frame_.ended && frame_.status == "complete" && canvas_.frame() == asked_.newest();
}

std::shared_ptr<const Still> RemoteWindow::still(const State& state) {
  const std::lock_guard lock(mutex_);
  return still_ = Still::begin(*client_, kStillWindow, state, passes_);
}

// Closes the window of a finished still picture, because it holds data and memory on the server.
void RemoteWindow::closeStill() {
  {
    const std::lock_guard lock(mutex_);
    if (!still_ || !still_->progress().ended) return;
    still_ = nullptr;
  }
  client_->send("viewer.close " + std::to_string(kStillWindow), [](const Reply&) {});
}

void RemoteWindow::render(bool moving, Clock::time_point now) {
  json options{{"Camera", cameraJson(camera_)}, {"rays", 1}};
  {
    const std::lock_guard lock(mutex_);
    FramesAsked::Asked& asked = asked_.ask(now);
    asked.camera = camera_;
    if (moving) {
      asked.moving = statistics_.detail = pace_.choose();
      options["levels"] = {asked.moving->scale};
      options["encoding"] = "jpeg";
      options["quality"] = asked.moving->quality;
      options["wait"] = movingSent_;  // Do not wait for a frame at rest.
    } else {
      const uint32_t scale = statistics_.detail.scale;
      options["levels"] = statistics_.frames > 0 && scale > 1 ? json{scale, 1} : json{1};
      options["passes"] = passes_;
    }
    again_.reset();
  }
  cameraSent_ = true;
  movingSent_ = moving;
  client_->send(statement("viewer.render", options), [this](const Reply& reply) { takeNumber(reply); });
}

// Replies come in the order of the requests.
void RemoteWindow::takeNumber(const Reply& reply) {
  const std::lock_guard lock(mutex_);
  progress_.clear();
  if (reply.ok) {
    asked_.number(reply.value.at("frame").get<uint64_t>());
  } else {
    asked_.refuse();
    renderError_ = reply.error;
    again_ = Clock::now() + std::min(kAgain * (1 << std::min(refusals_++, 10)), kAgainAtMost);
  }
  changed_.notify_all();
}

bool RemoteWindow::loaded() const {
  const std::lock_guard lock(mutex_);
  return loaded_;
}

std::optional<RemoteWindow::Box> RemoteWindow::box() const {
  const std::lock_guard lock(mutex_);
  std::optional<Box> all;
  for (const auto& [name, box] : boxes_) {
    if (!all) all = box;
    for (size_t axis = 0; axis < 3; axis++) {
      (*all)[0][axis] = std::min((*all)[0][axis], box[0][axis]);
      (*all)[1][axis] = std::max((*all)[1][axis], box[1][axis]);
    }
  }
  return all;
}

ShownSoFar RemoteWindow::shown() const {
  const std::lock_guard lock(mutex_);
  return shown_;
}

void RemoteWindow::ifChanged(
    const std::function<void(const Canvas&, const Camera&, const Generations&)>& use) {
  const std::lock_guard lock(mutex_);
  if (std::exchange(canvasChanged_, false)) use(canvas_, shownCamera_, generations_);
}

void RemoteWindow::showAgain() {
  const std::lock_guard lock(mutex_);
  canvasChanged_ = true;
}

Canvas RemoteWindow::picture() const {
  const std::lock_guard lock(mutex_);
  return canvas_;
}

RemoteWindow::Generations RemoteWindow::generations() const {
  const std::lock_guard lock(mutex_);
  return generations_;
}

bool RemoteWindow::refused() const {
  const std::lock_guard lock(mutex_);
  return !whyRefused().empty();
}

std::string RemoteWindow::whyRefused() const {
  if (!setError_.empty()) return setError_;
  if (!renderError_.empty()) return renderError_;
  if (!frame_.ended || frame_.status != "failed") return {};
  return frame_.error.empty() ? "the frame failed" : frame_.error;
}

std::string RemoteWindow::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

std::string RemoteWindow::status() const {
  const std::lock_guard lock(mutex_);
  if (!failure_.empty()) return "error: " + failure_;
  if (!loaded_) return progress_.empty() ? "loading data ..." : progress_;
  if (!progress_.empty()) return progress_;
  if (const std::string why = whyRefused(); !why.empty()) return "error: " + why;
  if (frame_.number == 0) return "waiting for the first picture ...";
  if (frame_.scale != 1) return "rendering ...";
  if (!frame_.ended)
    return "refining: " + std::to_string(frame_.pass + 1) + " of " + std::to_string(passes_) + " passes";
  std::string text(32, '\0');
  text.resize(size_t(std::snprintf(text.data(), text.size(), "%.2f s", frame_.seconds)));
  for (const auto& [name, generation] : frame_.generations)
    if (generation > 1 && !own_.contains(name))
      text += ", " + name + ": generation " + std::to_string(generation);
  return text;
}

RemoteWindow::Statistics RemoteWindow::statistics() const {
  const std::lock_guard lock(mutex_);
  Statistics statistics = statistics_;
  statistics.passes = frame_.scale == 1 ? frame_.pass + 1 : 0;
  statistics.ended = frame_.ended && frame_.number == asked_.newest() && asked_.underWay() == 0;
  return statistics;
}

void RemoteWindow::waitUntilLoaded() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return loaded_ || !failure_.empty(); });
  if (!failure_.empty()) throw Error(failure_);
}

void RemoteWindow::renderWhole() {
  {
    const std::lock_guard lock(mutex_);
    renderError_.clear();
  }
  render(false, Clock::now());
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] {  // A frame with newer data may supersede it.
    return !failure_.empty() || !renderError_.empty() ||
           (asked_.underWay() == 0 && asked_.newest() > 0 && frame_.number == asked_.newest() &&
            frame_.ended && frame_.status != "superseded");
  });
  if (!failure_.empty()) throw Error(failure_);
  if (!renderError_.empty()) throw Error(renderError_);
  if (frame_.status != "complete")
    throw Error("the frame was " + frame_.status + (frame_.error.empty() ? "" : ": " + frame_.error));
}

}  // namespace gxy
