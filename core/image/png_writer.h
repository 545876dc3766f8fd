// SPDX-License-Identifier: Apache-2.0
// Writes .png files with libpng. Used inside core/image only.
#pragma once
#include <cstddef>
#include <vector>

#include "core/image/image.h"

namespace gxy {

/// Returns the bytes of a .png file: RGBA of 8 bits from eightBits(). Throws Error with libpng's message.
std::vector<std::byte> encodePng(const Image& image);

}  // namespace gxy
