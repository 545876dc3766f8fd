// SPDX-License-Identifier: Apache-2.0
// scene_view.h and sampling_view.h for C++ in float, with pointers: what ISPC reads.
#pragma once
#include "core/kernels/single.h"

namespace gxy::single {
// clang-format off
#include "core/kernels/view_types.h"
#include "core/kernels/scene_view.h"
#include "core/kernels/sampling_view.h"
// clang-format on
}  // namespace gxy::single
#undef PTR
#undef RAW
#undef BYTE
