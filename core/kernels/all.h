// SPDX-License-Identifier: Apache-2.0
// Every kernel file, in the order in which they depend on each other.
// clang-format off
#if defined(ISPC) || defined(GXY_GLSL)
#include "elementary.h"
#include "box.h"
#else
#include "gxy/kernels/elementary.h"
#include "gxy/kernels/box.h"
#endif
// clang-format on
