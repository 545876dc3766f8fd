// SPDX-License-Identifier: Apache-2.0
// Every kernel file, in the order in which they depend on each other.
// clang-format off
#if defined(ISPC) || defined(GXY_GLSL)
#include "elementary.h"
#include "exact.h"
#include "box.h"
#include "sphere.h"
#include "roundcone.h"
#include "tube.h"
#include "triangle.h"
#include "offset.h"
#include "light.h"
#else
#include "gxy/kernels/elementary.h"
#include "gxy/kernels/exact.h"
#include "gxy/kernels/box.h"
#include "gxy/kernels/sphere.h"
#include "gxy/kernels/roundcone.h"
#include "gxy/kernels/tube.h"
#include "gxy/kernels/triangle.h"
#include "gxy/kernels/offset.h"
#include "gxy/kernels/light.h"
#endif
// clang-format on
