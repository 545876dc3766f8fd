// SPDX-License-Identifier: Apache-2.0
// core/kernels/scene.h in C++ float, which nothing but the test of the dialects needs, and sceneProbe.
#pragma once
#include "core/kernels/single_views.h"
#include "core/rays/ray_fields.h"

#define R(x) real(x)
#define FN inline
#define FN_OUTLINE inline
#define INOUT(T) T&
#define OUT(T) T&
#define UNIFORM
#define NO_HIT R(1e30)
#define VOLUME const VolumeView&
#define MAP const MapView&
#define CLIPS const ClipView&
namespace gxy::single {
// clang-format off
#include "core/kernels/scene_fetch.h"
#include "core/kernels/scene.h"
#include "tests/agreement/scene_probe.h"
// clang-format on
}  // namespace gxy::single
#undef R
#undef FN
#undef FN_OUTLINE
#undef INOUT
#undef OUT
#undef UNIFORM
#undef NO_HIT
#undef VOLUME
#undef MAP
#undef CLIPS
#undef SCENE
#undef FRAME
#undef OPERATOR
#undef VOLUMES
#undef OPERATOR_AT
#undef VOLUME_AT
