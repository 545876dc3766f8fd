// SPDX-License-Identifier: Apache-2.0
// The kernels that read volumes, for a dialect whose VOLUME and fetch functions are known (volume_view.h for C++ and
// ISPC), in dependency order; all.h comes before.
// clang-format off
#if defined(ISPC) || defined(GXY_GLSL)
#include "grid.h"
#include "trilinear.h"
#include "cubic.h"
#include "volume_view.h"
#include "map.h"
#include "volume.h"
#include "march.h"
#include "isosurface.h"
#else
#include "gxy/kernels/grid.h"
#include "gxy/kernels/trilinear.h"
#include "gxy/kernels/cubic.h"
#include "gxy/kernels/volume_view.h"
#include "gxy/kernels/map.h"
#include "gxy/kernels/volume.h"
#include "gxy/kernels/march.h"
#include "gxy/kernels/isosurface.h"
#endif
// clang-format on
