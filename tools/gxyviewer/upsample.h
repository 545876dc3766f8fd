// SPDX-License-Identifier: Apache-2.0
// Enlarges a coarse level of a picture to the window's size.
#pragma once
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>

namespace gxy {

/// Interpolates linearly between the centres of pixels, premultiplied by alpha; beyond the outermost centres
/// the pixels are repeated. `coarse` is a picture of the window's camera with `level` pixels: its smaller
/// side spans the same as the window's, and the centres of both pictures coincide. Both are RGBA, not
/// premultiplied, with as many pixels as their sizes say.
void upsample(std::span<const uint8_t> coarse, glm::ivec2 level, std::span<uint8_t> rgba, glm::ivec2 size);

}  // namespace gxy
