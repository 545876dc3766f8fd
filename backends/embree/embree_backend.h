// SPDX-License-Identifier: Apache-2.0
// The CPU backend: kernels in ISPC, and hierarchies that Embree builds. Other backends are compared with it.
#pragma once
#include <memory>

#include "core/rays/backend.h"

namespace gxy {

/// Makes the backend of name "embree". It is thread safe; scenes build on oneTBB threads.
std::unique_ptr<Backend> makeEmbreeBackend();

}  // namespace gxy
