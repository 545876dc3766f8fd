// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "core/annotate/overlay.h"
#include "tools/gxyviewer/canvas.h"

namespace gxy {

/// Writes a picture, with the overlay drawn over it. Pixels that the overlay does not cover keep their bits.
/// The file is complete or absent. Throws Error if it cannot be written.
void writePng(const std::string& path, const Canvas& canvas, const Overlay& overlay = {});

}  // namespace gxy
