// SPDX-License-Identifier: Apache-2.0
// Scenes of one unstructured volume.
#pragma once
#include "tests/agreement/backend.h"
#include "tests/agreement/compare.h"
#include "tests/meshes/shapes.h"
#include "tests/support/meshes.h"

namespace gxy::test {

using agreement::expectAgreement;
using agreement::rendered;
using agreement::sceneFrom;
using agreement::waves;

/// A scene whose only operator is a mesh, seen from aside.
inline agreement::TestScene meshScene(const std::string& name, Vis vis, MeshPiece piece, int size = 40) {
  agreement::TestScene scene = sceneFrom(name, {2.1, 1.4, 3.3}, size, size);
  scene.add(std::move(vis), meshInOnePiece(std::move(piece)));
  return scene;
}

/// Opacity that rises with the value; extinction, so that no pictures depend on the number of cells.
inline Vis haze(double most = 1.5, double lo = -1, double hi = 1) {
  return rendered({{lo, 0}, {hi, most}}, lo, hi, true);
}
/// Two spikes, with nothing between.
inline Vis spikes() {
  return rendered({{-0.5, 0}, {-0.3, 0}, {-0.25, 12}, {-0.2, 0}, {0.3, 0}, {0.32, 20}, {0.34, 0}}, -1, 1,
                  true);
}

/// Isosurfaces and slices, not volume rendered.
inline Vis surfacesIn(std::vector<double> isovalues, std::vector<Plane> slices = {}, double opacity = 1) {
  Vis vis = agreement::surfaces(VisType::Volume, -1, 1);
  vis.isovalues = std::move(isovalues);
  vis.slices = std::move(slices);
  vis.opacity = opacity;
  return vis;
}
/// Three translucent surfaces and two slices in haze.
inline Vis surfacesInHaze() {
  Vis vis = haze(0.8);
  vis.isovalues = {-0.3, 0.15, 0.4};
  vis.slices = {{{1, 0.3, 0.2}, 0.1}, {{0, 0, -2}, 0.7}};
  vis.opacity = 0.5;
  return vis;
}

/// Renders with the first backend alone.
inline const agreement::CompareOptions kFirstAlone = [] {
  agreement::CompareOptions options;
  options.vulkan = false;
  return options;
}();

}  // namespace gxy::test
