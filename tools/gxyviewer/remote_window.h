// SPDX-License-Identifier: Apache-2.0
// A window of a server: what it shows, which frames are asked for and when, and what has come of them.
#pragma once
#include <array>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/scene/resolve.h"
#include "core/scene/scene.h"
#include "multiserver/client/client.h"
#include "tools/gxyviewer/canvas.h"
#include "tools/gxyviewer/frames_asked.h"
#include "tools/gxyviewer/pace.h"
#include "tools/gxyviewer/still.h"

namespace gxy {

/// While the camera moves, frames are JPEG of one level, whose detail follows the server and the link (pace.h). Two are under
/// way at a time: one is rendered while another travels, and no more than those two ever wait anywhere. When the camera
/// rests, one lossless frame is made, in passes that each add a ray to every pixel. Frames that the server makes by itself,
/// because data changed, are shown like any other. A frame that the server refuses is asked for again, less and less often.
///
/// Calls come from one thread, the user's; what the connection brings is taken by its own.
class RemoteWindow {
 public:
  using Clock = std::chrono::steady_clock;
  using Box = std::array<std::array<double, 3>, 2>;
  using Generations = std::map<std::string, uint64_t>;  ///< by dataset
  using OnWarning = std::function<void(const std::string& text)>;

  /// Connects; the server begins to import those of the state's datasets whose names it does not have. Throws Error.
  /// `state` has one visualization and one camera, whose dimensions are the window's.
  /// `passes`: of a frame at rest, each of one ray per pixel. `onWarning` is told what the server says of the state, on the
  /// connection's thread.
  RemoteWindow(Client::Options options, const State& state, uint32_t passes, OnWarning onWarning = {});

  /// What the next frames show instead; the camera stays. Its datasets are imported as the first state's; where the server
  /// refuses it, status() says so, and what was shown before stays.
  void show(const State& state);
  void setCamera(const Camera& camera);
  /// A camera where its `fit` puts it, in a window of this size. Waits for the server. Throws Error.
  Camera fittedCamera(const Camera& camera);
  void resize(glm::ivec2 size);
  /// Asks for what is due; called often.
  void update(Clock::time_point now);

  struct Imported {
    std::string error;        ///< why the data have not come; empty if they have
    Generations generations;  ///< that they have
  };
  /// Gives datasets the data of other files; imported() has the outcome once. One at a time.
  void import(const std::vector<DatasetSpec>& datasets);
  std::optional<Imported> imported();
  /// Ends the window on the server and drops datasets there, as far as it lets itself be told. Nothing is shown any more.
  void drop(const std::vector<DatasetSpec>& datasets);

  /// Whether the server has said what there is of the data. They as a whole, world, as of now, if anything of them has a box.
  bool loaded() const;
  std::optional<Box> box() const;

  /// What the server says of the data that are shown; nothing before.
  ShownSoFar shown() const;

  /// Calls `use` with the picture, the camera that sees it and the data's generations that it shows, if it has changed since the
  /// last call, or one of these has. `use` does not call this.
  void ifChanged(const std::function<void(const Canvas&, const Camera&, const Generations&)>& use);
  /// Of the data that the picture shows, by dataset.
  Generations generations() const;
  /// The picture counts as changed.
  void showAgain();
  /// What is shown now.
  Canvas picture() const;

  /// Asks what the last picture's camera shows at a pixel, row 0 at the bottom; picked() has the answer once it is there, for
  /// people.
  void pick(glm::ivec2 pixel);
  std::optional<std::string> picked();

  /// Of a frame at rest.
  uint32_t passes() const { return passes_; }
  /// Whether the picture is that of the newest camera with all its passes.
  bool whole() const;
  /// Begins a picture of `state`, as of one at rest, beside what goes on here; one at a time. The state is as the
  /// constructor's.
  std::shared_ptr<const Still> still(const State& state);

  /// Whether the newest picture cannot be made, for now; status() says why.
  bool refused() const;
  /// What goes on, for people: loading, refining, how long a frame took, what failed.
  std::string status() const;
  /// Why the data could not be shown, or the connection ended; empty while all is well.
  std::string failure() const;

  struct Statistics {
    uint64_t frames = 0;     ///< of which something has been shown
    uint64_t bytes = 0;      ///< of all pixels
    uint64_t passBytes = 0;  ///< of the last frame's first pass
    double firstPixels = 0;  ///< seconds from the last of these frames' request to its first pass shown
    Detail detail;           ///< of the last one that was asked for while the camera moved
    uint32_t passes = 0;     ///< of the newest frame: whole pictures of full detail
    bool ended = false;      ///< the newest frame
  };
  Statistics statistics() const;

  /// Waits until the data are there; then for one whole frame of `passes` passes. Throws Error when there will be none.
  void waitUntilLoaded();
  void renderWhole();

 private:
  struct Frame {
    uint64_t number = 0;
    uint32_t scale = 0, pass = 0;  ///< of the last pass that came
    bool ended = false;
    std::string status, error;
    double seconds = 0;
    std::map<std::string, uint64_t> generations;
    // Of its first pass.
    Clock::time_point begin{};
    uint64_t bytes = 0, firstBytes = 0;  ///< so far; of its first tile
    bool shown = false;
  };

  void takePixels(const protocol::PixelHeader& header, std::span<const std::byte> data);
  void takeEvent(const nlohmann::json& event);
  void askForBoxes();
  void takeShown(const Reply& reply);
  void takeInfo(const std::string& name, const Reply& reply);
  void takeNumber(const Reply& reply);
  void set(const State& state, std::function<void(const std::string& error)> refused);
  void showFirst(const nlohmann::json& pass);
  void fail(const std::string& why);
  std::string whyRefused() const;  ///< with the lock held
  void closeStill();
  void render(bool moving, Clock::time_point now);

  const uint32_t passes_;
  const OnWarning onWarning_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::string> names_;  ///< of the datasets that are shown
  Canvas canvas_;
  bool canvasChanged_ = false, loaded_ = false;
  std::map<std::string, Box> boxes_;  ///< of the datasets that have one
  ShownSoFar shown_;
  Camera shownCamera_;     ///< of the picture
  bool boxesDue_ = false;  ///< data have changed since they were asked for
  std::string failure_, progress_, setError_, renderError_;
  std::optional<std::string> picked_;
  std::optional<Imported> imported_;
  Generations generations_;    ///< that the picture shows
  std::set<std::string> own_;  ///< datasets that import() was given: their generations are no news
  Frame frame_;                ///< the newest of which something came
  FramesAsked asked_;
  int refusals_ = 0;                        ///< since something was shown
  std::optional<Clock::time_point> again_;  ///< when what was refused last is asked for again
  Pace pace_;
  std::shared_ptr<Still> still_;  ///< whose window the server has
  Statistics statistics_;

  // Of the user's thread.
  Camera camera_;
  bool cameraSent_ = false, movingSent_ = true;
  Clock::time_point moved_{};

  std::unique_ptr<Client> client_;  ///< last, so that it goes first
};

}  // namespace gxy
