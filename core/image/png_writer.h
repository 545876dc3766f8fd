// SPDX-License-Identifier: Apache-2.0
// Used inside core/io only.
#pragma once
#include <cstddef>
#include <vector>

#include "core/image/image.h"

namespace gxy {

/// A whole .png file of 8 bits, RGBA as eightBits() makes it, by libpng. Throws Error with libpng's words.
std::vector<std::byte> encodePng(const Image& image);

}  // namespace gxy
