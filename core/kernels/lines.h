// SPDX-License-Identifier: Apache-2.0
// The kernels about lines through vector fields, in the order of their dependencies. They read no samples; all.h and cells.h must
// come before.
// clang-format off
#include "core/kernels/philox.h"
#include "core/kernels/flow.h"
#include "core/kernels/advect.h"
// clang-format on
