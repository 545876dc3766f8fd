// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>

#include "core/scene/scene.h"

namespace gxy {

/// The name, without its ending, of picture `index` of all visualizations of a state from the first camera, then from the
/// next, and so on, and then of the next time step: PREFIX_00000, and the annotations of its visualization and camera, as PREFIX_00000_volume_front. An
/// annotation that begins with punctuation, as "-volume", stands as it is.
std::string pictureName(const std::string& prefix, const State& state, size_t index);

}  // namespace gxy
