// SPDX-License-Identifier: Apache-2.0
// Renderer: from camera to picture on all ranks.
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/comm/trace.h"
#include "core/comm/transport.h"
#include "core/rays/backend.h"
#include "core/rays/packet_size.h"
#include "core/render/admission.h"
#include "core/render/flights.h"
#include "core/render/framebuffer.h"
#include "core/render/picture_operation.h"
#include "core/render/task_runner.h"
#include "core/space/ledger.h"

namespace gxy {

using SceneId = uint64_t;
using FrameId = uint64_t;

/// A request for one picture.
struct FrameRequest {
  SceneId scene = 0;
  Camera camera;
  int32_t samples = 0;  ///< rays per pixel; 0: as many as the scene says
  /// Index of the first sample. The sums of pictures with different samples add up to those of a picture with
  /// all of them.
  int32_t firstSample = 0;
  bool depth = false;
  bool sums = false;  ///< hand the picture out as its sums, without `rgba`
  /// Not 0: a newer frame of the same window supersedes this one. This is for callers that do not call
  /// supersede() themselves. The server's windows do, and leave it 0.
  uint64_t window = 0;
  Priority priority;    ///< whose turn it is rendered in, and whether it is interactive
  std::string account;  ///< name of the tenant that the ledger charges; empty: Options::tenant
  /// What is done with the picture; null: it goes to the handler of onPicture().
  PictureOperationPtr operation;
};

/// Renders frames together with the Renderers of all other ranks; each rank has one, over its Transport.
///
/// A frame is a flight (Flights) whose items are rays. Rank 0 starts a frame and makes it known on all ranks.
/// Each rank spawns the primary rays that first meet something visible in one of its partitions. Rays are
/// traced where they are and forwarded where they go. Contributions are sent to the rank that has the
/// framebuffer of their pixels (PictureParts). A frame is done when Completion says that every ray and every
/// message of contributions has been retired. Only then do the parts of its picture come together on the rank
/// that owns it, which hands it out.
///
/// Memory: credits bound the rays. A primary ray takes 1 + (secondaries per hit) credits of its rank and
/// gives them back wherever it and its secondaries end. A rank spawns only while it has credits, so the rays
/// of a rank that are in flight anywhere never exceed Options::raysInFlight (or one tile, if that is more).
/// Forwarded rays are always accepted. Behind translucent surfaces a primary may make more secondaries than
/// it took credits for; those put its rank into debt. A framebuffer takes its memory when its first
/// contribution arrives, and gives it back before the picture's handler runs. Of the frames of a stream that
/// are not interactive, rank 0 begins as many as Options::framebufferBytes allows (Admission), and keeps the
/// requests of the others. The ledger shows what frames hold, 0 when none is under way: "rays" (lists that
/// wait or are traced), "framebuffer", "picture" (its parts, and while its handler runs), "parked messages" and
/// "tiles".
///
/// Order: each rank runs tasks and spawns tiles in the order of ReadyQueue, which shares the processors among
/// tenants and the streams of each. A running task is not interrupted. But a task traces one packet and puts
/// the rest off, so that a frame that arrives waits, on each rank, for the packets that are being traced, and
/// an interactive frame waits for nothing else. Tiles are smaller where a pixel makes many rays, so that
/// there are credits for all. Pictures of frames that are not interactive are handed out on threads of lower
/// priority (Transport::postLong), however long that takes. At most Options::handOuts of them are handed out
/// at once, and tenants take turns.
///
/// Errors: a superseded frame ends like any other, its rays retired where they are met, but hands out no
/// picture. So does a frame of which a rank or its device could not do its part: rank 0 is told what went
/// wrong, and other frames go on. Messages that a Renderer would not send (a pixel outside the picture, a
/// frame that is over, ...) are refused with an Error. What they hold counts as ended, and their frame fails
/// if it is under way.
///
/// Threads: all calls may come from any thread. Callbacks run as tasks of the Transport.
class Renderer {
 public:
  struct Options {
    int packetRays = 1024;           ///< most rays that are traced together; >= 16
    int64_t raysInFlight = 1 << 20;  ///< credits of a rank
    /// The ledger for the memory of frames; null: none. Must outlive frames that name an account.
    Ledger* ledger = nullptr;
    std::string tenant = "batch";  ///< the ledger's tenant for frames without an account
    /// Processor or device time that an interactive frame may take on a rank; after that it is treated like a
    /// frame that is not interactive. The interactive frames of a tenant may also get ahead of others by this
    /// much (ReadyQueue).
    std::chrono::nanoseconds urgentWork = std::chrono::seconds(1);
    /// Processor time of the calling thread, by which tenants share the processors.
    std::function<std::chrono::nanoseconds()> processorTime = PacketSize::processorTime;
    /// Bytes, on each rank, of the framebuffers of a stream's frames that are not interactive.
    int64_t framebufferBytes = int64_t(512) << 20;
    /// Records packets, tiles, pictures and frames; may be null; outlives the Renderer.
    Trace* trace = nullptr;
    int runners = 1024;  ///< most tasks that it gives the Transport at once
    /// Most pictures that are handed out at once, of frames that are not interactive; 0: no limit.
    int handOuts = 0;
    int ranksPerPart = 16;  ///< for so many ranks a picture has a part (PictureParts); the same on all ranks
  };
  /// The end of a frame: with a picture, superseded, or with an error of a rank or of the picture handler.
  struct Ending {
    bool superseded = false;
    std::string error;
    bool hasPicture() const { return !superseded && error.empty(); }
  };
  using Finished = std::function<void(FrameId, const Ending&)>;
  using PictureHandler = std::function<void(FrameId, const FrameRequest&, Picture)>;

  Renderer(Transport& transport, Options options);
  /// Waits for running tasks and for devices that trace. Drops the rest of the work of frames that are under
  /// way.
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Makes a scene known on this rank; needed on every rank before rank 0 starts a frame of it.
  void addScene(SceneId id, std::shared_ptr<const CompiledScene> scene,
                std::shared_ptr<const DeviceScene> device);
  /// Forgets a scene on this rank. Frames that are under way keep what they need.
  void removeScene(SceneId id);

  /// Sets the handler of pictures that this rank owns and that come without an operation. It is not called for
  /// frames that end without a picture. Call this before frames start.
  void onPicture(PictureHandler handler);
  /// Sets how this rank reads the operations that rank 0 has written. Call this on every rank before frames with
  /// operations start. Once the reader is empty, pictures that come with an operation are dropped.
  void onOperation(PictureOperationReader reader);

  /// Rank 0 only: starts a frame, or lets it wait (Admission). `finished` is called on rank 0 when the
  /// operation or the picture handler has returned on its rank, or when the frame has ended without a picture.
  /// Throws Error for an invalid camera or an unknown scene.
  FrameId render(const FrameRequest& request, Finished finished);

  /// Rank 0 only: ends a frame without a picture, because a newer one takes its place or because nobody wants
  /// it any more. Its Ending says `superseded` in both cases. Does nothing if the frame is over.
  void supersede(FrameId id);

  struct Counters {
    TraceCounters trace;
    uint64_t raysForwarded = 0;                    ///< sent to other ranks
    uint64_t rayBytes = 0, contributionBytes = 0;  ///< handed to the transport for other ranks
    uint64_t rayMessages = 0, contributionMessages = 0;
    uint64_t tilesSkipped = 0;   ///< outside the projections of all partitions of this rank
    uint64_t pixelsSkipped = 0;  ///< pixels of this rank's pictures to which nothing was added
    /// Partitions of this rank in which nothing can be seen; counted once for each frame.
    uint64_t partitionsSkipped = 0;
    /// Messages that were not sent, as they would have been empty: to owners of pictures (no pixel to
    /// change), and to ranks whose rays were traced here (no credit to give back).
    uint64_t messagesSkipped = 0;
    uint64_t completionWaves = 0;  ///< rank 0: waves that have asked whether a frame is complete
    int64_t mostRaysInFlight = 0;  ///< most credits out at once
    int mostFramebuffers = 0;      ///< most framebuffers of this rank that had memory at once
  };
  Counters counters() const;

  /// State that is kept for frames that are not over; all 0 when none is under way.
  struct ResourceCounts {
    size_t frames = 0;                  ///< started here and not finished
    size_t parkedMessages = 0;          ///< messages of frames that have not started here
    size_t callbacks = 0, windows = 0;  ///< rank 0
    size_t pictures = 0;                ///< of several parts, one of them this rank's
    size_t completionSets = 0;
    size_t tasks = 0;                           ///< tasks that wait for their turn
    int64_t credits = 0;                        ///< credits out
    std::map<uint32_t, int64_t> tenantCredits;  ///< credits out, by tenant
  };
  ResourceCounts kept() const;

 private:
  struct Frame;
  struct Scene;
  /// Ledger entries of one tenant with 0 bytes, from which LedgerEntry::another() makes those of a frame's
  /// allocations.
  struct Account {
    Account(const Options& options, const std::string& tenant);
    LedgerEntry rays, framebuffer, picture, tiles;
  };
  using FramePtr = std::shared_ptr<Frame>;

  /// Rank 0: a frame whose end has not been reported.
  struct Pending {
    Finished finished;
    uint64_t window = 0;
    Priority priority;
    std::optional<Ending> ending;         ///< once all its work is done
    std::optional<FrameRequest> waiting;  ///< the request of a frame that has not begun (Admission)
  };
  /// Counts this rank's framebuffers that have memory. Their memory keeps the counter alive.
  struct Framebuffers {
    std::atomic<int> now = 0, most = 0;
    void more();
  };

  void beginFrame(FrameId id, const FrameRequest& request);
  void beginWaiting(const std::vector<FrameId>& ids);
  FramePtr readFrame(FrameId id, Reader& in);
  void prepare(Frame& frame);
  void complete(FrameId id, const FlightEnding& ending);
  void finish(const FramePtr& frame, bool hasPicture);
  void handOut(const FramePtr& frame, bool hasPicture);
  void makePart(const FramePtr& frame);
  Picture ownRows(Frame& frame);
  void collect(const FramePtr& frame, int source, Bytes part);
  void receiveParts(int source, Bytes message);
  void sendParts(const FramePtr& frame);
  Picture wholePicture(Frame& frame);
  void deliver(const FramePtr& frame, bool hasPicture);
  void delivered(FrameId id, const std::string& error);
  void takeResult(Frame& frame, TraceResult& result);
  void contribute(Frame& frame, TraceResult& result);
  void addTo(Frame& frame, int part, std::span<const Contribution> contributions,
             std::span<const DepthContribution> depths);
  void receivePixels(int source, Bytes message);
  void receiveContributions(Bytes message);

  Transport& transport_;
  const Options options_;
  /// This has 0 bytes; allocations are entered by its another().
  const Account account_;
  const std::shared_ptr<Framebuffers> framebuffers_ = std::make_shared<Framebuffers>();
  TaskRunner handOuts_;  ///< tasks that hand out pictures

  mutable std::mutex mutex_;  ///< guards the members below, but for flights_
  std::map<SceneId, Scene> scenes_;
  PictureHandler pictureHandler_;
  PictureOperationReader operationReader_;
  std::map<FrameId, Pending> pending_;   ///< rank 0
  Admission admission_;                  ///< rank 0
  std::map<uint64_t, FrameId> windows_;  ///< rank 0: newest frame of each window, while it is pending
  /// Frames under way whose picture has several parts, one of them this rank's.
  std::map<FrameId, FramePtr> collecting_;
  Counters counters_;

  Flights<TraceResult> flights_;  ///< the last member, as it calls this Renderer from its constructor on
};

}  // namespace gxy
