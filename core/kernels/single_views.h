// SPDX-License-Identifier: Apache-2.0
// scene_view.h and sampling_view.h for C++ in float, with pointers: what ISPC reads.
#pragma once
#include "core/kernels/single.h"

#define PTR(T) const T*
#define RAW const void*
#define BYTE std::uint8_t
namespace gxy::single {
#include "core/kernels/sampling_view.h"
#include "core/kernels/scene_view.h"
}  // namespace gxy::single
#undef PTR
#undef RAW
#undef BYTE
