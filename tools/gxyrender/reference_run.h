// SPDX-License-Identifier: Apache-2.0
// The option --reference of gxyrender.
#pragma once
#include <string>

#include "tools/gxyrender/options.h"

namespace gxy {

/// Renders every picture with the reference renderer, in this process alone. `shown` is what the
/// visualizations have shown in earlier time steps; returns it extended by this one.
std::vector<ShownSoFar> renderWithReference(const State& state, const std::string& directory,
                                            const RenderOptions& options, bool progress,
                                            std::vector<ShownSoFar> shown);

}  // namespace gxy
