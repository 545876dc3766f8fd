// SPDX-License-Identifier: Apache-2.0
// The kernels that read volumes, in dependency order; cells.h and the dialect's volume_fetch come before.
// clang-format off
#include "core/kernels/map.h"
#include "core/kernels/volume.h"
#include "core/kernels/march.h"
#include "core/kernels/isosurface.h"
// clang-format on
