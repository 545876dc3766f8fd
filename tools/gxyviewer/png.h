// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "canvas.h"

namespace gxy {

/// Writes a picture as it is, bit by bit. Throws Error when the file cannot be written; it is whole or not there.
void writePng(const std::string& path, const Canvas& canvas);

}  // namespace gxy
