// SPDX-License-Identifier: Apache-2.0
// Every kernel file, in the order in which they depend on each other.
#if defined(ISPC) || defined(GXY_GLSL)
#include "box.h"
#include "elementary.h"
#else
#include "gxy/kernels/box.h"
#include "gxy/kernels/elementary.h"
#endif
