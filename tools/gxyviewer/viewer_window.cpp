// SPDX-License-Identifier: Apache-2.0
#include "tools/gxyviewer/viewer_window.h"

#include <X11/Xlib.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkObjectFactory.h>
#include <vtkRenderWindowInteractor.h>

#include <algorithm>
#include <cctype>
#include <deque>
#include <filesystem>
#include <functional>
#include <glm/geometric.hpp>
#include <map>

#include "core/annotate/annotations.h"
#include "core/comm/error.h"
#include "core/image/replace_file.h"
#include "core/scene/state_file.h"
#include "tools/gxyviewer/camera_view.h"
#include "tools/gxyviewer/picture_view.h"
#include "tools/gxyviewer/png.h"

namespace gxy {

namespace {

using Clock = RemoteWindow::Clock;
constexpr unsigned long kTickMilliseconds = 10;
constexpr double kSpinDegreesPerSecond = 30;
constexpr std::chrono::seconds kNoticeTime{4};
constexpr double kNarrower = 0.8, kShift = 0.1;  // change of a data range for each key press

/// VTK's trackball without VTK's key bindings.
class Style : public vtkInteractorStyleTrackballCamera {
 public:
  static Style* New();
  vtkTypeMacro(Style, vtkInteractorStyleTrackballCamera);
  void OnChar() override {}
  void OnTimer() override {}  // VTK would repeat the last step of a drag at each timer event.
};
vtkStandardNewMacro(Style);

class ViewerWindow {
 public:
  ViewerWindow(RemoteWindow& remote, Selection selection, Series series, std::string output, bool annotated,
               NewerState newer)
      : remote_(remote),
        selection_(std::move(selection)),
        series_(std::move(series)),
        output_(std::move(output)),
        newer_(std::move(newer)),
        annotates_(annotated),
        shown_(selection_.camera().dimensions) {
    interactor_->SetRenderWindow(&shown_.window());
    interactor_->SetInteractorStyle(style_);
    observe(vtkCommand::TimerEvent, [](ViewerWindow& self) { self.tick(); });
    observe(vtkCommand::KeyPressEvent, [](ViewerWindow& self) { self.key(); });
    show(selection_.camera(), view());
  }

  void run() {
    interactor_->Initialize();
    shown_.layOut();
    shown_.draw();
    interactor_->CreateRepeatingTimer(kTickMilliseconds);
    interactor_->Start();
    if (const std::string failure = remote_.failure(); !failure.empty()) throw Error(failure);
  }

 private:
  vtkCamera& view() { return *shown_.renderer().GetActiveCamera(); }
  Camera cameraNow() { return cameraOf(view(), size_, selection_.camera().annotation); }

  // While a button is held, the style has the focus, and only passive observers receive events besides it.
  void observe(unsigned long event, void (*action)(ViewerWindow&)) {
    vtkNew<vtkCallbackCommand> command;
    command->SetPassiveObserver(1);
    command->SetClientData(new Call{*this, action});
    command->SetClientDataDeleteCallback([](void* call) { delete static_cast<Call*>(call); });
    command->SetCallback([](vtkObject*, unsigned long, void* data, void*) {
      const Call& call = *static_cast<Call*>(data);
      try {
        call.action(call.self);
      } catch (const Error& e) {
        call.self.say(std::string("error: ") + e.what());
      }
    });
    interactor_->AddObserver(event, command);
  }

  void tick() {
    const Clock::time_point now = Clock::now();
    if (const glm::ivec2 size = shown_.size(); size != size_) {
      size_ = size;
      remote_.resize(size);
      view().SetUseHorizontalViewAngle(size.x < size.y);
      shown_.layOut();
    }
    if (!centered_ && remote_.box()) {
      centered_ = true;
      turnAboutData();
    }
    if (spinning_) {
      view().Azimuth(kSpinDegreesPerSecond * std::chrono::duration<double>(now - lastTick_).count());
      view().OrthogonalizeViewUp();
    }
    lastTick_ = now;
    takeNewer();
    goOnInTime();
    remote_.setCamera(cameraNow());
    remote_.update(now);
    if (const auto picked = remote_.picked()) say(*picked);
    savePictures();
    if (leaves_ && savings_.empty()) interactor_->TerminateApp();
    bool changed = false;
    const ShownSoFar data = remote_.shown();
    remote_.ifChanged(
        [&](const Canvas& canvas, const Camera& camera, const RemoteWindow::Generations& generations) {
          withOverlay(data, camera, canvas.size(), series_.stepOf(generationSeen(generations)),
                      [&](const Overlay& overlay) { shown_.setPicture(canvas, overlay); });
          changed = true;
        });
    changed |= shown_.setStatus(now < noticeEnd_ ? notice_ : status());
    if (changed) shown_.draw();
  }

  // Calls use(overlay) with the overlay for a camera's picture of a step. If it cannot be drawn, for example
  // without a font, it shows the reason and calls use() with an empty overlay.
  template <class Use>
  void withOverlay(const ShownSoFar& data, Camera camera, glm::ivec2 size, size_t step, const Use& use) {
    if (!annotates_) return use(Overlay());
    camera.dimensions = size;
    camera.fit = false;
    const State state = selection_.shown();
    Annotations what = state.annotations;
    if (what == Annotations()) {
      what.legend = what.axes = what.outline = true;
      if (series_.timeOf(step)) what.text = "time {time}";
    }
    try {
      return use(overlayOf(
          what, {state.visualizations[0], data, camera, state.settings, step, series_.timeOf(step)}));
    } catch (const Error& e) {
      annotates_ = false;
      say(std::string("error: ") + e.what());
    }
    use(Overlay());
  }

  std::string status() const {
    std::string text = newerError_.empty() ? remote_.status() : newerError_;
    for (const std::string& more : {selection_.text(), stepText(), std::string(spinning_ ? "spinning" : ""),
                                    saving(), std::string("h: keys")})
      if (!more.empty()) text += "   " + more;
    return text;
  }

  // If the focal point is outside the data's box, moves it along the view direction to the depth of the box's
  // centre.
  void turnAboutData() {
    const auto box = remote_.box();
    if (!box) return;
    const double* focus = view().GetFocalPoint();
    bool inside = true;
    for (int axis = 0; axis < 3; axis++)
      inside &= focus[axis] >= (*box)[0][axis] && focus[axis] <= (*box)[1][axis];
    if (inside) return;
    double along = 0;
    for (int axis = 0; axis < 3; axis++)
      along += view().GetDirectionOfProjection()[axis] *
               (((*box)[0][axis] + (*box)[1][axis]) / 2 - view().GetPosition()[axis]);
    if (along > 0) view().SetDistance(along);
  }

  void reset() {
    const auto box = remote_.box();
    if (!box) return say("there are no data to reset to yet");
    const auto& [low, high] = *box;
    shown_.renderer().ResetCamera(low[0], high[0], low[1], high[1], low[2], high[2]);
  }

  void lookAlong(int axis, double sign) {
    double direction[3] = {0, 0, 0};
    direction[axis] = sign;
    const double distance = view().GetDistance();
    double focus[3];
    view().GetFocalPoint(focus);
    view().SetPosition(focus[0] - distance * direction[0], focus[1] - distance * direction[1],
                       focus[2] - distance * direction[2]);
    view().SetViewUp(0, axis == 1 ? 0 : 1, axis == 1 ? 1 : 0);
  }

  // Shows a newer state. If the camera in the file has changed, it becomes the camera.
  void takeNewer() try {
    std::optional<State> newer = newer_();
    if (!newer) return;
    newerError_.clear();
    const Camera before = selection_.camera();
    selection_.replace(std::move(*newer));
    remote_.show(selection_.shown());
    if (!(selection_.camera() == before)) backToCamera();
    say("read the changed file");
  } catch (const Error& e) {
    newerError_ = std::string("error: ") + e.what();
  }

  // --- steps in time ---

  // Returns the generation of the series' data among `generations`; 0 if there is none.
  uint64_t generationSeen(const RemoteWindow::Generations& generations) const {
    const std::vector<DatasetSpec> datasets = series_.datasetsAt(series_.there());
    const auto seen = datasets.empty() ? generations.end() : generations.find(datasets[0].name);
    return seen == generations.end() ? 0 : seen->second;
  }
  size_t stepSeen() const { return series_.stepOf(generationSeen(remote_.generations())); }

  // A step is imported only when the step before is shown or the server has refused its picture, so that new
  // data do not overtake pictures under way.
  void goOnInTime() {
    if (series_.count() == 1) return;
    if (const auto outcome = remote_.imported()) takeStep(*outcome);
    if (generationSeen(remote_.generations()) < series_.generation() && !remote_.refused()) return;
    if (playing_ && series_.wanted() == series_.there()) {
      playing_ = series_.there() + 1 < series_.count();
      series_.next(playing_ ? 1 : 0);
    }
    if (const auto step = series_.begin()) remote_.import(series_.datasetsAt(*step));
  }

  void takeStep(const RemoteWindow::Imported& outcome) {
    const bool came = outcome.error.empty();
    const uint64_t generation = generationSeen(outcome.generations);
    const size_t step = series_.end(came, generation ? std::optional(generation) : std::nullopt);
    if (came) return selection_.setDatasets(series_.datasetsAt(series_.there()));
    playing_ = false;
    say("error: " + series_.textOf(step) + ": " + outcome.error);
  }

  void wantStep(void (*choose)(Series&)) {
    if (series_.count() == 1) return say("there is one time step");
    playing_ = false;
    choose(series_);
  }

  void play() {
    if (series_.count() == 1) return say("there is one time step");
    playing_ = !playing_;
    if (playing_ && series_.there() + 1 == series_.count()) series_.first();
  }

  std::string stepText() const {
    if (series_.count() == 1) return {};
    std::string text = series_.textOf(stepSeen());
    if (series_.wanted() != series_.there()) text += ", next " + std::to_string(series_.wanted() + 1);
    return text + (playing_ ? ", playing" : "");
  }

  // Asks what is under the mouse.
  void pick() {
    const int* const at = interactor_->GetEventPosition();
    remote_.pick({at[0], at[1]});
  }

  void nextVisualization(int by) {
    const Camera before = selection_.camera();
    selection_.nextVisualization(by);
    remote_.show(selection_.shown());
    if (!(selection_.camera() == before)) backToCamera();  // One of them is a view with a camera of its own.
  }

  void nextOperator(int by) {
    selection_.nextOperator(by);
    say(selection_.operatorText());
  }

  void changeRange(double factor, double shift) {
    selection_.changeRange(factor, shift);
    showRange();
  }

  void resetRange() {
    selection_.resetRange();
    showRange();
  }

  void showRange() {
    remote_.show(selection_.shown());
    say(selection_.operatorText());
  }

  void nextCamera(int by) {
    selection_.nextCamera(by);
    backToCamera();
  }

  void backToCamera() {
    Camera camera = selection_.camera();
    camera.dimensions = size_;
    show(camera, view());
  }

  // The actions of keys. A capital that is not listed acts as its small letter.
  using Action = std::function<void(ViewerWindow&)>;
  static const std::map<std::string, Action>& actions() {
    using Self = ViewerWindow;
    static const std::map<std::string, Action> all{
        {"q", &Self::leave},
        {"r", &Self::reset},
        {"b", &Self::backToCamera},
        {"s", [](Self& self) { self.spinning_ = !self.spinning_; }},
        {"h", [](Self& self) { self.shown_.turnHelp(); }},
        {"question", [](Self& self) { self.shown_.turnHelp(); }},
        {"x", [](Self& self) { self.lookAlong(0, 1); }},
        {"y", [](Self& self) { self.lookAlong(1, 1); }},
        {"z", [](Self& self) { self.lookAlong(2, 1); }},
        {"X", [](Self& self) { self.lookAlong(0, -1); }},
        {"Y", [](Self& self) { self.lookAlong(1, -1); }},
        {"Z", [](Self& self) { self.lookAlong(2, -1); }},
        {"v", [](Self& self) { self.nextVisualization(1); }},
        {"V", [](Self& self) { self.nextVisualization(-1); }},
        {"c", [](Self& self) { self.nextCamera(1); }},
        {"C", [](Self& self) { self.nextCamera(-1); }},
        {"o", [](Self& self) { self.nextOperator(1); }},
        {"O", [](Self& self) { self.nextOperator(-1); }},
        {"minus", [](Self& self) { self.changeRange(kNarrower, 0); }},
        {"plus", [](Self& self) { self.changeRange(1 / kNarrower, 0); }},
        {"equal", [](Self& self) { self.changeRange(1 / kNarrower, 0); }},
        {"bracketleft", [](Self& self) { self.changeRange(1, -kShift); }},
        {"bracketright", [](Self& self) { self.changeRange(1, kShift); }},
        {"0", &Self::resetRange},
        {"comma", [](Self& self) { self.wantStep([](Series& s) { s.next(-1); }); }},
        {"period", [](Self& self) { self.wantStep([](Series& s) { s.next(1); }); }},
        {"less", [](Self& self) { self.wantStep([](Series& s) { s.first(); }); }},
        {"greater", [](Self& self) { self.wantStep([](Series& s) { s.last(); }); }},
        {"Home", [](Self& self) { self.wantStep([](Series& s) { s.first(); }); }},
        {"End", [](Self& self) { self.wantStep([](Series& s) { s.last(); }); }},
        {"space", &Self::play},
        {"a", &Self::turnAnnotations},
        {"i", &Self::pick},
        {"w", &Self::saveState},
        {"p", [](Self& self) { self.savePicture(); }}};
    return all;
  }

  void key() {
    if (size_ == glm::ivec2(0)) return;  // There is no picture yet.
    const char* const symbol = interactor_->GetKeySym();
    std::string key = symbol ? symbol : "";
    if (key.size() == 1 && !actions().contains(key)) key[0] = char(std::tolower(key[0]));
    if (const auto at = actions().find(key); at != actions().end()) at->second(*this);
  }

  void turnAnnotations() {
    annotates_ = !annotates_;
    remote_.showAgain();
  }

  void saveState() {
    const std::string text = writeState(selection_.with(cameraNow()));
    replaceFile(output_ + ".json", std::as_bytes(std::span(text)));
    say("saved " + output_ + ".json");
  }

  // Saves the picture on the screen if it is whole. Otherwise it is rendered in another window, with the
  // present camera.
  void savePicture() {
    std::string path;
    do {
      char number[16];
      std::snprintf(number, sizeof number, "_%05d.png", pictures_++);
      path = output_ + number;
    } while (std::filesystem::exists(path));
    remote_.setCamera(cameraNow());
    if (remote_.whole()) return savePicture(path, remote_.picture(), cameraNow(), stepSeen());
    State state = selection_.shown();
    state.cameras = {cameraNow()};
    savings_.push_back({path, std::move(state), nullptr});
  }

  void savePicture(const std::string& path, const Canvas& canvas, const Camera& camera, size_t step) {
    withOverlay(remote_.shown(), camera, canvas.size(), step,
                [&](const Overlay& overlay) { writePng(path, canvas, overlay); });
    say("saved " + path);
  }

  void savePictures() {
    if (savings_.empty()) return;
    if (!savings_.front().still) savings_.front().still = remote_.still(savings_.front().state);
    const Still::Progress progress = savings_.front().still->progress();
    if (!progress.ended) return;
    const Saving saving = std::move(savings_.front());
    savings_.pop_front();
    const bool leaves =
        std::exchange(leaves_, false);  // If saving fails, the window stays open and shows the reason.
    if (!progress.error.empty()) throw Error(saving.path + ": " + progress.error);
    savePicture(saving.path, saving.still->canvas(), saving.state.cameras[0],
                series_.stepOf(generationSeen(progress.generations)));
    leaves_ = leaves;
  }

  std::string saving() const {
    if (savings_.empty()) return {};
    const Saving& first = savings_.front();
    const uint32_t passes = first.still ? first.still->progress().passes : 0;
    return "saving " + first.path + ": " + std::to_string(passes) + " of " +
           std::to_string(remote_.passes()) + " passes" +
           (savings_.size() == 1 ? "" : ", and " + std::to_string(savings_.size() - 1) + " more");
  }

  // Quits when pictures that are being saved are complete, or at once at the second call.
  void leave() {
    if (std::exchange(leaves_, true) || savings_.empty()) return interactor_->TerminateApp();
  }

  void say(const std::string& notice) {
    notice_ = notice;
    noticeEnd_ = Clock::now() + kNoticeTime;
  }

  struct Saving {
    std::string path;
    State state;
    std::shared_ptr<const Still> still;  ///< null until it has begun
  };
  struct Call {
    ViewerWindow& self;
    void (*action)(ViewerWindow&);
  };

  RemoteWindow& remote_;
  Selection selection_;
  Series series_;
  const std::string output_;
  const NewerState newer_;
  bool annotates_;
  PictureView shown_;
  vtkNew<vtkRenderWindowInteractor> interactor_;
  vtkNew<Style> style_;
  glm::ivec2 size_{0};
  bool centered_ = false, spinning_ = false, playing_ = false, leaves_ = false;
  Clock::time_point lastTick_{}, noticeEnd_{};
  std::string notice_, newerError_;
  std::deque<Saving> savings_;
  int pictures_ = 0;
};

}  // namespace

void checkDisplay() {
  const char* const name = XDisplayName(nullptr);
  Display* const display = XOpenDisplay(nullptr);
  if (!display)
    throw Error(std::string("no display") + (*name ? " at " + std::string(name) : ", DISPLAY is not set") +
                ": expected an X server for the window; --snapshot F.png makes a picture without one");
  int first = 0, event = 0, error = 0;
  const bool draws = XQueryExtension(display, "GLX", &first, &event, &error);
  XCloseDisplay(display);
  if (!draws)
    throw Error(
        "the display " + std::string(name) +
        " has no OpenGL (GLX): expected it for the window; --snapshot F.png makes a picture without one");
}

void runViewer(RemoteWindow& remote, Selection selection, Series series, const std::string& output,
               bool annotated, NewerState newer) {
  ViewerWindow(remote, std::move(selection), std::move(series), output, annotated, std::move(newer)).run();
}

}  // namespace gxy
