// SPDX-License-Identifier: Apache-2.0
// Every function of core/kernels is called by a probe, if only through others: all of them once more, static, so that it is an
// error to compile one that nothing calls (-Werror=unused-function; no kernel calls itself).
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>

#include "core/rays/ray_fields.h"

#define GXY_REAL float
#define FN static
#define FN_OUTLINE static
namespace gxy::all_probed {
// clang-format off
#include "core/kernels/dialect.h"
#include "core/kernels/all.h"
#include "core/kernels/philox.h"
#include "core/kernels/samples.h"
namespace rays {
#include "tests/kernels/probe.h"
}
#include "core/kernels/cells.h"
#include "core/kernels/map_fetch.h"
#include "core/kernels/volume_fetch.h"
#include "core/kernels/fields.h"
namespace fields {
#include "tests/rays/field_probe.h"
}
#include "core/kernels/scene_view.h"
#include "core/kernels/scene_fetch.h"
#include "core/kernels/scene.h"
namespace scenes {
#include "tests/agreement/scene_probe.h"
}
// clang-format on

float probes(VOLUME v, SCENE s, FRAME f, OPERATOR op, VOLUMES list) {
  return rays::probe(0, 0) + fields::fieldProbe(op.map, v, 0, {}) +
         scenes::sceneProbe(s, f, op, v, list, 0, 0, 0);
}

}  // namespace gxy::all_probed
