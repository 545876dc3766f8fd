// SPDX-License-Identifier: Apache-2.0
#define BOOST_ALLOW_DEPRECATED_HEADERS  // Boost.Geometry includes one

#include "core/analysis/mesh_reader.h"

#include <algorithm>
#include <array>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <boost/iterator/function_output_iterator.hpp>
#include <cmath>
#include <glm/common.hpp>
#include <limits>
#include <span>
#include <vector>

namespace gxy {
namespace {

namespace bg = boost::geometry;

using TreePoint = bg::model::point<float, 3, bg::cs::cartesian>;
using TreeBox = bg::model::box<TreePoint>;
using CellBox = std::pair<TreeBox, uint32_t>;
using CellTree = bg::index::rtree<CellBox, bg::index::quadratic<16>>;

float roundedDown(double x) {
  const auto f = float(x);
  return double(f) > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}
float roundedUp(double x) { return -roundedDown(-x); }

/// The box of a cell, a little larger, as a point may be outside of its cell by a rounding.
TreeBox boxOf(const MeshBlock& block, uint32_t cell) {
  glm::dvec3 lo(std::numeric_limits<double>::infinity()), hi = -lo;
  for (const uint32_t p : block.cells.pointsOf(cell)) {
    lo = glm::min(lo, block.points[p]);
    hi = glm::max(hi, block.points[p]);
  }
  const glm::dvec3 more = 1e-9 * (hi - lo);
  lo -= more, hi += more;
  return {{roundedDown(lo.x), roundedDown(lo.y), roundedDown(lo.z)},
          {roundedUp(hi.x), roundedUp(hi.y), roundedUp(hi.z)}};
}

}  // namespace

class MeshReader::Tree {
 public:
  Tree(const MeshBlock& block, const std::function<void()>& check)
      : block_(block), tree_(boxesOf(block, check)) {}

  std::optional<MeshPlace> place(glm::dvec3 world) const {
    const TreeBox at{{roundedDown(world.x), roundedDown(world.y), roundedDown(world.z)},
                     {roundedUp(world.x), roundedUp(world.y), roundedUp(world.z)}};
    std::vector<uint32_t> cells;
    tree_.query(bg::index::intersects(at), boost::make_function_output_iterator(
                                               [&](const CellBox& found) { cells.push_back(found.second); }));
    std::sort(cells.begin(), cells.end());
    for (const uint32_t cell : cells) {
      const CellType type = block_.cells.typeOf(cell);
      const std::span<const uint32_t> points = block_.cells.pointsOf(cell);
      std::array<glm::dvec3, 8> corners;
      for (size_t k = 0; k < points.size(); k++) corners[k] = block_.points[points[k]];
      glm::dvec3 middle(0);
      for (size_t k = 0; k < points.size(); k++) middle += reference::placeOfCorner(type, k);
      const auto inverse = reference::invert(type, std::span(corners).first(points.size()), world,
                                             middle / double(points.size()));
      if (inverse) return MeshPlace{&block_, cell, reference::shapeAt(type, inverse->place)};
    }
    return std::nullopt;
  }

 private:
  static std::vector<CellBox> boxesOf(const MeshBlock& block, const std::function<void()>& check) {
    std::vector<CellBox> boxes;
    boxes.reserve(block.cells.size());
    for (uint32_t cell = 0; cell < block.cells.size(); cell++) {
      if (cell % 65536 == 0) check();
      boxes.emplace_back(boxOf(block, cell), cell);
    }
    return boxes;
  }

  const MeshBlock& block_;
  const CellTree tree_;
};

MeshReader::MeshReader(const Mesh& mesh, const std::function<void()>& check) : mesh_(mesh) {
  for (const auto& [partition, block] : mesh.blocks)
    trees_.emplace(partition, std::make_unique<const Tree>(block, check));
}

MeshReader::~MeshReader() = default;

int64_t MeshReader::bytesFor(const Mesh& mesh) {
  // The boxes of the cells, once more while the tree is built, and nodes of 16 boxes that are at least a third full.
  constexpr int64_t kBytesOfCell = 3 * sizeof(CellBox);
  int64_t bytes = 0;
  for (const auto& [partition, block] : mesh.blocks) bytes += int64_t(block.cells.size()) * kBytesOfCell;
  return bytes;
}

std::optional<MeshPlace> MeshReader::place(int partition, glm::dvec3 world) const {
  const auto tree = trees_.find(partition);
  return tree == trees_.end() ? std::nullopt : tree->second->place(world);
}

double MeshReader::value(const MeshPlace& place, int component) const {
  const std::span<const uint32_t> points = place.block->cells.pointsOf(place.cell);
  const auto n = size_t(mesh_.components);
  reference::OfCorners corners{};
  double finite = 0;
  if (!place.block->cellValues.empty())
    for (size_t c = 0; c < n; c++) {
      const float own = place.block->cellValues[place.cell * n + c];
      finite += double(own - own);
    }
  for (size_t k = 0; k < points.size(); k++) {
    const auto valueOf = [&](size_t c) {
      return mesh_.shift + mesh_.scale * double(place.block->values[points[k] * n + c]);
    };
    if (component >= 0) {
      corners[k] = valueOf(size_t(component));
    } else {
      double squares = 0;
      for (size_t c = 0; c < n; c++) squares += valueOf(c) * valueOf(c);
      corners[k] = std::sqrt(squares);
    }
    finite += corners[k] - corners[k];
  }
  if (!(finite == 0)) return std::numeric_limits<double>::quiet_NaN();
  const auto [least, most] =
      std::minmax_element(corners.begin(), corners.begin() + std::ptrdiff_t(points.size()));
  return std::clamp(place.shape.mean(corners), *least, *most);
}

}  // namespace gxy
