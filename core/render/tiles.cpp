// SPDX-License-Identifier: Apache-2.0
#include "core/render/tiles.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace gxy {

namespace {

// Rounding error of the float lattice that decides in which partition a ray is, in render space. It matters
// where a pixel is smaller than this.
constexpr double kRounding = 2e-6;

struct PixelBox {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

// Computes the box, in render space, of the part of partition `p` in which something can be seen. Outer
// partitions reach to the end of the visible domain.
void visibleBox(const CompiledScene& scene, int p, glm::dvec3& lo, glm::dvec3& hi) {
  const Box& box = scene.partitioning->box(p);
  const Box& domain = scene.partitioning->domain();
  lo = scene.space.toRender(box.lo);
  hi = scene.space.toRender(box.hi);
  lo -= kRounding;
  hi += kRounding;
  for (int k = 0; k < 3; k++) {
    if (box.lo[k] == domain.lo[k] || lo[k] < scene.lo[k]) lo[k] = scene.lo[k];
    if (box.hi[k] == domain.hi[k] || hi[k] > scene.hi[k]) hi[k] = scene.hi[k];
  }
}

// Returns the pixels that a box may cover, with a margin for rounding; all pixels if part of the box is
// beside or behind the eye.
PixelBox project(const CompiledFrame& f, glm::dvec3 lo, glm::dvec3 hi) {
  const CameraBasis& b = f.basis;
  const PixelBox all{0, 0, double(f.width), double(f.height)};
  PixelBox box{1e300, 1e300, -1e300, -1e300};
  const double uu = glm::dot(b.du, b.du), vv = glm::dot(b.dv, b.dv);
  for (int c = 0; c < 8; c++) {
    const glm::dvec3 corner(c & 1 ? hi.x : lo.x, c & 2 ? hi.y : lo.y, c & 4 ? hi.z : lo.z);
    glm::dvec3 onPlane = corner;
    if (!b.orthographic) {
      const double depth = glm::dot(corner - b.eye, b.view);
      // The image plane has this depth in all directions, since du and dv are orthogonal to the view.
      const double plane = glm::dot(b.corner, b.view);
      if (depth <= 1e-6 * glm::length(corner - b.eye)) return all;
      onPlane = (corner - b.eye) * (plane / depth);
    }
    const double x = glm::dot(onPlane - b.corner, b.du) / uu, y = glm::dot(onPlane - b.corner, b.dv) / vv;
    if (!(std::abs(x) < 1e15 && std::abs(y) < 1e15)) return all;
    box.x0 = std::min(box.x0, x);
    box.x1 = std::max(box.x1, x);
    box.y0 = std::min(box.y0, y);
    box.y1 = std::max(box.y1, y);
  }
  return {box.x0 - 1, box.y0 - 1, box.x1 + 1, box.y1 + 1};
}

}  // namespace

int tileSide(int64_t credits, int64_t perPrimary) {
  // A packet of 64 rays still fills the gangs, and most of a tile's work is still in its rays.
  constexpr int kLeast = 8;
  int side = kTile;
  while (side > kLeast && int64_t(side) * side * perPrimary > credits / 32) side /= 2;
  return side;
}

TileList tilesOf(const CompiledScene& scene, const CompiledFrame& frame, int rank, int side) {
  std::vector<PixelBox> seen;
  for (int p : scene.partitioning->owned(rank)) {
    if (!scene.visible[p]) continue;
    glm::dvec3 lo, hi;
    visibleBox(scene, p, lo, hi);
    seen.push_back(project(frame, lo, hi));
  }
  TileList list;
  for (int y = 0; y < frame.height; y += side)
    for (int x = 0; x < frame.width; x += side) {
      const SpawnTile tile{x, y, std::min(x + side, frame.width), std::min(y + side, frame.height),
                           frame.firstSample};
      const bool meets = std::any_of(seen.begin(), seen.end(), [&](const PixelBox& b) {
        return b.x0 < tile.x1 && tile.x0 < b.x1 && b.y0 < tile.y1 && tile.y0 < b.y1;
      });
      if (meets)
        list.tiles.push_back(tile);
      else
        list.skipped++;
    }
  return list;
}

}  // namespace gxy
