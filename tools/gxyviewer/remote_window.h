// SPDX-License-Identifier: Apache-2.0
// A window on a server: sets what it shows, decides when to request frames, and receives them.
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

/// While the camera moves, frames are JPEG of one level, whose detail adapts to the server and the link
/// (pace.h). At most two are under way: one is rendered while another is transferred. When the camera rests,
/// one lossless frame is requested, in passes that each add a ray to every pixel. Frames that the server
/// makes because data changed are shown like any other. A frame that the server refuses is requested again,
/// less and less often.
///
/// One thread, the user's, calls the functions. The client's thread receives data from the server.
class RemoteWindow {
 public:
  using Clock = std::chrono::steady_clock;
  using Box = std::array<std::array<double, 3>, 2>;
  using Generations = std::map<std::string, uint64_t>;  ///< by dataset
  using OnWarning = std::function<void(const std::string& text)>;

  /// Connects. The server begins to import the state's datasets whose names it does not have. `state` has one
  /// visualization and one camera, whose dimensions are the window's. `passes` is the number of passes of a
  /// frame at rest, each of one ray per pixel. `onWarning` is called on the client's thread with the server's
  /// warnings about the state. Throws Error if it cannot connect or the window is too large.
  RemoteWindow(Client::Options options, const State& state, uint32_t passes, OnWarning onWarning = {});

  /// Shows another state with the same camera. Its datasets are imported as in the constructor. If the server
  /// refuses it, status() says so, and the window continues to show the previous state.
  void show(const State& state);
  void setCamera(const Camera& camera);
  /// Returns the camera after fitted(), with the data on the server. Waits for the server. Throws Error if it
  /// answers an error.
  Camera fittedCamera(const Camera& camera);
  void resize(glm::ivec2 size);
  /// Sends requests that are due. It is called often.
  void update(Clock::time_point now);

  struct Imported {
    std::string error;        ///< the reason why the import failed; empty if it succeeded
    Generations generations;  ///< generations of the imported datasets
  };
  /// Imports other files into existing datasets. imported() returns the outcome once. Only one import at a time.
  void import(const std::vector<DatasetSpec>& datasets);
  std::optional<Imported> imported();
  /// Closes the window on the server and drops datasets there; ignores a lost connection. Nothing is
  /// shown afterwards.
  void drop(const std::vector<DatasetSpec>& datasets);

  /// Whether the server has answered about the data.
  bool loaded() const;
  /// The bounding box of all shown data in world coordinates, if any of them has one.
  std::optional<Box> box() const;

  /// Ranges and box that the server's pictures have shown; empty until it has answered.
  ShownSoFar shown() const;

  /// If the picture, its camera or the generations of its data have changed since the last call, calls `use`
  /// with them. `use` must not call this object.
  void ifChanged(const std::function<void(const Canvas&, const Camera&, const Generations&)>& use);
  /// The generations of the data that the picture shows, by dataset.
  Generations generations() const;
  /// Makes the next ifChanged() treat the picture as changed.
  void showAgain();
  /// The picture that is shown now.
  Canvas picture() const;

  /// Asks the server what the last picture shows at a pixel, row 0 at the bottom. picked() returns the
  /// answer, as text for users, once when it has come.
  void pick(glm::ivec2 pixel);
  std::optional<std::string> picked();

  /// The number of passes of a frame at rest.
  uint32_t passes() const { return passes_; }
  /// Whether the picture is that of the newest camera with all its passes.
  bool whole() const;
  /// Begins a picture of `state` with all passes, in another window of the server. Only one at a time.
  /// `state` is as in the constructor.
  std::shared_ptr<const Still> still(const State& state);

  /// Whether the newest picture cannot be made at present; status() says why.
  bool refused() const;
  /// The state of affairs as text for users: loading, refining, the time of a frame, errors.
  std::string status() const;
  /// The reason why the data could not be shown or the connection ended; empty if neither has happened.
  std::string failure() const;

  struct Statistics {
    uint64_t frames = 0;     ///< number of frames of which something has been shown
    uint64_t bytes = 0;      ///< bytes of all pixels
    uint64_t passBytes = 0;  ///< bytes of the first pass of the last of these frames
    double firstPixels = 0;  ///< seconds from that frame's request until its first pass was shown
    Detail detail;           ///< detail of the last frame that was requested while the camera moved
    uint32_t passes = 0;     ///< passes of full resolution of the newest frame
    bool ended = false;      ///< the newest frame has ended
  };
  Statistics statistics() const;

  /// Waits until the data are loaded. Throws Error if that fails.
  void waitUntilLoaded();
  /// Waits for one complete frame of `passes` passes. Throws Error if there will be none.
  void renderWhole();

 private:
  struct Frame {
    uint64_t number = 0;
    uint32_t scale = 0, pass = 0;  ///< of the last pass that has come
    bool ended = false;
    std::string status, error;
    double seconds = 0;
    std::map<std::string, uint64_t> generations;
    // The frame's first pass.
    Clock::time_point begin{};
    uint64_t bytes = 0, firstBytes = 0;  ///< bytes so far, and bytes of the first tile
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
  std::string whyRefused() const;  ///< called with the lock held
  void closeStill();
  void render(bool moving, Clock::time_point now);

  const uint32_t passes_;
  const OnWarning onWarning_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::string> names_;  ///< names of the shown datasets
  Canvas canvas_;
  bool canvasChanged_ = false, loaded_ = false;
  std::map<std::string, Box> boxes_;  ///< boxes of the datasets that have one
  ShownSoFar shown_;
  Camera shownCamera_;     ///< camera of the picture
  bool boxesDue_ = false;  ///< data have changed since boxes were requested
  std::string failure_, progress_, setError_, renderError_;
  std::optional<std::string> picked_;
  std::optional<Imported> imported_;
  Generations generations_;    ///< generations that the picture shows
  std::set<std::string> own_;  ///< datasets of import(); status() does not mention their new generations
  Frame frame_;                ///< the newest frame of which something has come
  FramesAsked asked_;
  int refusals_ = 0;                        ///< number of refusals since something was shown
  std::optional<Clock::time_point> again_;  ///< time at which the refused frame is requested again
  Pace pace_;
  std::shared_ptr<Still> still_;  ///< the picture whose window the server has
  Statistics statistics_;

  // Used by the user's thread.
  Camera camera_;
  bool cameraSent_ = false, movingSent_ = true;
  Clock::time_point moved_{};

  std::unique_ptr<Client> client_;  ///< the last member, so that it is destroyed first
};

}  // namespace gxy
