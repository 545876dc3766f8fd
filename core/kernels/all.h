// SPDX-License-Identifier: Apache-2.0
// Every kernel file, in the order in which they depend on each other.
// clang-format off
#include "core/kernels/elementary.h"
#include "core/kernels/exact.h"
#include "core/kernels/box.h"
#include "core/kernels/sphere.h"
#include "core/kernels/roundcone.h"
#include "core/kernels/tube.h"
#include "core/kernels/triangle.h"
#include "core/kernels/offset.h"
#include "core/kernels/light.h"
// clang-format on
