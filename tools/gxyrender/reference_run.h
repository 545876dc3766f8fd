// SPDX-License-Identifier: Apache-2.0
// gxyrender --reference.
#pragma once
#include <string>

#include "tools/gxyrender/options.h"

namespace gxy {

/// Renders every picture with the reference renderer, on this process alone. `shown`, and what is returned: what the
/// visualizations have shown before, and with these pictures.
std::vector<ShownSoFar> renderWithReference(const State& state, const std::string& directory,
                                            const RenderOptions& options, bool progress,
                                            std::vector<ShownSoFar> shown);

}  // namespace gxy
