// SPDX-License-Identifier: Apache-2.0
// The kernels that read volumes, in the order of their dependencies. cells.h and the dialect's map_fetch and volume_fetch must come
// before.
// clang-format off
#include "core/kernels/map.h"
#include "core/kernels/cell_curve.h"
#include "core/kernels/volume.h"
#include "core/kernels/march.h"
#include "core/kernels/isosurface.h"
// clang-format on
