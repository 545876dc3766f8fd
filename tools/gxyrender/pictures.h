// SPDX-License-Identifier: Apache-2.0
// Names and files of pictures.
#pragma once
#include <string>
#include <vector>

#include "core/render/framebuffer.h"
#include "tools/gxyrender/load.h"
#include "tools/gxyrender/options.h"

namespace gxy {

/// Of the picture of a visualization from a camera (core/scene/picture_name.h), with the prefix of the options.
std::string pictureName(const State& state, const RenderOptions& options, size_t visualization,
                        size_t camera);

/// Draws what the state asks for over the picture of visualization v from camera c. Throws Error.
void annotate(Picture& picture, const State& state, const LoadedState& loaded, const RenderOptions& options,
              size_t visualization, size_t camera);

/// Writes name.FORMAT and, if there are depths, name.depth. Throws Error when a file cannot be written.
void writePicture(const std::string& name, const RenderOptions& options, Picture picture);

}  // namespace gxy
