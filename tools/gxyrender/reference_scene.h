// SPDX-License-Identifier: Apache-2.0
// Converts loaded data to scenes of the reference renderer.
#pragma once
#include <cstdint>
#include <span>

#include "core/reference/reference.h"
#include "tools/gxyrender/load.h"

namespace gxy {

/// Makes a scene from a visualization and its data, which must be in one partition; meshes may be in several, with all
/// blocks present.
reference::ReferenceScene referenceScene(const Visualization& visualization,
                                         std::span<const OperatorData> data, const RenderSettings& settings);

/// Makes a scene from visualization v of a state whose data are loaded into one partition.
reference::ReferenceScene referenceScene(const State& state, const LoadedState& loaded, size_t v);

/// Returns the directions of ambient occlusion rays that backends use in frame `frameNumber` of a camera
/// `width` pixels wide, so that pictures can be compared pixel by pixel.
reference::AoDirections occlusionDirections(int aoCount, int width, uint32_t frameNumber);

}  // namespace gxy
