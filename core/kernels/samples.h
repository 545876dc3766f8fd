// SPDX-License-Identifier: Apache-2.0
// The kernels about sources of sampling rays, in the order of their dependencies. They read no samples; all.h and philox.h must come
// before.
// clang-format off
#include "core/kernels/random_line.h"
// clang-format on
