// SPDX-License-Identifier: Apache-2.0
// The option --cinema of gxyrender.
#pragma once
#include "tools/gxyrender/options.h"
#include "tools/gxyrender/run.h"

namespace gxy {

/// Collective: makes the database of options.sweepFile, or adds to it, step by step. Throws Error; what was made of earlier steps
/// stays.
void runCinema(const Steps& steps, const RenderOptions& options, const Place& at);

}  // namespace gxy
