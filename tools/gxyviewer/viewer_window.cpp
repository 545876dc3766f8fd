// SPDX-License-Identifier: Apache-2.0
#include "viewer_window.h"

#include <X11/Xlib.h>
#include <vtkActor2D.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkImageData.h>
#include <vtkImageMapper.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkProperty2D.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <filesystem>
#include <glm/geometric.hpp>

#include "camera_view.h"
#include "gxy/comm/error.h"
#include "gxy/io/replace_file.h"
#include "gxy/scene/state_file.h"
#include "keys.h"
#include "png.h"

namespace gxy {

namespace {

using Clock = RemoteWindow::Clock;
constexpr unsigned long kTickMilliseconds = 10;
constexpr double kSpinDegreesPerSecond = 30;
constexpr std::chrono::seconds kNoticeTime{4};

/// VTK's trackball, without the keys that VTK binds to other things.
class Style : public vtkInteractorStyleTrackballCamera {
 public:
  static Style* New();
  vtkTypeMacro(Style, vtkInteractorStyleTrackballCamera);
  void OnChar() override {}
  void OnTimer() override {}  // VTK would repeat the last step of a drag, at each tick
};
vtkStandardNewMacro(Style);

class ViewerWindow {
 public:
  ViewerWindow(RemoteWindow& remote, const State& state, std::string output)
      : remote_(remote), state_(state), output_(std::move(output)) {
    const glm::ivec2 size = camera().dimensions;
    renderer_->SetBackground(0, 0, 0);
    mapper_->SetColorWindow(255);
    mapper_->SetColorLevel(127.5);
    mapper_->SetInputData(image_);
    picture_->SetMapper(mapper_);
    picture_->GetProperty()->SetDisplayLocationToBackground();
    place(*statusText_, 14, 10, false);
    place(*helpText_, 15, 0, true);
    helpText_->SetInput(kKeyHelp);
    helpText_->VisibilityOff();
    renderer_->AddActor2D(picture_);
    renderer_->AddActor2D(statusText_);
    renderer_->AddActor2D(helpText_);
    window_->AddRenderer(renderer_);
    window_->SetMultiSamples(0);
    window_->SetSize(size.x, size.y);
    window_->SetWindowName("gxyviewer");
    interactor_->SetRenderWindow(window_);
    interactor_->SetInteractorStyle(style_);
    observe(vtkCommand::TimerEvent, [](ViewerWindow& self) { self.tick(); });
    observe(vtkCommand::KeyPressEvent, [](ViewerWindow& self) { self.key(); });
    show(camera(), view());
  }

  void run() {
    interactor_->Initialize();
    layOut();
    window_->Render();
    interactor_->CreateRepeatingTimer(kTickMilliseconds);
    interactor_->Start();
    if (const std::string failure = remote_.failure(); !failure.empty()) throw Error(failure);
  }

 private:
  const Camera& camera() const { return state_.cameras[0]; }
  vtkCamera& view() { return *renderer_->GetActiveCamera(); }
  glm::ivec2 size() const { return {window_->GetSize()[0], window_->GetSize()[1]}; }

  // While a button is held the style has the focus, and of the others only passive observers are told of events.
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

  static void place(vtkTextActor& text, int fontSize, int left, bool fixedWidth) {
    vtkTextProperty& p = *text.GetTextProperty();
    p.SetFontSize(fontSize);
    p.SetColor(1, 1, 1);
    p.SetBackgroundColor(0, 0, 0);
    p.SetBackgroundOpacity(0.6);
    if (fixedWidth) p.SetFontFamilyToCourier();
    text.SetPosition(left, 8);
  }

  // Help hangs from the upper left corner, as large as the window lets it be.
  void layOut() {
    helpText_->GetTextProperty()->SetVerticalJustificationToTop();
    helpText_->GetTextProperty()->SetFontSize(std::clamp(size().x / 40, 7, 15));
    helpText_->SetPosition(10, size().y - 10);
  }

  void tick() {
    const Clock::time_point now = Clock::now();
    if (size() != shownSize_) {
      shownSize_ = size();
      remote_.resize(size());
      view().SetUseHorizontalViewAngle(size().x < size().y);
      layOut();
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
    remote_.setCamera(cameraOf(view(), size(), camera().annotation));
    remote_.update(now);
    bool changed = false;
    remote_.ifChanged([&](const Canvas& canvas) {
      upload(canvas);
      changed = true;
    });
    const std::string status =
        now < noticeEnd_ ? notice_ : remote_.status() + (spinning_ ? "   spinning" : "") + "   h: keys";
    if (status != status_) {
      status_ = status;
      statusText_->SetInput(status.c_str());
      changed = true;
    }
    if (changed) window_->Render();
  }

  // Over black, as JPEG has it.
  void upload(const Canvas& canvas) {
    const int width = canvas.size().x, height = canvas.size().y;
    if (image_->GetDimensions()[0] != width || image_->GetDimensions()[1] != height ||
        !image_->GetScalarPointer()) {
      image_->SetDimensions(width, height, 1);
      image_->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
    }
    auto* to = static_cast<uint8_t*>(image_->GetScalarPointer());
    const std::span<const uint8_t> from = canvas.rgba();
    for (size_t i = 0; i < from.size(); i += 4)
      for (size_t c = 0; c < 3; c++) *to++ = uint8_t((from[i + c] * from[i + 3] + 127) / 255);
    image_->Modified();
  }

  // A direction without a length that means anything leads to the middle of the data.
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
    renderer_->ResetCamera(low[0], high[0], low[1], high[1], low[2], high[2]);
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

  void key() {
    const char* const symbol = interactor_->GetKeySym();
    const std::string key = symbol ? symbol : "";
    if (key == "q" || key == "Q") interactor_->TerminateApp();
    if (key == "r" || key == "R") reset();
    if (key == "b" || key == "B") show(withSize(camera()), view());
    if (key == "s" || key == "S") spinning_ = !spinning_;
    if (key == "h" || key == "H" || key == "question") {
      helpText_->SetVisibility(!helpText_->GetVisibility());
      window_->Render();
    }
    if (key.size() == 1 && key[0] >= 'x' && key[0] <= 'z') lookAlong(key[0] - 'x', 1);
    if (key.size() == 1 && key[0] >= 'X' && key[0] <= 'Z') lookAlong(key[0] - 'X', -1);
    if (key == "w" || key == "W") saveState();
    if (key == "p" || key == "P") savePicture();
  }

  Camera withSize(Camera camera) const {
    camera.dimensions = size();
    return camera;
  }

  void saveState() {
    State state = state_;
    state.cameras = {cameraOf(view(), size(), camera().annotation)};
    const std::string text = writeState(state);
    replaceFile(output_ + ".json", std::as_bytes(std::span(text)));
    say("saved " + output_ + ".json");
  }

  void savePicture() {
    std::string path;
    do {
      char number[16];
      std::snprintf(number, sizeof number, "_%05d.png", pictures_++);
      path = output_ + number;
    } while (std::filesystem::exists(path));
    writePng(path, remote_.picture());
    say("saved " + path);
  }

  void say(const std::string& notice) {
    notice_ = notice;
    noticeEnd_ = Clock::now() + kNoticeTime;
  }

  struct Call {
    ViewerWindow& self;
    void (*action)(ViewerWindow&);
  };

  RemoteWindow& remote_;
  const State& state_;
  const std::string output_;
  vtkNew<vtkImageData> image_;
  vtkNew<vtkImageMapper> mapper_;
  vtkNew<vtkActor2D> picture_;
  vtkNew<vtkTextActor> statusText_, helpText_;
  vtkNew<vtkRenderer> renderer_;
  vtkNew<vtkRenderWindow> window_;
  vtkNew<vtkRenderWindowInteractor> interactor_;
  vtkNew<Style> style_;
  glm::ivec2 shownSize_{0};
  bool centered_ = false, spinning_ = false;
  Clock::time_point lastTick_{}, noticeEnd_{};
  std::string status_, notice_;
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

void runViewer(RemoteWindow& remote, const State& state, const std::string& output) {
  ViewerWindow(remote, state, output).run();
}

}  // namespace gxy
