// SPDX-License-Identifier: Apache-2.0
// The kernels that read scenes, in dependency order; all.h, fields.h, scene_view.h and core/rays/ray_fields.h come before.
// clang-format off
#if defined(ISPC) || defined(GXY_GLSL)
#include "scene_fetch.h"
#include "clip.h"
#include "cuts.h"
#include "many.h"
#include "camera.h"
#include "lattice.h"
#include "primitives.h"
#include "surface.h"
#include "shares.h"
#else
#include "gxy/kernels/scene_fetch.h"
#include "gxy/kernels/clip.h"
#include "gxy/kernels/cuts.h"
#include "gxy/kernels/many.h"
#include "gxy/kernels/camera.h"
#include "gxy/kernels/lattice.h"
#include "gxy/kernels/primitives.h"
#include "gxy/kernels/surface.h"
#include "gxy/kernels/shares.h"
#endif
// clang-format on
