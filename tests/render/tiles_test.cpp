// SPDX-License-Identifier: Apache-2.0
#include "core/render/tiles.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/frames.h"

namespace gxy::test {
namespace {

// A scene in which every partition is visible: something to compute tiles of, without data.
CompiledScene sceneOf(const Partitioning& partitioning) {
  CompiledScene scene;
  scene.partitioning = std::make_shared<const Partitioning>(partitioning);
  scene.space = renderSpaceOf(partitioning);
  scene.lo = scene.space.toRender(partitioning.domain().lo);
  scene.hi = scene.space.toRender(partitioning.domain().hi);
  scene.visible.assign(size_t(partitioning.partitions()), 1);
  return scene;
}

bool meets(const Box& b, const CameraRay& ray) {
  double t0 = 0, t1 = 1e300;
  for (int a = 0; a < 3; a++) {
    if (ray.direction[a] == 0) {
      if (ray.origin[a] < b.lo[a] || ray.origin[a] > b.hi[a]) return false;
      continue;
    }
    const double u = (b.lo[a] - ray.origin[a]) / ray.direction[a],
                 v = (b.hi[a] - ray.origin[a]) / ray.direction[a];
    t0 = std::max(t0, std::min(u, v));
    t1 = std::min(t1, std::max(u, v));
  }
  return t0 <= t1;
}

// Every pixel whose ray meets a box of a rank is in a tile of that rank, once per sample.
void expectCovered(const Cut& cut, Camera camera) {
  camera.dimensions = {75, 50};
  const CompiledScene scene = sceneOf(cut.partitioning);
  CompiledFrame frame = compileFrame(scene, camera, 0, false);
  frame.samples = 2;
  frame.firstSample = 5;
  const CameraBasis basis = cameraBasis(camera);
  for (int rank = 0; rank < cut.ranks; rank++) {
    const TileList list = tilesOf(scene, frame, rank);
    EXPECT_EQ(list.tiles.size() + list.skipped, size_t(2 * 3));
    std::vector<int> claimed(size_t(75 * 50));
    for (const SpawnTile& t : list.tiles) {
      EXPECT_LE(t.x1 - t.x0, kTile);
      EXPECT_LE(t.y1 - t.y0, kTile);
      for (int y = t.y0; y < t.y1; y++)
        for (int x = t.x0; x < t.x1; x++) claimed.at(size_t(y * 75 + x))++;
      EXPECT_EQ(t.sample, 5);
    }
    for (int pixel = 0; pixel < 75 * 50; pixel++) {
      bool met = false;
      for (int p : cut.partitioning.owned(rank))
        met = met || meets(cut.partitioning.box(p), cameraRay(basis, pixel % 75 + 0.5, pixel / 75 + 0.5));
      const int n = claimed[size_t(pixel)];
      ASSERT_LE(n, 1);
      ASSERT_TRUE(n == 1 || !met) << "pixel " << pixel << " of rank " << rank << ", " << cut.name;
    }
  }
}

TEST(Tiles, CoverEachPixelOfTheProjectedBoxesOnce) {
  const Box d = sceneDomain();
  Camera camera = cameraOutside(d, {75, 50});
  for (const Cut& cut : manyCuts(d, 5)) {
    expectCovered(cut, camera);
    Camera parallel = camera;
    parallel.aov = 0;
    parallel.height = 1.7;
    expectCovered(cut, parallel);
  }
}

TEST(Tiles, CoverWhatIsBesideAndBehindAnEyeInside) {
  const Box d = sceneDomain();
  Camera camera = cameraOutside(d, {75, 50});
  camera.viewpoint = {0.1, 0.2, 0.3};
  for (double aov : {20.0, 120.0, 179.0}) {
    camera.aov = aov;
    for (const Cut& cut : manyCuts(d, 6)) expectCovered(cut, camera);
  }
}

TEST(Tiles, AreSkippedWhereARankShowsNothing) {
  const Box d = sceneDomain();
  const Cut cut = lattice(d, {2, 1, 1}, 2);
  CompiledScene scene = sceneOf(cut.partitioning);
  Camera camera = cameraOutside(d, {640, 640});
  camera.aov = 120;  // the domain is small in the picture
  const CompiledFrame frame = compileFrame(scene, camera, 0, false);
  const TileList some = tilesOf(scene, frame, 0);
  EXPECT_GT(some.tiles.size(), 0u);
  EXPECT_GT(some.skipped, 300u);
  EXPECT_EQ(tilesOf(scene, frame, 5).tiles.size(), 0u) << "a rank that owns nothing";
  scene.visible[0] = 0;
  EXPECT_EQ(tilesOf(scene, frame, 0).tiles.size(), 0u) << "nothing to see in its partition";
}

}  // namespace
}  // namespace gxy::test
