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

#include "multiserver/graph/graphs.h"
#include "multiserver/modules/viewer/first_looks.h"
#include "multiserver/modules/viewer/retries.h"
#include "multiserver/modules/viewer/table_locks.h"
#include "multiserver/protocol/pixel_record.h"
#include "multiserver/rendering/rendering.h"
#include "multiserver/server/outbox.h"
#include "multiserver/server/tenants.h"

namespace gxy::viewer {

/// The parts of the viewer module on a rank.
struct Services {
  explicit Services(Registration& registration)
      : serverRank(registration.serverRank()),
        looks(registration),
        rendering(renderingOf(registration)),
        graphs(graphsOf(registration)) {}
  ServerRank& serverRank;
  FirstLooks looks;
  const std::shared_ptr<Rendering> rendering;
  const std::shared_ptr<Graphs> graphs;
  SceneCache& scenes = rendering->scenes;
  PictureDelivery& pictures = rendering->pictures;
  TableLocks tables;
  Retries retries;  ///< of windows; the last member, since its thread calls windows, which use the others
};

/// The options of `render` (docs/protocol.md).
struct FrameOptions {
  std::vector<uint32_t> levels{4, 1};  ///< scales, descending
  uint32_t passes = 1;                 ///< of the last level
  uint32_t rays = 0;                   ///< per pixel in each pass; 0: as many as the state says
  protocol::PixelEncoding encoding = protocol::PixelEncoding::Zstd;
  int quality = 75;
  uint32_t tile = protocol::kTileSide;
  /// The frame begins once the first pass of the frame under way has been sent, instead of superseding that frame.
  bool wait = false;
};

/// A window. Frames under way keep it alive. Thread safe.
class Window : public std::enable_shared_from_this<Window> {
 public:
  Window(Services& services, std::shared_ptr<Outbox> outbox, std::string tenant, uint32_t id);

  struct Settings {
    glm::ivec2 size{512, 512};
    bool follow = false;
  };
  Settings settings() const;
  void setSettings(const Settings& settings);

  /// These replace one part of the window's state document. `memory` is the ledger's entry for the visualization.
  void setVisualization(const Visualization& visualization, LedgerEntry memory);
  void setRenderer(const RenderSettings& settings);
  /// From now on the window shows this view and its edits, until setVisualization(). It follows its data, until settings say otherwise.
  void setGraph(std::shared_ptr<Graph> graph, const std::string& view);
  void setCamera(const Camera& camera);
  State state() const;
  /// A camera, and what the window has shown since its visualization was set.
  struct Seen {
    Camera camera;
    ShownSoFar shown;
  };
  /// Returns `camera` (none: the window's) where its `fit` puts it for the data that are shown now, and what
  /// has been shown, these data included.
  Seen seen(const std::optional<Camera>& camera) const;

  /// What a frame that began now would show.
  struct View {
    SceneCache::Pinned pinned;
    Visualization visualization;
    Camera camera;
  };
  /// Returns it. Its camera has the window's size. Builds the scene if need be, as render().
  View view(const Asker& asker) const;

  /// Begins a frame, which supersedes older ones, and returns its number. A frame with FrameOptions::wait may begin later. At
  /// most one frame waits, since any newer frame supersedes it. Builds the scene if need be, which takes long and tells `asker`
  /// its progress (SceneCache::get). Throws Error.
  uint64_t render(const FrameOptions& options, const Asker& asker);
  /// Ends the frame under way and the one that waits, if any.
  void cancel();
  /// Cancels. From now on no frame begins.
  void endFrames();
  /// Does what endFrames() does, and waits until no frame is under way.
  void close();
  uint64_t lastFrame() const;

  /// Is told of every change of datasets. If a name that the window shows now means something else or newer data, the window
  /// lets go of its scenes of the old data, and a frame that waits will show the new data. If the window follows and a frame
  /// has been asked for before, a frame of the new data begins once the client has read enough and the frame under way has a
  /// picture of all pixels, which is then refined no further. Returns soon.
  void onData(const DatasetEvent& event);
  /// Is told that an update needs the room of a generation. A frame of it that waits will show newer data. A frame of it that
  /// has a picture of all pixels is refined no further. Another frame of it ends with its first picture of all pixels, or now if
  /// it has kept another tenant waiting for too long (DataHold). Returns soon.
  void onWanted(Key key, Generation generation);
  /// Renders newer data if that is still due. Returns soon.
  void tryAgain();

 private:
  struct Frame;
  using FramePtr = std::shared_ptr<Frame>;

  /// How far the window's newest frame that has begun is. In Rendering and Sending another frame may wait (`waiting_`).
  enum class Phase {
    Idle,       ///< no frame is under way
    Rendering,  ///< the frame under way has not made its first pass
    Sending,   ///< its first pass waits in the outbox; the frame makes further passes meanwhile, or has ended
    Refining,  ///< its first pass has been sent, and the frame makes further passes
    Closed,    ///< no frame begins any more
  };
  /// Whether newer data are to be shown, and what the window waits for before it shows them.
  struct PendingUpdate {
    /// There are newer data than the newest frame shows, and no task is on its way to render them.
    bool due = false;
    bool awaitsOutbox = false;  ///< the client has not read enough; onBelowWatermark() will be called
    bool awaitsRoom = false;    ///< there was no room for a frame; the window is in Services::retries
    std::string refusal;        ///< the last error of a frame of newer data that the client was told of
  };
  /// Consequences of an event that are carried out after the lock has been released.
  struct Change {
    std::vector<ScenePtr> scenes;  ///< to be destroyed
    std::vector<Pin> pins;         ///< to be destroyed
    FrameId ended = 0;             ///< the rendering to supersede; 0: none
    bool newData = false;          ///< whether to call renderNewData()
  };
  Change changeBy(const DatasetEvent& event);
  void onGraph();
  void carryOut(const Change& change);
  bool concerns(const DatasetEvent& event) const;
  bool allThereAfter(const DatasetEvent& event) const;
  void forgetScene();
  void wantNews();
  void end(Phase after);

  struct Snapshot;
  Snapshot takeSnapshot();
  FramePtr frameOf(const FrameOptions& options, const Snapshot& snapshot) const;
  static void keep(Frame& frame, std::vector<Pin> pins, bool ofGraph, const ViewContent& content);
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
  /// The values of asked_ and frames_ when the window decided to render by itself.
  struct Since {
    uint64_t asked, frames;
  };
  uint64_t render(const FrameOptions& options, const Asker& asker, std::optional<Since> byItself);
  uint64_t enter(const FramePtr& frame, Snapshot snapshot, std::optional<Since> byItself);
  void renderNewData();
  void renderByItself();
  void tryAgainUnlessMade(uint64_t lastFrame);
  void onRefused(uint64_t lastFrame, const std::string& error);
  void onBelowWatermark();

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
  std::shared_ptr<GraphView> view_;  ///< of a graph, which says what is shown; null: none
  ViewContent content_;              ///< of it
  ShownSoFar shown_;                 ///< since the visualization was set
  uint64_t asked_ = 0;               ///< frames that the client has asked for, refused ones included
  FrameOptions lastOptions_;         ///< of the last of these
  ScenePtr scene_;   ///< of the last frame, kept for the next; null once the state or the data have changed
  ScenePtr edited_;  ///< the scene before an edit, kept until the next scene has taken over what it can
  Phase phase_ = Phase::Idle;
  uint64_t sending_ = 0;  ///< in Phase::Sending: the frame whose first pass waits in the outbox
  FramePtr current_;      ///< under way and not superseded; null when Idle and Closed
  FramePtr waiting_;      ///< begins once the first pass of `current_` has been sent
  PendingUpdate update_;
  std::shared_ptr<void> wish_;  ///< for newer data of what a window that follows shows
  uint64_t frames_ = 0;         ///< frames so far that have begun or wait; the number of the newest
  uint64_t updates_ = 0;        ///< changes so far of the data that the window shows
  int unfinished_ = 0;          ///< frames under way, superseded ones included, and tasks that may begin one
};

}  // namespace gxy::viewer
