// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "core/annotate/overlay.h"
#include "tools/gxyviewer/canvas.h"

namespace gxy {

/// Writes a picture as it is, bit by bit, where the overlay leaves it so. Throws Error when the file cannot be written; it is whole or not there.
void writePng(const std::string& path, const Canvas& canvas, const Overlay& overlay = {});

}  // namespace gxy
