// SPDX-License-Identifier: Apache-2.0
// The GPU backend: Vulkan 1.2 compute. It needs no window system and no ray-tracing extension.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/rays/backend.h"
#include "core/space/ledger.h"

namespace gxy {

/// A Vulkan device of this machine.
struct VulkanDeviceInfo {
  std::string name, driver;
  enum class Kind { Discrete, Integrated, Virtual, Software, Other } kind = Kind::Other;
  uint64_t memory = 0;               ///< bytes of the largest heap in the device's own memory
  std::vector<std::string> missing;  ///< features that this backend needs and the device lacks
};

/// Lists all devices, in the loader's order; none where there is no Vulkan. The call loads every driver into
/// the process; Mesa's software device takes 67 MB of it.
std::vector<VulkanDeviceInfo> vulkanDevices();

/// Whether `devices` has a discrete GPU that this backend can use.
bool hasDiscreteGpu(const std::vector<VulkanDeviceInfo>& devices);

/// Says what discrete GPUs that it cannot use lack: `"NAME" lacks FEATURE, FEATURE; ...`; empty where there
/// are none.
std::string lackingOf(const std::vector<VulkanDeviceInfo>& devices);

/// Whether a driver shows a GPU's device node in `folder` (dri/renderD*, nvidia<number>, dxg). Without one
/// there is no GPU. This tells so without loading any driver.
bool showsGpu(const std::string& folder = "/dev");

struct VulkanOptions {
  /// A number in the order of vulkanDevices(), or a part of a device's name (digits alone are always a
  /// number). Empty: the best kind of device. Software devices are taken only if nothing else is there, or if
  /// asked for.
  std::string device;
  /// The number of this rank on its machine. Ranks share equally good devices, or all that have the name,
  /// round robin.
  int rankOnMachine = 0;
  /// The largest buffer to bind as texels of one word. Larger ones are read as texels of four words, or by
  /// address. 0: what the device binds.
  uint64_t bindingBytes = 0;
  /// For tests: the largest buffer to bind as texels of four words instead. 0: what Mesa's software device
  /// binds; no other device binds any.
  uint64_t quadBytes = 0;
  /// For tests: the largest storage buffer to bind for what is read ahead. 0: what the device binds.
  uint64_t storageBytes = 0;
  /// The ledger for device memory, tenant "device", except the bytes that scenes report by bytes() and
  /// sharedBytes(). Used only by makeVulkanBackend; null: none.
  Ledger* ledger = nullptr;
  /// For tests: the largest allocation that the device grants. 0: its own limit.
  uint64_t allocationBytes = 0;
  /// For tests: all memory that the device grants. 0: its own limit.
  uint64_t memoryBytes = 0;
  /// The most memory of rays that wait on the device; set by tests only. 0: an eighth of the device's memory.
  uint64_t keptBytes = 0;
  /// How many compiled pipelines stay that no scene needs: those that were asked for last. Tests, which show many scenes in
  /// turn, keep more.
  size_t keptPipelines = 24;
  /// For gpu_report and tests: count TraceCounters::nodes and ::primitives, in scenes with geometry.
  bool countsNodes = false;
  bool asGpu = false;  ///< for tests: treat a software device as a GPU, although it still ends long loops
  bool hidesMemory = false;  ///< for tests: act as if the host could not see the device's memory
  uint64_t lostAfter = 0;    ///< for tests: the device is lost after this many submissions; 0: never
  bool lostInWaits = false;  ///< for tests: a later submission succeeds, and only waiting for it fails
  /// For tests: use the validation layer. GpuAssisted also checks each access of the shaders, but not
  /// synchronization, and is slow.
  enum class Validation { None, CoreAndSynchronization, GpuAssisted } validation = Validation::None;
  /// With validation: called with each message of the layers, on any thread.
  std::function<void(const char* message)> heard;
};

/// Makes the backend of name "vulkan". It is thread safe. Throws Error if there is no such device or it lacks
/// something. Its makeScene() throws Error if a scene needs more memory than there is.
std::unique_ptr<Backend> makeVulkanBackend(const VulkanOptions& options = {});

/// The device of a backend that makeVulkanBackend has made; any other throws std::bad_cast.
const VulkanDeviceInfo& deviceOf(const Backend& backend);

}  // namespace gxy
