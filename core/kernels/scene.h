// SPDX-License-Identifier: Apache-2.0
// The kernels that read scenes, in dependency order; all.h, fields.h, scene_view.h and core/rays/ray_fields.h come before.
// clang-format off
#include "core/kernels/scene_fetch.h"
#include "core/kernels/clip.h"
#include "core/kernels/cuts.h"
#include "core/kernels/many.h"
#include "core/kernels/camera.h"
#include "core/kernels/lattice.h"
#include "core/kernels/primitives.h"
#include "core/kernels/surface.h"
#include "core/kernels/shares.h"
// clang-format on
