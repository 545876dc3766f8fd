// SPDX-License-Identifier: Apache-2.0
// The kernels that read scenes, for ISPC and GLSL, in dependency order; all.h, fields.h and core/rays/ray_fields.h come
// before.
// clang-format off
#include "scene_view.h"
#include "clip.h"
#include "cuts.h"
#include "many.h"
#include "camera.h"
#include "lattice.h"
#include "primitives.h"
#include "surface.h"
#include "shares.h"
// clang-format on
