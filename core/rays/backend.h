// SPDX-License-Identifier: Apache-2.0
// Backend: traces ray lists on one kind of device. The core never sees a device pointer, and a backend never
// sees MPI.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/rays/compiled_frame.h"
#include "core/rays/compiled_sampling.h"
#include "core/rays/compiled_scene.h"
#include "core/rays/device_fields.h"
#include "core/rays/ray_list.h"
#include "core/rays/sample_list.h"

namespace gxy {

class Ledger;

/// Kernels that some scenes do not need; each has code of its own.
enum class Kernel { Geometry, Slices, Isosurfaces, Integrate, IntegrateVolumes, IntegrateMesh, Shade };
inline constexpr const char* kKernelNames[] = {"geometry",       "slices",         "isosurfaces", "integrate",
                                               "integrate many", "integrate mesh", "shade"};
inline constexpr size_t kKernels = std::size(kKernelNames);

/// Counters of what was done and what was skipped, in one call, or in several that a device has done as one.
/// They add up.
struct TraceCounters {
  uint64_t raysSpawned = 0;  ///< primaries
  uint64_t raysTraced = 0;   ///< ray visits to a partition
  uint64_t raysShaded = 0;   ///< surface hits of primaries
  uint64_t raysRetired = 0;  ///< primaries and secondaries that have ended
  uint64_t secondariesSpawned = 0;
  /// Shadow and occlusion rays that hits did not make, because they would take nothing away (from a light
  /// behind the surface, say), or because nothing that may block them is on their way.
  uint64_t secondariesSkipped = 0;
  uint64_t raysEndedEarly = 0;                     ///< because nothing behind could be seen
  uint64_t samples = 0;                            ///< samples of volumes
  uint64_t macrocells = 0, macrocellsSkipped = 0;  ///< of the march
  uint64_t segmentsSkipped = 0;  ///< of the march, in macrocells that it integrates cell by cell
  uint64_t cells = 0, isoMacrocellsSkipped = 0;  ///< of the isosurface walk
  uint64_t meshCells = 0,
           meshWalks = 0;  ///< cells of unstructured volumes that rays crossed, and walks through them
  uint64_t nsSpawn = 0, nsGeometry = 0, nsSurfaces = 0, nsIntegrate = 0, nsShade = 0,
           nsRoute = 0;  ///< nanoseconds
  /// For a device with a queue: how often work was submitted to it, how many nanoseconds it worked, and how
  /// many it had nothing to do while some frame was under way on it. The last may be negative in one result,
  /// which then corrects another.
  uint64_t submissions = 0, nsDevice = 0;
  int64_t nsDeviceIdle = 0;
  /// Nanoseconds, by the host's clock, during which the device had requests that it had not done or whose
  /// results nobody had looked at.
  uint64_t nsDeviceAsked = 0;
  /// Nodes and primitives of hierarchies over geometry that rays came to; 0 unless the backend was told to
  /// count them.
  uint64_t nodes = 0, primitives = 0;
  /// Rays that a device with a queue copied to the host, to be sent away. Rays that go on in other partitions
  /// of the rank stay on the device as long as it has room for them.
  uint64_t raysRead = 0;
  std::array<uint64_t, kKernels> kernelRuns{};  ///< how often each was started, by Kernel

  uint64_t& runs(Kernel kernel) { return kernelRuns[size_t(kernel)]; }
  uint64_t nsWork() const { return nsSpawn + nsGeometry + nsSurfaces + nsIntegrate + nsShade + nsRoute; }
  TraceCounters& operator+=(const TraceCounters& o);
};

/// Rays that leave a packet for a partition; all primaries or all secondaries. Those for other ranks are in
/// host memory (RayList::kept() is null). It is an ItemList (core/render/flight.h), whose kind is 1 for
/// primaries and 0 for secondaries.
struct LeavingRays {
  int partition = 0;
  bool primary = true;
  RayList rays;

  uint32_t kind() const { return primary; }
  int size() const { return rays.size(); }
  int64_t bytes() const { return rays.bytes(); }
  std::vector<LeavingRays> split(int most) const;
  void write(Bytes& out) const;
  static int wireBytes(uint32_t kind) { return kind > 1 ? 0 : RayList::wireBytes(kind == 1); }
};

/// The result of a traced packet or a spawned tile.
struct TraceResult {
  std::vector<LeavingRays> leaving;  ///< forwarded rays and new secondaries, which may stay in this partition
  std::vector<Contribution> contributions;
  std::vector<DepthContribution> depths;  ///< only if the frame wants them
  TakenSamples samples;                   ///< of a sampling; if some were refused, others are missing
  uint64_t retired = 0;                   ///< rays of the packet that have ended
  /// New secondary rays in `leaving`. The backend may have made and traced others itself.
  uint64_t created = 0;
  TraceCounters counters;
  std::string error;  ///< not empty: the call failed, and the result has only `retired`
};

/// The pixels whose primary rays are spawned together: [x0, x1) x [y0, y1), at most kTile a side, of one
/// sample.
struct SpawnTile {
  int x0, y0, x1, y1, sample;
};
inline constexpr int kTile = 32;

/// A frame as a device holds it. Immutable, except for whether it is urgent and whether it is cancelled.
/// Thread safe.
class DeviceFrame {
 public:
  virtual ~DeviceFrame() = default;
  /// A device with a queue does urgent frames before others, in turn. The Renderer makes interactive frames
  /// urgent until they have taken Renderer::Options::urgentWork.
  virtual void setUrgent(bool urgent) const { urgent_ = urgent; }
  bool urgent() const { return urgent_; }
  /// A device with a queue answers what waits in it for this frame without doing it: all its rays are
  /// `retired`.
  virtual void cancel() const { cancelled_ = true; }
  bool cancelled() const { return cancelled_; }

 private:
  mutable std::atomic<bool> urgent_ = false, cancelled_ = false;
};

/// A compiled scene on a device, for the partitions of one rank; shared by all frames that show it. Calls may
/// come from any number of threads at once. `done` is called once with the result, on any thread, possibly
/// before the call returns, otherwise soon and without further calls. Until then the scene and the frame must
/// live. `done` must be short and must not throw. If the device fails, the result says so. A call that throws
/// does not call `done`.
class DeviceScene {
 public:
  using Done = std::function<void(TraceResult)>;
  virtual ~DeviceScene() = default;

  virtual std::shared_ptr<const DeviceFrame> makeFrame(const CompiledFrame& frame) const = 0;

  /// Makes a frame whose rays sample surfaces instead of shading them: trace() of it takes sampling rays (RAY_SAMPLE) as
  /// secondaries, and its results have samples and no contributions. The sampling is of this scene. `enter` is asked for room
  /// for samples while a packet records them, by any thread, as long as rays are traced; if it throws, the frame is cancelled.
  /// Null: this device cannot.
  virtual std::shared_ptr<const DeviceFrame> makeSampling(std::shared_ptr<const CompiledSampling>,
                                                          EnterMemory) const {
    return nullptr;
  }

  /// Spawns the primary rays of a tile whose first visible partition is one of this rank's. The result has
  /// them as leaving rays; if the backend has already traced some, it has what became of these. It counts no
  /// rays as `retired`.
  virtual void spawn(const DeviceFrame& frame, const SpawnTile& tile, Done done) const = 0;

  /// Begins rays of a sampling: `pixel`, `sr`, `info`, `start`, `o*`, `d*`, `tMax` and `sg` of each are set, and they begin at t =
  /// 0. The result has them as leaving rays, for partitions of any rank; those that meet no visible partition are left out.
  /// Only for devices that make samplings.
  virtual void spawnRays(const DeviceFrame& frame, RayList rays, Done done) const;

  /// Traces rays through a local partition until each has ended or left it. This includes shading hits and
  /// finding where rays go on.
  virtual void trace(const DeviceFrame& frame, int partition, bool primary, RayList rays,
                     Done done) const = 0;

  /// Bytes that the device holds for this scene alone.
  virtual size_t bytes() const = 0;
  /// Allocations that it may hold together with other scenes. What else scenes share is in the ledger, if
  /// any, that the backend was made with.
  virtual std::vector<SharedBytes> sharedBytes() const { return {}; }
};

class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string name() const = 0;
  virtual std::string device() const = 0;  ///< device and instruction set, to be shown to users
  /// Makes a scene on the device, for the partitions of `rank`. This takes long for much geometry; `advance`
  /// is called meanwhile. Throws Error if the device has no room, and what `advance` throws; nothing is left
  /// behind then.
  virtual std::unique_ptr<DeviceScene> makeScene(
      std::shared_ptr<const CompiledScene> scene, int rank, const Advance& advance = [](double) {}) const = 0;
  /// Brings fields to the device, for the partitions of `rank`. Null: this device cannot. Throws Error if it
  /// has no room.
  virtual std::unique_ptr<DeviceFields> makeFields(std::shared_ptr<const CompiledFields>,
                                                   int /*rank*/) const {
    return nullptr;
  }
  /// Whether the device is lost. Nothing can be done on it any more.
  virtual bool lost() const { return false; }
};

/// Backends by name. A program registers the backends that it links. Not thread safe.
class BackendRegistry {
 public:
  /// Makes a backend. `ledger` (may be null) is where it enters device memory for tenant "device", except
  /// what scenes report themselves.
  using Maker = std::function<std::unique_ptr<Backend>(Ledger* ledger)>;
  struct Entry {
    std::string name;
    Maker maker;
    std::function<bool()> fits;
  };
  /// `auto` is the first backend added that `fits` (null: always) and can be made. Backends added after it
  /// are its substitutes (substitutes.h).
  void add(std::string name, Maker maker, std::function<bool()> fits = {}) {
    entries_.push_back({std::move(name), std::move(maker), std::move(fits)});
  }
  /// Says how the backend is made that advances lines where the one in use cannot (field_maker.h).
  void addForFields(Maker maker) { forFields_ = std::move(maker); }
  /// Empty if there is none.
  const Maker& forFields() const { return forFields_; }
  /// Makes a backend. Throws Error for an unknown name, with the known ones, and what the maker throws. With
  /// `auto`, if none can be made, it throws what the first one threw. Logs a warning of each backend that
  /// `auto` had to pass over.
  std::unique_ptr<Backend> make(const std::string& name, Ledger* ledger = nullptr) const;

 private:
  std::vector<Entry> entries_;
  Maker forFields_;
};

}  // namespace gxy
