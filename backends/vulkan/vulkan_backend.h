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
  uint64_t memory = 0;               ///< bytes, of the largest heap that is the device's own
  std::vector<std::string> missing;  ///< what this backend needs and the device lacks
};

/// All of them, in the loader's order; none where there is no Vulkan. Asking loads every driver into the process; Mesa's
/// software device takes 67 MB of it.
std::vector<VulkanDeviceInfo> vulkanDevices();

/// Whether there is a discrete GPU among them that this backend can use.
bool hasDiscreteGpu(const std::vector<VulkanDeviceInfo>& devices);

/// What those discrete GPUs lack that it cannot use: `"NAME" lacks FEATURE, FEATURE; ...`; empty where there are none.
std::string lackingOf(const std::vector<VulkanDeviceInfo>& devices);

/// Whether a driver shows a GPU's device node in that folder (dri/renderD*, nvidia<number>, dxg): without one there is no GPU,
/// which this tells without loading any driver.
bool showsGpu(const std::string& folder = "/dev");

struct VulkanOptions {
  /// A number in that order, or a part of a device's name (as is a number that no device has); empty: the best
  /// kind that there is. Software devices are taken only if nothing else is there, or if asked for.
  std::string device;
  /// Of those that may take a device: they share round robin equally good ones, or all that have the name.
  int rankOnMachine = 0;
  /// The largest buffer to bind as texels of a word; what is larger is read as texels of four words, or by address. 0: what
  /// the device binds.
  uint64_t bindingBytes = 0;
  /// For tests: the largest buffer to bind as texels of four words instead. 0: what Mesa's software device binds; others
  /// bind none.
  uint64_t quadBytes = 0;
  /// For tests: as if the device bound no larger storage buffer for what is read ahead. 0: what it binds.
  uint64_t storageBytes = 0;
  /// Where its memory is entered for tenant "device", but what scenes tell by bytes() and sharedBytes(); needed by
  /// the maker only.
  Ledger* ledger = nullptr;
  /// For tests: as if the device gave no more memory at once. 0: what it gives.
  uint64_t allocationBytes = 0;
  /// For tests: as if the device gave no more memory in all. 0: what it gives.
  uint64_t memoryBytes = 0;
  /// For tests: rays that wait on the device take no more. 0: an eighth of its memory.
  uint64_t keptBytes = 0;
  bool countsNodes =
      false;  ///< for gpu_report and tests: TraceCounters::nodes and ::primitives, in scenes with geometry
  bool asGpu = false;  ///< for tests: a software device does what a GPU does, but for loops that it ends
  bool hidesMemory = false;  ///< for tests: as if the host did not see the device's memory
  uint64_t lostAfter = 0;    ///< for tests: the device is lost after so many submissions; 0: it is not
  bool lostInWaits = false;  ///< for tests: who waits for a later one is told, not who hands it over
  /// For tests: with the validation layer. GpuAssisted checks each access of the shaders, too, but not synchronization, and is
  /// slow.
  enum class Validation { None, CoreAndSynchronization, GpuAssisted } validation = Validation::None;
  std::function<void(const char* message)>
      heard;  ///< with validation: is told what the layers say, on any thread
};

/// Device name "vulkan". Thread safe. Throws Error where there is no such device, or it lacks something, and
/// later, from makeScene, where a scene needs more memory than there is.
std::unique_ptr<Backend> makeVulkanBackend(const VulkanOptions& options = {});

/// The device of a backend that makeVulkanBackend has made.
const VulkanDeviceInfo& deviceOf(const Backend& backend);

}  // namespace gxy
