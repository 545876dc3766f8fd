// SPDX-License-Identifier: Apache-2.0
// The CPU backend: ISPC, and Embree for what builds trees. The reference for all others.
#pragma once
#include <memory>

#include "core/rays/backend.h"

namespace gxy {

/// Device name "embree". Thread safe; scenes build on oneTBB threads.
std::unique_ptr<Backend> makeEmbreeBackend();

}  // namespace gxy
