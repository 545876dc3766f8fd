// SPDX-License-Identifier: Apache-2.0
// The kernels in C++ with float, in namespace gxy::single.
#pragma once
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>

#define GXY_REAL float
namespace gxy::single {
// clang-format off
#include "core/kernels/dialect.h"
#include "core/kernels/all.h"
#include "core/kernels/cells.h"
#include "core/kernels/map_fetch.h"
#include "core/kernels/volume_fetch.h"
#include "core/kernels/fields.h"
#include "core/kernels/lines.h"
#include "core/kernels/samples.h"
// clang-format on
}  // namespace gxy::single
#undef GXY_REAL
#undef R
#undef FN
#undef INOUT
#undef OUT
#undef UNIFORM
#undef VOLUME
#undef MAP
#undef CLIPS
#undef FLOW
#undef PTR
#undef RAW
#undef BYTE
#undef OFFSET
#undef FN_OUTLINE
#undef NO_HIT
#undef ROOT_ITERATIONS
#undef ROOT_TOLERANCE
