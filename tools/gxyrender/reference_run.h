// SPDX-License-Identifier: Apache-2.0
// gxyrender --reference.
#pragma once
#include <string>

#include "options.h"

namespace gxy {

/// Renders every picture with the reference renderer, on this process alone.
void renderWithReference(const State& state, const std::string& directory, const RenderOptions& options,
                         bool progress);

}  // namespace gxy
