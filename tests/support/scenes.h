// SPDX-License-Identifier: Apache-2.0
// Small scenes: one of each kind, and one with everything. They do not depend on a partitioning.
#pragma once
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/scene/scene.h"
#include "tests/support/data_sets.h"

namespace gxy::test {

struct TestScene {
  std::string name;
  Box domain;  ///< domain of all partitionings of the scene
  Visualization visualization;
  RenderSettings settings;
  Camera camera;
  /// The data of each operator.
  std::vector<std::variant<std::shared_ptr<const WholeVolume>, std::shared_ptr<const WholeGeometry>,
                           std::shared_ptr<const WholeMesh>>>
      data;
};

/// The domain of the scenes below. Its sides are unequal and its centre is not the origin.
Box sceneDomain();

/// Returns a perspective camera that sees all of a domain from outside.
Camera cameraOutside(const Box& domain, glm::ivec2 size);

/// These add operators with their data, or change operators and lighting. They can be combined.
void addSmoothVolume(TestScene& scene);  ///< rendered; 33 x 28 x 38 points that fill the domain
void addSpikyVolume(TestScene& scene);   ///< rendered; steps and spikes in the map
void addSecondVolume(TestScene& scene);  ///< rendered; 8 bits; a grid of its own, smaller than the domain
void addIsosurfaces(TestScene& scene, double opacity);
void addSlices(TestScene& scene, double opacity);
void addParticles(TestScene& scene, double opacity);  ///< radius from data
void addTubes(TestScene& scene, double opacity);
void addMesh(TestScene& scene, double opacity);  ///< a triangulated sphere with values and normals
void addColors(TestScene& scene);                ///< for all geometry added so far, instead of values
void addClipPlane(TestScene& scene);             ///< on all operators added so far
void addLights(TestScene& scene);                ///< directional, point and camera lights with shadows
void addOcclusion(TestScene& scene);             ///< four ambient-occlusion rays

TestScene emptyScene(std::string name, glm::ivec2 size = {56, 48});

/// Returns a scene of each kind, and scenes with an orthographic camera, a camera inside, and several rays
/// per pixel.
std::vector<TestScene> scenesOfEachKind();

/// Returns a scene with everything at once, some of it translucent.
TestScene everything(glm::ivec2 size = {56, 48});

}  // namespace gxy::test
