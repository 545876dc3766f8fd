// SPDX-License-Identifier: Apache-2.0
// fieldProbe in GLSL.
#pragma once
#include <span>
#include <vector>

#include "tests/rays/field.h"

namespace gxy::test {

/// fieldProbe(p, ray i) at p * rays + i for p < probes, rays being 8 numbers each, on the device of Vulkan's
/// tests. The field is uploaded as the backend does.
std::vector<float> fieldProbesInGlsl(const Field& f, const Shown& shown, std::span<const float> rays,
                                     int probes);

}  // namespace gxy::test
