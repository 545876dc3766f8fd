// SPDX-License-Identifier: Apache-2.0
// The backends that this build has: the one place that knows their names.
#pragma once
#include <string>
#include <vector>

#include "core/rays/backend.h"

namespace gxy {

/// What tools say of --backend and --device in their --help.
extern const char* const kBackendHelp;
extern const char* const kDeviceHelp;

struct BackendOptions {
  std::string device;     ///< of the vulkan backend: a number or a part of a name (see listDevices), or empty
  int rankOnMachine = 0;  ///< among those for which hasDevices(): they share its devices round robin
};

/// "embree" and, where the build has it, "vulkan"; `auto` is vulkan where there is a discrete GPU, or a device
/// was asked for, else embree, which also stands in for a GPU that fails (substitutes.h), but for none that was asked for. The
/// first rank of a machine logs a warning where its device is software.
BackendRegistry allBackends(const BackendOptions& options);

/// Whether a backend, or `auto`, takes BackendOptions::device.
bool hasDevices(const std::string& backend);

/// For people: a line for each device that a backend may use.
std::vector<std::string> listDevices();

}  // namespace gxy
