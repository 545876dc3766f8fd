// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <string>

#include "core/scene/scene.h"

namespace gxy {

/// Returns the file name, without its extension, of picture `index`. Pictures are numbered in this order: all
/// visualizations from the first camera, all from the next camera, and so on, then the next time step. The name
/// is PREFIX_00000 followed by the annotations of the visualization and the camera: PREFIX_00000_volume_front.
/// An annotation that begins with punctuation ("-volume") is appended without an underscore.
std::string pictureName(const std::string& prefix, const State& state, size_t index);

}  // namespace gxy
