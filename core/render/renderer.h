// SPDX-License-Identifier: Apache-2.0
// From camera to picture on all ranks: spawn, trace, forward, retire.
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/comm/completion.h"
#include "core/comm/trace.h"
#include "core/comm/transport.h"
#include "core/rays/backend.h"
#include "core/rays/packet_size.h"
#include "core/render/admission.h"
#include "core/render/framebuffer.h"
#include "core/render/ready_queue.h"
#include "core/space/ledger.h"

namespace gxy {

using SceneId = uint64_t;
using FrameId = uint64_t;

/// One picture that is wanted.
struct FrameRequest {
  SceneId scene = 0;
  Camera camera;
  int32_t samples = 0;  ///< rays per pixel; 0: what the scene says
  /// Index of the first of them: the sums of pictures of different samples add up to those of all.
  int32_t firstSample = 0;
  bool depth = false;
  bool sums = false;    ///< the picture is handed out as its sums, without `rgba`
  uint64_t window = 0;  ///< not 0: a newer frame of the same window supersedes this one
  Share share;          ///< who goes first
  std::string account;  ///< the tenant whose memory it is in the ledger; empty: Options::tenant
  std::string note;     ///< of the one who asks, for the picture handler
};

/// What all ranks run, one Renderer each over the rank's Transport.
///
/// A frame is started on rank 0 and made known down a tree. Each rank spawns the primary rays that first meet something
/// visible in one of its partitions; rays are traced where they are and forwarded where they go, contributions are sent
/// to the rank that owns the framebuffer (frames are dealt out round robin). A frame is done when Completion says that
/// every ray and every message of contributions has been retired; then, and only then, its owner hands out the picture.
///
/// Memory: spawning is throttled by credits. A primary takes 1 + (secondaries per hit) credits of its rank and gives
/// them back, wherever it and they end; a rank spawns only while it has credits, so the rays of a rank that are in
/// flight anywhere never exceed Options::raysInFlight (or one tile, if that is more). What is forwarded is always
/// accepted. Behind translucent surfaces a primary may make more secondaries than it reserved; those put its rank into
/// debt. A framebuffer takes its memory when its first contribution comes, and gives it back before the picture's handler runs.
/// Of the frames of a stream that nobody watches, rank 0 begins as many as Options::framebufferBytes allow (Admission), and
/// keeps the requests of the others. What frames hold is in the ledger, and 0 when none is under way: "rays" (lists that wait
/// or are traced), "framebuffer", "picture" (while its handler runs), "parked messages" and "tiles".
///
/// Whose turn it is: on each rank, tasks run and tiles are spawned in the order of ReadyQueue, which shares the processors
/// among tenants and the streams of each. A task that is under way is not interrupted, but it traces one packet and puts the
/// rest off, so that who comes anew waits, on each rank, for the packets that are being traced, and an interactive frame for no
/// others. Tiles are smaller where a pixel makes many rays, so that there are credits for all.
/// Pictures of frames that nobody watches are handed out beside the tasks (Transport::postLong), however long that takes, at
/// most Options::handOuts of them at once and those of each tenant in turn.
///
/// A superseded frame ends like any other, its rays retired where they are met, but hands out no picture. So does a frame
/// that a rank or its device could not do its part of: rank 0 hears what was wrong, and other frames go on. Messages that
/// are not what a Renderer sends (a pixel outside the picture, a frame that is over, ...) are refused with an Error; what
/// they hold counts as ended, and a frame that is under way fails.
///
/// Threads: all calls may come from any thread. Callbacks run as tasks of the Transport.
class Renderer {
 public:
  struct Options {
    int packetRays = 1024;           ///< rays that are traced together, at most; >= 16
    int64_t raysInFlight = 1 << 20;  ///< credits of a rank
    /// Where memory is accounted, if anywhere; outlives frames that name an account.
    Ledger* ledger = nullptr;
    std::string tenant = "batch";  ///< whose memory it is
    /// Of a rank's processors or device: after that a frame is like those that nobody watches. So far the watched frames of a
    /// tenant may get ahead of what nobody watches, too (ReadyQueue).
    std::chrono::nanoseconds urgentWork = std::chrono::seconds(1);
    /// Of the calling thread: the clock by which tenants share the processors.
    std::function<std::chrono::nanoseconds()> processorTime = PacketSize::processorTime;
    int64_t framebufferBytes = int64_t(512)
                               << 20;  ///< of a stream's frames that nobody watches, on each rank
    Trace* trace = nullptr;            ///< of packets, tiles, pictures and frames; outlives the Renderer
    int runners = 1024;                ///< tasks that it gives the Transport at once
    int handOuts = 0;  ///< pictures that nobody waits for and that are handed out at once; 0: all there are
  };
  /// How a frame has ended: with a picture, or superseded, or with what went wrong on a rank or in its handler.
  struct Ending {
    bool superseded = false;
    std::string error;
    bool hasPicture() const { return !superseded && error.empty(); }
  };
  using Finished = std::function<void(FrameId, const Ending&)>;
  using PictureHandler = std::function<void(FrameId, const FrameRequest&, Picture)>;

  Renderer(Transport& transport, Options options);
  /// Waits for the tasks that run and for devices that trace; what is still to come of frames under way is dropped.
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Makes a scene known on this rank; needed on every rank before rank 0 starts a frame of it.
  void addScene(SceneId id, std::shared_ptr<const CompiledScene> scene,
                std::shared_ptr<const DeviceScene> device);
  /// Forgets it; frames that are under way keep what they need.
  void removeScene(SceneId id);

  /// What is done with pictures that this rank owns; not called for frames that end without. Set before frames start.
  void onPicture(PictureHandler handler);

  /// Rank 0 only: starts a frame. `finished` is called on rank 0 when the picture handler has returned on its rank.
  FrameId render(const FrameRequest& request, Finished finished);

  /// Rank 0 only: gives a frame up, as if a newer one of its window had come. Nothing happens if it is over.
  void supersede(FrameId id);

  struct Counters {
    TraceCounters trace;
    uint64_t raysForwarded = 0;                    ///< sent to other ranks
    uint64_t rayBytes = 0, contributionBytes = 0;  ///< handed to the transport for other ranks
    uint64_t rayMessages = 0, contributionMessages = 0;
    uint64_t tilesSkipped = 0;       ///< outside the projections of all partitions of this rank
    uint64_t pixelsSkipped = 0;      ///< of pictures of this rank, to which nothing was added
    uint64_t partitionsSkipped = 0;  ///< of this rank, with nothing in them that is seen; once for each frame
    /// To owners of pictures, and to ranks whose rays were traced: no pixel to change, no credit to give back.
    uint64_t messagesSkipped = 0;
    int64_t mostRaysInFlight = 0;  ///< credits out at once
    int mostFramebuffers = 0;      ///< of this rank, with memory at once
  };
  Counters counters() const;

  /// What is kept for frames that are not over; all 0 when none is under way.
  struct Kept {
    size_t frames = 0;                  ///< started and not finished here
    size_t parkedMessages = 0;          ///< of frames that have not started here
    size_t callbacks = 0, windows = 0;  ///< rank 0
    size_t completionSets = 0;
    size_t tasks = 0;                           ///< that wait for their turn
    int64_t credits = 0;                        ///< out
    std::map<uint32_t, int64_t> tenantCredits;  ///< out, by tenant
  };
  Kept kept() const;

 private:
  struct Frame;
  struct Scene;
  struct Parked;
  struct Held;
  struct Asked;
  class Tasks;
  /// Entries without bytes, for what frames hold.
  struct Account {
    Account(const Options& options, const std::string& tenant);
    LedgerEntry rays, framebuffer, picture, tiles;
  };
  using FramePtr = std::shared_ptr<Frame>;

  /// Rank 0: a frame whose end has not been reported.
  struct Pending {
    Finished finished;
    uint64_t window = 0;
    Share share;
    Ending ending;  ///< superseded by a frame that came before all its work was done, or the first error
    bool complete = false;                ///< all its work is done: too late to be superseded
    std::optional<FrameRequest> waiting;  ///< of one that has not begun (Admission)
  };
  /// How many framebuffers of this rank have memory; they hold it.
  struct Framebuffers {
    std::atomic<int> now = 0, most = 0;
    void more();
  };

  void receiveFrame(const Bytes& message);
  void receiveRays(Bytes message);
  void receiveContributions(Bytes message);
  void beginFrame(FrameId id, const FrameRequest& request);
  void beginWaiting(const std::vector<FrameId>& ids);
  void start(FrameId id, FrameRequest request, const Bytes& message);
  void prepare(Frame& frame);
  void cancel(FrameId id);
  void cancelEverywhere(FrameId id);
  void fail(const FramePtr& frame, const std::string& error);
  void failed(FrameId id, const std::string& error);
  void complete(FrameId id);
  void finish(FrameId id, bool hasPicture);
  void deliver(const FramePtr& frame, bool hasPicture);
  void delivered(FrameId id, const std::string& error);
  void sendDown(const Bytes& message);

  class Tiles;
  void dropTiles(const FramePtr& frame);
  void spawnTile(const FramePtr& frame, const Tile& tile, int64_t reserved);
  void spawned(const FramePtr& frame, TraceResult& result, int64_t reserved, std::vector<Held>& stack);
  void take(const FramePtr& frame, int origin, TraceResult& result, std::vector<Held>& stack);
  void traced(const FramePtr& frame, int origin, bool primary, TraceResult& result, std::vector<Held>& stack);
  void retire(const FramePtr& frame, int origin, bool primary, uint64_t rays);
  void process(const FramePtr& frame, int origin, std::vector<Held> stack);
  using Call = std::function<void(DeviceScene::Done)>;
  using Then = std::function<void(TraceResult&, std::vector<Held>&)>;
  void ask(const FramePtr& frame, int origin, uint64_t rays, const Call& call, Then then,
           std::vector<Held>& stack);
  void answered(Asked& asked, TraceResult result);
  void putOff(const FramePtr& frame, int origin, std::vector<Held> rest);
  static Held hold(const Frame& frame, LeavingRays rays);
  void forward(const FramePtr& frame, int rank, int partition, bool primary, int origin, const RayList& rays);
  void contribute(const FramePtr& frame, TraceResult& result);
  void giveBack(int origin, const Share& share, int64_t credits);
  FramePtr find(FrameId id) const;
  FramePtr findOrPark(FrameId id, Channel channel, Bytes& message);
  bool isOver(FrameId id) const { return id < firstNotOver_ || over_.count(id) > 0; }
  void post(std::function<void()> task);
  void post(const Share& share, FrameId frame, std::function<void()> task, bool first = false);
  void post(const FramePtr& frame, std::function<void()> task, bool first = false);
  void runNext(ReadyQueue& queue);
  void startRunner();
  void startHandOut();

  Transport& transport_;
  const Options options_;
  Completion completion_;
  /// Without bytes: those of a purpose are entered by their another().
  const Account account_;
  const LedgerEntry parkedMemory_;
  const std::shared_ptr<Tasks> tasks_;
  const std::shared_ptr<Framebuffers> framebuffers_ = std::make_shared<Framebuffers>();
  ReadyQueue ready_;
  std::atomic<int> runners_ = 0;   ///< posted to the Transport; each runs one task of ready_
  ReadyQueue pictures_;            ///< to be handed out
  std::atomic<int> handOuts_ = 0;  ///< as runners_, each for one task of pictures_

  mutable std::mutex mutex_;  ///< guards all below but the atomics
  std::map<SceneId, Scene> scenes_;
  std::map<FrameId, FramePtr> frames_;
  std::map<FrameId, std::vector<Parked>> parked_;  ///< messages that overtook their frame's start
  PictureHandler pictureHandler_;
  FrameId firstNotOver_ = 1;             ///< all frames below are over here
  std::set<FrameId> over_;               ///< those above that are
  std::map<FrameId, Pending> pending_;   ///< rank 0
  Admission admission_;                  ///< rank 0
  std::map<uint64_t, FrameId> windows_;  ///< rank 0: newest frame of each window, while it is pending
  FrameId nextFrame_ = 1;
  Counters counters_;
};

}  // namespace gxy
