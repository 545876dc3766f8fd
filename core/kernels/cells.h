// SPDX-License-Identifier: Apache-2.0
// The cells of volumes: how a ray finds them, how a value is interpolated in one, and the structures that volumes and maps are
// read from. In dependency order; all.h comes before. Behind it a dialect includes its own map_fetch and volume_fetch, and then
// fields.h.
// clang-format off
#include "core/kernels/grid.h"
#include "core/kernels/trilinear.h"
#include "core/kernels/cubic.h"
#include "core/kernels/view_types.h"
#include "core/kernels/map_view.h"
#include "core/kernels/volume_view.h"
// clang-format on
