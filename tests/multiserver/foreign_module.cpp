// SPDX-License-Identifier: Apache-2.0
// A module that was built for another interface: what GALAXY_MODULE defines, with another number.
#include "multiserver/server/module.h"

extern "C" uint32_t galaxy_module_abi() { return gxy::kModuleAbi + 1; }

extern "C" void galaxy_module_register(gxy::Registration& registration) {
  registration.work("foreign.work", [](const gxy::Work::Call&) -> nlohmann::json { return nullptr; });
}
