// SPDX-License-Identifier: Apache-2.0
// A window of a client: what it shows, and its frames, one after the other. Rank 0.
#pragma once
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "multiserver/modules/viewer/first_looks.h"
#include "multiserver/modules/viewer/retries.h"
#include "multiserver/protocol/pixel_record.h"
#include "multiserver/rendering/rendering.h"
#include "multiserver/server/outbox.h"
#include "multiserver/server/tenants.h"

namespace gxy::viewer {

/// What the viewer module has on a rank.
struct Services {
  explicit Services(Registration& registration)
      : node(registration.node()), looks(registration), rendering(renderingOf(registration)) {}
  Node& node;
  FirstLooks looks;
  const std::shared_ptr<Rendering> rendering;
  SceneCache& scenes = rendering->scenes;
  PictureDelivery& pictures = rendering->pictures;
  Retries retries;  ///< of windows; last: it uses them
};

/// How a frame is wanted.
struct FrameOptions {
  std::vector<uint32_t> levels{4, 1};  ///< descending
  uint32_t passes = 1;                 ///< of the last level
  uint32_t rays = 0;                   ///< per pixel, of each pass; 0: what the state says
  protocol::PixelEncoding encoding = protocol::PixelEncoding::Zstd;
  int quality = 75;
  bool wait = false;  ///< for the first pass of the frame under way to be sent, instead of superseding it
};

/// Thread safe. Frames under way keep their window alive.
class Window : public std::enable_shared_from_this<Window> {
 public:
  Window(Services& services, std::shared_ptr<Outbox> outbox, std::string tenant, uint32_t id);

  struct Settings {
    glm::ivec2 size{512, 512};
    bool follow = false;
  };
  Settings settings() const;
  void setSettings(const Settings& settings);

  /// These replace what a state document says. `memory` is for the visualization.
  void setVisualization(const Visualization& visualization, LedgerEntry memory);
  void setRenderer(const RenderSettings& settings);
  void setCamera(const Camera& camera);
  State state() const;
  /// The camera, or the window's, where the data that are shown now put it, and what these data are.
  struct Seen {
    Camera camera;
    ShownSoFar shown;
  };
  Seen seen(const std::optional<Camera>& camera) const;

  /// What a frame that began now would show; its camera has the window's size. Compiles the scene if need be, as render does.
  struct View {
    SceneCache::Pinned pinned;
    Visualization visualization;
    Camera camera;
  };
  View view(const Asker& asker) const;

  /// Begins a frame; older ones are superseded. One that waits begins later, and is superseded by any newer one, so that at
  /// most one does. Compiles the scene if need be, so it takes its time, of which `asker` is told (SceneCache::get). Throws Error.
  uint64_t render(const FrameOptions& options, const Asker& asker);
  /// Ends the frame under way and the one that waits, if any.
  void cancel();
  /// Cancels, and begins no frame any more.
  void endFrames();
  /// The same, and waits until no frame is under way.
  void close();
  uint64_t lastFrame() const;

  /// A name that it shows means something else, or newer data: scenes of the old ones are let go, a frame that waits will
  /// show the new ones, and, if it follows and there is something to see, a frame begins once the client has read enough and
  /// the one under way is whole, which is then refined no further. Short.
  void onData(const DatasetEvent& event);
  /// An update needs the room of a generation. Where a frame of it waits, it gets newer data; where one is whole, it is
  /// refined no further; another ends with its first whole picture, or now if it has long kept another tenant waiting. Short.
  void onWanted(Key key, Generation generation);
  /// Renders newer data, if that is still due. Short.
  void tryAgain();

 private:
  struct Frame;
  using FramePtr = std::shared_ptr<Frame>;

  /// How far the frames of the window are. In Rendering and Sending another frame may wait (`waiting_`).
  enum class Phase {
    Idle,       ///< no frame is under way
    Rendering,  ///< the frame under way has not made its first pass
    Sending,   ///< a frame's first pass waits in the outbox; meanwhile it makes further ones, or it has ended
    Refining,  ///< the first pass has been sent, and the frame makes further ones
    Closed,    ///< no frame begins any more
  };
  /// The client has not been shown the newest data.
  struct PendingUpdate {
    bool due = false;           ///< the newest frame shows older data than there are
    bool awaitsOutbox = false;  ///< onDrained() will be called
    bool awaitsRoom = false;    ///< the window is in Services::retries
    std::string refusal;        ///< why there is no frame of the newest data, as the client was told
  };
  /// What is to be done once the lock is not held any more.
  struct Change {
    std::vector<ScenePtr> scenes;  ///< to be let go of
    std::vector<Pin> pins;         ///< as well
    FrameId ended = 0;             ///< a rendering to be superseded; 0: none
    bool newData = false;          ///< renderNewData() is to be called
  };
  Change changeBy(const DatasetEvent& event);
  void carryOut(const Change& change);
  bool concerns(const DatasetEvent& event) const;
  bool allThereAfter(const DatasetEvent& event) const;
  void forgetScene();
  void end(Phase after);

  struct Snapshot;
  Snapshot takeSnapshot();
  FramePtr frameOf(const FrameOptions& options, const Snapshot& snapshot) const;
  void compile(Frame& frame, Snapshot& snapshot, const Asker& asker);
  void takeRoom(Frame& frame) const;
  FramePtr makeCurrent(const FramePtr& frame);
  void begin(const FramePtr& frame);
  void onFirstPassSent(uint64_t number);
  void beginWaiting();
  void beginWithNewData(const FramePtr& frame);
  void supersede(const FramePtr& older);
  FrameId endRefinement();
  void addPass(const FramePtr& frame);
  void startStage(const FramePtr& frame);
  void onTile(const FramePtr& frame, Bytes record);
  void onSums(const FramePtr& frame, Picture picture);
  void onStage(const FramePtr& frame, bool superseded, const std::string& error);
  void sendEndOfPass(const FramePtr& frame);
  void finish(const FramePtr& frame, const char* status, const std::string& error);
  /// What the window had been asked for when it decided to render by itself.
  struct Since {
    uint64_t asked, frames;
  };
  uint64_t render(const FrameOptions& options, const Asker& asker, std::optional<Since> byItself);
  uint64_t enter(const FramePtr& frame, Snapshot snapshot, std::optional<Since> byItself);
  void renderNewData();
  void renderByItself();
  void tryAgainUnlessMade(uint64_t lastFrame);
  void onRefused(uint64_t lastFrame, const std::string& error);
  void onDrained();

  Services& services_;
  const std::shared_ptr<Outbox> outbox_;
  const std::string tenant_;
  const uint32_t id_;
  const uint64_t stream_;

  mutable std::mutex mutex_;
  std::condition_variable ended_;
  Settings settings_;
  State state_;
  LedgerEntry stateMemory_;
  bool hasVisualization_ = false;
  ShownSoFar shown_;          ///< since the visualization was set
  uint64_t asked_ = 0;        ///< for so many frames, which may have been refused
  FrameOptions lastOptions_;  ///< with which it was asked for last
  ScenePtr scene_;
  ScenePtr edited_;  ///< shown before an edit: the next scene takes over what it may
  Phase phase_ = Phase::Idle;
  uint64_t sending_ = 0;  ///< in Phase::Sending: the frame whose first pass waits in the outbox
  FramePtr current_;      ///< under way and not superseded; null when Idle and Closed
  FramePtr waiting_;      ///< begins once the first pass of `current_` has been sent
  PendingUpdate update_;
  uint64_t frames_ = 0;   ///< begun, or waiting to begin, so far
  uint64_t updates_ = 0;  ///< of its data so far
  int unfinished_ = 0;    ///< frames under way, superseded ones included, and tasks that may begin one
};

}  // namespace gxy::viewer
