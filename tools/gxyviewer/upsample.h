// SPDX-License-Identifier: Apache-2.0
// A coarse level of a picture in the window's size.
#pragma once
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>

namespace gxy {

/// Interpolates linearly between the middles of pixels, premultiplied by their alpha; beyond the outermost middles it goes on
/// with their pixels. `coarse` is what the window's camera shows in `level` pixels: its smaller side spans what the window's
/// does, and their middles fall together. RGBA, not premultiplied; both hold as many pixels as their sizes say.
void upsample(std::span<const uint8_t> coarse, glm::ivec2 level, std::span<uint8_t> rgba, glm::ivec2 size);

}  // namespace gxy
