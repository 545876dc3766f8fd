// SPDX-License-Identifier: Apache-2.0
// The kernels that read volumes, for a dialect whose VOLUME and fetch functions are known (volume_view.h for C++ and
// ISPC), in dependency order; all.h comes before.
// clang-format off
#include "core/kernels/grid.h"
#include "core/kernels/trilinear.h"
#include "core/kernels/cubic.h"
#include "core/kernels/volume_view.h"
#include "core/kernels/map.h"
#include "core/kernels/volume.h"
#include "core/kernels/march.h"
#include "core/kernels/isosurface.h"
// clang-format on
