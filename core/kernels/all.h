// SPDX-License-Identifier: Apache-2.0
// All kernels that read neither volumes nor scenes, in the order of their dependencies.
// clang-format off
#include "core/kernels/elementary.h"
#include "core/kernels/exact.h"
#include "core/kernels/box.h"
#include "core/kernels/sphere.h"
#include "core/kernels/roundcone.h"
#include "core/kernels/tube.h"
#include "core/kernels/triangle.h"
#include "core/kernels/face.h"
#include "core/kernels/hexahedron.h"
#include "core/kernels/offset.h"
#include "core/kernels/light.h"
// clang-format on
