// SPDX-License-Identifier: Apache-2.0
// Backend: answers ray lists on one kind of device. The core never sees a device pointer, a backend never sees MPI.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/rays/compiled_frame.h"
#include "core/rays/compiled_scene.h"
#include "core/rays/ray_list.h"

namespace gxy {

class Ledger;

/// The kernels that scenes may do without; each has code of its own.
enum class Kernel { Geometry, Slices, Isosurfaces, Integrate, IntegrateMany, Shade };
inline constexpr const char* kKernelNames[] = {"geometry",  "slices",         "isosurfaces",
                                               "integrate", "integrate many", "shade"};
inline constexpr size_t kKernels = std::size(kKernelNames);

/// What was done, and what was skipped. Counters of one call, or of several that a device has done as one; they add.
struct TraceCounters {
  uint64_t raysSpawned = 0;  ///< primaries
  uint64_t raysTraced = 0;   ///< ray visits to a partition
  uint64_t raysShaded = 0;   ///< surface hits of primaries
  uint64_t raysRetired = 0;  ///< primaries and secondaries that have ended
  uint64_t secondariesSpawned = 0;
  /// Rays of lights and ambient occlusion that hits did not make: they would have nothing to take away (a
  /// light behind the surface, say), or nothing that may block them is on their way.
  uint64_t secondariesSkipped = 0;
  uint64_t raysEndedEarly = 0;                     ///< as nothing behind could be seen any more
  uint64_t samples = 0;                            ///< of volumes
  uint64_t macrocells = 0, macrocellsSkipped = 0;  ///< of the march
  uint64_t segmentsSkipped = 0;  ///< of the march, in macrocells that it goes through cell by cell
  uint64_t cells = 0, isoMacrocellsSkipped = 0;  ///< of the isosurface walk
  uint64_t nsSpawn = 0, nsGeometry = 0, nsSurfaces = 0, nsIntegrate = 0, nsShade = 0,
           nsRoute = 0;  ///< nanoseconds
  /// Of a device with a queue: how often it was handed work, how long it worked, and how long it had nothing to do while
  /// some frame was under way on it. The last may be below 0 in one result, which then corrects another.
  uint64_t submissions = 0, nsDevice = 0;
  int64_t nsDeviceIdle = 0;
  /// How long something was asked of it that it had not done yet, or that nobody had looked at yet, by the host's clock.
  uint64_t nsDeviceAsked = 0;
  /// Of hierarchies over geometry, what rays came to; 0 but of a backend that was told to count it.
  uint64_t nodes = 0, primitives = 0;
  /// Rays that such a device gave to the host, to be sent away: those that go on in other partitions of the rank it keeps as
  /// long as it has room for them.
  uint64_t raysRead = 0;
  std::array<uint64_t, kKernels> kernelRuns{};  ///< how often each was started, by Kernel

  uint64_t& runs(Kernel kernel) { return kernelRuns[size_t(kernel)]; }
  uint64_t nsWork() const { return nsSpawn + nsGeometry + nsSurfaces + nsIntegrate + nsShade + nsRoute; }
  TraceCounters& operator+=(const TraceCounters& o);
};

/// Rays that leave a packet for a partition; all primaries or all secondaries. Those for other ranks are here (RayList::kept() is null).
struct LeavingRays {
  int partition = 0;
  bool primary = true;
  RayList rays;
};

/// What became of a packet.
struct TraceResult {
  std::vector<LeavingRays> leaving;  ///< forwarded rays and new secondaries, which may stay in this partition
  std::vector<Contribution> contributions;
  std::vector<DepthContribution> depths;  ///< only if the frame wants them
  uint64_t retired = 0;                   ///< rays of the packet that have ended
  /// Rays that were made and are in `leaving`; a backend may have traced others itself.
  uint64_t secondaries = 0;
  TraceCounters counters;
  std::string error;  ///< not empty: it could not be done, and nothing is in the result but `retired`
};

/// Pixels [x0, x1) x [y0, y1), at most kTile on a side, and one sample.
struct Tile {
  int x0, y0, x1, y1, sample;
};
inline constexpr int kTile = 32;

/// A frame as a device holds it. Immutable but for whether it is urgent and whether it is wanted any more. Thread safe.
class DeviceFrame {
 public:
  virtual ~DeviceFrame() = default;
  /// A device with a queue takes it first, the urgent ones in turn.
  virtual void setUrgent(bool urgent) const { urgent_ = urgent; }
  bool urgent() const { return urgent_; }
  /// A device with a queue answers what waits in it for this frame without doing it: all rays are `retired`.
  virtual void cancel() const { cancelled_ = true; }
  bool cancelled() const { return cancelled_; }

 private:
  mutable std::atomic<bool> urgent_ = false, cancelled_ = false;
};

/// A compiled scene on a device, for the partitions of one rank; shared by all frames that show it. Calls may come from
/// any number of threads at once. `done` is called once, with the result, on any thread, possibly before the call
/// returns, else soon and without further calls; until then the scene and the frame must live. It must be short and not
/// throw. Where the device fails, the result says so; a call that throws does not call `done`.
class DeviceScene {
 public:
  using Done = std::function<void(TraceResult)>;
  virtual ~DeviceScene() = default;

  virtual std::shared_ptr<const DeviceFrame> makeFrame(const CompiledFrame& frame) const = 0;

  /// Primary rays whose first visible partition is one of this rank's, as leaving rays, or traced already, and then what
  /// has become of them; none is `retired`.
  virtual void spawn(const DeviceFrame& frame, const Tile& tile, Done done) const = 0;

  /// Traces rays through a local partition until each has ended or left it: trace, act and route in one go.
  virtual void trace(const DeviceFrame& frame, int partition, bool primary, RayList rays,
                     Done done) const = 0;

  /// Bytes that the device holds for this scene alone.
  virtual size_t bytes() const = 0;
  /// What it may hold for others, too. What else scenes share is in the ledger that the backend was made with, if in any.
  virtual std::vector<SharedBytes> sharedBytes() const { return {}; }
};

class Backend {
 public:
  virtual ~Backend() = default;
  virtual std::string name() const = 0;
  virtual std::string device() const = 0;  ///< for people: device and instruction set
  /// Long for much geometry, of which `advance` is told. Throws Error for what the device has no room for, and what `advance`
  /// throws, and leaves nothing then.
  virtual std::unique_ptr<DeviceScene> makeScene(
      std::shared_ptr<const CompiledScene> scene, int rank, const Advance& advance = [](double) {}) const = 0;
  /// Whether its device has gone: nothing can be done on it any more.
  virtual bool lost() const { return false; }
};

/// Backends by name; a program registers those that it links. Not thread safe.
class BackendRegistry {
 public:
  /// `ledger`: where a device's memory is entered for tenant "device", but what scenes tell of themselves; or null.
  using Maker = std::function<std::unique_ptr<Backend>(Ledger* ledger)>;
  struct Entry {
    std::string name;
    Maker maker;
    std::function<bool()> fits;
  };
  /// `auto` is the first that is added, `fits` (null: always) and can be made; where others were added after it, they stand in
  /// for it (substitutes.h).
  void add(std::string name, Maker maker, std::function<bool()> fits = {}) {
    entries_.push_back({std::move(name), std::move(maker), std::move(fits)});
  }
  /// Throws Error naming what there is; what the maker throws; with `auto`, where none can be made, what the
  /// first threw. Logs a warning of each that `auto` had to pass over.
  std::unique_ptr<Backend> make(const std::string& name, Ledger* ledger = nullptr) const;

 private:
  std::vector<Entry> entries_;
};

}  // namespace gxy
