// SPDX-License-Identifier: Apache-2.0
// Names and files of pictures.
#pragma once
#include <string>
#include <vector>

#include "core/render/framebuffer.h"
#include "tools/gxyrender/load.h"
#include "tools/gxyrender/options.h"

namespace gxy {

/// Returns the name of picture `index` of picturesOf(state), with the prefix of the options.
std::string pictureName(const State& state, const RenderOptions& options, size_t index);

/// Draws the state's annotations over picture `index` of picturesOf(state). Throws Error if the font is
/// missing.
void annotate(Picture& picture, const State& state, const LoadedState& loaded, const RenderOptions& options,
              size_t index);

/// Writes name.FORMAT and, if the picture has depths, name.depth. Throws Error if a file cannot be written.
void writePicture(const std::string& name, const RenderOptions& options, Picture picture);

}  // namespace gxy
