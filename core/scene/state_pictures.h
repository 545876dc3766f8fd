// SPDX-License-Identifier: Apache-2.0
// The pictures that a state makes in one time step, in their order, and their names.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace gxy {

struct StatePicture {
  size_t visualization = 0;  ///< index of State::visualizations
  Camera camera;             ///< before fitted() (resolve.h), with the picture's size
};

/// Returns the pictures: all visualizations from the first camera, all from the next camera, and so on. A visualization with a camera
/// of its own is rendered from that alone, in the first round. Without any camera, those that have none get defaultCamera()
/// (resolve.h).
std::vector<StatePicture> picturesOf(const State& state);

/// If the only visualization of a state has a camera or a size of its own, makes these the state's.
void useOwnCamera(State& state);

/// Returns the file name, without its extension, of picture `number`, which counts through all time steps. It is PREFIX_00000 followed
/// by the annotations of the visualization and the camera: PREFIX_00000_volume_front. An annotation that begins with punctuation
/// ("-volume") is appended without an underscore.
std::string pictureName(const std::string& prefix, size_t number, const Visualization& visualization,
                        const Camera& camera);

}  // namespace gxy
