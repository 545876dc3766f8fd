// SPDX-License-Identifier: Apache-2.0
// Scenes from a seed: any mixture of what a state file can say, at any scale and place.
#pragma once
#include <cstdint>
#include <string>

#include "tests/agreement/scenes.h"
#include "tests/support/partitionings.h"
#include "tests/support/scenes.h"

namespace gxy::test {

/// 1 to 4 operators on volumes (all sample types, 1 to 4 components, any spacing, needles, holes without data), particles,
/// path lines and triangles (degenerate ones among them); maps that are smooth, spiky, stepped, opaque, transparent, of one
/// point or unsorted; isovalues, slices and clip planes; lights, shadows and occlusion; cameras outside, inside, on grid
/// planes, far away, orthographic and wide; everything scaled by 1e-30 to 1e30 and moved by up to 1e6 extents.
/// A function of the seed alone. What it says has passed through the text of a state file.
TestScene randomScene(uint64_t seed);

/// The same with an unstructured volume as the only one that is rendered. Up to two other operators show surfaces.
TestScene randomMeshScene(uint64_t seed);

/// A way to cut the scene's domain and share it among 1 to 6 ranks, some of which may own nothing.
Cut randomCut(const TestScene& scene, uint64_t seed);

/// The scene in one partition, as the comparison with the reference takes it.
agreement::TestScene inOnePiece(const TestScene& scene);

/// The largest value that a channel of a picture of the scene may have.
double brightest(const TestScene& scene);

/// The scene as a state file has it, with the names of its data: data0.vti, data1.vtp, data2.vtu ...
State stateOf(const TestScene& scene);

/// Writes the scene as FOLDER/scene.state.json and its data beside it, for gxyrender; returns the path of the state file.
std::string saveScene(const TestScene& scene, const std::string& folder);

}  // namespace gxy::test
