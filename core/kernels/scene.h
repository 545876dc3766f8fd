// SPDX-License-Identifier: Apache-2.0
// The kernels that read scenes, in the order of their dependencies. fields.h, core/rays/ray_fields.h, scene_view.h and the dialect's
// scene_fetch must come before.
// clang-format off
#include "core/kernels/clip.h"
#include "core/kernels/cuts.h"
#include "core/kernels/multi_volume.h"
#include "core/kernels/mesh.h"
#include "core/kernels/hex_walk.h"
#include "core/kernels/camera.h"
#include "core/kernels/lattice.h"
#include "core/kernels/primitives.h"
#include "core/kernels/surface.h"
#include "core/kernels/cell_surface.h"
#include "core/kernels/hex_surface.h"
#include "core/kernels/light_terms.h"
#include "core/kernels/act_sample.h"
// clang-format on
