// SPDX-License-Identifier: Apache-2.0
// The structures of core/kernels as the shaders see them: pointers are replaced by places in a buffer.
#pragma once
#include <cstdint>

#include "shaders/layout.h"

namespace gxy::shader {
using real = float;
using uint = std::uint32_t;
#define GXY_LAYOUT
// clang-format off
#include "core/kernels/view_types.h"
#include "core/kernels/map_view.h"
#include "core/kernels/volume_view.h"
#include "core/kernels/scene_view.h"
#include "core/kernels/sampling_view.h"
// clang-format on
#undef GXY_LAYOUT
#undef PTR
#undef RAW
#undef VOLUME
#undef MAP
#undef CLIPS
}  // namespace gxy::shader
