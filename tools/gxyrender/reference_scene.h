// SPDX-License-Identifier: Apache-2.0
// What is loaded, as the reference renderer wants it.
#pragma once
#include <cstdint>
#include <span>

#include "core/reference/reference.h"
#include "tools/gxyrender/load.h"

namespace gxy {

/// A visualization of data that are whole, in one partition.
reference::ReferenceScene referenceScene(const Visualization& visualization,
                                         std::span<const OperatorData> data, const RenderSettings& settings);

/// Visualization v of a state whose data are loaded whole, in one partition.
reference::ReferenceScene referenceScene(const State& state, const LoadedState& loaded, size_t v);

/// The directions of ambient occlusion that backends take, so that pictures can be compared pixel by pixel:
/// of frame `frameNumber`, seen by a camera `width` pixels wide.
reference::AoDirections occlusionDirections(int aoCount, int width, uint32_t frameNumber);

}  // namespace gxy
